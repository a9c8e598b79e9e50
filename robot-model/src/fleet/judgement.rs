//! What all robots of a kind have in common, who changes with time, and who is unlike the others.

use super::robots::{Line, Measured, Trend};
use crate::numeric::distributions::{chi_squared, false_discovery_rates, fisher};
use crate::numeric::median::median;

/// Of what is said to be there, at most this share is chance.
pub const RATE: f64 = 0.01;
/// Of fewer robots nothing is said of what they have in common.
const ROBOTS_MIN: usize = 3;
/// Of fewer others no robot is said to be unlike them.
const OTHERS_MIN: usize = 3;
/// A robot further from the median than so many times the usual distance is not alike.
const FAR: f64 = 5.0;
/// A standard deviation over the median distance, of a normal distribution.
const MEDIAN_TO_SIGMA: f64 = 1.482_6;
/// What all have in common is more than so many times what they differ by: nearly every robot has it.
const COMMON_SPREADS: f64 = 2.0;

/// One parameter, over all robots of a kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// The mean robot, of those that are alike.
    pub mean: f64,
    /// Its standard error.
    pub mean_sigma: f64,
    /// By how much robots differ, one standard deviation beyond what their uncertainty explains.
    pub spread: f64,
    /// How many robots are alike: all but those far from the others.
    pub alike: usize,
    /// These have it, with the same sign.
    pub is_common: bool,
    /// Each robot, by its number.
    pub robots: Vec<RobotJudged>,
}

/// One robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotJudged {
    /// Its number.
    pub robot: usize,
    /// How many campaigns it has.
    pub campaigns: usize,
    /// Mean of its values.
    pub mean: f64,
    /// Its standard error.
    pub sigma: f64,
    /// How they change with time, if there are two dates.
    pub trend: Option<Trend>,
    /// Probability that a robot like the others is as far off; `None` if there are too few others.
    pub unlike_p: Option<f64>,
    /// It is unlike the others: the false discovery rate is below [`RATE`].
    pub is_unlike: bool,
}

/// Judges all parameters of a fleet at once, each with the values that it has in all campaigns of a kind.
pub fn judge(parameters: &[Vec<Measured>]) -> Vec<Judgement> {
    let (mut judged, p_values): (Vec<Judgement>, Vec<f64>) =
        parameters.iter().map(|values| one_parameter(values)).unzip();
    // One list of questions: the mean of each parameter, then trend and distance of each of its robots.
    let mut questions = Vec::new();
    for (one, p_value) in judged.iter().zip(&p_values) {
        questions.push(*p_value);
        let trends = one.robots.iter().filter_map(|robot| Some(robot.trend?.p_value));
        questions.extend(trends.chain(one.robots.iter().filter_map(|robot| robot.unlike_p)));
    }
    let rates = false_discovery_rates(&questions);
    let mut answers = rates.into_iter().map(|rate| rate < RATE);
    let mut next = || answers.next().unwrap_or(false);
    for one in &mut judged {
        let is_there = next();
        let enough = one.alike >= ROBOTS_MIN;
        one.is_common = is_there && enough && one.mean.abs() > COMMON_SPREADS * one.spread;
        for trend in one.robots.iter_mut().filter_map(|robot| robot.trend.as_mut()) {
            trend.is_there = next();
        }
        for robot in one.robots.iter_mut().filter(|robot| robot.unlike_p.is_some()) {
            robot.is_unlike = next();
        }
    }
    judged
}

