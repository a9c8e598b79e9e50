use super::*;
use crate::campaign::Campaign;
use crate::sides::Sides;
use crate::synthetic::{ALONE, ROBOT, campaign, end_poses_only, full_plan, term};

/// What is said of a campaign that another robot drove than `robot` and `change` say.
fn said(robot: &Robot, ends_only: bool, change: impl Fn(&mut Recording)) -> Option<Mismatch> {
    let mut campaign = sound(ends_only);
    campaign.runs.iter_mut().for_each(change);
    mismatch(robot, &campaign.runs)
}

fn sound(ends_only: bool) -> Campaign {
    let mut campaign = campaign(&full_plan(), &[], 3);
    if ends_only {
        // The way out alone: out and back leads nowhere.
        for run in campaign.runs.iter_mut().filter(|it| it.name.starts_with("out_and_back")) {
            let middle = run.wheels[run.wheels.len() / 2].t_s;
            run.wheels.retain(|it| it.t_s < middle);
            run.sights.retain(|it| it.t_s < middle);
        }
        return end_poses_only(campaign);
    }
    campaign
}

fn nothing(_: &mut Recording) {}

#[test]
fn a_robot_that_is_merely_wrong_is_none_and_has_no_stray_poses() {
    for ends_only in [false, true] {
        assert_eq!(said(&ROBOT, ends_only, nothing), None);
        let runs = sound(ends_only).runs;
        assert_eq!(strays(&ROBOT, &runs), vec![None; runs.len()]);
        assert_eq!(runs.iter().find_map(|it| beside(&ROBOT, it)), None);
    }
    for (id, values) in ALONE {
        let campaign = campaign(&full_plan(), &[term(id, values)], 3);
        assert_eq!(mismatch(&ROBOT, &campaign.runs), None, "{id}");
        assert_eq!(strays(&ROBOT, &campaign.runs), vec![None; campaign.runs.len()], "{id}");
        assert_eq!(campaign.runs.iter().find_map(|it| beside(&ROBOT, it)), None, "{id}");
    }
    let other = |radius: f64, track: f64| Robot {
        wheel_radius_m: radius * ROBOT.wheel_radius_m,
        track_width_m: track * ROBOT.track_width_m,
        ..ROBOT
    };
    for (radius, track) in [(1.35, 1.0), (0.75, 1.0), (1.0, 1.3), (1.0, 0.75)] {
        assert_eq!(said(&other(radius, track), false, nothing), None, "{radius}, {track}");
    }
}

#[test]
fn a_radius_or_a_count_off_by_a_factor_is_seen() {
    for ends_only in [false, true] {
        for times in [1000.0, 4.0, 2.0, 0.5, 0.25, 0.01] {
            let robot = Robot { wheel_radius_m: ROBOT.wheel_radius_m * times, ..ROBOT };
            let Some(Mismatch::Travel { times: found }) = said(&robot, ends_only, nothing) else {
                panic!("{times}: {:?}", said(&robot, ends_only, nothing));
            };
            assert!((found * times - 1.0).abs() < 0.1, "{times}: {found}");
        }
    }
}

#[test]
fn a_track_width_off_by_a_factor_is_seen() {
    for times in [1000.0, 100.0, 10.0, 2.0, 0.5, 0.3] {
        let robot = Robot { track_width_m: ROBOT.track_width_m * times, ..ROBOT };
        let Some(Mismatch::Turns { times: found }) = said(&robot, false, nothing) else {
            panic!("{times}: {:?}", said(&robot, false, nothing));
        };
        assert!((found / times - 1.0).abs() < 0.1, "{times}: {found}");
    }
}

#[test]
fn exchanged_encoders_and_signs_are_seen() {
    let each = |change: fn(Sides<f64>) -> Sides<f64>| {
        said(&ROBOT, false, |run| {
            run.wheels.iter_mut().for_each(|it| it.phi_rad = change(it.phi_rad));
        })
    };
    let exchanged = each(|it| Sides::new(it.right, it.left));
    assert!(
        matches!(exchanged, Some(Mismatch::Turns { times }) if (times + 1.0).abs() < 0.05),
        "{exchanged:?}"
    );
    assert_eq!(each(|it| Sides::new(-it.left, -it.right)), Some(Mismatch::Backwards));
    // One alone: straight ahead is a spin to the encoders.
    let one = each(|it| Sides::new(-it.left, it.right));
    assert!(matches!(one, Some(Mismatch::Turns { times }) if times.abs() < 0.5), "{one:?}");
}

