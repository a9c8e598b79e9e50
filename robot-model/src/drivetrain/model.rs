//! The motors' equation, and the travel that follows from a voltage.

use super::recording::VoltageRecording;
use crate::kinematics::WheelPair;
use crate::numeric::lanes::Number;

/// One wheel's motor, gear and share of the robot. The fit moves several models beside each other: one in each lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelMotor<T = f64> {
    /// Voltage that overcomes friction forwards, kS+ \[V\].
    pub ks_forward_v: T,
    /// Voltage that overcomes friction backwards, kS-, positive \[V\].
    pub ks_backward_v: T,
    /// Voltage per speed, kV \[V s/m\].
    pub kv_v_s_per_m: T,
    /// Voltage per acceleration of this wheel, kA \[V s^2/m\].
    pub ka_v_s2_per_m: T,
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
    pub fn travel_m(&self, recording: &VoltageRecording) -> Vec<WheelPair<f64>> {
        Couple { wheels: self.wheels, kc: self.kc_v_s2_per_m, kw: self.kw_v_s2_per_m2 }
            .travel_m(self.delay_s, recording)
    }
}

/// What moves after the delay: one robot, or one in each lane.
pub(super) struct Couple<T> {
    /// Each wheel's motor.
    pub wheels: WheelPair<WheelMotor<T>>,
    /// kC \[V s^2/m\].
    pub kc: T,
    /// kW \[V s^2/m^2\].
    pub kw: T,
}

impl<T: Number> Couple<T> {
    /// Travel at each sample \[m\], from rest at the first one, by voltages that act after this delay.
    ///
    /// The trapezoidal rule with steps of a millisecond at most. Friction is what it must be to hold a wheel or to stop
    /// it, within kS.
    pub fn travel_m(&self, delay_s: f64, recording: &VoltageRecording) -> Vec<WheelPair<T>> {
        let samples = recording.samples();
        let mut cursor = 0;
        let mut wheels = Wheels::at_rest();
        let mut travel = Vec::with_capacity(samples.len());
        travel.push(wheels.travel_m);
        let mut applied = recording.applied_vs_at(samples[0].t_s - delay_s, &mut cursor);
        for pair in samples.windows(2) {
            let dt_s = pair[1].t_s - pair[0].t_s;
            let steps = (dt_s / STEP_S).ceil().clamp(1.0, 10_000.0);
            let h_s = dt_s / steps;
            let scheme = Scheme::new(&self.wheels, self.kc, h_s);
            for step in 1..=steps as usize {
                let t_s = pair[0].t_s + step as f64 * h_s;
                let next = recording.applied_vs_at(t_s - delay_s, &mut cursor);
                let volts = next.zip(applied).map(|(next, before)| (next - before) / h_s);
                applied = next;
                let volts = turning(self.kw, wheels.speed_mps, volts.map(T::of));
                scheme.step(&mut wheels, volts);
            }
            travel.push(wheels.travel_m);
        }
        travel
    }
}

/// The voltages that are left after what kW takes.
pub(super) fn turning<T: Number>(
    kw_v_s2_per_m2: T,
    speed_mps: WheelPair<T>,
    volts: WheelPair<T>,
) -> WheelPair<T> {
    let WheelPair { left, right } = speed_mps;
    WheelPair::new(
        volts.left - kw_v_s2_per_m2 * right * (right - left),
        volts.right - kw_v_s2_per_m2 * left * (left - right),
    )
}

/// Both wheels' state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wheels<T> {
    /// Since the first sample \[m\].
    pub travel_m: WheelPair<T>,
    /// Speed \[m/s\].
    pub speed_mps: WheelPair<T>,
    /// Friction of the last step, against forward motion \[V\].
    pub friction_v: WheelPair<T>,
}

impl<T: Number> Wheels<T> {
    /// At the first sample.
    pub fn at_rest() -> Self {
        let zero = WheelPair::both(T::of(0.0));
        Self { travel_m: zero, speed_mps: zero, friction_v: zero }
    }
}

/// One step of the trapezoidal rule: (M + h/2 K) v' = (M - h/2 K) v + h (V - F).
pub(super) struct Scheme<T> {
    motors: WheelPair<WheelMotor<T>>,
    kc_v_s2_per_m: T,
    h_s: T,
    /// Half a step \[s\].
    half_s: T,
    /// Inverse of the left side: on the diagonal for each wheel, and beside it.
    inverse: (T, T, T),
    /// Voltage that stops a wheel within the step, per speed at its end.
    of_speed: WheelPair<T>,
}

impl<T: Number> Scheme<T> {
    /// For motors that are coupled by kC, and a step of h.
    pub fn new(motors: &WheelPair<WheelMotor<T>>, kc_v_s2_per_m: T, h_s: f64) -> Self {
        let (h_s, half_s) = (T::of(h_s), T::of(0.5 * h_s));
        let diagonal = |motor: &WheelMotor<T>| motor.ka_v_s2_per_m + half_s * motor.kv_v_s_per_m;
        let (left, right) = (diagonal(&motors.left), diagonal(&motors.right));
        let beside = kc_v_s2_per_m;
        let determinant = left * right - beside * beside;
        let inverse = (right / determinant, left / determinant, -beside / determinant);
        let one = T::of(1.0);
        let of_speed = WheelPair::new(one / (h_s * inverse.0), one / (h_s * inverse.1));
        Self { motors: *motors, kc_v_s2_per_m, h_s, half_s, inverse, of_speed }
    }

    /// Moves both wheels on by a step, at these voltages.
    pub fn step(&self, wheels: &mut Wheels<T>, volts: WheelPair<T>) {
        let Self { motors, kc_v_s2_per_m, h_s, half_s, inverse: (left, right, beside), of_speed } =
            *self;
        let before = wheels.speed_mps;
        let kept = |motor: &WheelMotor<T>, own: T, other: T| {
            (motor.ka_v_s2_per_m - half_s * motor.kv_v_s_per_m) * own + kc_v_s2_per_m * other
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
            // Wheels that slide have the friction of the step before: nothing would change any more. Nor would it in
            // a lane that is swept on because of another one.
            if friction.left.equals(before_sweep.left) && friction.right.equals(before_sweep.right)
            {
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
            wheels.travel_m.left + half_s * (before.left + after.left),
            wheels.travel_m.right + half_s * (before.right + after.right),
        );
    }
}

/// Friction that would hold a wheel, within what it has.
fn held<T: Number>(motor: &WheelMotor<T>, wanted_v: T) -> T {
    wanted_v.within(-motor.ks_backward_v, motor.ks_forward_v)
}
