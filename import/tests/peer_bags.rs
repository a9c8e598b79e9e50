//! Bags that other programs wrote: the Python package `rosbags` 0.11.9, in MCAP with the types of Humble (no compression) and of
//! Jazzy (chunks in zstd), and in SQLite; and SQLite itself, with pages so small that most messages go on elsewhere. All hold
//! the same twenty poses of everything that is read.

use std::path::{Path, PathBuf};

use import::bag::{PosePlace, inventory, poses, wheels};

const STAMP_S: f64 = 1_732_473_042.25;

fn bags() -> [PathBuf; 4] {
    ["humble_plain.mcap", "jazzy_zstd.mcap", "humble_sqlite.db3", "small_pages.db3"]
        .map(|name| Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bags")).join(name))
}

#[test]
fn every_type_is_read_as_it_was_written() {
    let places = [
        PosePlace::Topic("/pose".into()),
        PosePlace::Topic("/amcl".into()),
        PosePlace::Topic("/odom".into()),
        PosePlace::Topic("/vicon".into()),
        PosePlace::Transform {
            topic: "/tf".into(),
            parent: "map".into(),
            child: "odom_frame_longer_name".into(),
        },
    ];
    for bag in bags() {
        let (log, notes) =
            wheels(&[&bag], "/joint_states", ["wheel_left_joint", "wheel_right_joint"]).unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!(log.t_s.len(), 20);
        for (k, (t_s, turned)) in log.t_s.iter().zip(&log.turned).enumerate() {
            let k = k as f64;
            assert!(
                (t_s - STAMP_S - 0.05 * k).abs() < 1e-6,
                "the stamp of the header, not of the recorder"
            );
            assert_eq!(*turned, [0.25 * k, -0.3 * k]);
        }
        for place in &places {
            let (log, notes) = poses(&[&bag], place).unwrap();
            assert!(notes.is_empty(), "{notes:?}");
            assert_eq!(log.poses.len(), 20, "{place}");
            for (k, pose) in log.poses.iter().enumerate() {
                let k = k as f64;
                assert!((pose.t_s - STAMP_S - 0.05 * k).abs() < 1e-6);
                assert_eq!(pose.position_m, [0.1 * k, -0.2 * k, 0.5]);
                let [x, y, z, w] = pose.orientation.unwrap();
                assert!(
                    x == 0.0
                        && y == 0.0
                        && (z - (0.01 * k).sin()).abs() < 1e-15
                        && (w - (0.01 * k).cos()).abs() < 1e-15
                );
            }
        }
    }
}

#[test]
fn a_list_has_all_topics_and_says_which_are_read() {
    for bag in bags() {
        let found = inventory(&bag).unwrap();
        let topics: Vec<(&str, usize, bool)> = found
            .topics
            .iter()
            .map(|(name, topic)| (name.as_str(), topic.messages, topic.kind().is_some()))
            .collect();
        let all = ["/amcl", "/joint_states", "/odom", "/pose", "/tf", "/vicon"];
        assert_eq!(topics, all.map(|name| (name, 20, true)));
        assert_eq!(found.topics["/tf"].transforms.len(), 2);
        assert!(found.topics.values().all(|topic| topic.unread.is_none()), "{found:?}");
    }
}

/// A crash cuts a file off, or leaves messages beside it.
#[test]
fn of_a_bag_in_sqlite_what_is_whole_is_read_and_the_rest_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("crashed.db3");
    let [_, _, whole, _] = bags().map(|bag| std::fs::read(bag).unwrap());
    let said = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        let found = inventory(&file).map_err(|error| error.to_string())?;
        let messages: usize = found.topics.values().map(|topic| topic.messages).sum();
        Ok::<_, String>((
            messages,
            found.notes.into_iter().map(|note| note.text).collect::<Vec<_>>(),
        ))
    };
    assert_eq!(said(&whole), Ok((120, vec![])));
    let (messages, notes) = said(&whole[..whole.len() * 2 / 3]).unwrap();
    assert!((20..100).contains(&messages), "{messages}");
    assert!(notes[0].contains("the bag is cut off at byte 51882"), "{notes:?}");
    // The page above the leaves, the sixth, is not there either: the leaves are.
    let mut headless = whole[..whole.len() * 2 / 3].to_vec();
    headless[5 * 4096] = 0;
    let (messages, notes) = said(&headless).unwrap();
    assert!((20..100).contains(&messages), "{messages}");
    assert!(notes.len() == 1 && notes[0].contains("the bag is cut off"), "{notes:?}");
    // The page of the topics is none.
    let place = whole.windows(14).position(|bytes| bytes == b"/vicongeometry").unwrap();
    let mut corrupt = whole.clone();
    corrupt[place / 4096 * 4096] = 0x77;
    let (messages, notes) = said(&corrupt).unwrap();
    assert_eq!(messages, 0);
    assert!(notes.iter().any(|note| note.contains("120 rows contradict themselves")), "{notes:?}");
    // The first page is none, or is of something else.
    corrupt[100] = 0x77;
    assert!(said(&corrupt).unwrap_err().contains("not a ROS 2 bag"));
    corrupt[16..18].copy_from_slice(&[0, 3]);
    assert!(said(&corrupt).unwrap_err().contains("the head of this SQLite file is corrupt"));
    std::fs::write(folder.path().join("crashed.db3-wal"), b"more").unwrap();
    let (_, notes) = said(&whole).unwrap();
    assert!(notes[0].contains("crashed.db3-wal has messages"), "{notes:?}");
}
