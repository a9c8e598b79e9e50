//! `beeline tune` on the simulator.

use campaign::Campaign;

use crate::outcome::Outcome;
use crate::temp_folder::TempFolder;

fn gain(temp: &TempFolder, field: &str) -> f64 {
    temp.run(&format!("config get {field} --json --flash flash")).ok().json().as_f64().unwrap()
}

#[test]
fn it_saves_what_drives_better_and_undo_takes_it_back() {
    let temp = TempFolder::new();
    temp.run("config save --flash flash").ok();
    let outcome = temp.run("tune --floor 1m --flash flash").ok();
    assert!(outcome.stdout.contains("kS forwards [V]"), "{outcome:#?}");
    assert!(outcome.stdout.contains("tuned: feedforward and gains saved"), "{outcome:#?}");
    let kv = gain(&temp, "feedforward.left.kv_v_s_per_m");
    assert!((kv - 23.6).abs() < 0.5, "{kv}");
    assert_ne!(gain(&temp, "pid.kp_per_m"), 40.0);

    temp.run("tune --undo --flash flash").ok();
    assert_eq!(gain(&temp, "feedforward.left.kv_v_s_per_m"), 24.0);
    assert_eq!(gain(&temp, "pid.kp_per_m"), 40.0);
    let again = temp.run("tune --undo --flash flash");
    assert_eq!(again.code, Some(2), "{again:#?}");
    assert!(again.stderr.contains("no tuning of this robot to undo"), "{again:#?}");
}

#[test]
fn json_has_the_numbers() {
    let temp = TempFolder::new();
    let tuned = temp.run("tune --json").ok().json();
    let number = |path: &str| tuned.pointer(path).and_then(serde_json::Value::as_f64).unwrap();
    assert!((number("/motors/left/kv_v_s_per_m/value") - 23.6).abs() < 0.5);
    assert!(number("/motors/left/kv_v_s_per_m/half_width_95") > 0.0);
    assert!(number("/gains/ms_worst") <= 1.6);
    assert!(number("/after/fast_rms_m") <= number("/before/fast_rms_m"));
    assert!(number("/floor_used_m") < 1.5);
    assert_eq!(number("/config/feedforward/supply_v"), 12.0);
}

/// Wheels that spin without grip accelerate no robot, straight on as little as on the spot.
#[test]
fn wheels_without_grip_are_told() {
    let temp = TempFolder::new();
    temp.write("ice.toml", "name = \"ice\"\n[plant.floor]\nfriction = 0.0\n");
    let outcome = temp.run("tune --port sim:ice.toml").ok();
    assert!(outcome.stdout.contains("odd: kA is the same"), "{outcome:#?}");
    // With its wheels up that is what they do, and a robot on its floor is odd.
    let outcome = temp.run("tune --wheels-up --port sim:ice.toml").ok();
    assert!(!outcome.stdout.contains("odd:"), "{outcome:#?}");
    assert!(outcome.stdout.contains("wheels in the air"), "{outcome:#?}");
    assert!(outcome.stdout.contains("not done: kA is that of the wheels alone"), "{outcome:#?}");
    let outcome = temp.run("tune").ok();
    assert!(!outcome.stdout.contains("odd:"), "{outcome:#?}");
    let outcome = temp.run("tune --wheels-up -o page.html").ok();
    assert!(outcome.stdout.contains("are both wheels in the air?"), "{outcome:#?}");
    let page = String::from_utf8(temp.read("page.html")).unwrap();
    assert!(page.contains("are both wheels in the air?"));
    assert!(page.contains("With the wheels in the air: kA is that of the wheels alone"));
}

#[test]
fn options_that_make_no_sense_are_refused_before_anything_moves() {
    let temp = TempFolder::new();
    for (arguments, says) in [
        ("tune --floor 10cm", "too little"),
        ("tune --floor 1000m", "more than any robot needs"),
        ("tune --floor 0m", "above zero"),
        ("tune --stiffness 3", "from 0.1 to 1"),
        ("tune --undo", "nothing to undo"),
        ("tune --undo --floor 1m", "cannot be used with"),
        ("tune --wheels-up --floor 1m", "cannot be used with"),
    ] {
        let outcome = temp.run(arguments);
        assert_eq!(outcome.code, Some(2), "{outcome:#?}");
        assert!(outcome.stderr.contains(says), "{arguments}: {}", outcome.stderr);
    }
}

