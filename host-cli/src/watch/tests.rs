//! What is drawn, as text.

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::Color;
use shared_proto::{
    Event, Fault, FaultReport, MotionEnd, MotionId, Pose, PoseDeviation, State, Telemetry,
    WheelPair, WheelTelemetry,
};

use super::{Column, Condition, Driver, History, Shown, USUAL, draw};

/// A frame of a robot that drives an arc to the left.
fn frame(number: u32) -> Telemetry {
    let t_s = f64::from(number) * 0.02;
    let speed_mps = 0.2 * (t_s / 2.0).min(1.0);
    let wheel = |share: f64, duty: i16| WheelTelemetry {
        counts: (900.0 * t_s) as i64,
        setpoint_um: (2e5 * share * t_s) as i64,
        error_um: (300.0 * share * (3.0 * t_s).sin()) as i32,
        speed_um_s: (1e6 * share * speed_mps) as i32,
        duty,
        ..WheelTelemetry::default()
    };
    let angle = 0.3 * t_s;
    Telemetry {
        number,
        t_us: 5_000_000 + u64::from(number) * 20_000,
        state: State::Driving,
        probing: false,
        wheels: WheelPair::new(wheel(0.8, 9_000), wheel(1.2, 13_000)),
        supply_mv: 12_040,
        pose: Pose {
            x_um: (6e5 * angle.sin()) as i64,
            y_um: (6e5 * (1.0 - angle.cos())) as i64,
            heading_urad: (1e6 * angle) as i64,
        },
        deviation: PoseDeviation {
            x_um: 1_230,
            y_um: 4_560,
            heading_urad: 7_000,
            ..PoseDeviation::default()
        },
    }
}

fn history() -> History {
    let mut history = History::default();
    (0..400).for_each(|number| history.push(&frame(number)));
    history
}

fn condition() -> Condition {
    let mut condition = Condition {
        robot: "Bumblebee".into(),
        port: "/dev/ttyACM0".into(),
        state: Some(State::Driving),
        driver: Driver::Another,
        lost: 1,
        late: 3,
        rate_hz: 49.8,
        ..Condition::default()
    };
    condition.note(&Event::State { t_us: 5_000_000, state: State::Driving });
    condition.note(&Event::MotionEnded {
        t_us: 9_100_000,
        motion: MotionId(7),
        end: MotionEnd::Completed,
    });
    condition
}

fn faulted() -> Condition {
    let mut condition = condition();
    condition.note(&Event::Fault(FaultReport {
        number: 1,
        t_us: 13_000_000,
        fault: Fault::EmergencyStop,
        followed_by: 0,
        wheels: WheelPair::default(),
        supply_mv: 12_040,
    }));
    condition
}

fn buffer((width, height): (u16, u16), shown: &Shown<'_>) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(|frame| draw(frame, shown)).unwrap();
    terminal.backend().buffer().clone()
}

fn text(buffer: &Buffer) -> String {
    let width = usize::from(buffer.area.width).max(1);
    let symbols: Vec<&str> = buffer.content.iter().map(|cell| cell.symbol()).collect();
    let lines = symbols.chunks(width).map(|line| line.concat().trim_end().to_owned() + "\n");
    lines.collect()
}

fn shown<'a>(condition: &'a Condition, history: &'a History) -> Shown<'a> {
    Shown { condition, history, paused: false, colours: true }
}

#[test]
fn everything_is_there_in_words_at_80_and_at_60_columns() {
    let (condition, history) = (faulted(), history());
    for size in [(80, 24), (60, 24)] {
        let text = text(&buffer(size, &shown(&condition, &history)));
        // To be looked at.
        println!("{text}");
        for words in [
            "Bumblebee",
            "/dev/ttyACM0",
            "FAULTED: motors off",
            "driven by another host",
            "supply 12.04 V",
            "50 a second, 1 frame lost, 3 came late",
            "fault: ",
            "what to do: ",
            "then `beeline clear`",
            "left wheel",
            "right wheel",
            "160.0 mm/s",
            "240.0 mm/s",
            "setpoint",
            "error",
            "27 %",
            "40 %",
            "path: x ",
            "heading 137.2\u{b0}",
            " s  or  space  emergency stop    p  pause    q  quit",
        ] {
            assert!(text.contains(words), "{size:?}, {words}:\n{text}");
        }
        let braille = |c: char| ('\u{2801}'..='\u{28ff}').contains(&c);
        assert!(text.chars().filter(|c| braille(*c)).count() > 15, "{text}");
        assert_eq!(text.contains("motion completed"), size.0 == 80, "{text}");
    }
}

