//! What is on the screen.
//!
//! ```text
//! robot                                     port
//! DRIVING   driven by another host   12.04 V
//! telemetry: 50 a second, 0 lost, 0 late
//! fault, and what to do                            only if there is one
//! left wheel            right wheel
//! path                  what happened              on a narrow screen the path alone
//! keys
//! ```

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Points};
use ratatui::widgets::{Block, Paragraph, Wrap};
use shared_proto::State;

use super::condition::{Condition, Driver};
use super::shown::Shown;
use super::wheels;

/// A narrower screen has no room for what happened beside the path.
const WIDE: u16 = 76;

/// Rows of a box of both wheels, with its frame.
const WHEEL_ROWS: u16 = 6;

/// Longer without a frame, telemetry is late \[s\].
const SILENT_S: f64 = 0.5;

/// Draws everything.
pub fn draw(frame: &mut Frame<'_>, shown: &Shown<'_>) {
    let area = frame.area();
    let fault = fault_lines(shown, area.width);
    let rows = [
        Constraint::Length(3),
        Constraint::Length(fault.len() as u16),
        Constraint::Length(WHEEL_ROWS),
        Constraint::Min(0),
        Constraint::Length(1),
    ];
    let [head, fault_rows, wheel_rows, rest, keys] = Layout::vertical(rows).areas(area);
    frame.render_widget(Paragraph::new(head_lines(shown, area.width)), head);
    frame.render_widget(Paragraph::new(fault), fault_rows);
    wheels::draw(frame, wheel_rows, shown);
    if area.width >= WIDE {
        let columns = [Constraint::Fill(1), Constraint::Length(34)];
        let [path, events] = Layout::horizontal(columns).areas(rest);
        draw_path(frame, path, shown);
        draw_events(frame, events, shown);
    } else {
        draw_path(frame, rest, shown);
    }
    frame.render_widget(Paragraph::new(key_line(shown)), keys);
}

fn head_lines<'a>(shown: &Shown<'a>, width: u16) -> Vec<Line<'a>> {
    let condition = shown.condition;
    let robot = Span::styled(&condition.robot, Style::new().add_modifier(Modifier::BOLD));
    let room = usize::from(width).saturating_sub(robot.width() + 1);
    let port = Span::styled(format!("{:>room$}", condition.port), shown.dim());
    let probing = shown.history.last().is_some_and(|last| last.probing);
    let (state, style) = match condition.state {
        None => ("CONNECTING", shown.dim()),
        Some(_) if probing => ("PROBING: motors checked", shown.attention()),
        Some(State::Faulted) => ("FAULTED: motors off", shown.bad()),
        Some(State::Boot) => ("STARTING", shown.dim()),
        Some(State::Idle) => ("IDLE: motors off", shown.good()),
        Some(State::Armed) => ("ARMED: motors on", shown.attention()),
        Some(State::Driving) => ("DRIVING", shown.attention()),
        Some(State::Stopping) => ("STOPPING", shown.attention()),
    };
    let driver = match condition.driver {
        Driver::Another => "driven by another host",
        Driver::Nobody => "driven by nobody",
    };
    let supply = shown.history.last().map_or_else(
        || "no telemetry yet".to_owned(),
        |last| format!("supply {:.2} V", f64::from(last.supply_mv) * 1e-3),
    );
    vec![
        Line::from(vec![robot, Span::raw(" "), port]),
        Line::from(vec![Span::styled(state, style), Span::raw(format!("  {driver}  {supply}"))]),
        link_line(shown),
    ]
}

fn link_line<'a>(shown: &Shown<'_>) -> Line<'a> {
    let Condition { rate_hz, lost, late, silent_s, .. } = shown.condition;
    if *silent_s > SILENT_S {
        let words = format!("telemetry is late: none for {silent_s:.1} s");
        return Line::styled(words, shown.attention());
    }
    let frames = |count: u64| if count == 1 { "1 frame".into() } else { format!("{count} frames") };
    let words =
        format!("telemetry: {rate_hz:.0} a second, {} lost, {late} came late", frames(*lost));
    Line::styled(words, if *lost > 0 { shown.attention() } else { shown.dim() })
}

