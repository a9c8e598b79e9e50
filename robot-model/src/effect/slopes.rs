//! How do travel and turn of one step depend on every free parameter? All columns at once.
//!
//! A model may have hundreds of columns, and a campaign has ten thousands of steps. So each number stands beside the same
//! number of the next column, and the processor takes several columns with each instruction.

use core::ops::Range;

use multiversion::multiversion;

use crate::effect::definition::Change;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};

/// The derivatives of an increment by each column: those of [`super::composition::Increment`].
pub(crate) struct Slopes {
    pub travel_m: Vec<f64>,
    pub sideways_m: Vec<f64>,
    pub turn_rad: Vec<f64>,
    pub drift_m: [Vec<f64>; 2],
    of_changes: SlopesOfChanges,
}

/// The derivatives of what each term changes, by the columns of that term; and what that term changes by itself.
struct SlopesOfChanges {
    angle_rad: WheelPair<Vec<f64>>,
    travel: WheelPair<Vec<f64>>,
    turning: Vec<f64>,
    turn_rad: Vec<f64>,
    /// One and the term's own change of travel.
    own_travel: WheelPair<Vec<f64>>,
    /// One and the term's own change of the turn.
    own_turning: Vec<f64>,
}

/// What all terms together make of the wheels and the turn in one step.
pub(super) struct WheelsAndTurn {
    /// Derivative of each wheel's travel by its angle \[m\].
    pub by_angle_m: WheelPair<f64>,
    /// Travel of each wheel \[m\].
    pub wheels_m: WheelPair<f64>,
    /// Derivative of the turn by the difference of these \[1/m\].
    pub by_difference: f64,
    /// The turn that comes of these \[rad\].
    pub turn_rad: f64,
}

impl Slopes {
    pub fn new(columns: usize) -> Self {
        let zeros = || vec![0.0; columns];
        Self {
            travel_m: zeros(),
            sideways_m: zeros(),
            turn_rad: zeros(),
            drift_m: [zeros(), zeros()],
            of_changes: SlopesOfChanges::new(columns),
        }
    }

    /// What a term changes, in its columns.
    pub(super) fn set(&mut self, columns: Range<usize>, change: &Change) {
        // Of a known number of columns each copy is an instruction or two.
        match columns.len() {
            0 => {}
            1 => self.set_columns::<1>(columns.start, change),
            2 => self.set_columns::<2>(columns.start, change),
            3 => self.set_columns::<3>(columns.start, change),
            _ => self.set_columns::<PARAMETERS_MAX>(columns.start, change),
        }
    }

    /// What a term of so many parameters changes.
    #[inline(always)]
    fn set_columns<const N: usize>(&mut self, first: usize, change: &Change) {
        let of = &mut self.of_changes;
        let put = |numbers: &mut [f64], by: &Jet| {
            numbers[first..first + N].copy_from_slice(&by.by[..N]);
        };
        put(&mut of.angle_rad.left, &change.angle_rad.left);
        put(&mut of.angle_rad.right, &change.angle_rad.right);
        put(&mut of.travel.left, &change.travel.left);
        put(&mut of.travel.right, &change.travel.right);
        put(&mut of.turning, &change.turning);
        put(&mut of.turn_rad, &change.turn_rad);
        put(&mut self.sideways_m, &change.sideways_m);
        put(&mut self.drift_m[0], &change.drift_m[0]);
        put(&mut self.drift_m[1], &change.drift_m[1]);
        let own = |numbers: &mut [f64], change: &Jet| {
            numbers[first..first + N].fill(1.0 + change.value);
        };
        own(&mut of.own_travel.left, &change.travel.left);
        own(&mut of.own_travel.right, &change.travel.right);
        own(&mut of.own_turning, &change.turning);
    }

    /// What comes of the wheels: travel and turn.
    pub(super) fn combine(&mut self, together: &WheelsAndTurn) {
        wheels_and_turn(&mut self.travel_m, &mut self.turn_rad, &self.of_changes, together);
    }
}

impl SlopesOfChanges {
    fn new(columns: usize) -> Self {
        let zeros = || vec![0.0; columns];
        let ones = || vec![1.0; columns];
        Self {
            angle_rad: WheelPair::new(zeros(), zeros()),
            travel: WheelPair::new(zeros(), zeros()),
            turning: zeros(),
            turn_rad: zeros(),
            own_travel: WheelPair::new(ones(), ones()),
            own_turning: ones(),
        }
    }
}

/// Derivatives of travel and turn by each column.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn wheels_and_turn(
    travel_m: &mut [f64],
    turn_rad: &mut [f64],
    of: &SlopesOfChanges,
    together: &WheelsAndTurn,
) {
    let n = travel_m.len();
    let turn_rad = &mut turn_rad[..n];
    let WheelPair { left: angle_left, right: angle_right } = &of.angle_rad;
    let (angle_left, angle_right) = (&angle_left[..n], &angle_right[..n]);
    let WheelPair { left: travel_left, right: travel_right } = &of.travel;
    let (travel_left, travel_right) = (&travel_left[..n], &travel_right[..n]);
    let WheelPair { left: own_left, right: own_right } = &of.own_travel;
    let (own_left, own_right) = (&own_left[..n], &own_right[..n]);
    let (turning, own_turning, turn) = (&of.turning[..n], &of.own_turning[..n], &of.turn_rad[..n]);
    let WheelsAndTurn { by_angle_m, wheels_m, by_difference, turn_rad: all_rad } = together;
    for c in 0..n {
        let left = by_angle_m.left * angle_left[c] + wheels_m.left / own_left[c] * travel_left[c];
        let right =
            by_angle_m.right * angle_right[c] + wheels_m.right / own_right[c] * travel_right[c];
        travel_m[c] = (left + right) / 2.0;
        turn_rad[c] =
            (right - left) * by_difference + all_rad / own_turning[c] * turning[c] + turn[c];
    }
}
