//! What a tuning found, row by row, for the terminal and for the page.

use robot_model::drivetrain::{Constants, Drivetrain, HalfWidths, WheelMotor};

use super::{DriveOutcome, Following, Tuned};

/// A constant whose interval is wider, as a share of it, is worth a word.
const UNSURE: f64 = 0.5;

/// On the floor a wheel's inertia is hardly the same straight on and on the spot; this share apart it is.
const ALIKE: f64 = 0.1;

/// A constant of both motors: value and half the width of its 95 % interval.
pub struct ConstantRow {
    /// With its unit.
    pub name: &'static str,
    /// So many are worth printing.
    pub decimals: usize,
    /// The left wheel's, and the right one's.
    pub wheels: [(f64, f64); 2],
}

/// The constants.
pub fn constants(constants: &Constants) -> [ConstantRow; 5] {
    type Value = fn(&Drivetrain, &WheelMotor) -> f64;
    let row = |name, decimals, of: Value, off: fn(&HalfWidths) -> f64| {
        let Constants { value, half_widths_95 } = constants;
        let wheels = [
            (of(value, &value.wheels.left), off(&half_widths_95.left)),
            (of(value, &value.wheels.right), off(&half_widths_95.right)),
        ];
        ConstantRow { name, decimals, wheels }
    };
    [
        row("kS forwards [V]", 3, |_, motor| motor.ks_forward_v, |off| off.ks_forward_v),
        row("kS backwards [V]", 3, |_, motor| motor.ks_backward_v, |off| off.ks_backward_v),
        row("kV [V s/m]", 2, |_, motor| motor.kv_v_s_per_m, |off| off.kv_v_s_per_m),
        row(
            "kA straight on [V s^2/m]",
            3,
            |value, motor| value.ka_of_robot(motor).0,
            |off| off.ka_straight_v_s2_per_m,
        ),
        row(
            "kA on the spot [V s^2/m]",
            3,
            |value, motor| value.ka_of_robot(motor).1,
            |off| off.ka_spin_v_s2_per_m,
        ),
    ]
}

/// The constants that the experiments hardly tell, each in a sentence.
pub fn unsure(of: &Constants) -> Vec<String> {
    let rows = constants(of);
    // Friction may be as good as nothing.
    let told = rows.iter().filter(|row| !row.name.starts_with("kS"));
    told.flat_map(|row| ["left", "right"].into_iter().zip(row.wheels).map(move |of| (row, of)))
        .filter(|(_, (_, (value, half_width)))| *half_width > UNSURE * value.abs())
        .map(|(row, (wheel, (value, half_width)))| {
            let name = row.name.split(" [").next().unwrap_or(row.name);
            format!(
                "{name} of the {wheel} wheel is known to {:.0} % only: coarse counts, a caster or a cable that pulls, or wheels that slip",
                100.0 * half_width / value.abs()
            )
        })
        .collect()
}

/// What a tuning in the air leaves undone.
pub const WHEELS_UP: &str = "kA is that of the wheels alone. On its floor the robot is heavier: run `beeline tune` there before it drives.";

/// No two motors of a kind differ by more in kV.
const KV_RATIO_MAX: f64 = 1.3;

/// Whether one wheel's counts are likely of another length, or the wheels answer as if they carried no robot, or, in the air, as
/// if they did.
pub fn odd(of: &Constants, wheels_up: bool) -> Option<&'static str> {
    let kv = of.value.wheels.map(|motor| motor.kv_v_s_per_m);
    if kv.left.max(kv.right) > KV_RATIO_MAX * kv.left.min(kv.right) {
        return Some(
            "kV of one wheel is far from the other's: are counts_per_rev and gear_reduction right for both, and the motors of one kind?",
        );
    }
    let [.., straight, spin] = constants(of);
    let alike = straight.wheels.into_iter().zip(spin.wheels).all(
        |((straight, straight_off), (spin, spin_off))| {
            let off = straight_off.hypot(spin_off);
            (straight - spin).abs() < ALIKE * straight && off < 2.0 * ALIKE * straight
        },
    );
    match (alike, wheels_up) {
        (true, false) => Some(
            "kA is the same straight on and on the spot, as of wheels in the air or without grip: did the robot move as far as its wheels turned?",
        ),
        (false, true) => Some(
            "kA is not the same straight on and on the spot, or not known well enough to tell: are both wheels in the air?",
        ),
        _ => None,
    }
}

/// How well the wheels follow, in one respect.
pub struct FollowingRow {
    /// With its unit.
    pub name: &'static str,
    /// So many are worth printing.
    pub decimals: usize,
    /// Before; None if the robot stopped with a fault.
    pub before: Option<f64>,
    /// Now.
    pub after: f64,
}

/// How well the wheels followed before, and how well they do now.
pub fn following(before: &DriveOutcome, after: &Following) -> [FollowingRow; 5] {
    let row = |name, decimals, of: fn(&Following) -> f64| {
        let before = match before {
            DriveOutcome::Followed(before) => Some(of(before)),
            DriveOutcome::Faulted(_) => None,
        };
        FollowingRow { name, decimals, before, after: of(after) }
    };
    [
        row("rms, fast [mm]", 3, |following| following.fast_rms_m * 1e3),
        row("worst [mm]", 3, |following| following.worst_m * 1e3),
        row("settling [ms]", 0, |following| following.settling_s * 1e3),
        row("overshoot [%]", 2, |following| following.overshoot * 100.0),
        row("duty noise [%]", 2, |following| following.duty_noise * 100.0),
    ]
}

/// The limits that were lowered to what the motors reach, each in a sentence.
pub fn lowered(tuned: &Tuned) -> Vec<String> {
    let (before, after) = (&tuned.change.0.limits, &tuned.change.1.limits);
    [
        ("speed_mps_max", "m/s", before.speed_mps_max, after.speed_mps_max),
        (
            "acceleration_mps2_max",
            "m/s^2",
            before.acceleration_mps2_max,
            after.acceleration_mps2_max,
        ),
        (
            "stop_deceleration_mps2",
            "m/s^2",
            before.stop_deceleration_mps2,
            after.stop_deceleration_mps2,
        ),
    ]
    .into_iter()
    .filter(|(_, _, before, after)| after < before)
    .map(|(field, unit, before, after)| {
        format!(
            "limits.{field} {before:.3} -> {after:.3} {unit}: with this supply the motors reach no more and keep some for the loop"
        )
    })
    .collect()
}
