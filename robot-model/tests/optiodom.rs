//! Real recordings: the subset of OptiOdom in examples/optiodom.

use std::path::Path;

use robot_model::effect::{CATALOGUE, Effect, find};
use robot_model::explain::explain;
use robot_model::explain::model::{Model, fit};
use robot_model::kinematics::WheelPair;
use robot_model::recording::Campaign;
use robot_model::recording::{PoseMeasurement, Recording, Robot, WheelSample};

/// As in its robot.toml.
const ROBOT: Robot = Robot {
    wheel_radius_m: 0.042,
    track_width_m: 0.2,
    gear_reduction: 43.7,
    rad_per_count: core::f64::consts::TAU / (64.0 * 43.7),
    position_sigma_m: None,
    heading_sigma_rad: None,
};

/// The runs whose names begin with one of these, separated by commas.
fn campaign(beginning: &str) -> Campaign {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/optiodom/runs");
    let mut files: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let mut runs = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
        if !beginning.split(',').any(|prefix| name.starts_with(prefix)) {
            continue;
        }
        let text = std::fs::read_to_string(&file).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("t_s,left_counts,right_counts,x_m,y_m,heading_rad"));
        let mut run = Recording { name, ..Recording::default() };
        for line in lines {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let t_s = cells[0];
            let phi_rad =
                WheelPair::new(cells[1], cells[2]).map(|counts| counts * ROBOT.rad_per_count);
            run.wheels.push(WheelSample { t_s, phi_rad });
            run.measured_poses.push(PoseMeasurement {
                t_s,
                position_m: Some([cells[3], cells[4]]),
                heading_rad: Some(cells[5]),
            });
        }
        runs.push(run);
    }
    Campaign { robot: ROBOT, runs }
}

/// R_L, R_R, b of a fitted model of three parameters \[m\].
fn geometry(model: &Model) -> [f64; 3] {
    let value = |index: usize| model.effects[index].parameters[0].value;
    let (rho, scale, delta) = (value(0), value(1), value(2));
    let radius_m = ROBOT.wheel_radius_m * (1.0 + scale);
    let width_m = ROBOT.track_width_m * (1.0 + delta);
    [radius_m * (1.0 - rho / 2.0), radius_m * (1.0 + rho / 2.0), width_m]
}

#[test]
fn three_parameters_agree_with_least_squares_fits_of_whole_tracks() {
    let three: Vec<&'static dyn Effect> =
        ["wheel_radius_ratio", "wheel_radius_scale", "track_width"]
            .into_iter()
            .map(|id| find(id).unwrap())
            .collect();
    // Least squares of whole tracks with free start poses, of all runs of each kind in the session; of all kinds with a
    // clock of its own for each run as well, without which 0.3 % are lost. Their errors are those of free start poses alone.
    let cases = [
        ("square", [0.04189, 0.04186, 0.2013], [0.0198, 0.0051]),
        ("circular", [0.04193, 0.04188, 0.2025], [0.0398, 0.0045]),
        ("", [0.04201, 0.04198, 0.2018], [0.0258, 0.0060]),
    ];
    for (kind, reference, [nominal_m, three_m]) in cases {
        let model = fit(&campaign(kind), &three).unwrap();
        for (got, want) in geometry(&model).into_iter().zip(reference) {
            // Innovations weigh short ways more than whole tracks do, and these are a third of the runs.
            assert!((got / want - 1.0).abs() < 0.003, "{kind}: {got} {want}");
        }
        let nominal = fit(&campaign(kind), &[]).unwrap();
        // Kinds disagree about the track width, as the tyres scrub: all together need a fourth number.
        let model = if kind.is_empty() {
            fit(&campaign(kind), &[&three[..], &[find("scrub").unwrap()]].concat()).unwrap()
        } else {
            model
        };
        let errors = [nominal, model].map(|model| model.errors.cross_validated.position_rms_m);
        // Of all runs of the session 19.8, 39.8 and 25.8 mm nominal; these are a third of them.
        assert!((errors[0] / nominal_m - 1.0).abs() < 0.2, "{kind}: {errors:?}");
        // Their best fits leave 5.1, 4.5 and 6.0 mm. Here runs are cross-validated, and a fit to innovations does
        // not make whole tracks least: up to 1.6 times as much, and not far below either.
        assert!((0.7..1.6).contains(&(errors[1] / three_m)), "{kind}: {errors:?}");
    }
}

