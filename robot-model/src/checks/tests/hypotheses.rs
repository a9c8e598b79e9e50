//! Is what was done to the data told, and nothing else?

use core::f64::consts::{FRAC_PI_2, PI};

use super::mutations::*;
use crate::checks::{Axes, DataFault, DataHypothesis, Wheel, data_hypotheses};
use crate::recording::{Recording, Robot};
use crate::tests::synthetic::{
    ROBOT, campaign, each_alone, end_poses_only, full_plan, sound, term,
};

/// The runs that a mutation shows in are curves, those that go anywhere, those that turn.
#[derive(Clone, Copy, PartialEq)]
enum In {
    Curves,
    Ways,
    Turns,
}

fn heading(degrees: bool, negated: bool, turned_rad: f64) -> DataFault {
    let axes = Axes::Heading { degrees, negated, turned_rad };
    DataFault::Axes { axes, after_first: false }
}

fn axes(axes: Axes) -> DataFault {
    DataFault::Axes { axes, after_first: false }
}

/// What was done, what should be told of it, with headings and without, and a run in which it shows.
fn table() -> Vec<(&'static str, Mutation, DataFault, Option<DataFault>, In)> {
    let mirrored = Some(DataFault::WheelsExchanged);
    let reversed = |wheel| DataFault::CountsReversed { wheel };
    let mm = DataFault::Positions { per_m: 1e3 };
    let cm = DataFault::Positions { per_m: 1e2 };
    vec![
        ("wheels exchanged", exchanged, DataFault::WheelsExchanged, mirrored, In::Curves),
        (
            "left reversed",
            left_reversed,
            reversed(Wheel::Left),
            Some(reversed(Wheel::Left)),
            In::Ways,
        ),
        (
            "right reversed",
            right_reversed,
            reversed(Wheel::Right),
            Some(reversed(Wheel::Right)),
            In::Ways,
        ),
        ("both reversed", both_reversed, reversed(Wheel::Both), mirrored, In::Curves),
        ("y mirrored", y_mirrored, axes(Axes::YMirrored), mirrored, In::Curves),
        ("x mirrored", x_mirrored, axes(Axes::XMirrored), mirrored, In::Curves),
        ("x and y exchanged", axes_exchanged, axes(Axes::Exchanged), mirrored, In::Curves),
        ("heading negated", heading_negated, heading(false, true, 0.0), None, In::Turns),
        ("degrees", degrees, heading(true, false, 0.0), None, In::Turns),
        (
            "degrees of a compass",
            degrees_of_compass,
            heading(true, true, -FRAC_PI_2),
            None,
            In::Curves,
        ),
        ("heading + 90", turned_left, heading(false, false, FRAC_PI_2), None, In::Ways),
        ("heading + 180", turned_round, heading(false, false, PI), None, In::Ways),
        ("heading - 40", turned_askew, heading(false, false, -0.7), None, In::Ways),
        ("compass", compass, heading(false, true, -FRAC_PI_2), None, In::Curves),
        ("millimetres", millimetres, mm, Some(mm), In::Ways),
        ("centimetres", centimetres, cm, Some(cm), In::Ways),
    ]
}

/// Without the angle's sign at half a turn, and to a hundredth.
fn alike(a: &DataFault, b: &DataFault) -> bool {
    match (a, b) {
        (
            DataFault::Axes { axes: Axes::Heading { degrees, negated, turned_rad }, after_first },
            DataFault::Axes {
                axes: Axes::Heading { degrees: d, negated: n, turned_rad: t },
                after_first: f,
            },
        ) => {
            (degrees, negated, after_first) == (d, n, f)
                && crate::numeric::angle::wrap(turned_rad - t).abs() < 0.03
        }
        (a, b) => a == b,
    }
}

fn show(found: &[DataHypothesis]) -> String {
    let each = found.iter().map(|found| {
        format!(
            "{:?} in {:?}, {:.3} -> {:.3}, or {:?}, next {:?}",
            found.what, found.run, found.error_m, found.mended_m, found.or, found.next
        )
    });
    each.collect::<Vec<_>>().join("\n    ")
}