#[test]
fn the_pages_have_the_numbers_of_the_table_and_every_experiment() {
    let temp = TempFolder::new();
    let outcome = temp.run("tune --record motors -o tuning.html").ok();
    let page = String::from_utf8(temp.read("tuning.html")).unwrap();
    let row = outcome.stdout.lines().find(|line| line.starts_with("kV")).unwrap();
    let left = row.split_whitespace().nth(3).unwrap();
    assert!(page.contains(&format!("<td>{left} \u{b1}")), "{left}");
    assert!(page.contains("Distance from the setpoint") && page.contains("Lowered: limits"));
    // Both wheels' distances, and what it identifies from; none of what it only records.
    let figures = page.matches("<figure>").count();
    assert!((10..30).contains(&figures), "{figures}");
    assert!(!page.contains("NaN") && !page.contains("inf"), "a number that is none");

    temp.run("report --drivetrain motors -o motors.html").ok();
    let page = String::from_utf8(temp.read("motors.html")).unwrap();
    let experiments = std::fs::read_dir(temp.path("motors/runs")).unwrap();
    let experiments =
        experiments.flatten().filter(|file| file.path().extension().is_some_and(|of| of == "csv"));
    assert_eq!(page.matches("<figure>").count(), experiments.count());
    assert!(page.contains("Each effect alone"));

    let refused = temp.run("tune -o missing/tuning.html");
    assert_eq!(refused.code, Some(2), "{refused:#?}");
    assert!(refused.stderr.contains("cannot write missing"), "{refused:#?}");
    assert!(!refused.stderr.contains("break-away"), "before anything moves: {refused:#?}");
}

#[test]
fn experiments_that_are_added_to_a_campaign_come_after_those_that_it_has() {
    let temp = TempFolder::new();
    temp.run("tune --record motors").ok();
    let started_s = || {
        let campaign = Campaign::read(&temp.path("motors")).unwrap();
        let runs = campaign.runs.iter();
        let mut all_s: Vec<f64> = runs.map(|run| run.facts.started_s.unwrap()).collect();
        all_s.sort_by(f64::total_cmp);
        all_s
    };
    let first_s = started_s();
    temp.run("tune --record motors").ok();
    let both_s = started_s();
    assert_eq!(both_s[..first_s.len()], first_s, "as they were");
    let pause_s = both_s[first_s.len()] - first_s[first_s.len() - 1];
    assert!(both_s.len() > first_s.len() && pause_s > 60.0, "{pause_s} s");
}

/// Drag that the tuner does not look for.
const DRAG: &str = "\
name = \"drag\"
[plant.motor_defects.left]
drag_nms2 = 6e-4
[plant.motor_defects.right]
drag_nms2 = 6e-4
";

#[test]
fn an_effect_that_motors_hide_is_added_to_their_model_and_the_error_falls() {
    let temp = TempFolder::new();
    temp.write("drag.toml", DRAG);
    temp.run("tune --port sim:drag.toml --record motors").ok();
    let error_m = |outcome: Outcome| outcome.json()["error"]["cross_validated_m"].as_f64().unwrap();
    let before_m = error_m(temp.run("compare --drivetrain motors --json").ok());
    let explained = temp.run("explain --drivetrain motors").ok().stdout;
    assert!(explained.contains("1  quadratic_drag"), "{explained}");
    let added = temp.run("model add quadratic_drag --drivetrain motors").ok().stdout;
    assert!(added.contains("+ quadratic_drag") && added.contains("needed: without it"), "{added}");
    // What `compare` shows from then on is the model with it.
    let after_m = error_m(temp.run("compare --drivetrain motors --json").ok());
    assert!(after_m < 0.3 * before_m, "{before_m} {after_m}");
    let shown = temp.run("model show --drivetrain motors").ok().stdout;
    assert!(shown.contains("q "), "{shown}");

    let written = temp.read("motors/motors.toml");
    for (arguments, says) in [
        ("model add drag --drivetrain motors", "motors have no effect `drag`"),
        ("model add quadratic_drag --drivetrain motors", "quadratic_drag is in the model already"),
        ("model remove cogging --drivetrain motors", "cogging is not in the model of the motors"),
        ("model add --drivetrain motors", "name an effect and a campaign"),
        ("model add heating --drivetrain nowhere", "nowhere"),
        ("model add --drivetrain dV=q*v*abs(v) motors", "an equation goes with --custom"),
    ] {
        let outcome = temp.run(arguments);
        assert_eq!(outcome.code, Some(2), "{outcome:#?}");
        assert!(outcome.stderr.contains(says), "{arguments}: {}", outcome.stderr);
    }
    assert_eq!(temp.read("motors/motors.toml"), written, "nothing was written");
    let removed = temp.run("model remove quadratic_drag --drivetrain motors").ok().stdout;
    assert!(removed.contains("no effects"), "{removed}");
    temp.write("motors/motors.toml", "[[effect]]\nid = \"magic\"\n");
    let outcome = temp.run("compare --drivetrain motors");
    assert!(outcome.stderr.contains("line 2") && outcome.stderr.contains("magic"), "{outcome:#?}");
    temp.write("motors/motors.toml", "");
    an_equation_is_added(&temp, before_m);
}

