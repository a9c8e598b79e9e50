//! `beeline tune`.

use std::path::Path;

use campaign::CampaignWriter;
use campaign::file::{WriteError, check_writable, write_whole};
use host_link::Session;
use robot_model::drivetrain::{Gains, HalfWidths, LoadDisturbance, WheelMotor};
use serde_json::{Value, json};

use crate::campaign_recorder::clock::CampaignClock;
use crate::cli::{Common, TuneArgs};
use crate::error::{Error, Result};
use crate::hex::hex;
use crate::motor_page;
use crate::port::with_robot;
use crate::tune::result_tables::{ConstantRow, FollowingRow};
use crate::tune::{
    DriveOutcome, FLOOR_M_MAX, FLOOR_M_MIN, Following, LoopConfig, Progress, Settings, Tuned,
    recorded, result_tables, tune,
};
use crate::ui::{BOLD, DIM, GOOD, WARN, note, paint, say, warn};
use crate::undo::state_folder;

use super::undo::last_change;

pub(super) fn run(common: &Common, args: &TuneArgs) -> Result<()> {
    if args.undo {
        return undo(common);
    }
    check_floor(args)?;
    if let Some(page) = &args.output {
        // Before the work: a file that cannot be written must not cost the time.
        check_writable(page).map_err(|error| cannot_write(page, &error))?;
    }
    let forgets = common.port.is_sim() && common.flash.is_none();
    let settings = Settings {
        floor_m: args.floor.m,
        wheels_up: args.wheels_up,
        stiffness: args.stiffness,
        record: args.record.is_some(),
        undo_folder: if forgets { None } else { Some(state_folder()?) },
    };
    let (tuned, written) = with_robot(&common.port, &common.sim(), async |session, _| {
        // A simulated robot is new, and measures its supply at its first control tick.
        session.listen(std::time::Duration::from_millis(5)).await?;
        let writer = match &args.record {
            Some(folder) => Some(recorder(session, folder, common.port.is_sim()).await?),
            None => None,
        };
        let mut written = Ok(0);
        let tuned = tune(session, &settings, &mut |progress| {
            tell_progress(common.json, &progress);
            if let (Progress::Driven(config, driven), Some((writer, clock, _))) =
                (&progress, &writer)
            {
                written = recorded::write(writer, *clock, config, driven);
            }
        })
        .await;
        if let (Some(folder), false, Ok(experiments)) = (&args.record, common.json, &written) {
            let before = writer.as_ref().map_or(0, |(_, _, runs)| *runs);
            let beside = match before {
                0 => String::new(),
                runs => format!(", beside the {runs} that were there"),
            };
            note(format_args!("{}: {experiments} experiments{beside}", folder.display()));
        }
        Ok((tuned, written))
    })?;
    // The experiments are worth having, and the gains as well, whatever came of the others.
    let tuned = match (tuned, &written) {
        (Ok(tuned), _) => tuned,
        (Err(error), written) => {
            if let Err(unwritten) = written {
                warn(format_args!("the experiments were not kept: {unwritten}"));
            }
            return Err(error);
        }
    };
    if common.json {
        say(as_json(&tuned));
    } else {
        print(&tuned, common.robot_forgets());
    }
    if let Some(page) = &args.output {
        write_whole(page, motor_page::of_tuning(&tuned).as_bytes())
            .map_err(|error| cannot_write(page, &error).hint("the tuning itself is done"))?;
        if !common.json {
            say(format_args!("{} written", page.display()));
        }
    }
    written?;
    Ok(())
}

fn check_floor(args: &TuneArgs) -> Result<()> {
    if args.floor.m < FLOOR_M_MIN {
        return Err(Error::new(format_args!(
            "{:.0} cm of floor is too little to tell a motor from its friction",
            args.floor.m * 100.0
        ))
        .hint("use at least --floor 30cm; 1.5 m is better"));
    }
    if args.floor.m > FLOOR_M_MAX {
        return Err(Error::new(format_args!(
            "{:.0} m of floor is more than any robot needs",
            args.floor.m
        ))
        .hint(format_args!("give at most {FLOOR_M_MAX:.0} m; 1.5 m is enough for most robots")));
    }
    Ok(())
}

