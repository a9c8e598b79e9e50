//! The sensitivities S = dx/dp of the filter in [`crate::estimation::ekf`], for all columns at once.
//!
//! A flexible model has hundreds of columns, and in them the filter spends its time. So each number of the state stands
//! beside that of the next column, and the processor takes several columns with each instruction: as many as it can, found
//! out when the program runs. The results are the same, bit for bit: no sum is taken in another order.

use multiversion::multiversion;

use crate::effect::slopes::Slopes;
use crate::estimation::state::{PSI, Reading, STATES, THETA};
use crate::estimation::transition::Transition;

/// One row of numbers for each number of the state, with one number for each column.
pub(crate) struct Sensitivities {
    rows: [Vec<f64>; STATES],
}

impl Sensitivities {
    pub fn new(columns: usize) -> Self {
        Self { rows: core::array::from_fn(|_| vec![0.0; columns]) }
    }

    /// Those of one column at the beginning: the pose depends on the parameter, what else is in the state does not.
    pub fn start(&mut self, column: usize, pose: [f64; 3]) {
        for (state, row) in self.rows.iter_mut().enumerate() {
            row[column] = pose.get(state).copied().unwrap_or(0.0);
        }
    }

    /// Equation (1): a move by a share of an increment with these slopes, while e fades.
    pub fn advance(&mut self, there: &Transition, slopes: &Slopes, share: f64, fade: f64) {
        advance(&mut self.rows, there, slopes, share, fade);
    }

    /// Equations (2) and (3): `row` has dh/dp, and has whitened derivatives afterwards.
    pub fn measure(
        &mut self,
        reading: &Reading<f64>,
        gain: &[f64; STATES],
        weight: f64,
        row: &mut [f64],
    ) {
        measure(&mut self.rows, reading, gain, weight, row);
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn advance(
    rows: &mut [Vec<f64>; STATES],
    there: &Transition,
    slopes: &Slopes,
    share: f64,
    fade: f64,
) {
    let [x, y, theta, fading @ ..] = rows;
    let n = x.len();
    let (y, theta) = (&mut y[..n], &mut theta[..n]);
    let (travel, sideways) = (&slopes.travel_m[..n], &slopes.sideways_m[..n]);
    let (turn, drift_x, drift_y) =
        (&slopes.turn_rad[..n], &slopes.drift_m[0][..n], &slopes.drift_m[1][..n]);
    let ([gx, gy], [cos, sin]) = (there.by_heading, there.ahead);
    let ([x_by_turn, y_by_turn], turn_by_heading) = (there.by_turn, there.turn_by_heading);
    for c in 0..n {
        let ahead = travel[c] * cos - sideways[c] * sin;
        let left = travel[c] * sin + sideways[c] * cos;
        let turned = share * turn[c] + turn_by_heading * theta[c];
        x[c] += gx * theta[c] + x_by_turn * turned + share * (ahead + drift_x[c]);
        y[c] += gy * theta[c] + y_by_turn * turned + share * (left + drift_y[c]);
        theta[c] += turned;
    }
    for row in &mut fading[..PSI - THETA - 1] {
        for error in row.iter_mut() {
            *error *= fade;
        }
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn measure(
    rows: &mut [Vec<f64>; STATES],
    reading: &Reading<f64>,
    gain: &[f64; STATES],
    weight: f64,
    row: &mut [f64],
) {
    let n = row.len();
    let states = rows.each_ref().map(|row| &row[..n]);
    for c in 0..n {
        row[c] += reading.along(|state| states[state][c]);
    }
    for (sensitivity, k) in rows.iter_mut().zip(gain) {
        for (s, j) in sensitivity.iter_mut().zip(row.iter()) {
            *s -= k * j;
        }
    }
    for j in row {
        *j *= weight;
    }
}