/// A run of the full plan in which it shows.
fn shown_in(runs: &[Recording], shows: In) -> usize {
    let name = match shows {
        In::Curves => "arc_0.9",
        In::Ways => "out_and_back_1",
        In::Turns => "square",
    };
    runs.iter().position(|run| run.name.starts_with(name)).unwrap()
}

#[test]
fn what_is_done_to_all_runs_is_told_of_all_runs() {
    let mut wrong = Vec::new();
    for headings in [true, false] {
        for (name, mutation, with, without, _) in table() {
            let Some(expected) = (if headings { Some(with) } else { without }) else { continue };
            let mut runs = sound().runs.clone();
            runs.iter_mut().for_each(mutation);
            if !headings {
                runs.iter_mut().for_each(without_headings);
            }
            let found = data_hypotheses(&ROBOT, &runs);
            let right = found.first().is_some_and(|first| {
                alike(&first.what, &expected) && first.run.is_none() && found.len() == 1
            });
            if !right {
                wrong.push(format!("{name}, headings {headings}:\n    {}", show(&found)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_done_to_one_run_is_told_of_that_run() {
    let mut wrong = Vec::new();
    for headings in [true, false] {
        for (name, mutation, with, without, shows) in table() {
            let Some(expected) = (if headings { Some(with) } else { without }) else { continue };
            let mut runs = sound().runs.clone();
            let index = shown_in(&runs, shows);
            mutation(&mut runs[index]);
            if !headings {
                runs.iter_mut().for_each(without_headings);
            }
            let found = data_hypotheses(&ROBOT, &runs);
            let right = found.first().is_some_and(|first| {
                let told = alike(&first.what, &expected)
                    || first.or.iter().any(|other| alike(other, &expected));
                told && first.run.as_ref() == Some(&runs[index].name) && found.len() == 1
            });
            if !right {
                wrong.push(format!("{name}, headings {headings}:\n    {}", show(&found)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_happens_in_a_run_is_told_with_its_time() {
    type Is = fn(&DataFault) -> bool;
    let is: [(&str, Mutation, Is); 8] = [
        ("wraps", wraps, |what| {
            matches!(what, DataFault::CounterWraps { wheel: Wheel::Right, bits: 16, .. })
        }),
        ("wraps once", wraps_once, |what| {
            matches!(what, DataFault::CounterWraps { wheel: Wheel::Left, bits: 16, times: 1, .. })
        }),
        ("reset", reset, |what| matches!(what, DataFault::CounterReset { wheel: Wheel::Both, .. })),
        (
            "jump",
            jump,
            |what| matches!(what, DataFault::TrackerJump { by_m, .. } if (0.1..0.14).contains(by_m)),
        ),
        ("frozen", frozen, |what| matches!(what, DataFault::TrackerFrozen { .. })),
        ("counts held", counts_held, |what| matches!(what, DataFault::CountsHeld { .. })),
        ("poses held", poses_held, |what| matches!(what, DataFault::PosesHeld { .. })),
        (
            "half counts",
            half_counts,
            |what| matches!(what, DataFault::Counts { wheel: Wheel::Both, times } if *times == 2.0),
        ),
    ];
    let mut wrong = Vec::new();
    for headings in [true, false] {
        for (name, mutation, right) in is {
            let mut runs = sound().runs.clone();
            let index = shown_in(&runs, In::Curves);
            mutation(&mut runs[index]);
            if !headings {
                runs.iter_mut().for_each(without_headings);
            }
            let found = data_hypotheses(&ROBOT, &runs);
            let told = |found: &DataHypothesis| {
                right(&found.what) && found.run.as_ref() == Some(&runs[index].name)
            };
            if !(found.len() == 1 && told(&found[0])) {
                wrong.push(format!("{name}, headings {headings}:\n    {}", show(&found)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_counter_with_many_bits_steps_by_more_than_half_the_range_of_few_and_wraps_nowhere() {
    let fast = sound().runs.iter().flat_map(|run| run.wheels.windows(2));
    let fast_rad = fast
        .map(|pair| pair[1].phi_rad.since(pair[0].phi_rad))
        .map(|step| step.left.abs().max(step.right.abs()))
        .fold(0.0, f64::max);
    for counts in [34_000.0, 45_000.0, 60_000.0] {
        let robot = Robot { rad_per_count: fast_rad / counts, ..ROBOT };
        let found = data_hypotheses(&robot, &sound().runs);
        assert!(found.is_empty(), "{counts} counts in a step:\n    {}", show(&found));
        // Such a counter that restarts in the middle of a run is told all the same.
        let mut runs = sound().runs.clone();
        let index = shown_in(&runs, In::Curves);
        reset(&mut runs[index]);
        let found = data_hypotheses(&robot, &runs);
        let is_reset = |what: &DataFault| matches!(what, DataFault::CounterReset { .. });
        assert!(found.iter().any(|one| is_reset(&one.what)), "{counts}: {}", show(&found));
    }
}

#[test]
fn outliers_and_late_clocks_are_no_errors() {
    for (name, mutation) in [("glitch", glitch as Mutation), ("late", late)] {
        for all in [false, true] {
            let mut runs = sound().runs.clone();
            let index = shown_in(&runs, In::Curves);
            let chosen = |run: usize| all || run == index;
            (runs.iter_mut().enumerate())
                .filter(|(run, _)| chosen(*run))
                .for_each(|(_, run)| mutation(run));
            let found = data_hypotheses(&ROBOT, &runs);
            assert!(found.is_empty(), "{name}, all {all}:\n    {}", show(&found));
            runs.iter_mut().for_each(without_headings);
            let found = data_hypotheses(&ROBOT, &runs);
            assert!(found.is_empty(), "{name}, all {all}, positions:\n    {}", show(&found));
        }
    }
}

#[test]
fn a_data_sheet_that_is_off_by_a_factor_is_told_and_by_a_quarter_is_not() {
    let mut wrong = Vec::new();
    for (headings, ends) in [(true, false), (false, false), (true, true)] {
        let mut campaign = super::end_pose::sound(ends);
        if !headings {
            campaign.runs.iter_mut().for_each(without_headings);
        }
        let few: &[f64] = &[0.8, 2.0, 0.25];
        let all: &[f64] = &[0.8, 1.25, 2.0, 0.5, PI, 0.25, 0.01];
        for &times in if headings && !ends { all } else { few } {
            let radius = Robot { wheel_radius_m: ROBOT.wheel_radius_m * times, ..ROBOT };
            let track = Robot { track_width_m: ROBOT.track_width_m * times, ..ROBOT };
            for (robot, is_radius) in [(radius, true), (track, false)] {
                let found = data_hypotheses(&robot, &campaign.runs);
                let near = |found: f64| (found * times - 1.0).abs() < 0.1;
                let right = match found.first().map(|found| found.what) {
                    None => (0.7..1.4).contains(&times),
                    Some(DataFault::Radius { times }) => is_radius && near(times),
                    Some(DataFault::Track { times }) => !is_radius && near(times),
                    Some(_) => false,
                };
                if !right || found.len() > 1 {
                    let what = if is_radius { "radius" } else { "track" };
                    wrong.push(format!(
                        "{what} {times}, headings {headings}, ends {ends}:\n    {}",
                        show(&found)
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_robot_that_is_merely_inaccurate_has_data_that_are_in_order() {
    let odd = [
        term("track_width", &[0.12]),
        term("traction_slip", &[0.2]),
        term("caster_kick", &[0.3, 0.06]),
        term("marker_offset", &[0.05, -0.05]),
    ];
    let mut wrong = Vec::new();
    let mut all = vec![("odd", campaign(&full_plan(), &odd, 6))];
    all.extend(each_alone().iter().cloned());
    for (id, campaign) in all {
        let mut positions = campaign.clone();
        positions.runs.iter_mut().for_each(without_headings);
        for (kind, campaign) in [
            ("whole", campaign.clone()),
            ("positions", positions),
            ("ends", end_poses_only(campaign)),
        ] {
            let found = data_hypotheses(&ROBOT, &campaign.runs);
            if !found.is_empty() {
                wrong.push(format!("{id}, {kind}:\n    {}", show(&found)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn left_counts_four_times_are_told() {
    let mut runs = sound().runs.clone();
    runs.iter_mut().for_each(left_four_times);
    let found = data_hypotheses(&ROBOT, &runs);
    let expected = DataFault::Counts { wheel: Wheel::Left, times: 0.25 };
    assert!(found.len() == 1 && found[0].what == expected, "{}", show(&found));
}
