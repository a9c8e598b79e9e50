//! How large are the errors of a model, as a user sees them? Predicted against measured tracks, from the best start,
//! on the runs fitted to and cross-validated.

use serde::{Deserialize, Serialize};

use nalgebra::DVector;

use crate::effect::composition::{PlacedTerm, Term};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::fit::moved_within_range;
use crate::estimation::left_out::LeftOut;
use crate::estimation::normal_equations::Sums;
use crate::estimation::predict::{PoseError, PredictedTrack, open_loop_as_seen};
use crate::numeric::parallel;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::odometry_noise::OdometryNoise;

/// Errors on the runs fitted to, and cross-validated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorPair {
    /// Fitted to all runs.
    pub fitted: Errors,
    /// Each run predicted by a fit to all others.
    pub cross_validated: Errors,
}

/// How far predicted and measured tracks lie apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Root of the mean squared distance, from the best start \[m\].
    pub position_rms_m: f64,
    /// Root of the mean squared heading error \[rad\].
    pub heading_rms_rad: f64,
    /// Root of the mean squared whitened residual; 1 is noise.
    pub chi: f64,
}

/// Errors of position and heading as one number: the displacement of the wheels' contact points \[m\].
pub(crate) fn displacement_m(errors: &Errors, track_width_m: f64) -> f64 {
    errors.position_rms_m.hypot(errors.heading_rms_rad * track_width_m / 2.0)
}

/// The lower of two reachable errors, as displacements of the wheels.
pub(crate) fn lower(one: &Errors, other: &Errors, track_width_m: f64) -> Errors {
    let lower = displacement_m(other, track_width_m) < displacement_m(one, track_width_m);
    if lower { *other } else { *one }
}

/// Sums of squares over measurements.
#[derive(Clone, Copy, Debug, Default)]
struct Squares {
    position: f64,
    positions: f64,
    heading: f64,
    headings: f64,
}

