//! Compare, explain, add, and compare again: on real recordings, and on runs of a simulated robot.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::recorded::SPINS_AND_ARCS;
use crate::schema::violation;
use crate::temp_folder::TempFolder;

/// The real recordings of the repository.
fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/optiodom")
}

/// A campaign of those runs whose names contain `part`, in that folder.
fn real_runs(temp: &TempFolder, part: &str) {
    std::fs::create_dir_all(temp.path("robot/runs")).unwrap();
    std::fs::copy(examples().join("robot.toml"), temp.path("robot/robot.toml")).unwrap();
    let mut copied = 0;
    for entry in std::fs::read_dir(examples().join("runs")).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_name().unwrap().to_str().unwrap();
        if name.contains(part) {
            std::fs::copy(&file, temp.path(&format!("robot/runs/{name}"))).unwrap();
            copied += 1;
        }
    }
    assert!(copied > 2, "{part}: {copied}");
}

/// A small campaign of the simulator's robot of one seed.
fn simulated_runs(temp: &TempFolder) {
    for motion in
        ["straight 5rev", "straight -5rev", "spin 360deg", "spin -360deg", "arc 50cm 180deg"]
    {
        temp.run(&format!("record robot {motion} --seed 3 --rate 50")).ok();
    }
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {value:#}"))
}

#[test]
fn the_error_of_real_squares_falls_when_what_is_missing_is_added() {
    let temp = TempFolder::new();
    real_runs(&temp, "square");
    let compared = temp.run("compare robot").ok().stdout;
    for words in [
        "The nominal robot is off by",
        "Where the error arises",
        "run kind",
        "turn direction",
        "all 6 runs",
    ] {
        assert!(compared.contains(words), "{words}: {compared}");
    }
    let before =
        number(&temp.run("compare robot --json").ok().json(), "/comparison/position_m/rms");
    let added = temp.run("model add wheel_radius_scale track_width robot").ok().stdout;
    assert!(added.contains("cross-validated") && added.contains("    significant: p"), "{added}");
    let compared = temp.run("compare robot --format json").ok().json();
    assert_eq!(compared["model"], serde_json::json!(["wheel_radius_scale", "track_width"]));
    let after = number(&compared, "/comparison/position_m/rms");
    // Least squares over all 16 squares: 19.8 mm and 5.1 mm.
    assert!(before > 0.012 && after < 0.6 * before, "{before} {after}");
    assert!((number(&compared, "/nominal/position_m/rms") - before).abs() < 1e-12);
    let shown = temp.run("model show robot").ok().stdout;
    assert!(shown.contains("track_width") && shown.contains("cross-validated"), "{shown}");
    let removed = temp.run("model remove track_width robot --json").ok().json();
    assert_eq!(removed["effects"].as_array().unwrap().len(), 1);
    assert!(
        number(&removed, "/after/heldout/chi") >= number(&removed, "/before/heldout/chi") * 0.9
    );
}

/// Before the runs of [`SPINS_AND_ARCS`].
const OUT_AND_BACK: &str = "\
acceleration_mps2 = 0.3
[[run]]
name = \"out_and_back\"
pieces = [{ straight_m = 1, speed_mps = 0.2 }, { straight_m = -1, speed_mps = 0.2 }]
";

/// After them: two spins that are held out.
const KEPT_ASIDE: &str = "\
[[run]]
name = \"aside_left\"
held_out = true
pieces = [{ spin_deg = 360, speed_mps = 0.12 }]
[[run]]
name = \"aside_right\"
held_out = true
pieces = [{ spin_deg = -360, speed_mps = 0.12 }]
";

#[test]
fn runs_that_a_plan_holds_out_are_reported_by_themselves_everywhere() {
    let temp = TempFolder::new();
    temp.write("plan.toml", &[OUT_AND_BACK, SPINS_AND_ARCS, KEPT_ASIDE].concat());
    temp.write("wide.toml", "name = \"wide\"\n[plant]\ngeometry.track_width_m = 0.37572\n");
    temp.run("campaign record robot --plan plan.toml --port sim:wide.toml").ok();
    let toml = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
    assert_eq!(toml.matches("held_out = true").count(), 2, "{toml}");

    let explained = temp.run("explain robot").ok().stdout;
    let line = explained.lines().find(|line| line.contains("on the 2 held-out runs (spin)"));
    let line = line.unwrap_or_else(|| panic!("{explained}"));
    // 1 % of a turn is 63 mrad; twice that at the end, a third of it in root mean square.
    let mrad: Vec<f64> =
        line.split(" mrad").filter_map(|text| text.rsplit(' ').next()?.parse().ok()).collect();
    assert!(mrad.len() == 2 && mrad[0] > 5.0 && mrad[1] < 0.5 * mrad[0], "{line}");
    let json = temp.run("explain robot --format json").ok().json();
    assert_eq!(violation(&json), None);

    let compared = temp.run("compare robot").ok().stdout;
    for words in ["06_aside_left", "spin, held out", "all other 5 runs", "held out, 2 runs"] {
        assert!(compared.contains(words), "{words}: {compared}");
    }
    let added = temp.run("model add track_width robot").ok().stdout;
    assert!(added.contains("on held-out runs"), "{added}");
    let model = String::from_utf8(temp.read("robot/model.toml")).unwrap();
    assert!(model.contains("runs = 5"), "{model}");
    temp.run("report robot -o report.html").ok();
    let page = String::from_utf8(temp.read("report.html")).unwrap();
    assert!(page.contains("On the 2 held-out runs (spin), used neither to fit nor to select"));

    // A run that is recorded to tell effects apart is fitted to.
    let more =
        ["campaign", "record", "robot", "--run", "square both ways", "--port", "sim:wide.toml"];
    temp.run_with(&more, "").ok();
    let toml = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
    assert_eq!(toml.matches("held_out = true").count(), 2, "{toml}");
    assert!(toml.contains("square_both_ways"), "{toml}");
    let all = toml
        .replace("\nheld_out = true\n", "\n")
        .replace("[[run]]\n", "[[run]]\nheld_out = true\n");
    temp.write("robot/robot.toml", &all);
    for command in ["compare robot", "explain robot", "model fit robot", "report robot -o a.html"] {
        let message = temp.run(command).refused();
        assert!(message.contains("all 9 runs are held out"), "{command}: {message}");
    }
}

#[test]
fn explain_says_what_it_says_in_the_shape_of_its_schema() {
    let temp = TempFolder::new();
    simulated_runs(&temp);
    let outcome = temp.run("explain robot --format json --exit-code");
    let answer = outcome.json();
    assert_eq!(violation(&answer), None);
    let missing = !answer["steps"].as_array().unwrap().is_empty()
        || answer["unexplained"]["structure"] == true;
    assert_eq!(outcome.code, Some(i32::from(missing)));
    // The schema refuses what is not in it.
    let mut wrong = answer.clone();
    wrong["baseline"]["train"]["chi"] = "one".into();
    assert!(violation(&wrong).is_some());
    // Without --exit-code, an answer is a success; and the same runs give the same answer.
    let again = temp.run("explain robot --json").ok().json();
    assert_eq!(again, answer);
    let text = temp.run("explain robot").ok().stdout;
    assert!(
        text.contains("cross-validated error") && text.contains("Considered and rejected"),
        "{text}"
    );
    if let Some(kind) = answer["next_run"]["kind"].as_str() {
        assert!(
            text.contains("beeline campaign record robot --run ") && text.contains(kind),
            "{text}"
        );
    }
    for step in answer["steps"].as_array().unwrap() {
        assert!(text.contains(step["effect"].as_str().unwrap()), "{text}");
    }
}

#[test]
fn an_effect_of_ones_own_is_added_fitted_and_kept() {
    let temp = TempFolder::new();
    real_runs(&temp, "circular");
    let equation = "dn = -k * v * omega";
    let arguments = [
        "model", "add", "--custom", equation, "--name", "slip", "--unit", "k=s", "robot", "--json",
    ];
    let added = temp.run_with(&arguments, "").ok().json();
    assert_eq!(added["effects"][0]["effect"], "slip");
    assert!(number(&added, "/after/train/chi") <= number(&added, "/before/train/chi") * 1.05);
    let text = String::from_utf8(temp.read("robot/model.toml")).unwrap();
    for line in [
        "[[custom]]",
        "target = \"dn\"",
        "per = \"second\"",
        "expression = \"-k * v * omega\"",
        "unit.k = \"s\"",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let own = number(&added, "/effects/0/parameters/0/value");
    // Neither the name nor the author of an effect makes a difference to its fit.
    let built_in = temp.run("model add side_slip robot --model other.toml --json").ok().json();
    let other = number(&built_in, "/effects/0/parameters/0/value");
    let sigma = number(&built_in, "/effects/0/parameters/0/sigma");
    assert!((own - other).abs() < sigma, "{own} {other} {sigma}");
    temp.run("model remove slip robot").ok();
    assert!(!String::from_utf8(temp.read("robot/model.toml")).unwrap().contains("slip"));
}

#[test]
fn the_report_is_one_page_that_needs_nothing_else() {
    let temp = TempFolder::new();
    simulated_runs(&temp);
    temp.run("report robot -o page.html").ok();
    let page = String::from_utf8(temp.read("page.html")).unwrap();
    for foreign in ["http", "<script", "src=", "@import", "url(", "<link", "NaN"] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    for words in [
        "prefers-color-scheme:dark",
        "@media print",
        "The error, effect by effect",
        "Measured and predicted",
        "times noise",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let message = temp.run("report robot -o nowhere/page.html").refused();
    assert!(message.contains("cannot write nowhere/page.html"), "{message}");
}

#[test]
fn bad_input_is_one_error_with_its_place_and_a_hint() {
    let temp = TempFolder::new();
    temp.write("t.csv", "t_s,left_counts,right_counts,x_m,y_m,heading_rad\n0,0,0,0,0,0\n1,9,9,0.01,0,0\n2,18,18,0.02,0,0\n");
    std::fs::create_dir_all(temp.path("robot/runs")).unwrap();
    temp.write(
        "robot/robot.toml",
        "name = \"r\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.372\ncounts_per_rev = 900\n",
    );
    for command in ["compare", "explain", "report", "model fit"] {
        let message = temp.run(&format!("{command} nowhere")).refused();
        assert!(message.contains("robot.toml: there is no such file"), "{command}: {message}");
        let message = temp.run(&format!("{command} robot")).refused();
        assert!(message.contains("this campaign has no runs"), "{command}: {message}");
    }
    std::fs::copy(temp.path("t.csv"), temp.path("robot/runs/01_a.csv")).unwrap();
    for (arguments, expected) in [
        (&["model", "fit", "robot"][..], "the model has no effects to fit"),
        (&["model", "add", "robot"], "name an effect"),
        (&["model", "add", "slip", "robot"], "did you mean side_slip?"),
        (&["model", "remove", "scrub", "robot"], "scrub is not in the model"),
        (&["model", "add", "--custom", "dtheta = k * omga", "robot"], "column 14: `omga`"),
        (
            &["model", "add", "--custom", "dtheta = k * omga", "robot"],
            "\n    dtheta = k * omga\n                 ^^^^",
        ),
        (&["model", "add", "--custom", "dtheta = k * (v + omega)", "robot"], "different units"),
        (
            &["model", "add", "--custom", "dtheta = k * v", "--unit", "k=s", "robot"],
            "dtheta per second has the unit 1/s",
        ),
        (&["model", "add", "--custom", "dtheta = k * v", "--unit", "k", "robot"], "NAME=UNIT"),
    ] {
        let message = temp.run_with(arguments, "").refused();
        assert!(message.contains(expected), "{arguments:?}: {message}");
    }
    temp.write("robot/model.toml", "[[effect]]\nid = \"scrub\"\n");
    let message = temp.run("compare robot").refused();
    assert!(
        message.contains("scrub has no values yet") && message.contains("beeline model fit robot"),
        "{message}"
    );
    temp.write("robot/model.toml", "[[effect]]\nid = \"scrab\"\n");
    let message = temp.run("explain robot").refused();
    assert!(
        message.contains("model.toml, line 2, column 6: there is no effect `scrab`"),
        "{message}"
    );
    assert_eq!(temp.listing(), ["robot", "t.csv"]);
}

#[test]
fn an_expression_that_overflows_is_refused_and_nothing_is_written() {
    let temp = TempFolder::new();
    simulated_runs(&temp);
    let wild = ["model", "add", "--custom", "dtheta = k * exp(v/0.0001[m/s])", "robot"];
    let message = temp.run_with(&wild, "").refused();
    assert!(
        message.contains(
            "with custom_dtheta the prediction is not finite on these runs; nothing was written"
        ),
        "{message}"
    );
    assert!(!temp.path("robot/model.toml").exists());
}

#[test]
fn what_is_no_campaign_is_refused_by_its_name_and_one_run_is_said_to_prove_little() {
    let temp = TempFolder::new();
    simulated_runs(&temp);
    for (arguments, expected) in [
        ("compare robot/robot.toml", "robot/robot.toml: this is a file, not a campaign"),
        ("model show nowhere", "nowhere does not exist"),
        ("model remove scrub robot", "scrub is not in the model"),
        ("apply nowhere --yes", "nowhere/robot.toml: there is no such file"),
        ("report robot/runs -o page.html", "robot/runs/robot.toml: there is no such file"),
    ] {
        let message = temp.run(arguments).refused();
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    assert_eq!(temp.listing(), ["robot"]);
    for run in ["02_straight", "03_spin", "04_spin", "05_arc"] {
        std::fs::remove_file(temp.path(&format!("robot/runs/{run}.csv"))).unwrap();
    }
    let outcome = temp.run("explain robot").ok();
    assert!(outcome.stderr.contains("only one run"), "{outcome:#?}");
    let compared = temp.run("compare robot").ok().stdout;
    assert!(compared.contains("all 1 run "), "{compared}");
    temp.run("model add wheel_radius_ratio robot").ok();
    let twice = temp.run("model add wheel_radius_ratio robot").refused();
    assert!(twice.contains("wheel_radius_ratio is in the model already"), "{twice}");
}
