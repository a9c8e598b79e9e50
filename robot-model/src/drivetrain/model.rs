//! The motors' equation, and the travel that follows from a voltage.

use super::recording::VoltageRecording;
use crate::kinematics::WheelPair;

/// One wheel's motor, gear and share of the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelMotor {
    /// Voltage that overcomes friction forwards, kS+ \[V\].
    pub ks_forward_v: f64,
    /// Voltage that overcomes friction backwards, kS-, positive \[V\].
    pub ks_backward_v: f64,
    /// Voltage per speed, kV \[V s/m\].
    pub kv_v_s_per_m: f64,
    /// Voltage per acceleration of this wheel, kA \[V s^2/m\].
    pub ka_v_s2_per_m: f64,
}

impl WheelMotor {
    /// Friction, mean of both directions \[V\].
    pub fn ks_mean_v(&self) -> f64 {
        0.5 * (self.ks_forward_v + self.ks_backward_v)
    }
}

/// Both motors and what couples them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drivetrain {
    /// Each wheel's.
    pub wheels: WheelPair<WheelMotor>,
    /// Voltage per acceleration of the other wheel, kC \[V s^2/m\].
    pub kc_v_s2_per_m: f64,
    /// Voltage per product of speeds, kW: what turning takes with the centre of mass off the axle \[V s^2/m^2\].
    pub kw_v_s2_per_m2: f64,
    /// From the voltage to its effect, tau \[s\].
    pub delay_s: f64,
}

/// Longest step of the integration \[s\].
const STEP_S: f64 = 1e-3;
/// Sweeps over both wheels' friction; they are coupled weakly.
const SWEEPS: usize = 4;

impl Drivetrain {
    /// kA straight on and on the spot, of one wheel \[V s^2/m\].
    pub fn ka_of_robot(&self, wheel: &WheelMotor) -> (f64, f64) {
        (wheel.ka_v_s2_per_m + self.kc_v_s2_per_m, wheel.ka_v_s2_per_m - self.kc_v_s2_per_m)
    }

    /// Travel at each sample \[m\], from rest at the first one, by the recording's voltages alone.
    ///
    /// The trapezoidal rule with steps of a millisecond at most. Friction is what it must be to hold a wheel or to stop
    /// it, within kS.
    pub fn travel_m(&self, recording: &VoltageRecording) -> Vec<WheelPair<f64>> {
        let samples = recording.samples();
        let mut cursor = 0;
        let mut wheels = Wheels::default();
        let mut travel = Vec::with_capacity(samples.len());
        travel.push(WheelPair::both(0.0));
        let mut applied = recording.applied_vs_at(samples[0].t_s - self.delay_s, &mut cursor);
        for pair in samples.windows(2) {
            let dt_s = pair[1].t_s - pair[0].t_s;
            let steps = (dt_s / STEP_S).ceil().clamp(1.0, 10_000.0);
            let h_s = dt_s / steps;
            let scheme = Scheme::new(&self.wheels, self.kc_v_s2_per_m, h_s);
            for step in 1..=steps as usize {
                let t_s = pair[0].t_s + step as f64 * h_s;
                let next = recording.applied_vs_at(t_s - self.delay_s, &mut cursor);
                let volts = next.zip(applied).map(|(next, before)| (next - before) / h_s);
                applied = next;
                let volts = turning(self.kw_v_s2_per_m2, wheels.speed_mps, volts);
                scheme.step(&mut wheels, volts);
            }
            travel.push(wheels.travel_m);
        }
        travel
    }
}

/// The voltages that are left after what kW takes.
pub(super) fn turning(
    kw_v_s2_per_m2: f64,
    speed_mps: WheelPair<f64>,
    volts: WheelPair<f64>,
) -> WheelPair<f64> {
    let WheelPair { left, right } = speed_mps;
    WheelPair::new(
        volts.left - kw_v_s2_per_m2 * right * (right - left),
        volts.right - kw_v_s2_per_m2 * left * (left - right),
    )
}

/// Both wheels' state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wheels {
    /// Since the first sample \[m\].
    pub travel_m: WheelPair<f64>,
    /// Speed \[m/s\].
    pub speed_mps: WheelPair<f64>,
    /// Friction of the last step, against forward motion \[V\].
    pub friction_v: WheelPair<f64>,
}

/// One step of the trapezoidal rule: (M + h/2 K) v' = (M - h/2 K) v + h (V - F).
pub(super) struct Scheme {
    motors: WheelPair<WheelMotor>,
    kc_v_s2_per_m: f64,
    h_s: f64,
    /// Inverse of the left side: on the diagonal for each wheel, and beside it.
    inverse: (f64, f64, f64),
    /// Voltage that stops a wheel within the step, per speed at its end.
    of_speed: WheelPair<f64>,
}

impl Scheme {
    /// For motors that are coupled by kC, and a step of h.
    pub fn new(motors: &WheelPair<WheelMotor>, kc_v_s2_per_m: f64, h_s: f64) -> Self {
        let diagonal = |motor: &WheelMotor| motor.ka_v_s2_per_m + 0.5 * h_s * motor.kv_v_s_per_m;
        let (left, right) = (diagonal(&motors.left), diagonal(&motors.right));
        let beside = kc_v_s2_per_m;
        let determinant = left * right - beside * beside;
        let inverse = (right / determinant, left / determinant, -beside / determinant);
        let of_speed = WheelPair::new(1.0 / (h_s * inverse.0), 1.0 / (h_s * inverse.1));
        Self { motors: *motors, kc_v_s2_per_m, h_s, inverse, of_speed }
    }

    /// Moves both wheels on by a step, at these voltages.
    pub fn step(&self, wheels: &mut Wheels, volts: WheelPair<f64>) {
        let Self { motors, kc_v_s2_per_m, h_s, inverse: (left, right, beside), of_speed } = *self;
        let before = wheels.speed_mps;
        let kept = |motor: &WheelMotor, own: f64, other: f64| {
            (motor.ka_v_s2_per_m - 0.5 * h_s * motor.kv_v_s_per_m) * own + kc_v_s2_per_m * other
        };
        let free = WheelPair::new(
            kept(&motors.left, before.left, before.right) + h_s * volts.left,
            kept(&motors.right, before.right, before.left) + h_s * volts.right,
        );
        let mut friction = wheels.friction_v;
        let mut after = before;
        for _ in 0..SWEEPS {
            let before_sweep = friction;
            let push =
                WheelPair::new(free.left - h_s * friction.left, free.right - h_s * friction.right);
            after.left = left * push.left + beside * push.right;
            friction.left = held(&motors.left, friction.left + after.left * of_speed.left);
            let push_left = free.left - h_s * friction.left;
            after.right = right * push.right + beside * push_left;
            friction.right = held(&motors.right, friction.right + after.right * of_speed.right);
            // Wheels that slide have the friction of the step before: nothing would change any more.
            if friction == before_sweep {
                break;
            }
        }
        let push =
            WheelPair::new(free.left - h_s * friction.left, free.right - h_s * friction.right);
        after.left = left * push.left + beside * push.right;
        after.right = right * push.right + beside * push.left;
        wheels.friction_v = friction;
        wheels.speed_mps = after;
        wheels.travel_m = WheelPair::new(
            wheels.travel_m.left + 0.5 * h_s * (before.left + after.left),
            wheels.travel_m.right + 0.5 * h_s * (before.right + after.right),
        );
    }
}

/// Friction that would hold a wheel, within what it has.
fn held(motor: &WheelMotor, wanted_v: f64) -> f64 {
    wanted_v.max(-motor.ks_backward_v).min(motor.ks_forward_v)
}
