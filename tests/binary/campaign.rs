//! `beeline campaign plan` and `beeline campaign record` on the simulator.

use std::io::Read;

use campaign::Campaign;
use campaign::plan::CampaignPlan;

use crate::outcome::{collect, wait_for};
use crate::temp_folder::TempFolder;

/// Three short runs.
const SHORT: &str = "\
acceleration_mps2 = 0.3
[[run]]
name = \"a\"
pieces = [{ rest_s = 1 }]
[[run]]
name = \"b\"
heading_deg = 90
pieces = [{ straight_m = 0.3, speed_mps = 0.2 }, { straight_m = -0.3, speed_mps = 0.2 }]
[[run]]
name = \"c\"
pieces = [{ arc_deg = -90, radius_m = 0.3, speed_mps = 0.1 }]
";

fn runs(temp: &TempFolder) -> Vec<String> {
    Campaign::read(&temp.path("robot")).unwrap().runs.into_iter().map(|run| run.name).collect()
}

#[test]
fn the_usual_plan_is_shown_with_room_time_and_reason_and_can_be_edited_and_given_back() {
    let temp = TempFolder::new();
    let table = temp.run("campaign plan --floor 2mx2.5m --payload 2kg").ok().stdout;
    for words in ["out_and_back_east", "square_right", "scrub", "21 runs", "minutes of driving"] {
        assert!(table.contains(words), "{words}: {table}");
    }
    temp.run("campaign plan --floor 2mx2.5m --payload 2kg -o plan.toml").ok();
    let text = String::from_utf8(temp.read("plan.toml")).unwrap();
    // The squares are held out.
    assert_eq!(text.matches("held_out = true").count(), 2, "{text}");
    temp.write("plan.toml", &text.replace("rest_s = 5", "rest_s = 7"));
    let edited = CampaignPlan::read(&temp.path("plan.toml")).unwrap();
    assert_eq!(edited.runs.len(), 21);
    let json = temp.run("campaign plan --plan plan.toml --json").ok().json();
    assert_eq!(json["runs"][0]["duration_s"], 7.0);
    let printed = temp.run("campaign plan --floor 2mx2.5m --payload 2kg -o -").ok().stdout;
    assert_eq!(printed, text);
}

#[test]
fn a_campaign_is_recorded_with_times_and_known_noise_and_facing_its_headings() {
    let temp = TempFolder::new();
    temp.write("short.toml", SHORT);
    let json = temp.run("campaign record robot --plan short.toml --json").ok().json();
    assert_eq!(json["recorded"].as_array().unwrap().len(), 3);
    let campaign = Campaign::read(&temp.path("robot")).unwrap();
    // The camera of the simulator.
    assert_eq!(campaign.robot.position_sigma_m, Some(0.001));
    assert_eq!(campaign.robot.heading_sigma_rad, Some(0.002));
    let began: Vec<f64> = campaign.runs.iter().map(|run| run.facts.started_s.unwrap()).collect();
    assert!(began.windows(2).all(|pair| pair[1] > pair[0] + 1.0), "{began:?}");
    let poses = |run: usize| campaign.runs[run].rows.iter().filter_map(|row| row.heading_rad);
    let north = poses(1).next().unwrap();
    // Ten sigma of the camera, put there to half a milliradian.
    assert!((north - std::f64::consts::FRAC_PI_2).abs() < 0.02, "{north}");
    let turned = poses(2).next_back().unwrap() - poses(2).next().unwrap();
    assert!((turned + std::f64::consts::FRAC_PI_2).abs() < 0.05, "{turned}");
}

/// No other test checks the middle of a run: in an old bug only the last piece was recorded.
#[test]
fn a_run_of_several_pieces_is_recorded_whole() {
    let temp = TempFolder::new();
    temp.write("short.toml", SHORT);
    temp.run("campaign record robot --plan short.toml").ok();
    let campaign = Campaign::read(&temp.path("robot")).unwrap();
    let rows = &campaign.runs[1].rows;
    let counts: Vec<f64> = rows.iter().filter_map(|row| row.counts.left).collect();
    let most = counts.iter().copied().fold(f64::MIN, f64::max);
    // 0.3 m out are 1194 counts of 900 a turn of 0.226 m; back again, to a few counts.
    assert!((most - counts[0] - 1194.0).abs() < 10.0, "{} {most}", counts[0]);
    assert!((counts[counts.len() - 1] - counts[0]).abs() < 10.0);
    // 2.2 s a way, a second of rest or so round each, and no hole between them.
    let steps = rows.windows(2).map(|pair| pair[1].t_s - pair[0].t_s);
    assert!(rows[rows.len() - 1].t_s > 4.4, "{}", rows[rows.len() - 1].t_s);
    assert!(steps.fold(0.0, f64::max) < 1.0);
}

