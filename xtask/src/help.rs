//! What `cargo xtask help` prints. The pages are checked by it: each chore in it begins a line.

pub const HELP: &str = "\
cargo xtask <chore>

  test               installs what is missing, then runs all that CI runs
  check              the part of it that takes seconds: format, words, pages, lengths, circles, side effects
  firmware [--board NAME] [--compiler pinned|distribution]
                     builds the boards' images and prints how large they are
  bench firmware     counts the instructions of a control tick, on the emulated board
  bench faults [--seed S] [--cases N] [--case I] [--threads T]
                     random faults at random instants on the emulated board: are the motors off
                     in time, and is each called what it is?
  fuzz [TARGET] [--seconds S] [--minimise]
                     searches for inputs that break a fuzz target, or each of them, guided by coverage;
                     `--minimise` then keeps the fewest that reach the same code, in fuzz/corpus
  bench crash        ends every command that writes at every system call that changes the file system
                     (Linux on x86-64): is what is left old or new, and does it complete afterwards?
  emulate [--listen HOST:PORT] [--scenario FILE] [--camera FILE] [--flash FILE]
                     the emulated board behind TCP, for `beeline --port tcp:HOST:PORT`
  bench NAME [ARGS]  runs tests/examples/bench_NAME.rs as a release build; `all` runs every one of
                     these, which firmware, faults and crash are none of
  arrows             draws which folder of robot-model uses which, into ARCHITECTURE.md
  dependencies       licences, sources and duplicates of what is depended on, by the rules of deny.toml;
                     and which crate must not depend on which
  third-party        writes THIRD-PARTY.txt, the notice of whose code is in the programs
  boards             writes the pin tables and wiring pictures in docs/boards/
  help               this
";