/// The track of one run.
fn track(run: &PreparedRun, terms: &[Term<'_>]) -> PredictedTrack {
    open_loop_as_seen(&run.motion, &run.recording.measured_poses, terms)
}

/// The errors of a track, from the best start.
fn track_errors(track: &PredictedTrack, noise: &OdometryNoise) -> Vec<PoseError> {
    let scale_m = noise.position_sigma_m.hypot(noise.position_wobble_m);
    let scale_rad = noise.heading_sigma_rad.hypot(noise.heading_wobble_rad);
    track.errors(scale_m, scale_rad)
}

/// The errors of a run with these terms as they are, from the best start.
pub(crate) fn errors_of_run(
    run: &PreparedRun,
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Vec<PoseError> {
    track_errors(&track(run, terms), noise)
}

/// How far these terms take the runs from where those take them, from the best start: the displacement of the wheels' contact
/// points, root of the mean square \[m\].
pub(crate) fn moves_m(prepared: &Prepared, these: &[Term<'_>], those: &[Term<'_>]) -> f64 {
    let half_track_m = prepared.robot.track_width_m / 2.0;
    let each = parallel::map(&prepared.runs, |run| {
        let (mut track, other) = (track(run, those), track(run, these));
        for (seen, pose) in track.measured.iter_mut().zip(&other.predicted) {
            seen.position_m = Some([pose.x_m, pose.y_m]);
            seen.heading_rad = Some(pose.heading_rad);
        }
        let errors = track.errors(1.0, 1.0 / half_track_m);
        let square = |error: &PoseError| {
            let [ahead_m, left_m] = error.position_m.unwrap_or_default();
            let turned_m = error.heading_rad.unwrap_or_default() * half_track_m;
            ahead_m * ahead_m + left_m * left_m + turned_m * turned_m
        };
        (errors.iter().map(square).sum::<f64>(), errors.len() as f64)
    });
    let (sum, count) = each.iter().fold((0.0, 0.0), |(a, b), (sum, count)| (a + sum, b + count));
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

/// The squared errors of a track.
fn squares(track: &PredictedTrack, noise: &OdometryNoise) -> Squares {
    let mut sum = Squares::default();
    for error in track_errors(track, noise) {
        if let Some([ahead_m, left_m]) = error.position_m {
            sum.position += ahead_m * ahead_m + left_m * left_m;
            sum.positions += 1.0;
        }
        if let Some(heading_rad) = error.heading_rad {
            sum.heading += heading_rad * heading_rad;
            sum.headings += 1.0;
        }
    }
    sum
}

fn sum(each: &[Squares]) -> Squares {
    each.iter().fold(Squares::default(), |a, b| Squares {
        position: a.position + b.position,
        positions: a.positions + b.positions,
        heading: a.heading + b.heading,
        headings: a.headings + b.headings,
    })
}

fn total(each: Vec<Squares>, chi_squared: f64, rows: f64) -> Errors {
    let sum = sum(&each);
    let root_of_mean = |sum: f64, count: f64| if count > 0.0 { (sum / count).sqrt() } else { 0.0 };
    Errors {
        position_rms_m: root_of_mean(sum.position, sum.positions),
        heading_rms_rad: root_of_mean(sum.heading, sum.headings),
        chi: root_of_mean(chi_squared.max(0.0), rows),
    }
}

/// Terms with some columns moved, shapes within the range that the runs can show.
pub(crate) fn moved<'a>(
    prepared: &Prepared,
    terms: &[PlacedTerm<'a>],
    columns: &[usize],
    delta: &DVector<f64>,
) -> Vec<Term<'a>> {
    let step: Vec<f64> = terms
        .iter()
        .flat_map(PlacedTerm::columns)
        .map(|column| {
            let index = columns.iter().position(|moved| *moved == column);
            index.map_or(0.0, |index| delta[index])
        })
        .collect();
    let mut terms: Vec<Term<'a>> = terms.iter().map(PlacedTerm::fixed).collect();
    moved_within_range(prepared, &mut terms, &step);
    terms
}

/// Errors on these runs, with these columns fitted to all of them.
pub(crate) fn errors_on_runs(
    prepared: &Prepared,
    (equations, terms): (&CampaignEquations, &[PlacedTerm<'_>]),
    columns: &[usize],
    noise: &OdometryNoise,
) -> Errors {
    let delta = equations.best(&equations.total, columns);
    let terms = moved(prepared, terms, columns, &delta);
    let each = parallel::map(prepared.recorded(), |run| squares(&track(run, &terms), noise));
    total(each, equations.total.chi_squared(columns, &delta), equations.total.rows)
}

/// Squared errors of tracks, run by run.
#[derive(Clone, Debug)]
pub(crate) struct TrackErrors {
    runs: Vec<Squares>,
}

impl TrackErrors {
    /// Whether these exceed the others by more than a share `tolerance`, in the mean of the ratio of positions and
    /// that of headings.
    pub fn worse_than(&self, other: &Self, tolerance: f64) -> bool {
        let share = |now: f64, then: f64| if then > 0.0 { now / then } else { 1.0 };
        let (now, then) = (sum(&self.runs), sum(&other.runs));
        let place = share(now.position, then.position);
        let heading = share(now.heading, then.heading);
        (place + heading) / 2.0 > 1.0 + tolerance
    }

    /// The mean squared displacement of the wheels' contact points \[m^2\].
    pub fn displacement_m2(&self, track_width_m: f64) -> f64 {
        sum(&self.runs).displacement_m2(track_width_m)
    }

    /// The displacement of the wheels' contact points in each run, root of the mean square \[m\].
    pub fn displacements_m(&self, track_width_m: f64) -> Vec<f64> {
        self.runs.iter().map(|run| run.displacement_m2(track_width_m).sqrt()).collect()
    }
}

impl Squares {
    fn displacement_m2(&self, track_width_m: f64) -> f64 {
        let heading_rad2 = self.heading / self.headings.max(1.0);
        self.position / self.positions.max(1.0) + heading_rad2 * (track_width_m / 2.0).powi(2)
    }
}

/// The squared errors of tracks, each run predicted with these columns fitted to all other runs.
///
/// `None` for a campaign of one run, which leaves nothing to fit to.
pub(crate) fn cross_validated_tracks(
    prepared: &Prepared,
    model: (&CampaignEquations, &[PlacedTerm<'_>]),
    columns: &[usize],
    noise: &OdometryNoise,
) -> Option<TrackErrors> {
    (prepared.runs.len() > 1).then(|| tracks(prepared, model, columns, noise))
}

/// The squared errors of tracks, each run predicted with these columns fitted to all other runs; the only run of a
/// campaign by the fit to itself.
pub(crate) fn tracks(
    prepared: &Prepared,
    model: (&CampaignEquations, &[PlacedTerm<'_>]),
    columns: &[usize],
    noise: &OdometryNoise,
) -> TrackErrors {
    TrackErrors { runs: left_out(prepared, &prepared.runs, model, columns, noise) }
}

/// The squared errors of these tracks of the runs.
fn left_out(
    prepared: &Prepared,
    recorded: &[PreparedRun],
    (equations, terms): (&CampaignEquations, &[PlacedTerm<'_>]),
    columns: &[usize],
    noise: &OdometryNoise,
) -> Vec<Squares> {
    let runs: Vec<usize> = (0..recorded.len()).collect();
    parallel::map(&runs, |index| {
        let run = &recorded[*index];
        let moved_by = |delta: &DVector<f64>| track(run, &moved(prepared, terms, columns, delta));
        let track = match &equations.folds[equations.folds_of(*index)] {
            [fold] if runs.len() > 1 => {
                let LeftOut { by_others, by_block } = equations.left_out(fold, columns);
                match by_block.is_empty() {
                    true => moved_by(&by_others),
                    false => {
                        let blocks: Vec<PredictedTrack> = by_block.iter().map(moved_by).collect();
                        PredictedTrack::block_by_block(&blocks, run.motion.steps.len())
                    }
                }
            }
            // The only run, or one that nothing was measured in.
            _ => moved_by(&equations.best(&equations.total, columns)),
        };
        squares(&track, noise)
    })
}

/// Errors with these columns fitted, for each run, to all others.
///
/// In a campaign of one run, chi is cross-validated over its blocks; the track is that of the fit to the whole run,
/// as a block has no start of its own.
pub(crate) fn cross_validated(
    prepared: &Prepared,
    model: (&CampaignEquations, &[PlacedTerm<'_>]),
    columns: &[usize],
    noise: &OdometryNoise,
) -> Errors {
    let equations = model.0;
    let each = left_out(prepared, prepared.recorded(), model, columns, noise);
    let chi_squared =
        parallel::map(&equations.folds, |fold| equations.chi_squared_left_out(fold, columns));
    total(each, chi_squared.into_iter().sum(), equations.total.rows)
}
