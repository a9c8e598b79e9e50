//! Input that is wrong or not whole: one clear error with its file and what to do, or what is whole and a word about the rest.

use std::path::{Path, PathBuf};

use import::log::{PoseLog, WheelLog, WheelUnit};
use import::mcap::{BagWriter, read};
use import::message::{Message, MessageType};
use import::received::Damage;
use import::source::{Choice, Sources};
use import::text;
use import::understand::{Hints, understand};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::MYSTERY;
use crate::one_log::OneLog;

const SEED: u64 = 18;

/// What choosing from and understanding these files fails with.
fn error_of(files: &[(&str, &[u8])], choice: &Choice) -> String {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<PathBuf> = files
        .iter()
        .map(|(name, bytes)| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        })
        .collect();
    let hints =
        Hints { wheel_radius_m: Some(0.036), track_width_m: Some(0.372), ..Hints::default() };
    let result = Sources::open(&paths, &choice.mappings)
        .and_then(|sources| sources.choose(choice))
        .and_then(|chosen| understand(chosen.wheels, &chosen.poses, &hints, chosen.same_clock));
    let error = result.unwrap_err();
    assert!(!error.hint.is_empty());
    let said = error.to_string();
    assert!(said.starts_with(folder.path().to_str().unwrap()), "{said}");
    said.replace(folder.path().to_str().unwrap(), "")
}

fn small() -> OneLog {
    OneLog::of_runs(Path::new(MYSTERY), 0.0, 4..8)
}

#[test]
fn what_cannot_be_imported_is_one_error_with_its_file_and_what_to_do() {
    let bag = small().bag();
    let choice = Choice::default();
    let pose = |topic: &str| Choice { pose: Some(topic.into()), ..Choice::default() };
    let wheels = |left: &str, right: &str| Choice {
        wheels: Some([left.into(), right.into()]),
        ..Choice::default()
    };
    let mut empty = BagWriter::new(Vec::new()).unwrap();
    empty.channel("/joint_states", "sensor_msgs/msg/JointState", "");
    let empty = empty.finish().unwrap();
    let track = small().trajectory();
    type Case<'a> = (&'a [(&'a str, &'a [u8])], &'a Choice, &'a str);
    let cases: [Case<'_>; 10] = [
        (
            &[("a.mcap", b"no bag")],
            &choice,
            "this is neither an MCAP nor an SQLite file; give a ROS 2 bag",
        ),
        (
            &[("a.db3.zstd", b"")],
            &choice,
            "this file is compressed as a whole; unpack it with `zstd -d`",
        ),
        (&[("a.bag", b"")], &choice, "ROS 1"),
        (
            &[("a.mcap", &empty)],
            &choice,
            "nothing in it is known to be the wheels; choose two joints with --wheels",
        ),
        (
            &[("a.mcap", &bag)],
            &pose("/tracker"),
            "no poses are called `/tracker`; choose one of /tracker/pose",
        ),
        (&[("a.mcap", &bag)], &wheels("a", "b"), "no topic has the joints a and b; there is"),
        (
            &[("a.mcap", &bag), ("b.tum", track.as_bytes())],
            &choice,
            "more than one thing in it may be the measured poses",
        ),
        (&[("b.tum", track.as_bytes())], &choice, "nothing in it is known to be the wheels"),
        (
            &[("a.csv", b"t_s,left_counts,right_counts\n0,1,1\n1,2,2\n")],
            &choice,
            "nothing in it is known to be measured poses",
        ),
        (
            &[("a.csv", b"t_s,left_rad,right_rad,x,y\n0,1,1,0,0\n1,2,2,0,0\n")],
            &choice,
            "left_rad, right_rad has only 2 samples",
        ),
    ];
    for (files, choice, says) in cases {
        let said = error_of(files, choice);
        assert!(said.contains(says), "{says:?}: {said}");
    }
}

#[test]
fn poses_of_another_drive_have_nothing_in_common_with_the_wheels() {
    let log = small();
    let other = OneLog::of_runs(Path::new(MYSTERY), 0.0, 17..19);
    let said = error_of(
        &[("wheels.csv", log.table().as_bytes()), ("track.tum", other.trajectory().as_bytes())],
        &{
            let mappings =
                text::parse_mappings("left_rad=enc_l,right_rad=enc_r,t_s=stamp:ns").unwrap();
            Choice { mappings, ..Choice::default() }
        },
    );
    assert!(
        said.contains("no motion in common") || said.contains("the motion repeats itself"),
        "{said}"
    );
}

#[test]
fn a_bag_that_is_cut_off_is_read_as_far_as_it_is_whole() {
    let bag = small().bag();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("crashed.mcap");
    // After the chunks, which are whole: of the end, only the bytes of three records.
    std::fs::write(&file, &bag[..bag.len() - 45]).unwrap();
    let sources = Sources::open(std::slice::from_ref(&file), &[]).unwrap();
    let chosen = sources.choose(&Choice::default()).unwrap();
    assert_eq!(chosen.wheels.t_s.len(), small().wheels.len());
    assert!(chosen.notes[0].text.contains("the bag is cut off at byte"), "{:?}", chosen.notes);
    // Within the only chunk: nothing is whole.
    let damage = read(&bag[..bag.len() / 2], |_| panic!("no chunk is whole")).unwrap();
    assert!(matches!(damage[..], [Damage::CutOff { .. }]), "{damage:?}");
    // A byte within the chunk is another: its checksum is wrong.
    let mut corrupt = bag.clone();
    corrupt[bag.len() / 2] ^= 0x10;
    let damage = read(corrupt.as_slice(), |_| {}).unwrap();
    assert!(matches!(damage[..], [Damage::Chunk { .. }]), "{damage:?}");
}

