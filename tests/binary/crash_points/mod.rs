//! Every command that writes, ended at every system call that changes the file system or says something.
//!
//! ```text
//! killed there       -> what is left is old or new; the same command again completes, with the result of one that was not
//!                       killed, and leaves nothing half-written
//! disk full there    -> one clear error, or none; what is left is old or new
//! a second process   -> refused by name while the first has the lock; whatever the order, each success counts exactly once
//! there
//! ```
//!
//! Between two stops nothing changes the file system, so these are the states that any system call, and any instant, can leave.
//! A part of it runs with the tests, all of it with `cargo xtask bench crash`.

mod call;
mod command;
mod tracer;
mod tree;

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use campaign::Campaign;
use campaign::lock::NAME;

use self::call::Call;
use self::command::{ALL, Writers, Writing, folder};
use self::tracer::{Then, Traced, trace};
use self::tree::{Tree, age, leftovers};
use crate::outcome::Outcome;
use crate::temp_folder::{TempFolder, words};

/// A command that writes, with what it starts from and what it comes to undisturbed.
struct CommandUnderTest {
    command: &'static Writing,
    /// Before it, after it, and after it was given a second time.
    old: Tree,
    new: Tree,
    newer: Tree,
    calls: usize,
    stops: Vec<Call>,
}

impl CommandUnderTest {
    fn new(command: &'static Writing) -> Self {
        let old = command.start();
        let temp = folder(&old);
        let mut stops = Vec::new();
        let traced = traced(&temp, command, |stop, _| {
            stops.push(stop.call);
            Then::Goes
        });
        assert_eq!(traced.code, Some(0), "{}: {}", command.line, traced.said[1]);
        // Else a power failure may undo the rename, after what followed.
        let (renames, syncs) = (Call::Takes("rename"), Call::Takes("sync"));
        let is_kept = |at: usize| stops.get(at + 1) == Some(&syncs);
        let mut renamed = (0..stops.len()).filter(|at| stops[*at] == renames);
        assert!(renamed.all(is_kept), "{}: a name is not synced: {stops:?}", command.line);
        let new = Tree::of(&temp.path(""));
        again(&temp, command);
        let newer = Tree::of(&temp.path(""));
        assert_eq!(leftovers(&temp.path("")), [] as [std::path::PathBuf; 0], "{}", command.line);
        Self { command, old, new, newer, calls: traced.calls, stops }
    }

    /// Kills it at a stop, and gives the command again.
    fn survives_a_kill(&self, at: usize) {
        let temp = folder(&self.old);
        let killed = traced(&temp, self.command, |stop, _| match stop.index == at {
            true => Then::Dies,
            false => Then::Goes,
        });
        let place = format!("`{}` killed at {at}, {:?}", self.command.line, self.stops.get(at));
        assert_eq!(killed.code, None, "{place}: {}", killed.said[1]);
        self.is_old_or_new(&temp, &place);
        if !killed.said[0].is_empty() && !self.command.line.starts_with("calibrate --flash") {
            let differing = Tree::of(&temp.path(""));
            let differing = differing.differing(&self.new);
            assert!(differing.is_empty(), "{place}: said before it was so: {differing:?}");
        }
        age(&temp.path(""));
        let outcome = again(&temp, self.command);
        self.is_complete(&temp, &format!("{place}, again: {outcome:?}"));
    }

    /// Lets one call fail as on a full disk.
    fn survives_a_full_disk(&self, at: usize) {
        let temp = folder(&self.old);
        let ended = traced(&temp, self.command, |stop, _| match stop.index == at {
            true => Then::FindsTheDiskFull,
            false => Then::Goes,
        });
        let [_, stderr] = &ended.said;
        let place =
            format!("`{}` with a full disk at {at}, {:?}", self.command.line, self.stops[at]);
        let errors = stderr.lines().filter(|line| line.starts_with("error: ")).count();
        let ends = (ended.code, errors);
        assert!(ends == (Some(0), 0) || ends == (Some(2), 1), "{place}: {ends:?}: {stderr}");
        self.is_old_or_new(&temp, &place);
        if ended.code == Some(0) {
            // A mark that could not be removed changes nothing, and the next writer removes it.
            for toml in ["robot/robot.toml", "again/robot.toml"] {
                if let Ok(text) = std::fs::read_to_string(temp.path(toml)) {
                    std::fs::write(temp.path(toml), text.replace("pending = true\n", "")).unwrap();
                }
            }
            self.is_complete(&temp, &format!("{place}: {stderr}"));
            return;
        }
        age(&temp.path(""));
        let outcome = again(&temp, self.command);
        self.is_complete(&temp, &format!("{place}: {stderr}, again: {outcome:?}"));
    }