#[test]
fn ctrl_c_keeps_the_complete_runs_and_the_same_command_goes_on_to_the_same_files() {
    let temp = TempFolder::new();
    let long = SHORT.replace("rest_s = 1", "rest_s = 200");
    temp.write("plan.toml", &long);
    let arguments = ["campaign", "record", "robot", "--plan", "plan.toml"];
    let mut child = temp.spawn(&arguments);
    let first = temp.path("robot/runs/01_a.csv");
    wait_for("the first run", || first.exists().then_some(()));
    interrupt(child.id());
    let mut stderr = child.stderr.take().unwrap();
    let outcome = collect(child);
    let mut said = String::new();
    stderr.read_to_string(&mut said).unwrap();
    if outcome.code == Some(130) {
        assert!(said.contains("complete and kept"), "{said}");
        assert!(runs(&temp).len() < 3, "{said}");
    } else {
        // The campaign was faster than the signal.
        assert_eq!(outcome.code, Some(0), "{said}");
    }
    let kept = temp.read("robot/runs/01_a.csv");
    let left: Vec<_> = std::fs::read_dir(temp.path("robot/runs")).unwrap().collect();
    assert_eq!(left.len(), runs(&temp).len(), "nothing half-written: {left:?}");

    temp.run("campaign record robot").ok();
    assert_eq!(runs(&temp), ["01_a", "02_b", "03_c"]);
    assert_eq!(temp.read("robot/runs/01_a.csv"), kept);
    let again = temp.run("campaign record robot").ok();
    assert!(again.stdout.contains("complete: it has all 3 runs"), "{again:#?}");
}

#[test]
fn a_fault_ends_the_campaign_with_the_complete_runs_kept_and_nothing_of_the_broken_one() {
    let temp = TempFolder::new();
    temp.write("plan.toml", SHORT);
    temp.write(
        "blocked.toml",
        "name = \"blocked\"\n[[fault]]\nkind = \"wheel_blocked\"\nwheel = \"left\"\nat_motion_s = 1.0\n",
    );
    let message =
        temp.run("campaign record robot --plan plan.toml --port sim:blocked.toml").refused();
    assert!(message.contains("stopped with a fault"), "{message}");
    assert!(message.contains("1 run complete"), "{message}");
    assert_eq!(runs(&temp), ["01_a"]);
    assert_eq!(std::fs::read_dir(temp.path("robot/runs")).unwrap().count(), 1);
    // Repaired.
    let outcome = temp.run("campaign record robot").ok();
    assert!(outcome.stderr.contains("already recorded: 1 run of the plan"), "{outcome:#?}");
    assert_eq!(runs(&temp), ["01_a", "02_b", "03_c"]);
    let campaign = Campaign::read(&temp.path("robot")).unwrap();
    let began: Vec<f64> = campaign.runs.iter().map(|run| run.facts.started_s.unwrap()).collect();
    assert!(began.is_sorted(), "{began:?}");
}

#[test]
fn a_single_kind_of_run_as_explain_suggests_it_is_added_to_a_campaign() {
    let temp = TempFolder::new();
    temp.write("short.toml", SHORT);
    temp.run("campaign record robot --plan short.toml").ok();
    for _ in 0..2 {
        let arguments = ["campaign", "record", "robot", "--run", "arcs both ways"];
        temp.run_with(&arguments, "").ok();
    }
    let names = runs(&temp);
    assert_eq!(
        names[3..],
        ["04_arcs_both_ways", "05_arcs_both_ways_2", "06_arcs_both_ways_3", "07_arcs_both_ways_4"]
    );
    // The campaign's fastest is 0.2 m/s, and a straight is driven at 0.7 of what is fastest: 1.5 m in
    // 11 s. At the usual speed it would be 6 s.
    temp.run("campaign record robot --run straight").ok();
    let last = Campaign::read(&temp.path("robot")).unwrap().runs.pop().unwrap();
    assert_eq!(last.name, "08_straight");
    assert!((10.5..13.0).contains(&last.rows.last().unwrap().t_s), "{:?}", last.rows.last());
    // A run of the plan once more, by the name that `explain` calls it by.
    temp.run("campaign record robot --run 02_b").ok();
    let last = Campaign::read(&temp.path("robot")).unwrap().runs.pop().unwrap();
    assert_eq!(last.name, "09_b_2");
    // The campaign's own plan is as it was, and complete.
    let again = temp.run("campaign record robot").ok();
    assert!(again.stdout.contains("complete: it has all 3 runs"), "{again:#?}");
    let message = temp.run("campaign record robot --run loop").refused();
    assert!(message.contains("arcs of two radii"), "{message}");
}

