//! What is left over once the model has said its part: does it depend on anything?
//!
//! Each regressor is a handful of probes: turns, travels and drifts in proportion to functions of
//! something that a step tells. They go through the same filter as the effects, so that what is tested
//! is what they would do to the track. Of those that show, the strongest is taken in, and the rest is
//! tested again, so that what merely resembles it is not named too.

use crate::campaign::Prepared;
use crate::effect::{ActsOn, Change, Effect, Facts, Memory, Parameter};
use crate::evidence::Evidence;
use crate::fit::Fitted;
use crate::increment::Term;
use crate::jet::{Jet, PARAMETERS_MAX};
use crate::judge::{Question, judge, run_scatter_in_the_mean, scatter};
use crate::motion::Step;
use crate::ripple::ripple;
use crate::sides::Sides;
use crate::tail::{chi_squared, false_discovery_rates};
use crate::unevenness::unevenness;

/// Regressors are to be named falsely at most this often.
const FALSE_DISCOVERY_RATE: f64 = 0.01;

/// From so many runs on a few of them may have something that the others do not have.
const MANY_RUNS: usize = 8;

/// By chance there is a ripple this seldom.
const RIPPLE_P: f64 = 1e-4;

/// What the residuals depend on, if on anything.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Unexplained {
    /// Whether anything is left.
    pub structure: bool,
    /// The regressors that it depends on, strongest first.
    pub depends_on: Vec<&'static str>,
    /// By chance at least this much, of the strongest regressor, corrected for how many were asked.
    pub p_value: f64,
}

/// A handful of functions of a step, each an amplitude of its own.
struct Probe {
    regressor: &'static str,
    act: fn(&[Jet; PARAMETERS_MAX], &Step) -> Change,
}

impl core::fmt::Debug for Probe {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.regressor)
    }
}

/// Limits far beyond anything: a probe is asked whether it is there, not whether it is plausible.
static PROBE: Facts = Facts {
    id: "probe",
    name: "probe",
    equation: "a sum of functions of one regressor",
    parameters: &[
        Parameter::amplitude("a", "1", 1.0),
        Parameter::amplitude("b", "1", 1.0),
        Parameter::amplitude("c", "1", 1.0),
        Parameter::amplitude("d", "1", 1.0),
    ],
    acts_on: ActsOn::Motion,
    signature: "",
    shown_by: "",
    compensation: "",
};

impl Effect for Probe {
    fn facts(&self) -> &'static Facts {
        &PROBE
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        (self.act)(p, step)
    }
}

fn wheel_harmonic(p: &[Jet; PARAMETERS_MAX], step: &Step, harmonic: f64) -> Change {
    let wave = |c: Jet, s: Jet, phi: f64| {
        let (sin, cos) = (harmonic * phi).sin_cos();
        c * cos + s * sin
    };
    let middle = step.phi_rad.zip(step.dphi_rad).map(|(phi, dphi)| phi + dphi / 2.0);
    let travel = Sides::new(wave(p[0], p[1], middle.left), wave(p[2], p[3], middle.right));
    Change { travel, ..Change::NONE }
}

/// Turning and scale along the path, as a function of something even.
fn path_and_turn(p: &[Jet; PARAMETERS_MAX], step: &Step, x: f64) -> Change {
    let path_m = step.travel_m().abs();
    Change {
        travel: Sides::both(p[0] * x + p[1] * (x * x)),
        turn_rad: (p[2] * x + p[3] * (x * x)) * path_m,
        ..Change::NONE
    }
}

/// Turning in proportion to the rim's rolling, so that spins count too, with scale.
fn wheels(p: &[Jet; PARAMETERS_MAX], x: Sides<f64>) -> Change {
    let travel = Sides::new(
        p[0] * x.left + p[1] * (x.left * x.left.abs()),
        p[2] * x.right + p[3] * (x.right * x.right.abs()),
    );
    Change { travel, ..Change::NONE }
}

