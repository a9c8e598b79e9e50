//! What `cargo xtask help` prints. The pages are checked by it: each chore in it begins a line.

pub const HELP: &str = "\
cargo xtask <chore>

  test               installs what is missing, then runs all that CI runs
  check              the part of these that takes seconds: format, words, pages, lengths, circles, side effects
  firmware [--board NAME] [--compiler pinned|distribution]
                     builds the boards' images and prints their sizes
  bench firmware     counts the instructions of a control tick, on the emulated board
  bench faults [--seed S] [--cases N [--first I]] [--case I] [--threads T]
                     random faults at random instants on the emulated board: are the motors off
                     in time, and is each fault named correctly?
  bench dead-hosts [--seed S] [--cases N]
                     hosts that die while the emulated board drives, with up to 16 MB of theirs held back: does
                     the controlled stop begin in time?
  fuzz [TARGET] [--seconds S] [--minimise]
                     searches, guided by coverage, for inputs that break this fuzz target, or any of them;
                     `--minimise` then keeps the fewest that reach the same code, in fuzz/corpus
  bench chaos [--seed S] [--sessions N]
                     sessions of simulated robots in which everything fails: do the invariants hold?
  bench pages        frames a second, delay from the robot to the screen, and switches of effects, in a browser
  bench crash        kills each writing command at every system call that changes the file system
                     (Linux on x86-64): is each file old or new, and does the command complete then?
  peers              exchanges bags, trajectories and parameters with the Python packages rosbags, mcap, evo and PyYAML,
                     which it installs into the build folder; a part of `test`
  wheel              builds the Python wheel, runs its tests and its notebook in an environment in the build folder
  emulate [--listen HOST:PORT] [--scenario FILE] [--camera FILE] [--flash FILE]
                     the emulated board behind TCP, for `beeline --port tcp:HOST:PORT`
  bench NAME [ARGS]  runs tests/examples/bench_NAME.rs as a release build; `all` runs all of these,
                     but not the benches above
  arrows             draws into ARCHITECTURE.md which folder of robot-model uses which
  dependencies       checks the dependencies' licences, sources and duplicates by the rules of deny.toml,
                     and that no crate depends on one that it must not
  third-party        writes THIRD-PARTY.txt, which says whose code is in the programs
  boards             writes the pin tables and wiring pictures in docs/boards/
  help               prints this
";
