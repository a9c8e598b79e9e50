//! Which travel follows from the voltages, with effects?
//!
//! The baseline, for both wheels and directions alike but for kD:
//!
//! ```text
//! V = kS sgn v + kV v + (kA + m kD) a + kC a_other + kW v_other (v_other - v)                        (1)
//! ```
//!
//! with m = 1 for the left wheel, -1 for the right one. kD: wheels with unequal radii, or a centre of mass off the midline, make
//! one wheel carry more inertia. kC and kW are those of the parent module's (1).
//!
//! Each effect changes what acts in a step (`Acting`). Play in the gear has a state of its own: while neither flank carries, the
//! motor has its share of the inertia, and the wheel rolls on; where they meet, they keep their momentum.

use super::experiment::{Experiment, KnownRobot};
use crate::drivetrain::effect::{Acting, KnownMotorEffect, MotorEffect, Play, moments};
use crate::drivetrain::model::{Scheme, WheelMotor, Wheels, turning};
use crate::kinematics::WheelPair;

/// Longest step of the integration \[s\].
const STEP_S: f64 = 2.5e-3;
/// Share of the friction that a wheel has by itself, behind the play.
const WHEEL_FRICTION_SHARE: f64 = 0.1;
/// How many constants the baseline has: kS, kV, kA, kC, kD, kW.
pub(super) const BASELINE: usize = 6;

/// A model: constants of the baseline, then the parameters of its effects one after the other.
pub(super) struct Simulation<'a> {
    pub robot: &'a KnownRobot,
    /// When the longest pause between two experiments ended; infinite without one \[s\].
    pub pause_end_s: f64,
    /// The highest voltage of the campaign \[V\].
    pub full_v: f64,
    pub effects: &'a [KnownMotorEffect],
    pub at: &'a [f64],
}

impl Simulation<'_> {
    /// Its effects with their parameters.
    fn terms(&self) -> impl Iterator<Item = (&dyn MotorEffect, &[f64])> {
        let mut next = BASELINE;
        self.effects.iter().map(move |effect| {
            let first = next;
            next += effect.facts().parameters.len();
            (&**effect, &self.at[first..next])
        })
    }

    /// The baseline's motors, kC and kW.
    fn baseline(&self) -> (WheelPair<WheelMotor>, f64, f64) {
        let [ks, kv, ka, kc, kd, kw] = core::array::from_fn(|i| self.at[i]);
        let motor = |ka_v_s2_per_m| WheelMotor {
            ks_forward_v: ks,
            ks_backward_v: ks,
            kv_v_s_per_m: kv,
            ka_v_s2_per_m,
        };
        (WheelPair::new(motor(ka + kd), motor(ka - kd)), kc, kw)
    }

    /// Since the longest pause, infinite before it \[s\].
    fn since_pause_s(&self, time_s: f64) -> f64 {
        if time_s < self.pause_end_s { f64::INFINITY } else { time_s - self.pause_end_s }
    }

    /// Travel at each sample since the first one \[m\].
    pub fn travel_m(&self, experiment: &Experiment) -> Vec<WheelPair<f64>> {
        let recording = &experiment.recording;
        let samples = recording.samples();
        let delay_s: f64 = self.terms().map(|(effect, p)| effect.delay_s(p)).sum();
        let play = self.terms().find_map(|(effect, p)| effect.play(p));
        let (motors, kc, kw) = self.baseline();
        let turn_m = self.robot.turn_m();
        let origin_m = samples[0].travel_m;
        let mut gears = play.map(Gears::new);
        let mut cursor = 0;
        let mut wheels = Wheels::at_rest();
        let mut travel = Vec::with_capacity(samples.len());
        travel.push(WheelPair::both(0.0));
        let mut applied = recording.applied_vs_at(samples[0].t_s - delay_s, &mut cursor);
        for pair in samples.windows(2) {
            let dt_s = pair[1].t_s - pair[0].t_s;
            let steps = (dt_s / STEP_S - 1e-6).ceil().clamp(1.0, 4000.0);
            let h_s = dt_s / steps;
            for step in 1..=steps as usize {
                let t_s = pair[0].t_s + step as f64 * h_s;
                let next = recording.applied_vs_at(t_s - delay_s, &mut cursor);
                let volts = next.zip(applied).map(|(next, before)| (next - before) / h_s);
                applied = next;
                let turns =
                    wheels.travel_m.zip(origin_m).map(|(moved, origin)| (moved + origin) / turn_m);
                let time_s = experiment.started_s + t_s - samples[0].t_s;
                let turned_m = wheels.travel_m.right - wheels.travel_m.left;
                let heading_rad = experiment.heading_rad + turned_m / self.robot.track_width_m;
                let clock = (time_s, self.since_pause_s(time_s), heading_rad);
                let moment = moments(wheels.speed_mps, (volts, self.full_v), turns, clock);
                let acting = moment.zip(volts).zip(motors).map(|((moment, volts), motor)| {
                    let mut acting = Acting { volts, motor };
                    self.terms().for_each(|(effect, p)| effect.act(p, &moment, &mut acting));
                    acting
                });
                let volts = turning(kw, wheels.speed_mps, acting.map(|acting| acting.volts));
                match &mut gears {
                    None => {
                        let motors = acting.map(|acting| acting.motor);
                        let scheme = Scheme::new(&motors, kc, h_s);
                        scheme.step(&mut wheels, volts);
                    }
                    Some(gears) => gears.step(&mut wheels, acting, volts, (kc, h_s)),
                }
            }
            travel.push(wheels.travel_m);
        }
        travel
    }
}