/// One parameter, and the probability that its mean is zero.
fn one_parameter(values: &[Measured]) -> (Judgement, f64) {
    let mut numbers: Vec<usize> = values.iter().map(|one| one.robot).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let own = |robot: usize| values.iter().copied().filter(move |one| one.robot == robot);
    let lines: Vec<Line> =
        numbers.iter().map(|robot| Line::through(&own(*robot).collect::<Vec<_>>())).collect();
    let freedom: usize = lines.iter().map(|line| line.freedom).sum();
    let chi: f64 = lines.iter().map(|line| line.chi_squared).sum();
    // (3)
    let phi = if freedom > 0 { (chi / freedom as f64).max(1.0) } else { 1.0 };
    let robots: Vec<(f64, f64)> =
        lines.iter().map(|line| (line.mean, line.mean_sigma * phi.sqrt())).collect();
    let alike = alike(&robots);
    let all = Population::of(&chosen(&robots, &alike, None));
    let judged = numbers.iter().zip(&lines).enumerate().map(|(k, (robot, line))| {
        let (mean, sigma) = robots[k];
        let others = chosen(&robots, &alike, Some(k));
        let unlike_p =
            (others.len() >= OTHERS_MIN).then(|| Population::of(&others).unlike(mean, sigma));
        let trend = line.slope.map(|(per_day, sigma)| {
            let sigma = sigma * phi.sqrt();
            let p_value = tail(per_day / sigma, (phi > 1.0).then_some(freedom));
            Trend { per_day, sigma, p_value, is_there: false }
        });
        let campaigns = own(*robot).count();
        RobotJudged { robot: *robot, campaigns, mean, sigma, trend, unlike_p, is_unlike: false }
    });
    let judgement = Judgement {
        mean: all.mean,
        mean_sigma: all.mean_sigma,
        spread: all.spread,
        alike: all.count,
        is_common: false,
        robots: judged.collect(),
    };
    let p_value = match all.count {
        0 | 1 => 1.0,
        many => tail(all.mean / all.mean_sigma, Some(many - 1)),
    };
    (judgement, p_value)
}

/// Which robots are alike: not further from the median than [`FAR`] times what the nearer half of them is. Those beyond would
/// widen the spread by which all are judged, and hide each other.
fn alike(robots: &[(f64, f64)]) -> Vec<bool> {
    let Some(middle) = median(robots.iter().map(|robot| robot.0).collect()) else {
        return Vec::new();
    };
    let off = |robot: &(f64, f64)| (robot.0 - middle).abs();
    let near = median(robots.iter().map(off).collect()).unwrap_or_default();
    let spread = |sigma: f64| sigma.hypot(MEDIAN_TO_SIGMA * near);
    robots.iter().map(|robot| off(robot) <= FAR * spread(robot.1)).collect()
}

/// The robots that are alike, without one.
fn chosen(robots: &[(f64, f64)], alike: &[bool], without: Option<usize>) -> Vec<(f64, f64)> {
    let is_in = |k: usize| alike[k] && Some(k) != without;
    robots.iter().enumerate().filter(|(k, _)| is_in(*k)).map(|(_, robot)| *robot).collect()
}

/// Probability of a value so many standard errors from zero on either side; `known_from`: the scale is an estimate.
fn tail(sigmas: f64, known_from: Option<usize>) -> f64 {
    let square = sigmas * sigmas;
    known_from.map_or_else(|| chi_squared(1, square), |freedom| fisher(1, freedom as f64, square))
}

/// Robots, each with its value and uncertainty: (2) of the module.
struct Population {
    count: usize,
    mean: f64,
    mean_sigma: f64,
    spread: f64,
}

impl Population {
    fn of(robots: &[(f64, f64)]) -> Self {
        let sums = |variance: f64| {
            let weights =
                robots.iter().map(|(value, sigma)| (1.0 / (sigma * sigma + variance), value));
            weights.fold((0.0, 0.0), |(sum, mean), (weight, value)| {
                (sum + weight, mean + weight * value)
            })
        };
        let (sum, weighted) = sums(0.0);
        let fixed = weighted / sum;
        let of = |f: &dyn Fn(f64, f64) -> f64| {
            robots.iter().map(|(value, sigma)| f(*value, *sigma)).sum::<f64>()
        };
        let q = of(&|value, sigma| ((value - fixed) / sigma).powi(2));
        let squares = of(&|_, sigma| sigma.powi(-4));
        let room = sum - squares / sum;
        let freedom = robots.len().saturating_sub(1) as f64;
        let variance = if room > 0.0 { ((q - freedom) / room).max(0.0) } else { 0.0 };
        let (sum, weighted) = sums(variance);
        Self {
            count: robots.len(),
            mean: weighted / sum,
            mean_sigma: sum.powf(-0.5),
            spread: variance.sqrt(),
        }
    }

