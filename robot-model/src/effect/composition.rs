//! What do all effects of a model together do in one step, and how does that depend on every free parameter?
//! Equations (1) to (4) of [`crate::effect`].
//!
//! The equation of each effect is in its own file in `catalogue/`.

use core::ops::{Deref, Range};

use crate::effect::definition::{Change, Effect, Memory, Role, View};
use crate::effect::slopes::{Slopes, WheelsAndTurn};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// One effect at certain parameter values.
#[derive(Clone, Debug)]
pub(crate) struct Term<'a> {
    /// The effect.
    pub effect: &'a dyn Effect,
    /// Its parameters' values.
    pub values: Vec<f64>,
    /// Faster than this it acts as it does on the same curve at this speed of the faster wheel \[m/s\].
    pub up_to_mps: Option<f64>,
}

impl<'a> Term<'a> {
    pub fn new(effect: &'a dyn Effect, values: Vec<f64>) -> Self {
        Self { effect, values, up_to_mps: None }
    }

    /// What it changes in a step.
    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, memory: &mut Memory) -> Change {
        let up_to_mps = self.up_to_mps.unwrap_or(f64::INFINITY);
        let speeds_mps = step.wheel_speed_mps.map(f64::abs);
        let faster_mps = speeds_mps.left.max(speeds_mps.right);
        if faster_mps <= up_to_mps {
            return self.effect.act(p, step, memory);
        }
        let share = up_to_mps / faster_mps;
        let wheel_speed_mps = step.wheel_speed_mps.map(|v| share * v);
        self.effect.act(p, &Step { wheel_speed_mps, ..*step }, memory)
    }

    /// Whether it does something else at another speed, up to twice this one \[m/s\].
    pub fn depends_on_speed(&self, speed_mps: f64) -> bool {
        let p = Jet::parameters(&self.values);
        let change = |times: f64| {
            // A gentle curve, in the middle of a run.
            let step = Step {
                dt_s: 0.01,
                dphi_rad: WheelPair::new(0.08, 0.1),
                wheel_speed_mps: WheelPair::new(0.8, 1.0).map(|v| v * times * speed_mps),
                path_m: 1.0,
                since_reversal_m: Some(1.0),
                wheel_radius_m: 0.03,
                track_width_m: 0.2,
                gear_reduction: 1.0,
                ..Step::default()
            };
            self.effect.act(&p, &step, &mut Memory::default())
        };
        [0.25, 0.5, 2.0].into_iter().any(|times| change(times) != change(1.0))
    }
}

/// A term whose parameters are free: each has its column in the normal equations.
#[derive(Clone, Debug)]
pub(crate) struct PlacedTerm<'a> {
    term: Term<'a>,
    first: usize,
}

impl<'a> PlacedTerm<'a> {
    /// Gives every parameter of these terms a column, in their order.
    pub fn place(terms: &[Term<'a>]) -> Vec<Self> {
        let mut next = 0;
        let place = |term: &Term<'a>| {
            let first = next;
            next += term.values.len();
            Self { term: term.clone(), first }
        };
        terms.iter().map(place).collect()
    }

    /// The columns of its parameters.
    pub fn columns(&self) -> Range<usize> {
        self.first..self.first + self.values.len()
    }

    /// The columns of its amplitudes.
    pub fn amplitudes(&self) -> Vec<usize> {
        let parameters = self.columns().zip(self.effect.facts().parameters);
        parameters.filter(|(_, of)| of.role == Role::Amplitude).map(|(column, _)| column).collect()
    }

    /// The value of the parameter in one of its columns.
    pub fn value(&self, column: usize) -> f64 {
        self.values[column - self.first]
    }

    /// The same term at fixed values.
    pub fn fixed(&self) -> Term<'a> {
        self.term.clone()
    }
}

impl<'a> Deref for PlacedTerm<'a> {
    type Target = Term<'a>;

    fn deref(&self) -> &Term<'a> {
        &self.term
    }
}

/// The terms of a model: at fixed values, or with derivatives by every parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Terms<'t, 'a> {
    Fixed(&'t [Term<'a>]),
    Free(&'t [PlacedTerm<'a>]),
}

impl<'t, 'a> Terms<'t, 'a> {
    /// The number of columns.
    pub fn columns(self) -> usize {
        match self {
            Self::Fixed(_) => 0,
            Self::Free(terms) => terms.iter().map(|term| term.columns().end).max().unwrap_or(0),
        }
    }