static PROBES: &[Probe] = &[
    Probe { regressor: WHEEL_ANGLE, act: |p, step| wheel_harmonic(p, step, 1.0) },
    Probe { regressor: WHEEL_ANGLE, act: |p, step| wheel_harmonic(p, step, 2.0) },
    Probe { regressor: WHEEL_ANGLE, act: |p, step| wheel_harmonic(p, step, 3.0) },
    Probe {
        regressor: WHEEL_ANGLE,
        act: |p, step| {
            let middle = step.phi_rad.zip(step.dphi_rad).map(|(phi, dphi)| phi + dphi / 2.0);
            let (left, right) = (middle.left.sin_cos(), middle.right.sin_cos());
            let aside = p[0] * left.1 + p[1] * left.0 + p[2] * right.1 + p[3] * right.0;
            Change { sideways_m: aside * step.travel_m(), ..Change::NONE }
        },
    },
    Probe {
        regressor: "heading",
        act: |p, step| {
            let (path_m, (sin, cos)) = (step.travel_m().abs(), step.heading_rad.sin_cos());
            Change {
                turn_rad: (p[0] * cos + p[1] * sin) * path_m,
                drift_m: [p[2] * path_m, p[3] * path_m],
                ..Change::NONE
            }
        },
    },
    Probe {
        regressor: "heading",
        act: |p, step| {
            let (sin, cos) = (2.0 * step.heading_rad).sin_cos();
            let path_m = step.travel_m().abs();
            Change {
                travel: Sides::both(p[0] * cos + p[1] * sin),
                turn_rad: (p[2] * cos + p[3] * sin) * path_m,
                ..Change::NONE
            }
        },
    },
    Probe { regressor: "speed", act: |p, step| path_and_turn(p, step, step.speed_mps().abs()) },
    Probe { regressor: "wheel speed", act: |p, step| wheels(p, step.wheel_speed_mps) },
    Probe { regressor: "acceleration", act: |p, step| wheels(p, step.wheel_accel_mps2) },
    Probe {
        regressor: "acceleration",
        act: |p, step| {
            let x = step.wheel_accel_mps2.zip(step.wheel_speed_mps).map(|(a, v)| a * v.signum());
            wheels(p, x)
        },
    },
    Probe {
        regressor: "turn rate",
        act: |p, step| {
            let omega = step.turn_rate_rad_s();
            Change {
                turning: p[0] * omega.abs() + p[1] * omega,
                sideways_m: p[2] * step.turn_rad() + p[3] * step.turn_rad().abs(),
                ..Change::NONE
            }
        },
    },
    Probe {
        regressor: "direction of travel",
        act: |p, step| {
            let v = step.speed_mps();
            Change {
                travel: Sides::both(p[0] * v.signum()),
                turn_rad: p[1] * step.travel_m().abs() + p[2] * step.travel_m(),
                sideways_m: p[3] * step.travel_m(),
                ..Change::NONE
            }
        },
    },
    Probe {
        regressor: "time in the run",
        act: |p, step| {
            let x = step.t_s / 60.0;
            Change {
                travel: Sides::new(p[0] * x, p[1] * x),
                turn_rad: p[2] * (x * step.travel_m().abs()),
                turning: p[3] * x,
                ..Change::NONE
            }
        },
    },
    Probe {
        regressor: "time in the campaign",
        act: |p, step| {
            let x = step.clock_s / 3600.0;
            Change {
                travel: Sides::new(p[0] * x, p[1] * x),
                turn_rad: p[2] * (x * step.travel_m().abs()),
                turning: p[3] * x,
                ..Change::NONE
            }
        },
    },
    Probe {
        regressor: "distance since reversal",
        act: |p, step| {
            let Some(since_m) = step.since_reversal_m else { return Change::NONE };
            let ds_m = step.travel_m();
            let near = |length_m: f64| (-since_m / length_m).exp() * ds_m.abs();
            let sign = ds_m.signum();
            Change {
                turn_rad: (p[0] * sign + p[1]) * near(0.05) + (p[2] * sign + p[3]) * near(0.2),
                ..Change::NONE
            }
        },
    },
    Probe {
        regressor: "place",
        act: |p, step| {
            let [x, y] = step.place_m;
            let path_m = step.travel_m().abs();
            Change {
                turn_rad: (p[0] * x + p[1] * y) * path_m,
                travel: Sides::both(p[2] * x + p[3] * y),
                ..Change::NONE
            }
        },
    },
    Probe {
        regressor: "load",
        act: |p, step| {
            let x = step.payload_kg;
            Change {
                travel: Sides::new(p[0] * x, p[1] * x),
                turn_rad: p[2] * (x * step.travel_m().abs()),
                turning: p[3] * x,
                ..Change::NONE
            }
        },
    },
];