#[test]
fn the_page_shows_what_is_drawn() {
    let (condition, history) = (condition(), history());
    let drawn = text(&buffer((80, 20), &shown(&condition, &history)));
    let page = include_str!("../../../docs/commands.md");
    assert!(page.contains(&format!("```text\n{drawn}```\n")), "{drawn}");
}

#[test]
fn no_screen_is_too_small_and_one_without_telemetry_says_so() {
    let (faulted, history) = (faulted(), history());
    for size in [(0, 0), (1, 1), (20, 5), (40, 12), (300, 100)] {
        buffer(size, &shown(&faulted, &history));
    }
    let (condition, history) = (Condition::default(), History::default());
    let text = text(&buffer((80, 24), &shown(&condition, &history)));
    assert!(text.contains("CONNECTING") && text.contains("no telemetry yet"), "{text}");
}

#[test]
fn without_colours_nothing_is_lost() {
    let (condition, history) = (faulted(), history());
    let with = buffer((80, 24), &shown(&condition, &history));
    let plain = Shown { colours: false, ..shown(&condition, &history) };
    let without = buffer((80, 24), &plain);
    assert_eq!(text(&with), text(&without));
    let coloured = |buffer: &Buffer| {
        buffer.content.iter().any(|cell| cell.fg != Color::Reset || cell.bg != Color::Reset)
    };
    assert!(coloured(&with) && !coloured(&without));
}

#[test]
fn a_pause_and_late_telemetry_are_said() {
    let (mut condition, history) = (condition(), history());
    condition.silent_s = 1.25;
    let paused = Shown { paused: true, ..shown(&condition, &history) };
    let text = text(&buffer((80, 24), &paused));
    assert!(text.contains("PAUSED") && text.contains("go on"), "{text}");
    assert!(text.contains("telemetry is late: none for 1.2 s"), "{text}");
}

#[test]
fn frames_that_no_robot_sends_are_shown_like_any_other() {
    let mut history = History::default();
    for (t_us, um) in [(0, i64::MIN), (1, i64::MAX), (u64::MAX - 1, i64::MIN), (u64::MAX, 0)] {
        let wheel = WheelTelemetry { setpoint_um: um, counts: um, ..WheelTelemetry::default() };
        let pose = Pose { x_um: um, y_um: um, heading_urad: um };
        history.push(&Telemetry { t_us, wheels: WheelPair::both(wheel), pose, ..frame(1) });
        let condition = condition();
        text(&buffer((80, 24), &shown(&condition, &history)));
    }
}

#[test]
fn what_a_robot_calls_itself_moves_no_cursor() {
    let condition = Condition { robot: "a\x1b[2Jb\u{9b}31m".into(), ..condition() };
    let text = text(&buffer((80, 24), &shown(&condition, &history())));
    assert!(!text.contains(['\x1b', '\u{9b}']), "{text:?}");
}

#[test]
fn a_robot_that_starts_anew_has_a_new_history_and_a_long_path_is_thinned() {
    let mut history = history();
    assert!(history.path().len() > 150);
    history.push(&frame(0));
    assert_eq!(history.path().len(), 1);
    for number in 0..20_000 {
        let pose = Pose { x_um: i64::from(number) * 6_000, ..Pose::default() };
        history.push(&Telemetry { pose, ..frame(number + 1) });
    }
    assert!((1000..=4000).contains(&history.path().len()), "{}", history.path().len());
}

#[test]
fn the_usual_line_is_shorter_than_80_characters_and_each_column_keeps_its_width() {
    let heads = Column::heads(&USUAL);
    let line = Column::line(&USUAL, &frame(399));
    println!("{heads}\n{line}");
    let width = |line: &str| line.chars().count();
    assert!(width(&heads) < 80 && width(&heads) == width(&line), "{heads}\n{line}");
}

#[test]
fn a_column_says_how_sure_each_number_of_the_pose_is() {
    let columns = [Column::XDeviation, Column::YDeviation, Column::HeadingDeviation];
    assert_eq!(Column::heads(&columns), "x sd mm y sd mm head sd \u{b0}");
    let line = Column::line(&columns, &frame(1));
    // 7 mrad are 0.401 degrees.
    assert_eq!(line, "   1.23    4.56     0.401");
}
