//! Whether the noise that `robot.toml` states can be that of the poses: it may be in another unit.
//!
//! Positions that have an independent error of sigma each differ from the mean of the two beside them by more than a robot's
//! acceleration explains:
//!
//! ```text
//! d = x_1 - 2 x_2 + x_3,   sigma_d = sqrt(6) sigma,   median |d| = 0.6745 sqrt(6) sigma = 1.652 sigma     (1)
//! ```
//!
//! Motion adds to d, so what (1) gives is at least the noise, and the noise itself where no wheel turns. A tracker that is wrong
//! by the same for seconds has less scatter than noise, so only what is far off is an error.

use std::path::Path;

use robot_model::recording::{Recording, Robot};

use super::place::key;
use crate::error::CampaignError;
use crate::range::short;

/// Off by less may be a tracker whose errors last, or a guess.
const FAR: f64 = 30.0;
/// Poses farther apart say nothing of noise \[s\].
const APART_S: f64 = 0.5;
/// Fewer say nothing.
const TRIPLES_MIN: usize = 50;
/// Equation (1).
const MEDIAN_PER_SIGMA: f64 = 1.652;

/// Refuses a stated noise that is far from the scatter of the poses.
pub(super) fn check(folder: &Path, robot: &Robot, runs: &[Recording]) -> Result<(), CampaignError> {
    let (mut position, mut heading) = (Scatter::default(), Scatter::default());
    for run in runs {
        add(run, &mut position, &mut heading);
    }
    for (name, unit, stated, scatter) in [
        ("position_sigma_m", "m", robot.position_sigma_m, position),
        ("heading_sigma_rad", "rad", robot.heading_sigma_rad, heading),
    ] {
        let Some((stated, sigma)) =
            stated.and_then(|stated| Some((stated, scatter.contradicts(stated)?)))
        else {
            continue;
        };
        let problem = format!(
            "{name} = {}, but the poses scatter by {} {unit} from one to the next",
            short(stated),
            short(two_digits(sigma))
        );
        let hint = format!("give one sigma in {unit}, or leave it out: it is estimated then");
        return Err(CampaignError::new(key(folder, name), problem, hint));
    }
    Ok(())
}

/// The sizes of d: of all poses, and of those that were taken while no wheel turned.
#[derive(Default)]
struct Scatter {
    all: Vec<f64>,
    at_rest: Vec<f64>,
}

impl Scatter {
    /// What the noise is, if it is far from what is stated.
    fn contradicts(self, stated: f64) -> Option<f64> {
        let [at_most, at_rest] = [self.all, self.at_rest].map(sigma);
        let too_large = at_most.filter(|sigma| stated > FAR * sigma.max(f64::MIN_POSITIVE));
        let too_small = at_rest.filter(|sigma| *sigma > FAR * stated);
        // Without any scatter there is no noise to be seen: repeated or synthetic poses.
        too_large.or(too_small).filter(|sigma| *sigma > 0.0)
    }
}

/// The noise by equation (1).
fn sigma(mut sizes: Vec<f64>) -> Option<f64> {
    if sizes.len() < TRIPLES_MIN {
        return None;
    }
    let middle = sizes.len() / 2;
    Some(*sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN_PER_SIGMA)
}

fn add(run: &Recording, position: &mut Scatter, heading: &mut Scatter) {
    for three in run.measured_poses.windows(3) {
        let [before, pose, after] = three else { continue };
        if after.t_s - before.t_s > APART_S {
            continue;
        }
        let rests = rests(run, before.t_s, after.t_s);
        let add = |scatter: &mut Scatter, values: [Option<f64>; 3]| {
            if let [Some(a), Some(b), Some(c)] = values {
                let size = (a - 2.0 * b + c).abs();
                scatter.all.push(size);
                if rests {
                    scatter.at_rest.push(size);
                }
            }
        };
        let three = [before, pose, after];
        for axis in [0, 1] {
            add(position, three.map(|pose| pose.position_m.map(|position_m| position_m[axis])));
        }
        let turned = three.map(|pose| pose.heading_rad);
        // Not where the heading goes round.
        if turned.iter().flatten().all(|heading_rad| heading_rad.abs() < 3.0) {
            add(heading, turned);
        }
    }
}