/// Regressors that change from run to run, and hardly within one.
const OF_RUNS: [&str; 2] = ["load", "time in the campaign"];

/// What a run may have for itself: its own travel of either wheel, its own turn.
static OF_A_RUN: Probe = Probe {
    regressor: "run",
    act: |p, step| Change {
        travel: Sides::new(p[0], p[1]),
        turn_rad: p[2] * step.travel_m().abs(),
        turning: p[3],
        ..Change::NONE
    },
};

/// Tests what the model leaves against every regressor, and whether its noise depends on the motion.
pub(crate) fn unexplained(prepared: &Prepared, fitted: &Fitted<'_>) -> Unexplained {
    let mut found = of_regressors(prepared, fitted);
    let p_value = ripple(prepared, fitted);
    if p_value < RIPPLE_P {
        if !found.structure {
            found.p_value = p_value;
        }
        found.structure = true;
        // Whatever else is found may be where its crests happened to stop.
        found.depends_on.retain(|it| *it != WHEEL_ANGLE);
        found.depends_on.insert(0, WHEEL_ANGLE);
    }
    let Some(uneven) = unevenness(prepared, fitted) else { return found };
    if !found.structure || uneven.rules {
        found.p_value = uneven.p_value;
    }
    found.structure = true;
    found.depends_on.retain(|it| *it != uneven.regressor);
    let place = if uneven.rules { 0 } else { found.depends_on.len() };
    found.depends_on.insert(place, uneven.regressor);
    found
}

/// Tests what the model leaves against every regressor.
fn of_regressors(prepared: &Prepared, fitted: &Fitted<'_>) -> Unexplained {
    let mut terms = fitted.terms.clone();
    let in_model = terms.len();
    let probes: Vec<&Probe> = PROBES.iter().collect();
    terms.extend(probes.iter().map(|probe| Term {
        effect: *probe as &dyn Effect,
        values: vec![0.0; PARAMETERS_MAX],
        column: None,
    }));
    terms.push(Term { effect: &OF_A_RUN, values: vec![0.0; PARAMETERS_MAX], column: None });
    let evidence = Evidence::gather(prepared, &mut terms, &fitted.noise);
    let first_of = |index: usize| terms[index].column.unwrap_or(0);
    let own: Vec<usize> = (0..PARAMETERS_MAX).map(|it| first_of(terms.len() - 1) + it).collect();
    let mut model: Vec<usize> = match terms.get(in_model) {
        Some(probe) => (0..probe.column.unwrap_or(0)).collect(),
        None => Vec::new(),
    };
    let mut open: Vec<usize> = (0..probes.len()).collect();
    let mut found = Unexplained { p_value: 1.0, ..Unexplained::default() };
    let many = prepared.runs.len() >= MANY_RUNS;
    let mut within;
    loop {
        let columns: Vec<Vec<usize>> = open
            .iter()
            .map(|probe| {
                let first = first_of(in_model + probe);
                visible(&evidence, &(first..first + PARAMETERS_MAX).collect::<Vec<_>>())
            })
            .collect();
        let shown = columns.iter().filter(|it| !it.is_empty());
        within = scatter(&evidence, shown.map(|asked| (&model[..], &asked[..])));
        let between = within.max(run_scatter_in_the_mean(&evidence, &model, &own));
        let judged: Vec<(usize, f64, f64)> = open
            .iter()
            .zip(&columns)
            .map(|(probe, asked)| {
                if asked.is_empty() {
                    return (*probe, 1.0, 0.0);
                }
                let effect = probes[*probe];
                // What is the same throughout a run is judged by what runs have for themselves.
                let is_of_runs = OF_RUNS.contains(&effect.regressor);
                let scatter = if is_of_runs { between } else { within };
                let question = Question { model: &model, asked, effect, scatter };
                let it = judge(&evidence, &question);
                // A flag says that something is there, not what it is: among many runs a few may raise it.
                let p_value = if many && !is_of_runs { it.p_value_of_many } else { it.p_value };
                let p_value = if it.held_out_gain > 0.0 { p_value } else { 1.0 };
                // The strongest is that which tells most about runs that it was not fitted to.
                (*probe, p_value, it.held_out_gain / it.dispersion)
            })
            .collect();
        let p_values: Vec<f64> = judged.iter().map(|it| it.1).collect();
        let rates = false_discovery_rates(&p_values);
        let best = (0..judged.len())
            .filter(|i| rates[*i] < FALSE_DISCOVERY_RATE)
            .max_by(|a, b| judged[*a].2.total_cmp(&judged[*b].2));
        let least = rates.iter().copied().fold(1.0, f64::min);
        if !found.structure {
            found.p_value = least;
        }
        let Some(best) = best else { break };
        let probe = judged[best].0;
        found.structure = true;
        if !found.depends_on.contains(&probes[probe].regressor) {
            found.depends_on.push(probes[probe].regressor);
        }
        let first = first_of(in_model + probe);
        model.extend(visible(&evidence, &(first..first + PARAMETERS_MAX).collect::<Vec<_>>()));
        open.retain(|it| *it != probe);
        if open.is_empty() || found.depends_on.len() >= 4 {
            break;
        }
    }
    if counts_start_anew(prepared) && !found.depends_on.contains(&WHEEL_ANGLE) {
        let waves = probes.iter().enumerate().filter(|(_, it)| it.regressor == WHEEL_ANGLE);
        let p_value = waves
            .map(|(index, _)| {
                let first = first_of(in_model + index);
                let asked =
                    visible(&evidence, &(first..first + PARAMETERS_MAX).collect::<Vec<_>>());
                each_run_by_itself(&evidence, (&model, &asked), within)
            })
            .fold(1.0, f64::min);
        if p_value < RIPPLE_P {
            if !found.structure {
                found.p_value = p_value;
            }
            found.structure = true;
            found.depends_on.push(WHEEL_ANGLE);
        }
    }
    found
}