fn cannot_write(page: &Path, error: &WriteError) -> Error {
    Error::new(format_args!("cannot write {}: {error}", page.display()))
        .hint(error.hint("choose another file with -o"))
}

/// A campaign folder for this robot, its clock if it has runs already, and how many.
async fn recorder(
    session: &mut Session,
    folder: &Path,
    is_sim: bool,
) -> Result<(CampaignWriter, Option<CampaignClock>, usize)> {
    let mut robot = recorded::robot_of(&session.read_config().await?);
    if !is_sim {
        // A simulated robot has another uid with each seed.
        robot.uid = Some(hex(&session.identify().await?.uid));
    }
    let clock = recorded::clock_of(folder, is_sim, session.status().await?.t_us)?;
    let runs = recorded::runs_in(folder)?;
    Ok((CampaignWriter::open(folder, &robot)?, clock, runs))
}

fn tell_progress(json: bool, progress: &Progress<'_>) {
    if json {
        return;
    }
    match progress {
        Progress::Doing(what) => note(format_args!("  {what} ...")),
        Progress::Driven(_, driven) => {
            note(format_args!("  {} experiments driven", driven.len()));
        }
        Progress::Before(outcome) => note(format_args!("  before: {}", in_words(outcome))),
        Progress::Identified(fit) => note(format_args!(
            "  motors identified: their travel is explained to {:.2} mm",
            fit.residual_m * 1e3
        )),
        Progress::Trying(gains) => note(format_args!(
            "  gains: kp {:.0} V/m, ki {:.0} V/(m s), kd {:.2} V s/m; drives with them ...",
            gains.kp_v_per_m, gains.ki_v_per_m_s, gains.kd_v_s_per_m
        )),
        Progress::After(outcome) => note(format_args!("  after: {}", in_words(outcome))),
    }
}

fn in_words(outcome: &DriveOutcome) -> String {
    match outcome {
        DriveOutcome::Followed(following) => format!(
            "{:.3} mm rms from the setpoints of the fast profile, {:.3} mm at worst",
            following.fast_rms_m * 1e3,
            following.worst_m * 1e3
        ),
        DriveOutcome::Faulted(fault) => format!("stopped by the fault {fault}"),
    }
}

/// A slope or a cable: what it does, and what was made of it.
fn print_push(push: LoadDisturbance) {
    let (way, other) =
        if push.volts > 0.0 { ("forwards", "backwards") } else { ("backwards", "forwards") };
    say(format_args!(
        "{} both wheels need {:.2} V less {way} than {other}: the floor slopes, or a cable pulls.",
        paint(WARN, "pushed:"),
        2.0 * push.volts.abs()
    ));
    say("The feedforward takes the mean. A level floor gives better constants.");
}

/// How the wheels followed before, and how they do now.
fn print_following(before: &DriveOutcome, after: &Following) {
    say("");
    let head = paint(DIM, format_args!("{:<24}", "following its profiles"));
    say(format_args!("{head}{:>10}{:>14}", "before", "after"));
    for FollowingRow { name, decimals, before, after } in result_tables::following(before, after) {
        let before = before.map_or("fault".into(), |before| format!("{before:.decimals$}"));
        say(format_args!("{name:<24}{before:>10}{after:>14.decimals$}"));
    }
}

