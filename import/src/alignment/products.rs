//! How well wheels and poses go together at one lag.

use core::ops::Range;

use super::speeds::Speeds;

/// A lag has to bring together so much of the motion that the poses show.
const OVERLAP_MIN: f64 = 0.3;
/// What motion of the poses without wheels beside it costs, as a misfit of all of it would cost 1.
const ALONE_COSTS: f64 = 0.3;
/// Wheels hardly go, or hardly turn, if that is so small a share of what they do; in squares.
const HARDLY: f64 = 0.003;
/// A robot that turns on the spot moves no further than its track width, whatever its marker does; and one that goes straight turns
/// less than one whose wheels roll round each other \[m\].
const METRES_A_RADIAN: (f64, f64) = (0.02, 1.0);
/// What equation (1) of [`super`] needs at one lag.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Products {
    /// z w, w^2 and z^2, of travel and turn.
    pub(super) both: [f64; 2],
    pub(super) wheels: [f64; 2],
    pub(super) poses: [f64; 2],
}

impl Products {
    /// Of these places of the poses at a shift: place k of the wheels is place k + shift of the poses.
    pub(super) fn of(wheels: &Speeds, poses: &Speeds, places: Range<usize>, shift: i64) -> Self {
        let mut products = Self::default();
        let first = places.start.max(usize::try_from(shift).unwrap_or(0)).min(places.end);
        let beside = usize::try_from(first as i64 - shift).unwrap_or(usize::MAX);
        let beside = &wheels.values[beside.min(wheels.values.len())..];
        for (z, w) in poses.values[first..places.end].iter().zip(beside) {
            for axis in 0..2 {
                if !z[axis].is_nan() && !w[axis].is_nan() {
                    let (z, w) = (f64::from(z[axis]), f64::from(w[axis]));
                    products.both[axis] += z * w;
                    products.wheels[axis] += w * w;
                    products.poses[axis] += z * z;
                }
            }
        }
        products
    }

    /// Adds those of other places.
    pub(super) fn add(&mut self, other: &Self) {
        for axis in 0..2 {
            self.both[axis] += other.both[axis];
            self.wheels[axis] += other.wheels[axis];
            self.poses[axis] += other.poses[axis];
        }
    }

    /// Equation (1), travel and turn weighed alike, as far as the wheels show them; `None` if too little of the poses' motion
    /// overlaps.
    pub(super) fn fit(&self, energies: &[f64; 2], shown: [bool; 2]) -> Option<Fit> {
        let (mut left, mut alone, mut axes) = (0.0, 0.0, 0.0);
        for (axis, energy) in energies.iter().enumerate() {
            // Headings that were not measured, or a robot that never turned.
            if *energy <= 0.0 || !shown[axis] {
                continue;
            }
            if self.poses[axis] < OVERLAP_MIN * energy {
                return None;
            }
            let explained = self.both[axis].powi(2) / self.wheels[axis].max(f64::MIN_POSITIVE);
            left += (self.poses[axis] - explained) / self.poses[axis];
            alone += 1.0 - self.poses[axis] / energy;
            axes += 1.0;
        }
        let fit = || Fit { misfit: left / axes, cost: (left + ALONE_COSTS * alone) / axes };
        (axes > 0.0).then(fit)
    }
}

/// How well a lag fits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    /// Equation (1).
    pub(super) misfit: f64,
    /// The same, and what the motion costs that has no wheels beside it.
    pub(super) cost: f64,
}

pub(super) fn energies(speeds: &Speeds) -> [f64; 2] {
    [0, 1].map(|axis| {
        let known = speeds
            .values
            .iter()
            .map(|value| f64::from(value[axis]))
            .filter(|value| !value.is_nan());
        known.map(|value| value * value).sum()
    })
}

/// Whether travel and turn are shown: of a robot that only goes straight, or only spins, the other is noise. Wheels are compared at
/// their rims, which turn with half of the difference. Poses that go metres a radian, or turn radians in centimetres, do move:
/// these wheels count something else.
pub(super) fn shown(wheels: &Speeds, poses: &Speeds) -> [bool; 2] {
    let [travel, turn] = energies(wheels);
    let rims = [travel, turn / 4.0];
    let [went, turned] = energies(poses);
    let moves =
        [went > METRES_A_RADIAN.1.powi(2) * turned, went < METRES_A_RADIAN.0.powi(2) * turned];
    [0, 1].map(|axis| moves[axis] || rims[axis] > HARDLY * rims[1 - axis])
}