/// The same drag as an equation of the user's own, and what can be wrong with one.
fn an_equation_is_added(temp: &TempFolder, before_m: f64) {
    let add = |equation: &str, options: &[&str]| {
        let command = ["model", "add", "--drivetrain", "motors", "--custom", equation];
        temp.run_with(&[&command[..], options].concat(), "")
    };
    for (equation, options, says) in [
        ("dV = q * v * volts", &["--unit", "q=V"][..], "dV has the unit V, but the right side"),
        ("dV = q v", &[], "`v` cannot stand here"),
        ("dtheta = q * v", &[], "the left side is dV, dkS, dkV or dkA"),
        ("dV = q / v", &[], "it grows without bound when the robot stands still"),
        ("dV = q * v", &["--per", "metre"], "cannot be used with"),
        ("dV = q * v", &["--range", "p=0..1"], "no --custom has a parameter `p`"),
        ("dV = q * v", &["--name", "backlash"], "`backlash` cannot be the id"),
    ] {
        let outcome = add(equation, options);
        assert_eq!(outcome.code, Some(2), "{outcome:#?}");
        assert!(outcome.stderr.contains(says), "{equation}: {}", outcome.stderr);
    }
    assert_eq!(temp.read("motors/motors.toml"), b"", "nothing was written");
    let drag = ["--name", "my_drag", "--range", "q=0..50", "--json"];
    let added = add("dV = q * v * abs(v)", &drag).ok().json();
    let after_m = added["after"]["cross_validated_m"].as_f64().unwrap();
    assert!(after_m < 0.3 * before_m, "{before_m} {added:#}");
    let effect = &added["effects"][0];
    assert!(effect["effect"] == "my_drag" && effect["needed"] == true, "{added:#}");
    assert_eq!(effect["parameters"][0]["unit"], "V s^2/m^2");
    // The same again, and what kA does already.
    for (equation, options, says) in [
        (
            "dV = 2 * k * v * abs(v)",
            &[][..],
            "custom_dv does what the rest of the model can do already",
        ),
        ("dkA = k", &[], "custom_dka does what the rest"),
        ("dV = k * v * volts", &["--name", "my_drag"], "there is an effect `my_drag` already"),
        ("dV = q * v_left", &[], "`v_left` is no variable here"),
    ] {
        let outcome = add(equation, options);
        assert_eq!(outcome.code, Some(2), "{outcome:#?}");
        assert!(outcome.stderr.contains(says), "{equation}: {}", outcome.stderr);
    }
    // Declared, it is a candidate, and these experiments cannot tell it from the built-in one.
    let explained = temp.run("explain --drivetrain motors --json").ok().json();
    let step = &explained["steps"][0];
    let named = [&step["effect"], &step["class"][0]];
    assert!(named.iter().any(|id| **id == "my_drag"), "{explained:#}");
    assert!(named.iter().any(|id| **id == "quadratic_drag"), "{explained:#}");
    let shown = temp.run("model show --drivetrain motors").ok().stdout;
    assert!(shown.contains("my_drag") && shown.contains("dV = q * v * abs(v)"), "{shown}");
    // No experiment tells an effect from one that does the same.
    let separates = &explained["next"]["separates"];
    assert!(!separates.to_string().contains("my_drag"), "{explained:#}");
    temp.run("report --drivetrain motors -o motors.html").ok();
    let page = String::from_utf8(temp.read("motors.html")).unwrap();
    assert!(page.contains("p b pale") && page.contains("pale, without them"), "both are drawn");
    // Without --drivetrain.
    let outcome = temp.run("explain motors");
    assert!(outcome.stderr.contains("with --drivetrain"), "{outcome:#?}");
    let removed = temp.run("model remove my_drag --drivetrain motors").ok();
    assert!(removed.stderr.contains("dV = q * v * abs(v)"), "to be pasted: {removed:#?}");
    assert!(!String::from_utf8(temp.read("motors/motors.toml")).unwrap().contains("my_drag"));
}