/// Whether no wheel turned from a sample before one time to a sample after another.
fn rests(run: &Recording, from_s: f64, to_s: f64) -> bool {
    let first = run.wheels.partition_point(|sample| sample.t_s < from_s);
    let last = run.wheels.partition_point(|sample| sample.t_s <= to_s);
    match (first.checked_sub(1), run.wheels.get(last)) {
        (Some(first), Some(_)) => {
            let samples = &run.wheels[first..=last];
            samples.iter().all(|sample| sample.phi_rad == samples[0].phi_rad)
        }
        _ => false,
    }
}

fn two_digits(value: f64) -> f64 {
    let scale = 10_f64.powf(1.0 - value.abs().log10().floor());
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::recorded::Campaign;

    /// A robot that rests, drives 1 m and rests, under a camera with a noise of a millimetre and two milliradians.
    fn read(stated: &str) -> Result<(), String> {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("runs")).unwrap();
        let toml =
            "name = \"r\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.372\ncounts_per_rev = 900\n";
        fs::write(folder.path().join("robot.toml"), format!("{toml}{stated}\n")).unwrap();
        let mut state = 7_u64;
        let mut noise = |sigma: f64| {
            // Twelve uniform numbers by Knuth's congruence: nearly normal.
            let uniform = (0..12).map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            });
            sigma * (uniform.sum::<f64>() - 6.0)
        };
        let mut csv = "t_s,left_counts,right_counts,x_m,y_m,heading_rad\n".to_owned();
        for k in 0..500 {
            let t_s = f64::from(k) * 0.03;
            let x_m = (0.1 * (t_s - 2.5)).clamp(0.0, 1.0);
            let counts = (x_m * 900.0 / (std::f64::consts::TAU * 0.036)).round();
            let (x_m, y_m, heading_rad) = (x_m + noise(0.001), noise(0.001), noise(0.002));
            csv += &format!("{t_s:.3},{counts},{counts},{x_m:.5},{y_m:.5},{heading_rad:.5}\n");
        }
        fs::write(folder.path().join("runs/01_a.csv"), csv).unwrap();
        let campaign = Campaign::read(folder.path()).unwrap();
        campaign.to_model(folder.path()).map(drop).map_err(|error| error.to_string())
    }

    #[test]
    fn a_noise_in_another_unit_is_refused_with_its_line_and_the_scatter_of_the_poses() {
        for (stated, expected) in [
            (
                "position_sigma_m = 0.1",
                "line 5, column 1: position_sigma_m = 0.1, but the poses scatter by 0.00",
            ),
            (
                "position_sigma_m = 0.000001",
                "position_sigma_m = 1e-6, but the poses scatter by 0.00",
            ),
            (
                "heading_sigma_rad = 0.1146",
                "line 5, column 1: heading_sigma_rad = 0.1146, but the poses scatter by 0.00",
            ),
            (
                "heading_sigma_rad = 0.00001",
                "heading_sigma_rad = 1e-5, but the poses scatter by 0.00",
            ),
        ] {
            let error = read(stated).unwrap_err();
            assert!(error.contains(expected) && error.contains("; give one sigma in "), "{error}");
        }
    }

    #[test]
    fn a_noise_that_is_right_or_guessed_or_left_out_is_no_error() {
        for stated in [
            "",
            "position_sigma_m = 0.001\nheading_sigma_rad = 0.002",
            "position_sigma_m = 0.01\nheading_sigma_rad = 0.0002",
        ] {
            assert_eq!(read(stated), Ok(()), "{stated}");
        }
    }
}
