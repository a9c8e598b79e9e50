//! `beeline identify`: which robot it is, and its state.

use host_link::fault_in_words::FaultInWords;
use serde_json::json;
use shared_proto::{ConfigOrigin, Identity, Status};

use crate::cli::Common;
use crate::error::Result;
use crate::hex::hex;
use crate::port::with_robot;
use crate::ui::{BAD, BOLD, DIM, GOOD, paint, say};

pub(super) fn run(common: &Common) -> Result<()> {
    let (identity, status, statistics) =
        with_robot(&common.port, &common.sim(), async |session, _| {
            // A simulated robot is new, and measures its supply at its first control tick.
            session.listen(std::time::Duration::from_millis(5)).await?;
            let identity = session.identify().await?;
            let status = session.status().await?;
            Ok((identity, status, session.statistics()))
        })?;
    if common.json {
        say(json!({
            "identity": identity,
            "status": status,
            "host": {
                "frames_received": statistics.frames_received,
                "frames_damaged": statistics.frames_damaged,
                "frames_lost": statistics.frames_lost,
                "frames_refused": statistics.frames_refused,
                "retries": statistics.retries,
            },
        }));
        return Ok(());
    }
    show(&identity, &status);
    Ok(())
}

fn show(identity: &Identity, status: &Status) {
    let row = |name: &str, value: String| {
        say(format_args!("{}  {value}", paint(DIM, format_args!("{name:>10}"))))
    };
    let [major, minor, patch] = identity.firmware;
    row("robot", paint(BOLD, display_name(identity)));
    row("board", format!("{}, {}", identity.board, hex(&identity.uid)));
    row(
        "firmware",
        format!(
            "Beeline {major}.{minor}.{patch}, protocol {}, control period {} us",
            identity.protocol, identity.control_period_us
        ),
    );
    let limits = &identity.limits;
    row(
        "limits",
        format!(
            "{} m/s, {} m/s^2, duty {}",
            limits.speed_mps_max, limits.acceleration_mps2_max, limits.duty_max
        ),
    );
    let origin = match identity.config_origin {
        ConfigOrigin::Factory if identity.store_damaged => "factory (the saved one is damaged)",
        ConfigOrigin::Factory => "factory (none was ever saved)",
        ConfigOrigin::Saved => "saved",
    };
    let unsaved = if identity.unsaved { ", with unsaved changes" } else { "" };
    row("config", format!("{origin}{unsaved}"));
    row("up", format!("{:.1} s since {}", status.t_us as f64 * 1e-6, reset_cause(identity)));
    let state = match status.fault {
        Some(report) => paint(BAD, format_args!("faulted: {}", FaultInWords(&report))),
        None => paint(GOOD, status.state.name()),
    };
    row("state", state);
    if let Some(report) = status.fault {
        row("", format!("{}; then `beeline clear`", report.fault.remedy()));
    }
    row("supply", format!("{:.2} V", f64::from(status.supply_mv) * 1e-3));
    let Status { ticks, ticks_lost, tick_delay_us_max, .. } = status;
    row("control", format!("{ticks} ticks, {ticks_lost} lost, latest {tick_delay_us_max} us late"));
    let link = &status.link;
    row(
        "link",
        format!(
            "{} frames received, {} sent, {} damaged, {} lost, {} refused, {} telemetry dropped",
            link.frames_received,
            link.frames_sent,
            link.frames_damaged,
            link.frames_lost,
            link.frames_refused,
            link.telemetry_dropped
        ),
    );
}

/// The robot's name for a terminal, or a substitute for a robot without one.
pub(crate) fn display_name(identity: &Identity) -> String {
    match identity.name.as_str() {
        "" => "unnamed robot".into(),
        // Control characters in a name could confuse a terminal.
        name => name.chars().filter(|c| !c.is_control()).collect(),
    }
}

fn reset_cause(identity: &Identity) -> &'static str {
    use shared_proto::ResetCause::*;
    match identity.reset_cause {
        PowerOn => "power-on",
        Pin => "the reset button",
        Software => "it restarted itself",
        Watchdog => "a watchdog reset",
        Panic => "its firmware panicked",
        BrownOut => "its supply dipped",
    }
}