    /// Lets a second process give the same command while the first stands still.
    /// Tells whether the first had the lock.
    fn keeps_a_second_writer_out(&self, at: usize) -> bool {
        let temp = folder(&self.old);
        let place = format!("`{}` stopped at {at}, {:?}", self.command.line, self.stops[at]);
        let (mut second, mut had_the_lock) = (None, false);
        let first = traced(&temp, self.command, |stop, process| {
            if stop.index == at {
                had_the_lock = is_locked(&temp);
                let outcome = temp.run(self.command.line);
                if had_the_lock {
                    let message = outcome.refused();
                    let names = [format!("process {process} "), "another process".to_owned()];
                    let named = names.iter().any(|name| message.contains(name));
                    assert!(named && message.contains("is writing into"), "{place}: {message}");
                    second = Some(false);
                } else {
                    second = Some(outcome.code == Some(0));
                }
            }
            Then::Goes
        });
        let succeeded = [first.code == Some(0), second.expect("it was stopped there")];
        let wanted = match succeeded {
            [true, true] => &self.newer,
            [true, false] | [false, true] => &self.new,
            [false, false] => panic!("{place}: neither wrote: {}", first.said[1]),
        };
        let found = Tree::of(&temp.path(""));
        let differing = found.differing(wanted);
        assert!(differing.is_empty(), "{place}: {succeeded:?} succeeded, and {differing:?} differ");
        had_the_lock
    }

    /// Each file is the old or the new one; each run of a campaign has its facts.
    fn is_old_or_new(&self, temp: &TempFolder, place: &str) {
        let found = Tree::of(&temp.path(""));
        for (name, bytes) in &found.0 {
            let pending = name.ends_with("robot.toml")
                && bytes.windows(14).any(|text| text == b"pending = true");
            // More than two runs: a file may be that of an instant between them.
            let grows = name.starts_with("robot") && !name.starts_with("robot/runs");
            let known = [&self.old, &self.new].iter().any(|tree| tree.0.get(name) == Some(bytes));
            assert!(known || pending || grows, "{place}: {} is neither", name.display());
        }
        let kept = self.old.0.keys().filter(|name| self.new.0.contains_key(*name));
        for name in kept {
            assert!(found.0.contains_key(name), "{place}: {} is gone", name.display());
        }
        self.has_its_facts(temp, place);
        if let Some((first, then)) = self.command.order {
            let differs = |name: &&&std::path::Path| name.starts_with(then);
            let then_is_new = self.old.differing(&found).iter().any(|name| differs(&name));
            let first_is_new =
                found.differing(&self.new).iter().all(|name| !name.starts_with(first));
            assert!(!then_is_new || first_is_new, "{place}: {then} is new and {first} is not");
        }
    }

    /// The runs are some of those of the undisturbed campaign, from the first, each as it is there.
    fn has_its_facts(&self, temp: &TempFolder, place: &str) {
        if !temp.path("robot/robot.toml").exists() {
            return;
        }
        let read = |temp: &TempFolder| {
            if !temp.path("robot/robot.toml").exists() {
                return None;
            }
            let campaign = Campaign::read_if_any(&temp.path("robot"));
            campaign.unwrap_or_else(|error| panic!("{place}: {error}")).map(|there| there.runs)
        };
        let found = read(temp).unwrap_or_default();
        let new = read(&folder(&self.new)).unwrap_or_default();
        let old = read(&folder(&self.old)).unwrap_or_default();
        assert!(found.len() >= old.len() && found.len() <= new.len(), "{place}: {}", found.len());
        for (index, (found, new)) in found.iter().zip(&new).enumerate() {
            let known = found == new || old.get(index) == Some(found);
            assert!(known, "{place}: {} is not as it should be", new.name);
        }
    }