/// Whether the counts begin at the same number in every run: a wheel's angle is then not known across runs.
pub(crate) fn counts_start_anew(prepared: &Prepared) -> bool {
    let mut starts = prepared.runs.iter().filter_map(|run| run.motion.steps.first());
    let Some(first) = starts.next() else { return false };
    let mut others = starts.peekable();
    others.peek().is_some() && others.all(|it| it.phi_rad == first.phi_rad)
}

/// By chance as much gain as these columns have where every run may have its own values of them: what the
/// median run gains, so that most of them have to.
fn each_run_by_itself(
    evidence: &Evidence,
    (model, asked): (&[usize], &[usize]),
    scatter: f64,
) -> f64 {
    if asked.is_empty() {
        return 1.0;
    }
    let best = evidence.solve(&evidence.total, model).delta;
    let mut gains: Vec<f64> = evidence
        .units
        .iter()
        .map(|unit| {
            let mut sums = unit.sums.clone();
            for (column, delta) in model.iter().zip(&best) {
                sums.right -= sums.gram.column(*column) * *delta;
            }
            let delta = evidence.solve(&sums, asked).delta;
            sums.squares = 0.0;
            -sums.chi_squared(asked, &delta)
        })
        .collect();
    gains.sort_by(f64::total_cmp);
    // Half of the runs gain more than the median does: binomially many of chi^2.
    let median = gains[gains.len() / 2];
    let alone = chi_squared(asked.len(), median / scatter);
    at_least_half(gains.len(), alone)
}

/// Probability that at least half of n independent things happen that each have this probability, at most.
fn at_least_half(n: usize, alone: f64) -> f64 {
    // C(n, k) < 2^n.
    let half = n.div_ceil(2) as f64;
    (2.0_f64.powi(n as i32) * alone.powf(half)).min(1.0)
}

/// The regressor of what goes round with a wheel.
pub(crate) const WHEEL_ANGLE: &str = "wheel angle";

/// Those of the columns that the campaign's motion shows at all.
fn visible(evidence: &Evidence, columns: &[usize]) -> Vec<usize> {
    // One sigma at the widest value that a probe can have: anything that is there is far above it.
    columns.iter().copied().filter(|it| evidence.total.gram[(*it, *it)] > 1.0).collect()
}