#[test]
fn what_cannot_be_recorded_is_refused_before_anything_moves() {
    let temp = TempFolder::new();
    temp.write("good.toml", SHORT);
    temp.write("fast.toml", &SHORT.replace("speed_mps = 0.1", "speed_mps = 3"));
    temp.write("bad.toml", &SHORT.replace("rest_s = 1", "rest_s = one"));
    temp.write("worse.toml", &SHORT.replace("radius_m = 0.3, ", ""));
    let spin = "spin_deg = 180000, speed_mps = 0.1";
    temp.write("spin.toml", &SHORT.replace("arc_deg = -90, radius_m = 0.3, speed_mps = 0.1", spin));
    temp.write("file", "");
    for (arguments, expected) in [
        ("campaign record robot --plan bad.toml", "bad.toml, line 4, column 22"),
        (
            "campaign record robot --plan worse.toml",
            "worse.toml, line 11, column 11: an arc needs radius_m",
        ),
        ("campaign record robot --plan none.toml", "none.toml"),
        ("campaign record robot --plan fast.toml", "limits.speed_mps_max"),
        ("campaign record /proc/robot --plan good.toml", "/proc/robot"),
        ("campaign record file --plan good.toml", "file"),
        ("campaign record robot --measure ruler", "more than a ruler"),
        ("campaign record robot --floor 1mx3m", "too small"),
        ("campaign record robot --run arc --floor 1.5mx3m", "`arc` needs a floor of 2 m by 2 m"),
        ("campaign plan --plan spin.toml", "the run c would take"),
        ("campaign record robot --plan spin.toml", "the run c would take"),
        ("campaign plan --floor 1x3m", "unit"),
        ("campaign plan -o /proc/plan.toml", "/proc/plan.toml"),
        ("campaign record robot --measure track:none.csv --yes --plan good.toml", "none.csv"),
    ] {
        let message = temp.run(arguments).refused();
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    assert!(!temp.path("robot/runs").exists() || runs_in(&temp) == 0);
}

fn runs_in(temp: &TempFolder) -> usize {
    std::fs::read_dir(temp.path("robot/runs")).unwrap().count()
}

#[test]
fn another_plan_for_a_campaign_that_has_begun_is_refused() {
    let temp = TempFolder::new();
    temp.write("short.toml", SHORT);
    temp.run("campaign record robot --plan short.toml").ok();
    temp.write("other.toml", &SHORT.replace("rest_s = 1", "rest_s = 2"));
    let message = temp.run("campaign record robot --plan other.toml").refused();
    assert!(message.contains("begun with another plan"), "{message}");
}

#[test]
fn a_person_skips_a_run_names_a_track_for_another_and_has_none_for_the_last() {
    let temp = TempFolder::new();
    temp.write("short.toml", SHORT);
    // What a tracker saw of the robot on its way there and back, on a clock of its own.
    temp.run("campaign record seen --plan short.toml").ok();
    let seen = Campaign::read(&temp.path("seen")).unwrap();
    let mut track = String::from("t_s,x_m,y_m,heading_rad\n");
    for row in seen.runs[1].rows.iter().filter(|row| row.x_m.is_some()) {
        let [x_m, y_m, heading_rad] = [row.x_m, row.y_m, row.heading_rad].map(Option::unwrap);
        track += &format!("{},{x_m},{y_m},{heading_rad}\n", row.t_s + 1234.5);
    }
    temp.write("track.csv", &track);
    let arguments = ["campaign", "record", "robot", "--plan", "short.toml", "--measure", "ask"];
    let outcome = temp.run_with(&arguments, "s\n\nnone.csv\ntrack.csv\n\n\n").ok();
    assert!(outcome.stdout.contains("left out: a"), "{outcome:#?}");
    assert!(outcome.stderr.contains("facing 90 degrees"), "{outcome:#?}");
    assert!(outcome.stderr.contains("1 run without measured poses"), "{outcome:#?}");
    assert_eq!(runs(&temp), ["01_b", "02_c"]);
    // The same robot drove: on the robot's clock its camera and this track agree to milliseconds.
    let campaign = Campaign::read(&temp.path("robot")).unwrap();
    let at = |campaign: &Campaign, run: usize| {
        let rows = campaign.runs[run].rows.iter();
        let seen: Vec<_> = rows.filter_map(|row| Some((row.t_s, row.y_m?))).collect();
        seen.iter().find(|(_, y_m)| *y_m > 0.15).unwrap().0
    };
    // The camera takes thirty pictures a second.
    assert!((at(&campaign, 0) - at(&seen, 1)).abs() < 0.05);
}

#[test]
fn going_on_with_another_simulated_robot_is_warned_of() {
    let temp = TempFolder::new();
    let quiet = |arguments: &str| {
        let said =
            temp.run(&format!("campaign record robot --run straight {arguments}")).ok().stderr;
        !said.contains("the simulated robot of this campaign was")
    };
    assert!(quiet("--seed 3"));
    assert!(quiet("--seed 3"));
    assert!(!quiet("--seed 4"));
}

#[cfg(unix)]
fn interrupt(id: u32) {
    let status = std::process::Command::new("kill").args(["-INT", &id.to_string()]).status();
    assert!(status.unwrap().success());
}