/// Bytes changed, removed and repeated at random.
fn mangled(bytes: &[u8], rng: &mut impl Rng) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..rng.random_range(1..6) {
        let at = rng.random_range(0..bytes.len());
        match rng.random_range(0..5) {
            0 => bytes[at] = rng.random(),
            1 => bytes[at] ^= 1 << rng.random_range(0..8),
            2 => bytes.truncate(at.max(9)),
            3 => {
                let until = (at + rng.random_range(0..40)).min(bytes.len());
                bytes.drain(at..until);
            }
            _ => {
                let until = (at + rng.random_range(0..40)).min(bytes.len());
                let again = bytes[at..until].to_vec();
                bytes.splice(at..at, again);
            }
        }
        if bytes.len() < 10 {
            break;
        }
    }
    bytes
}

#[test]
fn thousands_of_mangled_bags_neither_panic_nor_fill_the_memory() {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let bags = ["humble_plain.mcap", "jazzy_zstd.mcap"].map(|name| {
        std::fs::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bags")).join(name))
            .unwrap()
    });
    let mut messages = 0_usize;
    for round in 0..4000 {
        let bag = mangled(&bags[round % bags.len()], &mut rng);
        let _damage = read(bag.as_slice(), |received| {
            messages += 1;
            for kind in MessageType::ALL {
                let _ = Message::decode(kind, received.bytes);
            }
        });
    }
    assert!(messages > 10_000, "most of a mangled bag is whole: {messages}");
}

#[test]
fn mangled_parameters_of_controllers_are_errors_or_numbers_and_no_panic() {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let text = b"a: &x [1, {b: c}]\n/**:\n  base: !!map\n    ros__parameters:\n      names: [\"l\", 'r']\n      wheel_radius: 0.036 # m\n      wheel_separation: 0.372\n      note: |\n        two\n        lines\n      other: *x\n";
    let mut read = 0;
    for _ in 0..20_000 {
        let text = mangled(text, &mut rng);
        let Ok(text) = str::from_utf8(&text) else { continue };
        if let Ok(file) = import::controller_file::parse(Path::new("c.yaml"), text) {
            assert!(file.geometry.radii_m().iter().all(|m| *m > 0.0 && m.is_finite()));
            read += 1;
        }
    }
    assert!(read > 100, "some changes change nothing that matters: {read}");
}

#[test]
fn a_chunk_that_promises_more_than_it_can_hold_is_not_unpacked() {
    // Zeros compress to next to nothing.
    let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
    std::io::Write::write_all(&mut packed, &vec![0; 40 << 20]).unwrap();
    let packed = packed.finish().unwrap();
    let mut content = vec![0; 16];
    content.extend((40_u64 << 20).to_le_bytes());
    content.extend([0; 4]);
    content.extend(3_u32.to_le_bytes());
    content.extend(b"lz4");
    content.extend((1_u64 << 10).to_le_bytes());
    content.extend(&packed[..1 << 10]);
    let mut bag = b"\x89MCAP0\r\n".to_vec();
    bag.push(0x06);
    bag.extend((content.len() as u64).to_le_bytes());
    bag.extend(content);
    let damage = read(bag.as_slice(), |_| {}).unwrap();
    assert!(matches!(damage[0], Damage::Chunk { .. }), "{damage:?}");
}

#[test]
fn mangled_tables_and_wild_numbers_are_errors_or_runs_and_no_panic() {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let log = small();
    let (table, track) = (log.table(), log.trajectory());
    let texts = [&table.as_bytes()[..2000], &track.as_bytes()[..2000]];
    for round in 0..2000 {
        let text = mangled(texts[round % 2], &mut rng);
        let _ = text::parse(Path::new("log.csv"), &text, &[]);
    }
    let hints = Hints { counts_per_rev: Some(900.0), ..Hints::default() };
    for round in 0..200 {
        let size = 10_f64.powf(rng.random_range(-3.0..17.0));
        let mut number = || size * rng.random_range(-1.0..1.0);
        let mut wheels: Vec<(f64, [f64; 2])> =
            (0..30).map(|_| (number(), [number(), number()])).collect();
        wheels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut poses: Vec<_> = (0..30)
            .map(|_| import::log::Pose3 {
                t_s: number(),
                position_m: [number(), number(), number()],
                orientation: Some([0.0, 0.0, 0.6, 0.8]),
            })
            .collect();
        poses.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        let (t_s, turned) = wheels.into_iter().unzip();
        let unit = if round % 2 == 0 { WheelUnit::Counts } else { WheelUnit::Radians };
        let wheels = WheelLog { t_s, turned, unit, ..WheelLog::default() };
        let _ = understand(wheels, &PoseLog { poses, ..PoseLog::default() }, &hints, false);
    }
}
