//! The boxes of the wheels: speed and setpoint, following error, duty.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};
use shared_proto::WheelPair;

use super::history::WheelNow;
use super::shown::Shown;

/// A name, a number and its unit.
const NUMBER: usize = 20;

/// Curves reach the top at these, or at what was largest.
const SPEED_MPS: f64 = 0.05;
const ERROR_M: f64 = 0.001;

/// A duty of more than this, and the motor has little left.
const NEARLY_ALL: f64 = 0.9;

pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, shown: &Shown<'_>) {
    let halves = [Constraint::Fill(1), Constraint::Fill(1)];
    let [left, right] = Layout::horizontal(halves).areas(area);
    draw_wheel(frame, left, shown, (" left wheel ", |wheels| wheels.left));
    draw_wheel(frame, right, shown, (" right wheel ", |wheels| wheels.right));
}

type Which = fn(&WheelPair<WheelNow>) -> WheelNow;

fn draw_wheel(
    frame: &mut Frame<'_>,
    area: Rect,
    shown: &Shown<'_>,
    (title, which): (&'static str, Which),
) {
    let block = Block::bordered().title(title);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let Some(sample) = shown.history.now() else {
        frame.render_widget(Paragraph::new(Line::styled("no telemetry yet", shown.dim())), inner);
        return;
    };
    let now = which(&sample.wheels);
    let room = usize::from(inner.width).saturating_sub(NUMBER + 1);
    let curve = |least: f64, of: fn(WheelNow) -> f64| {
        let values = shown.history.largest(room, |wheels| of(which(wheels)).abs());
        sparkline(&values, least)
    };
    let row = |name: &str, number: String, picture: String, style: Style| {
        let picture = Span::styled(format!(" {picture}"), style);
        let width = NUMBER - 9;
        Line::from(vec![Span::raw(format!("{name:<9}{number:>width$}")), picture])
    };
    let good = shown.good();
    let duty = if now.duty.abs() > NEARLY_ALL { shown.bad() } else { good };
    frame.render_widget(
        Paragraph::new(vec![
            row("speed", mm_s(now.speed_mps), curve(SPEED_MPS, |now| now.speed_mps), good),
            row("setpoint", mm_s(now.setpoint_mps), curve(SPEED_MPS, |now| now.setpoint_mps), good),
            row(
                "error",
                format!("{:.2} mm", 1e3 * now.error_m),
                curve(ERROR_M, |now| now.error_m),
                good,
            ),
            row("duty", format!("{:.0} %", 100.0 * now.duty), bar(now.duty, room), duty),
        ]),
        inner,
    );
}

fn mm_s(speed_mps: f64) -> String {
    format!("{:.1} mm/s", 1e3 * speed_mps)
}

/// Sizes over time as blocks of eighths; the highest is the largest of all, or `least`.
fn sparkline(values: &[Option<f64>], least: f64) -> String {
    const BLOCKS: [char; 9] = [
        '\u{2581}', '\u{2581}', '\u{2582}', '\u{2583}', '\u{2584}', '\u{2585}', '\u{2586}',
        '\u{2587}', '\u{2588}',
    ];
    let most = values.iter().flatten().fold(least, |most, value| most.max(*value));
    let block = |value: &Option<f64>| match value {
        None => ' ',
        Some(value) => BLOCKS[((value / most * 8.0).ceil() as usize).min(8)],
    };
    values.iter().map(block).collect()
}

/// A share of -1 to 1 from the middle: backwards to the left.
fn bar(share: f64, room: usize) -> String {
    let half = room / 2;
    let filled = ((share.abs() * half as f64).round() as usize).min(half);
    let (empty, full) = (" ".repeat(half - filled), "\u{2588}".repeat(filled));
    let none = " ".repeat(half);
    match share < 0.0 {
        true => format!("{empty}{full}\u{2502}{none}"),
        false => format!("{none}\u{2502}{full}{empty}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duty_goes_from_the_middle_and_no_further_than_its_box() {
        for (share, room, drawn) in [
            (0.5, 9, "    \u{2502}\u{2588}\u{2588}  "),
            (-1.0, 9, "\u{2588}\u{2588}\u{2588}\u{2588}\u{2502}    "),
            (7.0, 3, " \u{2502}\u{2588}"),
            (1.0, 0, "\u{2502}"),
        ] {
            assert_eq!(bar(share, room), drawn, "{share} {room}");
        }
    }

    #[test]
    fn a_curve_reaches_the_top_at_its_largest_and_is_empty_where_nothing_is_known() {
        assert_eq!(
            sparkline(&[None, Some(0.0), Some(1.0), Some(2.0)], 0.1),
            " \u{2581}\u{2584}\u{2588}"
        );
        assert_eq!(sparkline(&[Some(0.1)], 1.0), "\u{2581}", "noise is no mountain");
    }
}
