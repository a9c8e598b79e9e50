//! All effects of a model put together: what one step moves the robot by, and how that depends on
//! every free parameter. Equations (1) to (4) of [`crate::effect`].

use crate::effect::definition::{Change, Effect, Memory, View};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::Jet;
use crate::recording::motion::Step;

/// One effect at certain parameter values.
#[derive(Clone, Debug)]
pub struct Term<'a> {
    /// The effect.
    pub effect: &'a dyn Effect,
    /// Its parameters' values.
    pub values: Vec<f64>,
    /// Index of its first column, if its parameters are free.
    pub column: Option<usize>,
}

/// What a step moves the robot by, in its own frame at the middle of the turn; or the derivative of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Increment {
    pub travel_m: f64,
    pub sideways_m: f64,
    pub turn_rad: f64,
    pub drift_m: [f64; 2],
}

/// The terms at work in one run.
pub(crate) struct Composer<'a> {
    terms: &'a [Term<'a>],
    parameters: Vec<[Jet; crate::numeric::jet::PARAMETERS_MAX]>,
    memories: Vec<Memory>,
    changes: Vec<Change>,
    /// The derivative of the last step's increment by each column.
    pub by_column: Vec<Increment>,
}

impl<'a> Composer<'a> {
    pub fn new(terms: &'a [Term<'a>], columns: usize) -> Self {
        Self {
            terms,
            parameters: terms.iter().map(|term| Jet::parameters(&term.values)).collect(),
            memories: vec![Memory::default(); terms.len()],
            changes: vec![Change::NONE; terms.len()],
            by_column: vec![Increment::default(); columns],
        }
    }

    /// What the terms together change in the measured pose, and each column's derivative of it.
    pub fn view(&self) -> (View, Vec<View>) {
        let mut sum = View::NONE;
        let mut by_column = vec![View::NONE; self.by_column.len()];
        for (term, p) in self.terms.iter().zip(&self.parameters) {
            let view = term.effect.observe(p);
            sum.offset_m[0].value += view.offset_m[0].value;
            sum.offset_m[1].value += view.offset_m[1].value;
            sum.delay_s.value += view.delay_s.value;
            let Some(first) = term.column else { continue };
            for j in 0..term.values.len() {
                let slope = &mut by_column[first + j];
                slope.offset_m = view.offset_m.map(|it| Jet::constant(it.by[j]));
                slope.delay_s = Jet::constant(view.delay_s.by[j]);
            }
        }
        (sum, by_column)
    }

    /// The increment of a step; [`Composer::by_column`] has its derivatives afterwards.
    pub fn step(&mut self, step: &Step) -> Increment {
        let mut angle = step.dphi_rad;
        let mut travel = WheelPair::both(1.0);
        let mut turning = 1.0;
        let mut sum = Increment::default();
        for (i, term) in self.terms.iter().enumerate() {
            let change = term.effect.act(&self.parameters[i], step, &mut self.memories[i]);
            angle = angle.zip(change.angle_rad).map(|(sum, it)| sum + it.value);
            travel = travel.zip(change.travel).map(|(product, it)| product * (1.0 + it.value));
            turning *= 1.0 + change.turning.value;
            sum.turn_rad += change.turn_rad.value;
            sum.sideways_m += change.sideways_m.value;
            sum.drift_m[0] += change.drift_m[0].value;
            sum.drift_m[1] += change.drift_m[1].value;
            self.changes[i] = change;
        }
        let wheels_m = angle.zip(travel).map(|(dphi, factor)| step.wheel_radius_m * dphi * factor);
        let wheel_turn_rad = wheels_m.difference() / step.track_width_m;
        sum.travel_m = wheels_m.mean();
        sum.turn_rad += wheel_turn_rad * turning;
        for (term, change) in self.terms.iter().zip(&self.changes) {
            let Some(first) = term.column else { continue };
            for j in 0..term.values.len() {
                let by_wheel = wheels_m.zip(travel).zip(change.angle_rad.zip(change.travel)).map(
                    |((ds_m, factor), (angle, travel))| {
                        step.wheel_radius_m * angle.by[j] * factor
                            + ds_m * travel.by[j] / (1.0 + travel.value)
                    },
                );
                self.by_column[first + j] = Increment {
                    travel_m: by_wheel.mean(),
                    turn_rad: by_wheel.difference() / step.track_width_m * turning
                        + wheel_turn_rad * turning * change.turning.by[j]
                            / (1.0 + change.turning.value)
                        + change.turn_rad.by[j],
                    sideways_m: change.sideways_m.by[j],
                    drift_m: change.drift_m.map(|it| it.by[j]),
                };
            }
        }
        sum
    }
}