/// R_L, R_R, b: what a person would calibrate.
const THREE: [&str; 3] = ["wheel_radius_ratio", "wheel_radius_scale", "track_width"];

fn effects<'a>(ids: impl IntoIterator<Item = &'a str>) -> Vec<&'static dyn Effect> {
    ids.into_iter().map(|id| find(id).unwrap()).collect()
}

#[test]
fn what_explain_chooses_is_no_worse_on_unseen_runs_than_three_parameters_and_says_what_is_left() {
    let campaign = campaign("");
    let answer = explain(&campaign).unwrap();
    let last = answer.steps[answer.steps.len() - 1].cross_validated.position_rms_m;
    let three = fit(&campaign, &effects(THREE)).unwrap().errors.cross_validated.position_rms_m;
    for id in THREE {
        let named = answer.steps.iter().any(|step| step.class.iter().any(|member| member == id));
        assert!(named, "{id}: {:?}", answer.steps);
    }
    // Spins and circles disagree about the track width, as the tyres scrub; without that the error is nearly twice as large.
    assert!(answer.steps.iter().any(|step| step.effect == "scrub"), "{:?}", answer.steps);
    assert!(last < 0.65 * three, "{last} against {three}");
    // That is not all.
    assert!(answer.unexplained.structure, "{:?}", answer.unexplained);
    assert!(!answer.unexplained.depends_on.is_empty());
}

#[test]
fn fitted_to_some_kinds_of_run_explain_predicts_the_others_no_worse_than_three_parameters() {
    let kinds = ["square", "circular", "ivanjko"];
    let (mut better, mut sums_m) = (0, [0.0; 2]);
    for (seen, unseen) in [([0], [1, 2]), ([1], [0, 2]), ([2], [0, 1])]
        .into_iter()
        .flat_map(|(one, two)| [(one.to_vec(), two.to_vec()), (two.to_vec(), one.to_vec())])
    {
        let of = |indices: &[usize]| {
            let names: Vec<&str> = indices.iter().map(|index| kinds[*index]).collect();
            campaign(&names.join(","))
        };
        let (fitted, others) = (of(&seen), of(&unseen));
        let answer = explain(&fitted).unwrap();
        let chosen_m = answer.errors_on(&others).unwrap().position_rms_m;
        let three = fit(&fitted, &effects(THREE)).unwrap();
        let three_m = three.errors_on(&others).unwrap().position_rms_m;
        println!("{seen:?} to {unseen:?}: chosen {chosen_m:.4} m, three {three_m:.4} m");
        assert!(chosen_m < 1.02 * three_m, "{seen:?}: {chosen_m} against {three_m}");
        better += usize::from(chosen_m < 0.98 * three_m);
        sums_m = [sums_m[0] + chosen_m, sums_m[1] + three_m];
        // What is not named was refused for a reason, or is fitted along.
        let named: Vec<&String> = answer.steps.iter().flat_map(|step| &step.class).collect();
        for id in CATALOGUE.iter().map(|effect| effect.facts().id) {
            let has = named.iter().any(|name| *name == id)
                || answer.fitted_along.iter().any(|along| along.effect == id)
                || answer.rejected.iter().any(|rejected| rejected.effect == id);
            assert!(has, "{id} without a reason");
        }
    }
    // Circles alone show no spins, and spins no arcs: there nothing tells more than the three numbers do.
    assert!(better >= 3 && sums_m[0] < 0.8 * sums_m[1], "better in {better} of 6: {sums_m:?} m");
}
