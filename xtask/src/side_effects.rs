//! Which crates must not print, and which must not spawn threads.
//!
//! A library that prints writes into its caller's output. `robot-model` works on all cores by rayon alone, whose results
//! come in the order of the input, so that sums are the same bits on any machine. Tests, examples and comments may do
//! both.

use std::collections::BTreeSet;
use std::path::Path;

use crate::repository::root;
use crate::source::Crate;
use crate::steps::Outcome;

/// Parts of paths by which code prints, `name!` for a macro.
const PRINTS: &[&[&str]] = &[
    &["print!"],
    &["println!"],
    &["eprint!"],
    &["eprintln!"],
    &["dbg!"],
    &["io", "stdout"],
    &["io", "stderr"],
];

/// Parts of paths by which code spawns a thread.
const SPAWNS: &[&[&str]] = &[&["std", "thread"]];

/// One crate, and what its code must not do.
struct Rule {
    /// The crate's root module.
    library: &'static str,
    forbidden: &'static [&'static [&'static [&'static str]]],
    /// What a reader is told.
    why: &'static str,
}

const RULES: [Rule; 5] = [
    Rule {
        library: "robot-model/src/lib.rs",
        forbidden: &[PRINTS, SPAWNS],
        why: "robot-model returns what it finds, and only rayon spawns threads",
    },
    Rule {
        library: "campaign/src/lib.rs",
        forbidden: &[PRINTS],
        why: "campaign returns warnings and errors; programs say them",
    },
    Rule {
        library: "host-link/src/lib.rs",
        forbidden: &[PRINTS],
        why: "host-link returns results and errors; programs say them",
    },
    Rule {
        library: "findings/src/lib.rs",
        forbidden: &[PRINTS],
        why: "findings are told; programs say them",
    },
    Rule {
        library: "import/src/lib.rs",
        forbidden: &[PRINTS],
        why: "import returns what it understood; programs say that",
    },
];

pub fn check() -> Outcome {
    let mut findings = BTreeSet::new();
    for rule in &RULES {
        findings.extend(broken(root(), rule)?);
    }
    if findings.is_empty() {
        return Ok(());
    }
    let findings: Vec<String> = findings.into_iter().collect();
    Err(format!("side effects in a library:\n{}", findings.join("\n")))
}

/// What a crate has against its rule, `file: path: why`, each once.
fn broken(base: &Path, rule: &Rule) -> Result<BTreeSet<String>, String> {
    let source = Crate::read(base, Path::new(rule.library))?;
    let is_forbidden = |path: &[String]| {
        rule.forbidden.iter().copied().flatten().any(|part| {
            path.windows(part.len()).any(|window| window.iter().zip(*part).all(|(a, b)| a == b))
        })
    };
    let found = source.mentions().filter(|(_, path)| is_forbidden(path));
    Ok(found
        .map(|(file, path)| format!("{}: `{}`: {}", file.display(), path.join("::"), rule.why))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example_repository::Example;

    /// What is found in a library with this line in a function of one of its modules.
    fn found(rule: &Rule, file: &str) -> Vec<String> {
        let module = Path::new(rule.library).with_file_name("module.rs");
        let name = module.to_str().unwrap();
        let example = Example::new(&[(rule.library, "mod module;\n"), (name, file)]);
        broken(example.base(), rule).unwrap().into_iter().collect()
    }

    #[test]
    fn a_library_that_prints_is_found() {
        for rule in &RULES {
            for (code, named) in [
                ("fn f() { println!(\"a\"); }", "println!"),
                ("fn f() { if true { std::eprintln!(); } }", "eprintln!"),
                ("fn f() { g(|x| print!(\"{x}\")) }", "print!"),
                ("fn f() { eprint!(\"a\") }", "eprint!"),
                ("fn f() -> u8 { dbg!(1) }", "dbg!"),
                ("fn f() { vec![println!()]; }", "println!"),
                ("fn f() { std::io::stdout().flush(); }", "std::io::stdout"),
                ("use std::io;\nfn f() { io::stderr().flush(); }", "io::stderr"),
                ("use std::io::{Write, stdout};", "std::io::stdout"),
            ] {
                let place = Path::new(rule.library).with_file_name("module.rs");
                let expected = format!("{}: `{named}`: {}", place.display(), rule.why);
                assert_eq!(found(rule, code), [expected], "{code}");
            }
        }
    }

    #[test]
    fn a_thread_of_its_own_is_found_in_robot_model() {
        for code in [
            "fn f() { std::thread::spawn(|| ()); }",
            "use std::thread;\nfn f() { thread::scope(|_| ()); }",
            "pub use std::{thread as workers};",
            "use std::thread::*;",
        ] {
            let found = found(&RULES[0], code);
            assert_eq!(found.len(), 1, "{code}: {found:?}");
            assert!(found[0].contains("`std::thread"), "{found:?}");
        }
    }

    #[test]
    fn tests_comments_and_what_rayon_does_are_let_pass() {
        let code = "//! println!(\"in a comment\")\n\
                    fn f() { rayon::scope(|_| ()); write!(text, \"println!\"); let _ = 1 != (2); }\n\
                    #[cfg(test)]\nmod tests {\n    fn f() { println!(\"a\"); std::thread::yield_now(); }\n}\n\
                    #[cfg(test)]\nfn g() { dbg!(1); }\n";
        for rule in &RULES {
            assert_eq!(found(rule, code), [""; 0]);
        }
    }

    #[test]
    fn no_library_breaks_its_rule() {
        for rule in &RULES {
            assert_eq!(broken(root(), rule).unwrap(), BTreeSet::new());
        }
    }
}
