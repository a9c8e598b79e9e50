//! Headings whose zero differs from run to run, in words.

use robot_model::recording::OdometryNoise;

/// The zero of headings differs if its standard deviation is more than this \[rad\], and more than so many times that of a
/// heading.
const DIFFERS_RAD: f64 = 0.01;
const DIFFERS_SIGMAS: f64 = 3.0;

/// That headings have another zero in each run, if they have.
pub fn heading_zeros(noise: &OdometryNoise) -> Option<String> {
    let sigma_rad = noise.heading_offset_rad;
    let differs = sigma_rad > DIFFERS_RAD && sigma_rad > DIFFERS_SIGMAS * noise.heading_sigma_rad;
    differs.then(|| {
        format!(
            "Headings: their zero differs by {:.0} mrad (standard deviation) from run to run, as if it were set anew at each \
             start. The model does not blame the robot for it, but whatever is predicted from a run's first heading errs by \
             as much: take headings against one direction of the room.",
            1e3 * sigma_rad
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_zero_that_differs_by_more_than_headings_do_is_told() {
        let of = |sigma_rad: f64, heading_sigma_rad: f64| {
            let noise = OdometryNoise {
                heading_offset_rad: sigma_rad,
                heading_sigma_rad,
                ..OdometryNoise::TYPICAL
            };
            heading_zeros(&noise)
        };
        assert_eq!(of(0.004, 0.001), None);
        assert_eq!(of(0.03, 0.02), None);
        assert!(of(0.03, 0.005).unwrap().starts_with("Headings: their zero differs by 30 mrad"));
    }
}
