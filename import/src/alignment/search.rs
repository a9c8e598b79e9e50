//! The lags at which wheels and poses go together best: on a coarse grid every one, on finer ones those near the best.

use core::ops::Range;

use super::products::{Fit, Products, energies, shown};
use super::speeds::Speeds;

/// The coarsest grid has at most so many places: every lag is tried on it.
const COARSE_MAX: usize = 3000;
/// So many lags of the coarsest grid are followed, as a drive that repeats itself has many alike, half of them to the next grid, and
/// at least so many.
const FOLLOWED: (usize, usize) = (64, 6);
/// Clocks differ by at most this share: that of a controller without a crystal.
const DRIFT_MAX: f64 = 0.012;
/// So many places have one shift, whatever the drift.
const CHUNK: usize = 64;

/// A lag, in steps of the grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lag {
    /// In the middle of the poses: place k of the wheels is place k + shift of the poses.
    pub(super) shift: i64,
    /// By how much it grows from one place of the poses to the next.
    pub(super) drift: f64,
}

impl Lag {
    /// The shift of some places of so many.
    fn of(&self, places: &Range<usize>, count: usize) -> i64 {
        let from_middle = (places.start + places.end) as f64 / 2.0 - count as f64 / 2.0;
        self.shift + (self.drift * from_middle).round() as i64
    }

    /// What equation (1) of [`super`] needs at it.
    pub(super) fn products(&self, wheels: &Speeds, poses: &Speeds) -> Products {
        let count = poses.values.len();
        if self.drift == 0.0 {
            return Products::of(wheels, poses, 0..count, self.shift);
        }
        let mut products = Products::default();
        for places in chunks(count) {
            let shift = self.of(&places, count);
            products.add(&Products::of(wheels, poses, places, shift));
        }
        products
    }
}

fn chunks(count: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).step_by(CHUNK).map(move |from| from..(from + CHUNK).min(count))
}

/// The best lags, the best first, each a valley of its own; of clocks that may drift, if this says so.
pub(super) fn lags(wheels: &Speeds, poses: &Speeds, may_drift: bool) -> Vec<(Lag, Fit)> {
    let longest = wheels.values.len().max(poses.values.len());
    let mut by = longest.div_ceil(COARSE_MAX).next_power_of_two();
    let (mut w, mut z) = (wheels.coarser(by), poses.coarser(by));
    let mut followed = FOLLOWED.0;
    let all = if may_drift { all_drifting(&w, &z) } else { all_steady(&w, &z) };
    let mut best = valleys(all, followed);
    while by > 1 {
        by /= 2;
        followed = FOLLOWED.1.max(followed / 2);
        (w, z) = (wheels.coarser(by), poses.coarser(by));
        let drifts = if may_drift { -1..=1 } else { 0..=0 };
        let step = drift_step(&z);
        let near = best.iter().flat_map(|(lag, _)| {
            let drifts = drifts.clone().map(move |steps| lag.drift + f64::from(steps) * step);
            drifts.flat_map(move |drift| {
                (2 * lag.shift - 2..=2 * lag.shift + 2).map(move |shift| Lag { shift, drift })
            })
        });
        let mut near: Vec<Lag> = near.collect();
        near.sort_by(|a, b| a.shift.cmp(&b.shift).then(a.drift.total_cmp(&b.drift)));
        near.dedup();
        let (energies, shown) = (energies(&z), shown(&w, &z));
        let fit = |lag: Lag| Some((lag, lag.products(&w, &z).fit(&energies, shown)?));
        best = valleys(near.into_iter().filter_map(fit).collect(), followed);
    }
    best
}

/// The drift that is one place more at either end than in the middle.
fn drift_step(poses: &Speeds) -> f64 {
    2.0 / poses.values.len().max(2) as f64
}

fn all_shifts(wheels: &Speeds, poses: &Speeds) -> core::ops::RangeInclusive<i64> {
    -(wheels.values.len() as i64)..=poses.values.len() as i64
}

fn all_steady(wheels: &Speeds, poses: &Speeds) -> Vec<(Lag, Fit)> {
    let (energies, shown) = (energies(poses), shown(wheels, poses));
    let lags = all_shifts(wheels, poses).map(|shift| Lag { shift, drift: 0.0 });
    let fit = |lag: Lag| Some((lag, lag.products(wheels, poses).fit(&energies, shown)?));
    lags.filter_map(fit).collect()
}

/// The products of every chunk at every shift are computed once, and added up along each drift.
fn all_drifting(wheels: &Speeds, poses: &Speeds) -> Vec<(Lag, Fit)> {
    let (energies, shown) = (energies(poses), shown(wheels, poses));
    let shifts = all_shifts(wheels, poses);
    let count = poses.values.len();
    let at_all = |places: Range<usize>| -> (Range<usize>, Vec<Products>) {
        let at = |shift| Products::of(wheels, poses, places.clone(), shift);
        let products = shifts.clone().map(at).collect();
        (places, products)
    };
    let table: Vec<(Range<usize>, Vec<Products>)> = chunks(count).map(at_all).collect();
    let step = drift_step(poses);
    let steps = (DRIFT_MAX / step).ceil() as i32;
    let fit = |lag: Lag| {
        let mut sum = Products::default();
        for (places, products) in &table {
            let index = usize::try_from(lag.of(places, count) - shifts.start()).ok();
            if let Some(products) = index.and_then(|index| products.get(index)) {
                sum.add(products);
            }
        }
        Some((lag, sum.fit(&energies, shown)?))
    };
    let drifts = (-steps..=steps).map(|steps| f64::from(steps) * step);
    let lags = drifts.flat_map(|drift| shifts.clone().map(move |shift| Lag { shift, drift }));
    lags.filter_map(fit).collect()
}

/// The best, the best first, each a valley of its own.
fn valleys(mut fits: Vec<(Lag, Fit)>, most: usize) -> Vec<(Lag, Fit)> {
    fits.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let mut best: Vec<(Lag, Fit)> = Vec::new();
    for (lag, fit) in fits {
        if best.len() == most {
            break;
        }
        if best.iter().all(|(other, _)| (other.shift - lag.shift).abs() > 3) {
            best.push((lag, fit));
        }
    }
    best
}
