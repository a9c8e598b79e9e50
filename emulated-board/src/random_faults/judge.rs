//! Compares what was seen with what is promised.

use shared_proto::{Fault, MotionEnd, Wheel, WheelPair};

use super::bound::{MotorsOff, Name};
use super::draw::Case;
use super::fault_instant::{FaultInstant, Situation};
use super::fault_kind::FaultKind;
use super::observed::{Happened, Observed};
use super::promise::Promise;

/// What became of a case.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// What it was called.
    pub names: Vec<Name>,
    /// The motors were off this long after what happened first, or after the first duty after it \[ms\].
    pub off_ms: f64,
    /// The bound on that, if a single one applies \[ms\].
    pub bound_ms: Option<f64>,
    /// Whether the motors were driven at all after it.
    pub was_driven: bool,
    /// What the robot was doing.
    pub situation: Situation,
    /// What was not as promised.
    pub wrong: Vec<String>,
}

impl Verdict {
    const NONE: Self = Self {
        names: Vec::new(),
        off_ms: 0.0,
        bound_ms: None,
        was_driven: false,
        situation: Situation::Before,
        wrong: Vec::new(),
    };
}

/// So much farther a sound robot drives at most, with a driver that coasts \[mm\].
const BEYOND_MM: f64 = 5.0;
/// How far the radius lets a wheel roll for an angle \[mm/rad\].
const RADIUS_MM: f64 = 36.0;

/// How long the motors were driven after something happened, and how far the wheels turned meanwhile.
#[derive(Clone, Copy)]
struct Driven {
    ms: f64,
    mm: f64,
    at_all: bool,
}

impl Driven {
    /// Whether the motors were on for longer than promised, and so much more.
    fn is_late(&self, bound: MotorsOff, more_ms: f64) -> bool {
        match bound {
            MotorsOff::NotNeeded => false,
            MotorsOff::Within(ms) => self.ms > ms + more_ms,
            MotorsOff::WithinOrTravel(ms, mm) => self.ms > ms + more_ms && self.mm > mm,
        }
    }
}

pub(super) fn judge(case: &Case, observed: &Observed) -> Verdict {
    let mut wrong = observed.wrong.clone();
    if observed.happened.is_empty() {
        wrong.push("the instant for it never came".into());
        return Verdict { wrong, ..Verdict::NONE };
    }
    let promises = promises(case, observed);
    // While the program itself is disturbed, it sees everything else later.
    let delay_ms = observed
        .happened
        .iter()
        .zip(&promises)
        .filter(|(happened, _)| happened.kind.is_of_the_program())
        .map(|(_, (promise, _))| match promise.bound {
            MotorsOff::Within(ms) | MotorsOff::WithinOrTravel(ms, _) => ms,
            MotorsOff::NotNeeded => 0.0,
        })
        .fold(0.0, f64::max);
    let names = names(observed);
    for (happened, (promise, driven)) in observed.happened.iter().zip(&promises) {
        if let Some(too_far) = drives_with_a_wrong_name(case, happened, &names, driven) {
            wrong.extend(too_far);
            continue;
        }
        // A core that stood until the motors were switched on: nothing was missed, and whether that may be is asked below.
        if matches!(happened.kind, FaultKind::CoreStands(_)) && names[..] == [Name::Harmless] {
            continue;
        }
        let own_ms = if happened.kind.is_of_the_program() { 0.0 } else { delay_ms };
        let own_ms = own_ms + overlaid_ms(happened, &observed.happened);
        if driven.is_late(promise.bound, own_ms) {
            let Driven { ms, mm, .. } = driven;
            wrong.push(format!(
                "{}: driven for {ms:.2} ms and {mm:.1} mm, promised {:?}",
                happened.kind.name(),
                promise.bound
            ));
        }
    }
    let mut allowed = allowed(&promises);
    if let [first, second] = observed.happened[..] {
        allowed.extend(both(first.kind, second.kind));
        allowed.extend(both(second.kind, first.kind));
    }
    for name in &names {
        if !allowed.contains(name) {
            let allowed: Vec<String> = allowed.iter().map(Name::to_string).collect();
            wrong.push(format!("called {name}, and is {}", allowed.join(" or ")));
        }
    }
    let must_end = !observed.timeline.tracks_us.is_empty() && !observed.drives_unanswered;
    if names.contains(&Name::Harmless) && must_end {
        let ended = matches!(observed.motion_end, Some(MotionEnd::Completed | MotionEnd::Stopped));
        if !ended {
            wrong.push(format!("no fault, and the motion's end is {:?}", observed.motion_end));
        }
    }
    wrong.extend(next_motion(&names, observed));
    let first = observed.happened[0];
    let bound_ms = match promises[0].0.bound {
        MotorsOff::Within(ms) if observed.happened.len() == 1 => Some(ms),
        _ => None,
    };
    let Driven { ms, at_all, .. } = promises[0].1;
    let situation = FaultInstant::new(case, &observed.timeline, &first).situation;
    Verdict { names, off_ms: ms, bound_ms, was_driven: at_all, situation, wrong }
}

