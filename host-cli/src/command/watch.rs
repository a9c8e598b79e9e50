//! `beeline watch`: shows telemetry and events live.

use std::time::Duration;

use host_link::Session;
use host_link::error::FaultInWords;
use serde_json::json;
use shared_proto::{Command, Event, Refusal, Telemetry};

use crate::cli::{Common, WatchArgs, period_ms};
use crate::error::Result;
use crate::interrupt;
use crate::port::with_robot;
use crate::ui::{BAD, DIM, is_heard, note, paint, say};

/// How much of a simulated robot's time is shown, as it exists only as long as the command.
const SIM_S: f64 = 2.0;

pub(super) fn run(common: &Common, args: &WatchArgs) -> Result<()> {
    let period_ms = period_ms(args.rate);
    let duration_s = args.duration.map(|time| time.s).or(common.port.is_sim().then_some(SIM_S));
    with_robot(&common.port, &common.sim(), async |session, _| {
        subscribe(session, period_ms).await?;
        if !common.json {
            say(paint(DIM, HEADER));
        }
        let start_us = session.clock().now_us();
        let mut checked_us = start_us;
        let mut shown_us = 0;
        loop {
            session.listen(Duration::from_millis(u64::from(period_ms).max(20))).await?;
            let mut heard = session.take_events().all(|event| show_event(common, &event));
            let json = common.json;
            // Another host may have asked for more.
            let every_us = if session.overhears() { u64::from(period_ms) * 1000 } else { 0 };
            let due: Vec<Telemetry> = session
                .take_telemetry()
                .filter(|frame| {
                    let is_due = frame.t_us >= shown_us + every_us;
                    shown_us = if is_due { frame.t_us } else { shown_us };
                    is_due
                })
                .collect();
            heard &= due
                .iter()
                .all(|frame| if json { is_heard(json!(frame)) } else { is_heard(line(frame)) });
            let now_us = session.clock().now_us();
            let elapsed_s = (now_us - start_us) as f64 * 1e-6;
            if !heard || interrupt::requested() || duration_s.is_some_and(|end| elapsed_s >= end) {
                break;
            }
            // Once a second, whether the robot is still there: this fails if it is not.
            if now_us - checked_us > 1_000_000 {
                checked_us = now_us;
                session.status().await?;
                if session.overhears() {
                    // Its driver may be gone, and the telemetry with it.
                    subscribe(session, period_ms).await?;
                }
            }
        }
        if !session.overhears() {
            subscribe(session, 0).await?;
        }
        match session.statistics().telemetry_lost {
            0 => {}
            lost => note(paint(DIM, format_args!("{lost} frames of telemetry were lost"))),
        }
        Ok(())
    })
}

/// Requests telemetry; of a robot that another host drives, takes what that one has requested.
async fn subscribe(session: &mut Session, period_ms: u16) -> Result<()> {
    match session.ask(Command::Subscribe { period_ms }).await? {
        Ok(_) => Ok(()),
        Err(Refusal::Driven) => {
            session.overhear();
            Ok(())
        }
        Err(refusal) => {
            Err(host_link::Error::Refused { request: "send telemetry", refusal }.into())
        }
    }
}

const HEADER: &str = "      t s  state      supply |  left counts   err um   mm/s  duty % | right counts   err um   mm/s  duty % |     x m     y m  heading";

fn line(frame: &Telemetry) -> String {
    let wheel = |w: shared_proto::WheelTelemetry| {
        format!(
            "{:>12} {:>8} {:>6.1} {:>7.1}",
            w.counts,
            w.error_um,
            f64::from(w.speed_um_s) * 1e-3,
            f64::from(w.duty) / 327.67
        )
    };
    let state = if frame.probing { "probing" } else { frame.state.name() };
    format!(
        "{:>9.3}  {state:<9} {:>5.2} V | {} | {} | {:>7.3} {:>7.3} {:>7.2}°",
        frame.t_us as f64 * 1e-6,
        f64::from(frame.supply_mv) * 1e-3,
        wheel(frame.wheels.left),
        wheel(frame.wheels.right),
        frame.pose.x_um as f64 * 1e-6,
        frame.pose.y_um as f64 * 1e-6,
        (frame.pose.heading_urad as f64 * 1e-6).to_degrees()
    )
}

/// Shows an event; false if nobody reads the output any more.
fn show_event(common: &Common, event: &Event) -> bool {
    if common.json {
        return is_heard(json!(event));
    }
    match event {
        Event::Fault(report) => note(paint(
            BAD,
            format_args!("fault: {}; {}", FaultInWords(report), report.fault.remedy()),
        )),
        Event::State { t_us, state } => {
            note(paint(DIM, format_args!("{:>9.3}  {}", *t_us as f64 * 1e-6, state.name())));
        }
        Event::MotionEnded { t_us, end, .. } => {
            note(paint(DIM, format_args!("{:>9.3}  motion ended: {end:?}", *t_us as f64 * 1e-6)));
        }
    }
    true
}
