//! How far do two tracks of one run lie apart, if one of them is moved and turned as a whole to where it fits best?
//!
//! ```text
//! minimise  sum |z_i - t - R(theta) q_i|^2 / s^2 + (alpha_i - theta - beta_i)^2 / h^2   over t and theta          (1)
//! ```
//!
//! z, alpha are measured, q, beta predicted; s and h are the noise of a position and of a heading.

use core::f64::consts::{PI, TAU};

/// x, y, heading \[m, m, rad\].
pub type Pose = [f64; 3];

/// Sum of the squared distances of positions \[m^2\] after (1), and their number.
pub fn squares(measured: &[Pose], predicted: &[Pose], [s_m, h_rad]: [f64; 2]) -> (f64, usize) {
    let n = measured.len().min(predicted.len());
    if n == 0 {
        return (0.0, 0);
    }
    let mean = |track: &[Pose], axis: usize| {
        track[..n].iter().map(|pose| pose[axis]).sum::<f64>() / n as f64
    };
    let middles = [measured, predicted].map(|track| [mean(track, 0), mean(track, 1)]);
    let centred =
        |which: usize, pose: &Pose| [pose[0] - middles[which][0], pose[1] - middles[which][1]];
    let pairs: Vec<([f64; 2], [f64; 2], f64)> = measured
        .iter()
        .zip(predicted)
        .map(|(z, q)| (centred(0, z), centred(1, q), wrap(z[2] - q[2])))
        .collect();
    let (position, heading) = (s_m.powi(-2), h_rad.powi(-2));
    let dot: f64 = pairs.iter().map(|(z, q, _)| z[0] * q[0] + z[1] * q[1]).sum();
    let cross: f64 = pairs.iter().map(|(z, q, _)| z[1] * q[0] - z[0] * q[1]).sum();
    // Turns are small: the differences of headings do not wrap round once more.
    let mut theta = pairs.iter().map(|pair| pair.2).sum::<f64>() / n as f64;
    for _ in 0..20 {
        let (sin, cos) = theta.sin_cos();
        let off: f64 = pairs.iter().map(|pair| theta - pair.2).sum();
        let slope = position * (dot * sin - cross * cos) + heading * off;
        let bend = position * (dot * cos + cross * sin) + heading * n as f64;
        // Towards the minimum even where the curve bends the other way.
        theta -= (slope / bend.abs().max(heading * n as f64)).clamp(-0.5, 0.5);
    }
    let (sin, cos) = theta.sin_cos();
    let square = |(z, q, _): &([f64; 2], [f64; 2], f64)| {
        (z[0] - cos * q[0] + sin * q[1]).powi(2) + (z[1] - sin * q[0] - cos * q[1]).powi(2)
    };
    (pairs.iter().map(square).sum(), n)
}

/// An angle within half a turn.
fn wrap(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moved_and_turned_track_fits_and_a_bent_one_does_not() {
        let track: Vec<Pose> = (0..50).map(|k| [0.04 * f64::from(k), 0.0, 0.0]).collect();
        let moved: Vec<Pose> = track
            .iter()
            .map(|[x, y, _]| [1.0 + 0.8 * x - 0.6 * y, 2.0 + 0.6 * x + 0.8 * y, 0.6_f64.asin()])
            .collect();
        let (sum, n) = squares(&moved, &track, [0.001, 0.002]);
        assert!(n == 50 && sum < 1e-18, "{sum}");
        let bent: Vec<Pose> = track.iter().map(|[x, _, _]| [*x, 0.01 * x * x, 0.02 * x]).collect();
        assert!(squares(&bent, &track, [0.001, 0.002]).0 > 1e-4);
    }
}
