//! W_T's uncertainty in words.

use robot_model::calibration::{Action, Advice, CurvatureCause, Source};

/// A source of uncertainty, for a table.
pub const fn source(source: Source) -> &'static str {
    match source {
        Source::Reading => "reading at the end",
        Source::TrackNoise => "noise of the track",
        Source::Wander => "random wander of the robot",
        Source::StartHeading => "alignment at the start",
        Source::TrackWidth => "track width",
        Source::WheelRadius => "wheel radius",
        Source::EncoderQuantisation => "encoder counts",
    }
}

/// What bends the path.
pub const fn out_and_back(verdict: CurvatureCause) -> &'static str {
    match verdict {
        CurvatureCause::Radius => {
            "the curvature flips its sign on reversing: unequal radii, or a caster that hangs to one side"
        }
        CurvatureCause::Pull => {
            "the curvature does not flip its sign on reversing: a pull or a kick on reversing, not a radius"
        }
        CurvatureCause::Both => {
            "the curvature changes on reversing, but not only its sign: unequal radii and a pull"
        }
        CurvatureCause::Neither => "neither unequal radii nor a pull stands out from the noise",
    }
}

/// What would reduce the uncertainty of W_T, and by how much.
pub fn advice(advice: &Advice) -> String {
    format!(
        "{:.0} % of the variance comes from the {}; {}: the sigma of W_T would be {}",
        100.0 * advice.share,
        source(advice.dominating),
        action(advice.action),
        two_digits(advice.sigma_then)
    )
}

/// What to do, an imperative without a full stop.
fn action(action: Action) -> String {
    match action {
        Action::OffsetInsteadOfTangent => {
            "measure the lateral offset at the end instead of the tangent".to_owned()
        }
        Action::OffsetInsteadOfHeading { sigma_m } => format!(
            "measure the lateral offset at the end to {} mm instead of the heading",
            sigma_m * 1e3
        ),
        Action::LongerBase { dx_m } => format!("use a longer base dx, of {dx_m:.2} m"),
        Action::DriveTwiceAsFar => "drive twice as far".to_owned(),
        Action::OffsetHalfWayToo => {
            "read the lateral offset half way as well as at the end, so that the alignment error cancels"
                .to_owned()
        }
        Action::CalibrateOnceMore => "calibrate again, starting from this W_T".to_owned(),
        Action::FourRuns => "drive four such runs and take their mean".to_owned(),
    }
}

/// A sigma with two significant digits, without an exponent where that reads well.
fn two_digits(sigma: f64) -> String {
    let text = format!("{sigma:.1e}");
    match text.rsplit('e').next().and_then(|power| power.parse::<i32>().ok()) {
        Some(power @ -6..=0) => format!("{sigma:.*}", power.unsigned_abs() as usize + 1),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_says_what_to_do_and_what_that_gives() {
        let given = Advice {
            dominating: Source::Reading,
            share: 0.994,
            action: Action::OffsetInsteadOfHeading { sigma_m: 0.0005 },
            sigma_then: 1.4e-4,
        };
        assert_eq!(
            advice(&given),
            "99 % of the variance comes from the reading at the end; measure the lateral offset at the end to 0.5 mm \
             instead of the heading: the sigma of W_T would be 0.00014"
        );
    }
}
