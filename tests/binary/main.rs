//! The `beeline` executable, as a user runs it: arguments in; exit code, output and files out. Each test has a folder
//! of its own, and no state from earlier runs.

mod analysis;
mod answers;
mod apply;
mod asked_for;
mod bad_input;
mod bad_port;
mod calculator;
mod campaign;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod crash_points;
mod drive;
mod example;
mod files;
mod first_run;
mod fit_cache;
mod fleet;
#[cfg(unix)]
mod full_disk;
mod gyro;
mod help;
mod import;
mod key;
mod libraries;
mod memory;
mod model_page;
#[path = "../../import/tests/round_trip/one_log.rs"]
mod one_log;
mod outcome;
mod outside_text;
mod page_code;
mod pages;
mod question;
mod real_time;
mod recorded;
mod report;
mod safe_folder;
mod schema;
mod served;
mod tape;
mod temp_folder;
mod tune;
mod walkthrough;
mod wiring;
mod wrong_campaign;