    /// Probability that another robot of this population is as far off as one with this value.
    fn unlike(&self, value: f64, sigma: f64) -> f64 {
        let scale = sigma.hypot(self.spread).hypot(self.mean_sigma);
        tail((value - self.mean) / scale, Some(self.count - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Random;

    const SIGMA: f64 = 1e-4;

    /// Eight robots, six dates each: their values are `mean`, what robots differ by, and what `more` adds.
    fn fleet(seed: u64, mean: f64, spread: f64, more: impl Fn(usize, f64) -> f64) -> Vec<Measured> {
        let mut random = Random::new(seed);
        let mut values = Vec::new();
        for robot in 0..8 {
            let own = mean + spread * random.normal();
            for date in 0..6 {
                let at_days = f64::from(date) * 30.0;
                let value = own + SIGMA * random.normal() + more(robot, at_days);
                values.push(Measured { robot, at_days: Some(at_days), value, sigma: SIGMA });
            }
        }
        values
    }

    #[test]
    fn an_effect_of_all_robots_is_common_and_one_that_scatters_about_zero_is_not() {
        let judged = judge(&[fleet(1, 5e-3, 5e-4, |_, _| 0.0), fleet(2, 0.0, 5e-3, |_, _| 0.0)]);
        assert!(judged[0].is_common && !judged[1].is_common, "{judged:?}");
        assert!((judged[0].mean - 5e-3).abs() < 4.0 * judged[0].mean_sigma);
        // Known to 1/sqrt(2 x 7) of itself: 27 %.
        assert!((2.5e-4..1e-3).contains(&judged[0].spread), "{}", judged[0].spread);
        let trends = judged.iter().flat_map(|one| &one.robots).filter_map(|robot| robot.trend);
        assert!(trends.clone().count() == 16 && trends.filter(|trend| trend.is_there).count() == 0);
        assert!(judged.iter().flat_map(|one| &one.robots).all(|robot| !robot.is_unlike));
    }

    #[test]
    fn the_robot_that_changes_is_named_with_its_rate() {
        let judged = judge(&[fleet(
            3,
            0.0,
            1e-3,
            |robot, days| if robot == 5 { -1e-5 * days } else { 0.0 },
        )]);
        for robot in &judged[0].robots {
            let trend = robot.trend.unwrap();
            assert_eq!(trend.is_there, robot.robot == 5, "{robot:?}");
            if trend.is_there {
                assert!((trend.per_day + 1e-5).abs() < 4.0 * trend.sigma, "{trend:?}");
            }
        }
    }

    #[test]
    fn the_robot_that_is_unlike_the_others_is_named() {
        let far = |robot, _| [0.0, 0.0, 2e-2, 0.0, 0.0, -3e-2, 0.0, 0.0][robot];
        let judged = judge(&[fleet(4, 8e-3, 1e-3, far)]);
        let unlike: Vec<usize> = judged[0]
            .robots
            .iter()
            .filter(|robot| robot.is_unlike)
            .map(|robot| robot.robot)
            .collect();
        assert_eq!(unlike, [2, 5], "{judged:?}");
        // Neither hides the other, nor what the rest have in common.
        assert!(judged[0].is_common && judged[0].alike == 6, "{judged:?}");
    }

    #[test]
    fn of_forty_fleets_without_anything_nearly_none_has_a_finding() {
        let found = (0..40).filter(|seed| {
            let judged = judge(&[fleet(100 + seed, 0.0, 1e-3, |_, _| 0.0)]);
            let robots = &judged[0].robots;
            judged[0].is_common
                || robots
                    .iter()
                    .any(|one| one.is_unlike || one.trend.is_some_and(|trend| trend.is_there))
        });
        // At a rate of 1 %, four of forty have a probability of 1e-3.
        assert!(found.count() < 4);
    }

    #[test]
    fn dates_that_scatter_more_than_one_fit_says_are_no_trend() {
        let mut values = fleet(5, 0.0, 1e-3, |_, _| 0.0);
        let mut random = Random::new(6);
        values.iter_mut().for_each(|one| one.value += 20.0 * SIGMA * random.normal());
        let judged = judge(&[values]);
        assert!(judged[0].robots.iter().all(|robot| !robot.trend.unwrap().is_there));
    }

    #[test]
    fn of_two_robots_nothing_is_said_of_their_kind() {
        let mut values = fleet(7, 5e-3, 0.0, |_, _| 0.0);
        values.retain(|one| one.robot < 2);
        let judged = judge(&[values, Vec::new()]);
        assert!(
            !judged[0].is_common && judged[0].robots.iter().all(|robot| robot.unlike_p.is_none())
        );
        assert!(judged[1].robots.is_empty());
    }
}
