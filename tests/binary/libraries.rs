//! The programs of docs/libraries.md: the page shows them as they are, and they do what it says.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::served::Served;
use crate::temp_folder::TempFolder;

const PROGRAMS: [&str; 3] = [
    "host-link/examples/drive.rs",
    "campaign/examples/read_campaign.rs",
    "robot-model/examples/explain.rs",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// What an example prints. Cargo builds the examples of all crates together with their tests.
fn output(name: &str, arguments: &[&str]) -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_beeline")).with_file_name("examples").join(name);
    let output = Command::new(&program).args(arguments).current_dir(root()).output();
    let output = output.unwrap_or_else(|error| {
        panic!("{}: {error}; build it with `cargo build --workspace --examples`", program.display())
    });
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name} {arguments:?}: {told}");
    String::from_utf8(output.stdout).unwrap()
}

/// All numbers in a line that is found by its first word.
fn numbers(text: &str, first: &str) -> Vec<f64> {
    let line = text.lines().find(|line| line.starts_with(first));
    let line = line.unwrap_or_else(|| panic!("no line `{first}...` in:\n{text}"));
    line.split([' ', ',']).filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn the_page_shows_the_programs_as_they_are() {
    let page = std::fs::read_to_string(root().join("docs/libraries.md")).unwrap();
    for program in PROGRAMS {
        let code = std::fs::read_to_string(root().join(program)).unwrap();
        assert!(page.contains(&format!("```rust\n{code}```")), "docs/libraries.md: {program}");
    }
}

#[test]
fn another_program_drives_a_robot() {
    let temp = TempFolder::new();
    let served = Served::start(&temp, "tcp:127.0.0.1:0");
    let text = output("drive", &[served.port()]);
    assert!(numbers(&text, "")[0] > 400.0, "{text}");
    for turns in numbers(&text, "left encoder") {
        // A wheel follows its profile to a hundredth of a turn.
        assert!((0.99..=1.01).contains(&turns), "{text}");
    }
}

#[test]
fn another_program_reads_a_campaign() {
    let text = output("read_campaign", &["examples/mystery-robot"]);
    assert!(text.contains(": 21 runs\n"), "{text}");
    // Four sides of a metre, and a turn to the left about the middle: 4 -+ pi b, with b = 0.372 m.
    let square = numbers(&text, "18_square_left");
    for (rolled_m, expected_m) in [(square[1], 2.831), (square[2], 5.169)] {
        assert!((rolled_m - expected_m).abs() < 0.02, "{rolled_m} m: {text}");
    }
}

#[test]
fn another_program_explains_its_own_recordings() {
    let text = output("explain", &[]);
    let named = numbers(&text, "wheel_radius_ratio: rho");
    // A right wheel larger by 1 % with the mean radius nominal: rho = 0.01 / 1.005.
    let [value, .., low, high] = named[..] else { panic!("{text}") };
    assert!(low < 0.00995 && 0.00995 < high && (value - 0.00995).abs() < 1e-3, "{text}");
    assert!(text.contains("anything left unexplained: false"), "{text}");
}