    /// What one command leaves, or two; and nothing beside.
    fn is_complete(&self, temp: &TempFolder, place: &str) {
        let found = Tree::of(&temp.path(""));
        let mut differing = found.differing(&self.new);
        if let Some(picture) = self.command.picture
            && !found.0.contains_key(Path::new(picture))
        {
            differing.retain(|name| *name != Path::new(picture));
        }
        let is_known = differing.is_empty() || found == self.newer;
        assert!(is_known, "{place}: {differing:?} differ");
        let left = leftovers(&temp.path(""));
        let left: Vec<_> = left.iter().filter(|file| !file.ends_with(NAME)).collect();
        assert!(left.is_empty(), "{place}: {left:?} are left");
    }
}

fn traced(
    temp: &TempFolder,
    command: &Writing,
    at: impl FnMut(&tracer::Stop, u32) -> Then,
) -> Traced {
    trace(temp.command(&words(command.line)), &temp.path(""), at)
}

/// The same command again: it completes, or is refused because there is nothing left to do.
fn again(temp: &TempFolder, command: &Writing) -> Outcome {
    let outcome = temp.run(command.line);
    let clear = outcome.code == Some(0) || outcome.stderr.contains("error: ");
    assert!(clear && outcome.code.is_some_and(|code| code <= 2), "{}: {outcome:?}", command.line);
    outcome
}

fn is_locked(temp: &TempFolder) -> bool {
    let folder = temp.path("robot");
    let file = std::fs::File::open(folder.join(NAME));
    file.is_ok_and(|file| matches!(file.try_lock(), Err(std::fs::TryLockError::WouldBlock)))
}

/// Every `step`-th point of a command in each of the three ways: how many there are, and what went wrong.
fn examine(command: &'static Writing, step: usize) -> (usize, Vec<String>) {
    let tested = CommandUnderTest::new(command);
    let takes = |index: &usize| matches!(tested.stops[*index], Call::Takes(_) | Call::Caches);
    let kills: Vec<usize> = (0..tested.stops.len()).step_by(step).collect();
    let fills: Vec<usize> = kills.iter().copied().filter(takes).collect();
    let seconds: Vec<usize> =
        if command.writers == Writers::One { Vec::new() } else { kills.clone() };
    let mut wrong = Vec::new();
    let mut hold = |points: &[usize], survives: &dyn Fn(usize)| {
        for point in points {
            let survived = catch_unwind(AssertUnwindSafe(|| survives(*point)));
            wrong.extend(survived.err().map(|panic| match panic.downcast::<String>() {
                Ok(text) => *text,
                Err(_) => format!("`{}` at {point}", command.line),
            }));
        }
    };
    hold(&kills, &|at| tested.survives_a_kill(at));
    hold(&fills, &|at| tested.survives_a_full_disk(at));
    let locked = Cell::new(0);
    hold(&seconds, &|at| {
        locked.set(locked.get() + u32::from(tested.keeps_a_second_writer_out(at)))
    });
    if command.writers == Writers::Locked && locked.get() == 0 {
        wrong.push(format!("`{}` writes without the lock of its folder", command.line));
    }
    let (calls, [kills, fills, seconds]) =
        (tested.calls, [kills, fills, seconds].map(|points| points.len()));
    println!(
        "{:<60} {calls:>6} system calls, {kills:>4} kills, {fills:>4} full disks, {seconds:>4} second writers, {} wrong",
        command.line,
        wrong.len()
    );
    (kills + fills + seconds, wrong)
}

/// What is not ended at any point below is held to this at least.
#[test]
fn every_writing_command_syncs_the_names_of_its_files_leaves_nothing_and_can_be_given_again() {
    for command in ALL {
        CommandUnderTest::new(command);
    }
}

/// Some points of some commands: a campaign's runs and facts, its model, an explanation, a file of its own, an undo, an import.
#[test]
fn commands_that_are_ended_at_some_points_leave_old_or_new_and_complete_when_given_again() {
    let wrong: Vec<String> = [(0, 5), (7, 5), (11, 15), (15, 4), (19, 2), (27, 17)]
        .iter()
        .flat_map(|(index, step)| examine(&ALL[*index], *step).1)
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Minutes: `cargo xtask bench crash`.
#[test]
#[ignore = "takes minutes: `cargo xtask bench crash` runs it"]
fn every_writing_command_ended_at_every_point_leaves_old_or_new_and_completes_when_given_again() {
    let (mut points, mut wrong) = (0, Vec::new());
    for command in ALL {
        let (of_command, wrong_there) = examine(command, 1);
        points += of_command;
        wrong.extend(wrong_there);
    }
    println!("{points} points of {} commands", ALL.len());
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