/// Play in both gears. The travel is the motors'.
struct Gears {
    play: Play,
    wheel: WheelPair<Behind>,
}

/// What is behind the play.
#[derive(Clone, Copy, Debug, Default)]
struct Behind {
    /// How far the motor is ahead of its wheel \[m\].
    ahead_m: f64,
    /// The wheel's own speed, while no flank carries \[m/s\].
    free_mps: Option<f64>,
}

impl Gears {
    fn new(play: Play) -> Self {
        Self { play, wheel: WheelPair::both(Behind { ahead_m: 0.0, free_mps: Some(0.0) }) }
    }

    fn step(
        &mut self,
        wheels: &mut Wheels<f64>,
        acting: WheelPair<Acting>,
        volts: WheelPair<f64>,
        (kc, h_s): (f64, f64),
    ) {
        let Self { play, wheel } = self;
        let is_free = wheel.map(|behind| behind.free_mps.is_some());
        let motors = acting.zip(is_free).map(|(acting, free)| {
            let mut motor = acting.motor;
            if free {
                motor.ka_v_s2_per_m *= play.motor_share;
            }
            motor
        });
        let coupled = if is_free.left || is_free.right { 0.0 } else { kc };
        let before = wheels.speed_mps;
        let scheme = Scheme::new(&motors, coupled, h_s);
        scheme.step(wheels, volts);
        let WheelPair { left, right } = acting;
        wheel.left.follow(play, &left.motor, before.left, &mut wheels.speed_mps.left, h_s);
        wheel.right.follow(play, &right.motor, before.right, &mut wheels.speed_mps.right, h_s);
    }
}

impl Behind {
    /// Follows the motor for a step: opens where the motor brakes harder than the wheel by itself, meets a flank otherwise.
    fn follow(
        &mut self,
        play: &Play,
        motor: &WheelMotor,
        before_mps: f64,
        speed_mps: &mut f64,
        h_s: f64,
    ) {
        let half_m = 0.5 * play.travel_m;
        let wheel_inertia = (1.0 - play.motor_share) * motor.ka_v_s2_per_m;
        let slower_mps = WHEEL_FRICTION_SHARE * motor.ks_forward_v / wheel_inertia * h_s;
        let rolled = |speed_mps: f64| speed_mps - speed_mps.clamp(-slower_mps, slower_mps);
        let Some(free_mps) = self.free_mps else {
            // On the flank in front the motor pushes forwards; it leaves where the wheel would be faster.
            let alone_mps = rolled(before_mps);
            if (alone_mps - *speed_mps) * self.ahead_m.signum() > 0.0 {
                self.free_mps = Some(alone_mps);
            }
            return;
        };
        let free_mps = rolled(free_mps);
        self.ahead_m += (*speed_mps - free_mps) * h_s;
        self.free_mps = Some(free_mps);
        if self.ahead_m.abs() >= half_m {
            self.ahead_m = half_m.copysign(self.ahead_m);
            let together = play.motor_share * *speed_mps + (1.0 - play.motor_share) * free_mps;
            *speed_mps = together;
            self.free_mps = None;
        }
    }
}
