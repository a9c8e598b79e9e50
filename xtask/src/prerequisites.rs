//! What the tests need beyond the compiler: looked for, and installed where it is missing.

use std::process::{Command, Stdio};

use crate::steps::{Outcome, run};

/// One thing that has to be there.
struct Need {
    name: &'static str,
    /// What it is for.
    why: &'static str,
    /// A command that succeeds if it is there.
    check: &'static [&'static str],
    /// How to get it.
    install: Install,
}

/// How to get a [`Need`].
enum Install {
    /// Debian packages, installed here where this is root or sudo asks for no password.
    Debian(&'static [&'static str]),
    /// A command for the user to run: it changes what is theirs.
    Yourself(&'static str),
}

/// Everything that `cargo xtask test` needs.
const NEEDS: &[Need] = &[
    Need {
        name: "git",
        why: "lists the files to check",
        check: &["git", "--version"],
        install: Install::Debian(&["git"]),
    },
    Need {
        name: "rustfmt",
        why: "checks the formatting",
        check: &["cargo", "fmt", "--version"],
        install: Install::Yourself("rustup component add rustfmt"),
    },
    Need {
        name: "clippy",
        why: "checks the code",
        check: &["cargo", "clippy", "--version"],
        install: Install::Yourself("rustup component add clippy"),
    },
    Need {
        name: "node",
        why: "drives the browser in tests of `beeline serve`",
        check: &["node", "--version"],
        install: Install::Debian(&["nodejs", "npm"]),
    },
    Need {
        name: "npm",
        why: "fetches what drives the browser",
        check: &["npm", "--version"],
        install: Install::Debian(&["npm"]),
    },
    Need {
        name: "chromium",
        why: "is the browser",
        check: &["chromium", "--version"],
        install: Install::Debian(&["chromium"]),
    },
];

/// What `cargo xtask fuzz` needs besides.
const FUZZ: &[Need] = &[Need {
    name: "c++",
    why: "compiles libFuzzer",
    check: &["c++", "--version"],
    install: Install::Debian(&["g++"]),
}];

/// What `cargo xtask wheel` and `cargo xtask peers` need besides.
const PYTHON: &[Need] = &[Need {
    name: "python3",
    why: "runs the wheel's tests, and the programs that bags are exchanged with",
    check: &["python3", "-c", "import venv, ensurepip"],
    install: Install::Debian(&["python3", "python3-venv"]),
}];

/// Looks for each need of the tests, and installs what is missing.
pub fn meet() -> Outcome {
    meet_all(NEEDS)
}

/// The same for the coverage-guided search.
pub fn meet_for_fuzzing() -> Outcome {
    meet_all(FUZZ)
}

/// The same for the wheel, and the exchange with other programs.
pub fn meet_for_python() -> Outcome {
    meet_all(PYTHON)
}

fn meet_all(needs: &[Need]) -> Outcome {
    needs.iter().try_for_each(|need| {
        if is_met(need) {
            println!("    {}: there", need.name);
            return Ok(());
        }
        println!("    {}: missing ({})", need.name, need.why);
        match need.install {
            Install::Yourself(line) => {
                return Err(format!("{} is missing ({}): run `{line}`", need.name, need.why));
            }
            Install::Debian(packages) => install(packages)?,
        }
        if is_met(need) {
            Ok(())
        } else {
            Err(format!("{} is still missing after its installation", need.name))
        }
    })
}

fn is_met(need: &Need) -> bool {
    succeeds(need.check)
}

fn succeeds(line: &[&str]) -> bool {
    Command::new(line[0])
        .args(&line[1..])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// Installs Debian packages, or says how to.
pub fn install(packages: &[&str]) -> Outcome {
    let by_hand = format!("install by hand: apt-get install {}", packages.join(" "));
    if !succeeds(&["apt-get", "--version"]) {
        return Err(format!("there is no apt-get here; {by_hand}"));
    }
    // Root writes to /etc; others need sudo, which must not ask.
    let prefix: &[&str] = if succeeds(&["test", "-w", "/etc"]) { &[] } else { &["sudo", "-n"] };
    let line = |args: &[&str]| {
        let words = [prefix, &["apt-get", "-y", "-qq"], args].concat();
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).env("DEBIAN_FRONTEND", "noninteractive").stdin(Stdio::null());
        command
    };
    run(&mut line(&["update"]), &by_hand)?;
    run(&mut line(&[&["install", "--no-install-recommends"], packages].concat()), &by_hand)
}
