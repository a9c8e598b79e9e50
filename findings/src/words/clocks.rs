//! Clocks of poses and counts that do not agree, in words.

use robot_model::clocks::ClockFound;

/// Of more runs than this, clocks are summed up.
const RUNS_LISTED: usize = 3;

/// Clocks that do not agree, a sentence for each run, or one for all if all are alike.
pub fn clocks(clocks: &[ClockFound]) -> Vec<String> {
    let (least, most) =
        clocks.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), clock| {
            (least.min(clock.offset_s), most.max(clock.offset_s))
        });
    let corrected = "Times of poses were corrected before the fit.";
    let side = |offset_s: f64| if offset_s > 0.0 { "late" } else { "early" };
    if clocks.len() > 1 && most - least < 0.05 && clocks.iter().all(|clock| clock.rate == 0.0) {
        let mut offsets_s: Vec<f64> = clocks.iter().map(|clock| clock.offset_s).collect();
        offsets_s.sort_by(f64::total_cmp);
        let middle_s = offsets_s[offsets_s.len() / 2];
        return vec![format!(
            "Clocks: the poses of all {} runs are {:.2} s {}. {corrected}",
            clocks.len(),
            middle_s.abs(),
            side(middle_s)
        )];
    }
    if let Some(rate) = one_rate(clocks) {
        return vec![format!("Clocks: {rate}. {corrected}")];
    }
    if clocks.len() > RUNS_LISTED {
        let (slow, fast) = clocks.iter().fold((0.0_f64, 0.0_f64), |(slow, fast), clock| {
            (slow.min(clock.rate), fast.max(clock.rate))
        });
        let rates = match (slow, fast) {
            (0.0, 0.0) => String::new(),
            _ => format!(", and their clocks run up to {:.2} % off", 100.0 * fast.max(-slow)),
        };
        return vec![format!(
            "Clocks: the poses of {} runs are between {:.0} ms {} and {:.0} ms {}{rates}. {corrected}",
            clocks.len(),
            1e3 * least.abs(),
            side(least),
            1e3 * most.abs(),
            side(most)
        )];
    }
    let each = clocks.iter().map(|clock| {
        let offset = format!(
            "{:.0} \u{b1} {:.0} ms {}",
            1e3 * clock.offset_s.abs(),
            (1e3 * clock.offset_sigma_s).max(1.0),
            side(clock.offset_s)
        );
        let rate = format!(
            ", their clock runs {:.3} % {}",
            100.0 * clock.rate.abs(),
            if clock.rate > 0.0 { "fast" } else { "slow" }
        );
        let rate = if clock.rate == 0.0 { String::new() } else { rate };
        format!("Clocks: the poses of run {} are {offset}{rate}.", clock.run)
    });
    let mut lines: Vec<String> = each.collect();
    if let Some(last) = lines.last_mut() {
        last.push(' ');
        last.push_str(corrected);
    }
    lines
}

/// The rate that the clocks of all these runs have, and by how much they are off where the runs start.
fn one_rate(clocks: &[ClockFound]) -> Option<String> {
    let [first, others @ ..] = clocks else { return None };
    let is_alike = |clock: &ClockFound| (clock.rate - first.rate).abs() <= 1e-9;
    if first.rate == 0.0 || others.is_empty() || !others.iter().all(is_alike) {
        return None;
    }
    let mut offsets_s: Vec<f64> = clocks.iter().map(|clock| clock.offset_s).collect();
    offsets_s.sort_by(f64::total_cmp);
    let middle_s = offsets_s[offsets_s.len() / 2];
    let (least_s, most_s) = (offsets_s[0], offsets_s[offsets_s.len() - 1]);
    let late = |offset_s: f64| {
        let side = if offset_s > 0.0 { "late" } else { "early" };
        format!("{:.2} s {side}", offset_s.abs())
    };
    let offset = if most_s - least_s >= 0.05 {
        format!("; where runs start, poses are between {} and {}", late(least_s), late(most_s))
    } else if middle_s.abs() < 0.005 {
        String::new()
    } else {
        format!("; where runs start, poses are {}", late(middle_s))
    };
    Some(format!(
        "the clock of the poses of {} runs is {:.3} \u{b1} {:.3} % {}{offset}",
        clocks.len(),
        100.0 * first.rate.abs(),
        100.0 * first.rate_sigma,
        if first.rate > 0.0 { "fast" } else { "slow" }
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_rate_of_all_clocks_comes_with_its_uncertainty() {
        let clock = |run: &str, offset_s, rate| ClockFound {
            run: run.to_owned(),
            offset_s,
            offset_sigma_s: 1e-3,
            rate,
            rate_sigma: 5e-5,
        };
        let runs = ["a", "b", "c", "d"];
        let of = |offset_s, rate| clocks(&runs.map(|run| clock(run, offset_s, rate)));
        assert_eq!(
            of(0.3, 0.01),
            [
                "Clocks: the clock of the poses of 4 runs is 1.000 \u{b1} 0.005 % fast; where runs start, poses are 0.30 s late. Times of poses were corrected before the fit."
            ]
        );
        assert_eq!(
            of(0.0, -0.003),
            [
                "Clocks: the clock of the poses of 4 runs is 0.300 \u{b1} 0.005 % slow. Times of poses were corrected before the fit."
            ]
        );
    }
}