/// A driver that takes the lines for the same, or nearly: the robot drives as far as it is told, or not quite. What is wrong with
/// that, if it is such a case.
fn drives_with_a_wrong_name(
    case: &Case,
    happened: &Happened,
    names: &[Name],
    driven: &Driven,
) -> Option<Option<String>> {
    let drives = |name: &Name| matches!(name, Name::Harmless | Name::Fault(Fault::Stall(_)));
    if !matches!(happened.kind, FaultKind::WrongName(_)) || !names.iter().all(drives) {
        return None;
    }
    let WheelPair { left, right } = case.motion.distance.map(|m| m.abs() * 1000.0);
    let too_far = driven.mm > left.max(right) + BEYOND_MM;
    Some(too_far.then(|| format!("drives {:.1} mm, told {left:.1}, {right:.1}", driven.mm)))
}

/// How much later something else happened to the same wheel \[ms\]: what the count did until then tells nothing any more.
fn overlaid_ms(happened: &Happened, all: &[Happened]) -> f64 {
    let wheel = happened.kind.wheel();
    all.iter()
        .filter(|other| wheel.is_some() && other.kind.wheel() == wheel)
        .map(|other| other.at_us.saturating_sub(happened.at_us) as f64 / 1000.0)
        .fold(0.0, f64::max)
}

/// A lead that nothing was missing of is named by the next motion: its check, or the motion itself.
fn next_motion(names: &[Name], observed: &Observed) -> Option<String> {
    let [Happened { kind: FaultKind::MotorCut(wheel), .. }] = observed.happened[..] else {
        return None;
    };
    let driven = names.contains(&Name::Harmless) && observed.timeline.commanded_us.is_some();
    let allowed = [Fault::Stall(wheel), Fault::NoResponse(wheel)];
    let named = observed.next_fault.is_some_and(|fault| allowed.contains(&fault));
    (driven && !named).then(|| format!("the next motion called it {:?}", observed.next_fault))
}

/// What is promised for each thing that happened, and what the motors did after it.
fn promises(case: &Case, observed: &Observed) -> Vec<(Promise, Driven)> {
    observed
        .happened
        .iter()
        .map(|happened| {
            let instant = FaultInstant::new(case, &observed.timeline, happened);
            let mut promise = Promise::of(happened.kind, case, &instant);
            let driven = driven_after(happened, observed);
            // A wheel that turns backwards and counts backwards follows its setpoint: no check of the robot's own can see it.
            if observed.happened.iter().any(|other| cancel(happened.kind, other.kind)) {
                promise.bound = MotorsOff::NotNeeded;
                promise.names.push(Name::Harmless);
            }
            // As when something else had cut the line before: what shows in a motion alone could not show.
            if !driven.at_all && happened.kind.shows_in_motion_only() {
                promise.names.push(Name::Harmless);
            }
            (promise, driven)
        })
        .collect()
}

