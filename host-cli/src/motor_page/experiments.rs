//! The experiments: what is left of travel once the model has had the voltage.

use robot_model::drivetrain::VoltageRecording;
use robot_model::kinematics::WheelPair;

use super::curves::{Curve, figure};
use crate::calibration_page::scale::number;

/// Which curve is which, and the beginning of the drawings.
pub(super) fn legend(html: &mut String) {
    html.push_str(
        "<p class=\"legend\"><span><i class=\"b\"></i>left wheel</span><span><i class=\"a\"></i>right wheel</span></p>\n<div class=\"grid\">\n",
    );
}

/// The end of the drawings.
pub(super) fn end(html: &mut String) {
    html.push_str("</div>\n");
}

/// Measured less modelled travel of both wheels in one experiment; `pale_m` is that of another model.
pub(super) fn draw(
    html: &mut String,
    name: &str,
    recording: &VoltageRecording,
    left_m: &[WheelPair<f64>],
    pale_m: Option<&[WheelPair<f64>]>,
) {
    let samples = recording.samples();
    let (first, last) = (&samples[0], &samples[samples.len() - 1]);
    let wheel = |class, left_m: &[WheelPair<f64>], of: fn(&WheelPair<f64>) -> f64| {
        let off_m: Vec<f64> = left_m.iter().map(of).collect();
        let count = off_m.len() as f64;
        // Where within its first count the wheel began is unknown.
        let mean_m = off_m.iter().sum::<f64>() / count;
        let squares: f64 = off_m.iter().map(|off_m| (off_m - mean_m).powi(2)).sum();
        let points = samples.iter().zip(&off_m);
        let points = points
            .map(|(sample, off_m)| [sample.t_s - first.t_s, 1e3 * (off_m - mean_m)])
            .collect();
        (Curve { class, points }, 1e3 * (squares / count).sqrt())
    };
    let (left, left_mm) = wheel("p b", left_m, |both| both.left);
    let (right, right_mm) = wheel("p a", left_m, |both| both.right);
    let mut curves = Vec::new();
    let way_m = last.travel_m.since(first.travel_m);
    let way = [way_m.left, way_m.right].map(|way_m| number(1e3 * way_m, 0)).join(", ");
    let mut caption = format!("{way} mm; rms {left_mm:.2}, {right_mm:.2} mm");
    if let Some(pale_m) = pale_m {
        let (left, left_before_mm) = wheel("p b pale", pale_m, |both| both.left);
        let (right, right_before_mm) = wheel("p a pale", pale_m, |both| both.right);
        curves.extend([left, right]);
        caption = format!(
            "rms {left_before_mm:.2}, {right_before_mm:.2} \u{2192} {left_mm:.2}, {right_mm:.2} mm"
        );
    }
    curves.extend([left, right]);
    figure(html, &name.replace('_', " "), &caption, "mm", &curves);
}