#[test]
fn a_misread_pose_is_a_stray_one() {
    let near = |it: Option<f64>, off: f64| match it {
        Some(it) => (it - off).abs() < 0.05,
        None => off == 0.0,
    };
    for ends_only in [false, true] {
        for (name, off_m, off_rad) in [
            ("arc", 0.0, 1.57),
            ("out_and_back", 1.0, 0.0),
            ("spin", 0.0, 1.57),
            ("spin", 0.0, -1.57),
        ] {
            let mut runs = sound(ends_only).runs;
            let index = runs.iter().position(|it| it.name.starts_with(name)).unwrap();
            let last = runs[index].sights.last_mut().unwrap();
            last.heading_rad = last.heading_rad.map(|it| it + off_rad);
            last.position_m = last.position_m.map(|[x, y]| [x, y + off_m]);
            let t_s = last.t_s;
            let mut found = strays(&ROBOT, &runs);
            let it = found[index].take().unwrap_or_else(|| panic!("{name}, {ends_only}"));
            assert_eq!(it.t_s, t_s);
            assert!(near(it.position_m, off_m) && near(it.heading_rad, off_rad), "{it:?}");
            assert_eq!(found, vec![None; runs.len()], "{name}, {ends_only}");
        }
    }
}

#[test]
fn poses_on_the_other_side_throughout_are_seen_though_the_run_ends_where_it_began() {
    for run in sound(false).runs.iter().filter(|it| it.name.starts_with("arc")) {
        let mut mirrored = run.clone();
        for sight in &mut mirrored.sights {
            sight.position_m = sight.position_m.map(|[x, y]| [x, -y]);
        }
        assert!(beside(&ROBOT, &mirrored).is_some_and(|it| it > 0.3), "{}", run.name);
    }
}

#[test]
fn a_track_width_that_is_wrong_makes_no_stray_poses_and_hides_none() {
    let robot = Robot { track_width_m: 1.12 * ROBOT.track_width_m, ..ROBOT };
    let mut runs = sound(true).runs;
    assert_eq!(strays(&robot, &runs), vec![None; runs.len()]);
    let index = runs.iter().position(|it| it.name.starts_with("spin")).unwrap();
    let last = runs[index].sights.last_mut().unwrap();
    last.heading_rad = last.heading_rad.map(|it| it + 1.57);
    let found = strays(&robot, &runs);
    assert!(found[index].is_some() && found.iter().flatten().count() == 1, "{found:?}");
}

#[test]
fn what_was_just_read_is_doubted_where_the_wheels_led_elsewhere() {
    let at = |t_s: f64, x_m: f64, heading_rad: Option<f64>| Sight {
        t_s,
        position_m: Some([x_m, 0.0]),
        heading_rad,
    };
    let ahead: Vec<Pose> = (0..=18).map(|k| Pose::new(0.1 * f64::from(k), 0.0, 0.0)).collect();
    let spin: Vec<Pose> = (0..=18).map(|k| Pose::new(0.0, 0.0, 0.7 * f64::from(k))).collect();
    let turned_rad = Some(0.7 * 18.0);
    let start = at(0.0, 0.0, Some(0.0));
    for (wheels, good, bad) in [
        (&ahead, at(9.0, 1.75, Some(0.1)), at(9.0, 1.2, Some(0.1))),
        (&ahead, at(9.0, 1.75, None), at(9.0, 1.75, Some(1.57))),
        (&spin, at(9.0, 0.02, turned_rad), at(9.0, 0.02, turned_rad.map(|it| it + 1.57))),
        (&spin, at(9.0, 0.02, None), at(9.0, 0.3, None)),
    ] {
        assert_eq!(doubtful(&start, &good, wheels), None);
        assert!(doubtful(&start, &bad, wheels).is_some(), "{bad:?}");
    }
}