fn driven_after(happened: &Happened, observed: &Observed) -> Driven {
    let mut later = observed.powered.iter().filter(|powered| powered.to_us > happened.at_us);
    let Some(first) = later.next() else { return Driven { ms: 0.0, mm: 0.0, at_all: false } };
    let last = later.next_back().unwrap_or(first);
    let origin_us = first.from_us.max(happened.at_us);
    let turned = last.angles_rad.zip(happened.angles_rad).map(|(to, from)| (to - from).abs());
    let rad = match happened.kind.wheel() {
        Some(wheel) => *turned.get(wheel),
        None => turned.left.max(turned.right),
    };
    Driven { ms: (last.to_us - origin_us) as f64 / 1000.0, mm: rad * RADIUS_MM, at_all: true }
}

/// What it was called: a restart, what was latched then, or nothing.
fn names(observed: &Observed) -> Vec<Name> {
    let mut names = Vec::new();
    let first_us = observed.happened.first().map_or(0, |happened| happened.at_us);
    if observed.resets_us.iter().any(|reset_us| *reset_us >= first_us) {
        names.extend(observed.cause.map(Name::Restart));
    }
    names.extend(observed.fault.map(Name::Fault));
    if names.is_empty() {
        names.push(Name::Harmless);
    }
    names
}

/// Whether the loop is as it was with both.
fn cancel(one: FaultKind, other: FaultKind) -> bool {
    match (one, other) {
        (FaultKind::MotorReversed(a), FaultKind::EncoderSwapped(b))
        | (FaultKind::EncoderSwapped(a), FaultKind::MotorReversed(b)) => a == b,
        // A robot in mirror image.
        (FaultKind::EncodersExchanged, FaultKind::MotorsExchanged)
        | (FaultKind::MotorsExchanged, FaultKind::EncodersExchanged) => true,
        _ => false,
    }
}

/// What only two things at once are called.
fn both(one: FaultKind, other: FaultKind) -> Vec<Name> {
    match (one, other) {
        // Whatever the one wheel's motor turns, its count does not show it.
        (
            FaultKind::EncodersExchanged | FaultKind::MotorsExchanged,
            FaultKind::EncoderLine(wheel, _) | FaultKind::EncoderUnplugged(wheel),
        ) => [Fault::EncoderDead, Fault::NoResponse]
            .map(|of| Name::Fault(of(wheel.other())))
            .to_vec(),
        (FaultKind::EncodersExchanged, FaultKind::EncoderNoise(wheel, _)) => {
            vec![Name::Fault(Fault::CountRate(wheel.other()))]
        }
        // Whatever is commanded of the one wheel drives the other one's motor.
        (
            FaultKind::MotorsExchanged,
            FaultKind::MotorCut(wheel)
            | FaultKind::WheelBlocked(wheel)
            | FaultKind::WheelJammed(wheel),
        ) => {
            vec![Name::Fault(Fault::NoResponse(wheel.other()))]
        }
        // The hardware stops the motors; the task that would say so does not run.
        (FaultKind::TaskStops("stop_line"), FaultKind::StopLine | FaultKind::StopLineBounce(_)) => {
            let faults =
                [Fault::EncoderDead, Fault::Stall, Fault::FollowingError, Fault::NoResponse];
            let of_both = |fault: fn(Wheel) -> Fault| Wheel::BOTH.map(fault).map(Name::Fault);
            faults.into_iter().flat_map(of_both).chain([Name::Harmless]).collect()
        }
        _ => Vec::new(),
    }
}

/// The names of all that happened. It is harmless only if all of it is.
fn allowed(promises: &[(Promise, Driven)]) -> Vec<Name> {
    let harmless = promises.iter().all(|(promise, _)| promise.names.contains(&Name::Harmless));
    let mut allowed: Vec<Name> =
        promises.iter().flat_map(|(promise, _)| promise.names.clone()).collect();
    allowed.retain(|name| harmless || *name != Name::Harmless);
    // A restart forgets what was latched. What still lasts is then named.
    if allowed.iter().any(|name| matches!(name, Name::Restart(_))) {
        allowed.extend(promises.iter().flat_map(|(promise, _)| promise.after_a_restart.clone()));
        allowed.retain(|name| *name != Name::Fault(Fault::EmergencyStop) || promises.len() > 1);
    }
    allowed
}