fn fault_lines<'a>(shown: &Shown<'_>, width: u16) -> Vec<Line<'a>> {
    let Some((fault, remedy)) = &shown.condition.fault else { return Vec::new() };
    let line = |text: String, style: Style| -> Vec<Line<'a>> {
        let lines = crate::table::wrapped(&text, usize::from(width).max(20));
        lines.into_iter().map(|line| Line::styled(line, style)).collect()
    };
    let clear = "then `beeline clear`";
    let mut lines = line(format!("fault: {fault}"), shown.bad());
    lines.extend(line(format!("what to do: {remedy}; {clear}"), Style::new()));
    lines
}

fn draw_path(frame: &mut Frame<'_>, area: Rect, shown: &Shown<'_>) {
    let Some(last) = shown.history.last().filter(|_| area.height > 3 && area.width > 8) else {
        return;
    };
    let (x_m, y_m) = (last.pose.x_um as f64 * 1e-6, last.pose.y_um as f64 * 1e-6);
    let heading_deg = (last.pose.heading_urad as f64 * 1e-6).to_degrees();
    let title = format!(" path: x {x_m:.3} m  y {y_m:.3} m  heading {heading_deg:.1}\u{b0} ");
    let block = Block::bordered().title(title);
    let inner = block.inner(area);
    // Ahead is to the right; a cell of a terminal is twice as high as wide.
    let points = shown.history.path();
    let range = |of: fn(&(f64, f64)) -> f64| {
        points
            .iter()
            .map(of)
            .fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(at), high.max(at)))
    };
    let ((x_low, x_high), (y_low, y_high)) = (range(|at| at.0), range(|at| at.1));
    let (wide, high) = (f64::from(inner.width), 2.0 * f64::from(inner.height));
    let m_per_cell = [(x_high - x_low) / wide, (y_high - y_low) / high, 0.5 / wide];
    let m_per_cell = 1.1 * m_per_cell.into_iter().fold(0.0, f64::max);
    let (x, y) = ((x_low + x_high) / 2.0, (y_low + y_high) / 2.0);
    let half = |cells: f64| m_per_cell * cells / 2.0;
    let style = shown.good();
    let canvas = Canvas::default()
        .block(block)
        .marker(Marker::Braille)
        .x_bounds([x - half(wide), x + half(wide)])
        .y_bounds([y - half(high), y + half(high)])
        .paint(|context| {
            let color = style.fg.unwrap_or(Color::Reset);
            context.draw(&Points { coords: points, color });
            context.print(x_m, y_m, Line::styled(arrow(heading_deg), shown.attention()));
        });
    frame.render_widget(canvas, area);
}

/// Where the robot looks, to the nearest eighth of a turn.
fn arrow(heading_deg: f64) -> &'static str {
    let eighth = (heading_deg / 45.0).round().rem_euclid(8.0) as usize;
    ["\u{2192}", "\u{2197}", "\u{2191}", "\u{2196}", "\u{2190}", "\u{2199}", "\u{2193}", "\u{2198}"]
        [eighth.min(7)]
}

fn draw_events(frame: &mut Frame<'_>, area: Rect, shown: &Shown<'_>) {
    let events = &shown.condition.events;
    let room = usize::from(area.height.saturating_sub(2));
    let lines: Vec<Line<'_>> = events
        .iter()
        .skip(events.len().saturating_sub(room))
        .map(|line| Line::raw(line.as_str()))
        .collect();
    let text = Paragraph::new(lines).block(Block::bordered().title(" what happened "));
    frame.render_widget(text.wrap(Wrap { trim: false }), area);
}

fn key_line<'a>(shown: &Shown<'_>) -> Line<'a> {
    let key =
        |name: &'static str| Span::styled(name, Style::new().add_modifier(Modifier::REVERSED));
    let pause = if shown.paused { " go on   " } else { " pause   " };
    let mut spans = vec![
        key(" s "),
        Span::raw(" or "),
        key(" space "),
        Span::raw(" emergency stop   "),
        key(" p "),
        Span::raw(pause),
        key(" q "),
        Span::raw(" quit"),
    ];
    if shown.paused {
        spans.push(Span::styled("   PAUSED", shown.attention()));
    }
    Line::from(spans)
}
