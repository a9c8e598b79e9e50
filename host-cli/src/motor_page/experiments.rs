//! The experiments: what is left of travel once the model has had the voltage.

use robot_model::drivetrain::{Drivetrain, VoltageRecording};

use super::curves::{Curve, figure};
use crate::calibration_page::scale::number;

/// Measured less modelled travel of both wheels in each experiment.
pub(super) fn draw<'a>(
    html: &mut String,
    model: &Drivetrain,
    experiments: impl IntoIterator<Item = (&'a str, &'a VoltageRecording)>,
) {
    html.push_str(
        "<p class=\"legend\"><span><i class=\"b\"></i>left wheel</span><span><i class=\"a\"></i>right wheel</span></p>\n<div class=\"grid\">\n",
    );
    for (name, recording) in experiments {
        let samples = recording.samples();
        let (first, last) = (&samples[0], &samples[samples.len() - 1]);
        let left: Vec<_> = samples
            .iter()
            .zip(model.travel_m(recording))
            .map(|(sample, modelled)| sample.travel_m.since(first.travel_m).since(modelled))
            .collect();
        let wheel = |class, off_m: Vec<f64>| {
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
        let (left_curve, left_mm) = wheel("p b", left.iter().map(|both| both.left).collect());
        let (right_curve, right_mm) = wheel("p a", left.iter().map(|both| both.right).collect());
        let way_m = last.travel_m.since(first.travel_m);
        let caption = format!(
            "{}, {} mm; rms {left_mm:.2}, {right_mm:.2} mm",
            number(1e3 * way_m.left, 0),
            number(1e3 * way_m.right, 0)
        );
        figure(html, &name.replace('_', " "), &caption, "mm", &[left_curve, right_curve]);
    }
    html.push_str("</div>\n");
}