fn print(tuned: &Tuned, forgets: bool) {
    let Tuned { fit, gains, before, after, .. } = tuned;
    let constants = &fit.constants;
    // Padded before it is painted: a style has width as well.
    let head = paint(DIM, format_args!("{:<30}", "motor"));
    say(format_args!("{head}{:>18}{:>18}", "left", "right"));
    for ConstantRow { name, decimals, wheels } in result_tables::constants(constants) {
        let [left, right] = wheels
            .map(|(value, half_width)| format!("{value:.decimals$} ± {half_width:.decimals$}"));
        say(format_args!("{name:<30}{left:>18}{right:>18}"));
    }
    let value = &constants.value;
    say(format_args!("delay {:.1} ms; ± gives 95 % intervals", value.delay_s * 1e3));
    if let Some(push) = constants.load_disturbance() {
        print_push(push);
    }
    if let Some(words) = result_tables::odd(constants, tuned.wheels_up) {
        say(format_args!("{} {words}", paint(WARN, "odd:")));
    }
    for words in result_tables::unsure(constants) {
        say(format_args!("{} {words}", paint(WARN, "unsure:")));
    }
    say(format_args!(
        "margin: Ms {:.2}, with kV and kA 30 % off {:.2}; phase margin {:.0} degrees at {:.0} rad/s",
        gains.ms,
        gains.ms_worst,
        gains.phase_margin_rad.to_degrees(),
        gains.crossover_rad_s
    ));
    print_following(before, after);
    for words in result_tables::lowered(tuned) {
        say(format_args!("{} {words}", paint(WARN, "lowered:")));
    }
    let saved = match forgets {
        true => "found, and forgotten with this simulated robot unless --flash FILE keeps them",
        false => "saved",
    };
    let floor = match tuned.wheels_up {
        true => "wheels in the air".to_owned(),
        false => format!("{:.2} m of floor", tuned.floor_used_m),
    };
    say(format_args!(
        "{} feedforward and gains {saved}; {:.0} s, {floor}",
        paint(GOOD, "tuned:"),
        tuned.took_s,
    ));
    if tuned.wheels_up {
        say(format_args!("{} {}", paint(WARN, "not done:"), result_tables::WHEELS_UP));
    }
    if !forgets {
        say(format_args!("{} puts the old ones back", paint(BOLD, "beeline tune --undo")));
    }
}

fn as_json(tuned: &Tuned) -> Value {
    let constants = &tuned.fit.constants;
    let motor = |motor: &WheelMotor, off: &HalfWidths| {
        let (straight, spin) = constants.value.ka_of_robot(motor);
        let number =
            |value: f64, half_width: f64| json!({"value": value, "half_width_95": half_width});
        json!({
            "ks_forward_v": number(motor.ks_forward_v, off.ks_forward_v),
            "ks_backward_v": number(motor.ks_backward_v, off.ks_backward_v),
            "kv_v_s_per_m": number(motor.kv_v_s_per_m, off.kv_v_s_per_m),
            "ka_straight_v_s2_per_m": number(straight, off.ka_straight_v_s2_per_m),
            "ka_spin_v_s2_per_m": number(spin, off.ka_spin_v_s2_per_m),
        })
    };
    let (wheels, off) = (&constants.value.wheels, &constants.half_widths_95);
    let following = |of: &Following| {
        json!({
            "rms_m": of.rms_m,
            "fast_rms_m": of.fast_rms_m,
            "worst_m": of.worst_m,
            "overshoot": of.overshoot,
            "settling_s": of.settling_s,
            "duty_noise": of.duty_noise,
        })
    };
    let before = match &tuned.before {
        DriveOutcome::Followed(before) => following(before),
        DriveOutcome::Faulted(fault) => json!({"fault": fault.id()}),
    };
    let Gains { kp_v_per_m, ki_v_per_m_s, kd_v_s_per_m, .. } = tuned.gains;
    json!({
        "motors": {
            "left": motor(&wheels.left, &off.left),
            "right": motor(&wheels.right, &off.right),
            "delay_s": constants.value.delay_s,
            "push_v": constants.load_disturbance().map_or(0.0, |push| push.volts),
        },
        "residual_m": tuned.fit.residual_m,
        "gains": {
            "kp_v_per_m": kp_v_per_m,
            "ki_v_per_m_s": ki_v_per_m_s,
            "kd_v_s_per_m": kd_v_s_per_m,
            "ms": tuned.gains.ms,
            "ms_worst": tuned.gains.ms_worst,
            "phase_margin_rad": tuned.gains.phase_margin_rad,
            "crossover_rad_s": tuned.gains.crossover_rad_s,
        },
        "before": before,
        "after": following(&tuned.after),
        "config": tuned.change.1,
        "took_s": tuned.took_s,
        "floor_used_m": tuned.floor_used_m,
    })
}

fn undo(common: &Common) -> Result<()> {
    let undone = last_change::<LoopConfig>(common)?;
    if common.json {
        say(json!({"undone": undone.before, "was": undone.after}));
    } else {
        say(
            "gains, feedforward and limits are restored to those before the last tuning, and saved",
        );
    }
    Ok(())
}