    /// Each term, with its first column if its parameters are free.
    pub fn each(self) -> Vec<(&'t Term<'a>, Option<usize>)> {
        match self {
            Self::Fixed(terms) => terms.iter().map(|term| (term, None)).collect(),
            Self::Free(terms) => {
                terms.iter().map(|placed| (&placed.term, Some(placed.first))).collect()
            }
        }
    }
}

/// The motion of the robot in one step, in its own frame at the middle of the turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Increment {
    pub travel_m: f64,
    pub sideways_m: f64,
    pub turn_rad: f64,
    /// The derivative of the turn by the heading.
    pub turn_by_heading: f64,
    pub drift_m: [f64; 2],
}

/// The terms of a model in one run, with their memories.
pub(crate) struct Composer<'a> {
    terms: Vec<(&'a Term<'a>, Option<usize>)>,
    parameters: Vec<[Jet; PARAMETERS_MAX]>,
    memories: Vec<Memory>,
    columns: usize,
    /// The derivatives of the last step's increment by each column.
    pub slopes: Slopes,
}

impl<'a> Composer<'a> {
    pub fn new(terms: Terms<'a, 'a>) -> Self {
        let (each, columns) = (terms.each(), terms.columns());
        Self {
            parameters: each.iter().map(|(term, _)| Jet::parameters(&term.values)).collect(),
            memories: vec![Memory::default(); each.len()],
            columns,
            slopes: Slopes::new(columns),
            terms: each,
        }
    }

    /// Values without derivatives, whether or not parameters are free.
    pub fn without_derivatives(terms: Terms<'a, 'a>) -> Self {
        let composer = Self::new(terms);
        let terms = composer.terms.iter().map(|(term, _)| (*term, None)).collect();
        Self { terms, columns: 0, slopes: Slopes::new(0), ..composer }
    }

    /// What all terms together change in the measured pose, and its derivative by each column.
    pub fn view(&self) -> (View, Vec<View>) {
        let mut sum = View::NONE;
        let mut by_column = vec![View::NONE; self.columns];
        for ((term, first), p) in self.terms.iter().zip(&self.parameters) {
            let view = term.effect.observe(p);
            sum.offset_m[0].value += view.offset_m[0].value;
            sum.offset_m[1].value += view.offset_m[1].value;
            sum.delay_s.value += view.delay_s.value;
            sum.heading_drift_rad_s.value += view.heading_drift_rad_s.value;
            let Some(first) = first else { continue };
            for j in 0..term.values.len() {
                let slope = &mut by_column[first + j];
                slope.offset_m = view.offset_m.map(|offset| Jet::constant(offset.by[j]));
                slope.delay_s = Jet::constant(view.delay_s.by[j]);
                slope.heading_drift_rad_s = Jet::constant(view.heading_drift_rad_s.by[j]);
            }
        }
        (sum, by_column)
    }

    /// The increment of a step; [`Composer::slopes`] has its derivatives afterwards.
    pub fn step(&mut self, step: &Step) -> Increment {
        let mut angle = step.dphi_rad;
        let mut travel = WheelPair::both(1.0);
        let mut turning = 1.0;
        let mut sum = Increment::default();
        for (i, (term, first)) in self.terms.iter().enumerate() {
            let change = term.act(&self.parameters[i], step, &mut self.memories[i]);
            angle = angle.zip(change.angle_rad).map(|(sum, change)| sum + change.value);
            travel =
                travel.zip(change.travel).map(|(product, change)| product * (1.0 + change.value));
            turning *= 1.0 + change.turning.value;
            sum.turn_rad += change.turn_rad.value;
            sum.turn_by_heading += change.turn_by_heading;
            sum.sideways_m += change.sideways_m.value;
            sum.drift_m[0] += change.drift_m[0].value;
            sum.drift_m[1] += change.drift_m[1].value;
            if let Some(first) = first {
                self.slopes.set(*first..first + term.values.len(), &change);
            }
        }
        let wheels_m = angle.zip(travel).map(|(dphi, factor)| step.wheel_radius_m * dphi * factor);
        let wheel_turn_rad = wheels_m.difference() / step.track_width_m;
        sum.travel_m = wheels_m.mean();
        sum.turn_rad += wheel_turn_rad * turning;
        if self.columns > 0 {
            self.slopes.combine(&WheelsAndTurn {
                by_angle_m: travel.map(|factor| step.wheel_radius_m * factor),
                wheels_m,
                by_difference: turning / step.track_width_m,
                turn_rad: wheel_turn_rad * turning,
            });
        }
        sum
    }
}
