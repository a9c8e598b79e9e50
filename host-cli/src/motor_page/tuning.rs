//! The page of a tuning.

use std::fmt::Write;

use shared_proto::Wheel;

use super::curves::{Curve, figure};
use super::{begin, experiments, section, table};
use crate::escape::html as escape;
use crate::tune::result_tables::{
    ConstantRow, FollowingRow, WHEELS_UP, constants, following, lowered, odd, unsure,
};
use crate::tune::{DriveOutcome, Tuned};

/// The page of a tuning.
pub fn of_tuning(tuned: &Tuned) -> String {
    let robot = tuned.identity.name.as_str();
    let mut html = begin(robot, "motors tuned");
    header(&mut html, tuned, robot);
    section(
        &mut html,
        "Distance from the setpoint",
        "The fast profile forwards: five times the paper's speed, as far as the limits allow. Positive: the wheel is behind. A drive begins ahead, by what the encoder check turned the wheel.",
    );
    errors(&mut html, tuned);
    section(
        &mut html,
        "Before and after",
        "Of the fast drives, and after tuning of a slow one as well.",
    );
    let rows = following(&tuned.before, &tuned.after).into_iter().map(|row| {
        let FollowingRow { name, decimals, before, after } = row;
        let before = before.map_or("fault".into(), |before| format!("{before:.decimals$}"));
        vec![name.to_owned(), before, format!("{after:.decimals$}")]
    });
    table(&mut html, &["", "before", "after"], rows);
    motors(&mut html, tuned);
    section(
        &mut html,
        "The experiments",
        "What the motors were identified from: measured less modelled travel. The measured voltage alone drives the model; where within its first count a wheel began is free. A curve that only jumps from count to count has nothing left to explain.",
    );
    experiments::legend(&mut html);
    for (name, recording) in &tuned.experiments {
        let samples = recording.samples();
        let modelled = tuned.fit.constants.value.travel_m(recording);
        let both = samples.iter().zip(modelled);
        let left_m: Vec<_> = both
            .map(|(sample, modelled)| sample.travel_m.since(samples[0].travel_m).since(modelled))
            .collect();
        experiments::draw(&mut html, name, recording, &left_m, None);
    }
    experiments::end(&mut html);
    let _ = write!(
        html,
        "\n<footer>{:.0} s, {:.2} m of floor. \u{b1}: half a 95 % interval.</footer>\n</body></html>\n",
        tuned.took_s, tuned.floor_used_m
    );
    html
}

fn header(html: &mut String, tuned: &Tuned, robot: &str) {
    let before = match &tuned.before {
        DriveOutcome::Followed(before) => format!("{:.3} mm", before.fast_rms_m * 1e3),
        DriveOutcome::Faulted(fault) => format!("stopped by {fault}"),
    };
    let _ = writeln!(
        html,
        "<p class=\"sub\">{}</p>\n<h1>The wheels follow: <span class=\"before\">{}</span> from their setpoints before, \
         <span class=\"after\">{:.3} mm</span> after</h1>",
        escape(robot),
        escape(&before),
        tuned.after.fast_rms_m * 1e3
    );
    if tuned.wheels_up {
        let _ = writeln!(html, "<p class=\"class\">With the wheels in the air: {WHEELS_UP}</p>");
    }
    for words in lowered(tuned) {
        let _ = writeln!(html, "<p class=\"class\">Lowered: {}.</p>", escape(&words));
    }
}

/// The errors of both wheels over time.
fn errors(html: &mut String, tuned: &Tuned) {
    html.push_str(
        "<p class=\"legend\"><span><i class=\"b\"></i>before</span><span><i class=\"a\"></i>after</span></p>\n<div class=\"pair\">\n",
    );
    let [before, after] = &tuned.traces;
    for (wheel, name) in [(Wheel::Left, "Left wheel"), (Wheel::Right, "Right wheel")] {
        let curves = [("p b", before), ("p a", after)].map(|(class, trace)| Curve {
            class,
            points: trace.iter().map(|s| [s.t_s, 1e3 * s.error_m.get(wheel)]).collect(),
        });
        let caption = if before.is_empty() { "before, it stopped with a fault" } else { "" };
        figure(html, name, caption, "mm", &curves);
    }
    html.push_str("</div>\n");
}

/// Constants and gains.
fn motors(html: &mut String, tuned: &Tuned) {
    let (fit, gains) = (&tuned.fit, &tuned.gains);
    section(
        html,
        "The motors",
        "Volts at the motor: V = kS sgn(v) + kV v + kA a, with the speed v and the acceleration a of the wheel's travel.",
    );
    let rows = constants(&fit.constants).into_iter().map(|row| {
        let ConstantRow { name, decimals, wheels } = row;
        let cells =
            wheels.map(|(value, off)| format!("{value:.decimals$} \u{b1} {off:.decimals$}"));
        std::iter::once(name.to_owned()).chain(cells).collect()
    });
    table(html, &["", "left", "right"], rows);
    let _ = writeln!(
        html,
        "<p class=\"note\">The effect comes {:.1} ms after the voltage. Travel is explained to {:.2} mm.</p>",
        fit.constants.value.delay_s * 1e3,
        fit.residual_m * 1e3
    );
    if let Some(words) = odd(&fit.constants, tuned.wheels_up) {
        let _ = writeln!(html, "<p class=\"class\">Odd: {}</p>", escape(words));
    }
    for words in unsure(&fit.constants) {
        let _ = writeln!(html, "<p class=\"class\">Unsure: {}.</p>", escape(&words));
    }
    if let Some(push) = fit.constants.load_disturbance() {
        let _ = writeln!(
            html,
            "<p class=\"class\">Pushed: both wheels need {:.2} V less one way than the other. The floor slopes, or a cable pulls.</p>",
            2.0 * push.volts.abs()
        );
    }
    section(
        html,
        "The gains",
        "The stiffest loop whose sensitivity stays at 1.6 with kV and kA 30 % off.",
    );
    let _ = writeln!(
        html,
        "<p>kp {:.0} V/m, ki {:.0} V/(m s), kd {:.2} V s/m. Ms {:.2}, with kV and kA 30 % off {:.2}; phase margin {:.0} degrees at {:.0} rad/s.</p>",
        gains.kp_v_per_m,
        gains.ki_v_per_m_s,
        gains.kd_v_s_per_m,
        gains.ms,
        gains.ms_worst,
        gains.phase_margin_rad.to_degrees(),
        gains.crossover_rad_s
    );
}
