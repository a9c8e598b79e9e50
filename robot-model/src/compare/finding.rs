//! The main finding in words: how far off, how much of it is not noise, and what it depends on.

use super::regime::{Cell, Question};
use super::rms::Rms;
use super::stretch::{Aspect, Drift};

/// A systematic error smaller than this many standard errors is not called one.
const SURE_SIGMAS: f64 = 3.0;

pub(super) fn sentence(
    nominal: bool,
    position_m: &Rms,
    heading_rad: &Rms,
    questions: &[Question],
) -> String {
    let who = if nominal { "The nominal robot" } else { "The model" };
    let (mm, mrad) = (position_m.rms * 1e3, heading_rad.rms * 1e3);
    let size = if heading_rad.rms > 0.0 {
        format!("{mm:.1} mm and {mrad:.1} mrad")
    } else {
        format!("{mm:.1} mm")
    };
    if !(position_m.rms.is_finite() && heading_rad.rms.is_finite()) {
        return format!(
            "{who} predicts no track that ends anywhere: one of its values makes no sense."
        );
    }
    if position_m.rms <= 0.0 {
        return "No places were measured, so there is nothing to compare with.".to_owned();
    }
    if !position_m.beyond_noise() && !heading_rad.beyond_noise() {
        return match worst(questions) {
            None => format!("{who} is off by {size}, which is what noise alone would give."),
            Some((question, cell)) => format!(
                "{who} is off by {size}, which over whole runs noise alone would give; but {}.",
                depends(question, cell)
            ),
        };
    }
    let times = if position_m.beyond_noise() {
        position_m.rms / position_m.noise
    } else {
        heading_rad.rms / heading_rad.noise
    };
    let start = format!("{who} is off by {size}, {times:.1} times what noise would give");
    match worst(questions) {
        Some((question, cell)) => format!("{start}: {}.", depends(question, cell)),
        None => format!("{start}, too little in any one regime to stand out there."),
    }
}

/// The cell that is furthest beyond noise, with its question; of a question with a single cell only
/// where there is no other.
fn worst(questions: &[Question]) -> Option<(&Question, &Cell)> {
    let key = |(question, cell): &(&Question, &Cell)| (question.cells.len() > 1, cell.chi);
    questions
        .iter()
        .flat_map(|question| question.cells.iter().map(move |cell| (question, cell)))
        .filter(|(_, cell)| cell.beyond_noise)
        .max_by(|a, b| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)))
}

fn depends(question: &Question, cell: &Cell) -> String {
    let drift = cell.main_drift();
    let place = match question.name {
        "run kind" => format!("in {} runs", cell.name),
        "path" if cell.name == "straight" => "on straights".to_owned(),
        "path" if cell.name == "arc" => "in arcs".to_owned(),
        "path" => "on the spot".to_owned(),
        "ramp or cruise" if cell.name == "ramp" => "on ramps".to_owned(),
        "ramp or cruise" => "at cruise".to_owned(),
        "direction of travel" => cell.name.clone(),
        "turn direction" => format!("in turns to the {}", cell.name),
        "speed" => format!("at speeds {}", cell.name),
        "heading" => format!("at headings {}", cell.name),
        name => format!("at {name} {}", cell.name),
    };
    if drift.sigmas() < SURE_SIGMAS {
        let (mm, mrad) = (cell.position_m.rms * 1e3, cell.heading_rad.rms * 1e3);
        return format!(
            "it is worst {place}, {mm:.1} mm and {mrad:.1} mrad over {:.2} m of rolling, {:.1} times noise",
            cell.rolled_m, cell.chi
        );
    }
    let opposite = question.cells.iter().any(|other| {
        let there = other.drifts[drift.aspect as usize];
        there.sigmas() > SURE_SIGMAS && there.per_m * drift.per_m < 0.0
    });
    let flips = match question.name {
        "direction of travel" | "turn direction" if opposite => {
            ", and the other way round in the opposite direction"
        }
        _ if opposite => ", and the other way round elsewhere",
        _ => "",
    };
    format!("it is worst {place}, where {} for each metre that the rims roll{flips}", says(&drift))
}

/// A systematic error in words.
fn says(drift: &Drift) -> String {
    let size = drift.per_m.abs() * 1e3;
    match (drift.aspect, drift.per_m > 0.0) {
        (Aspect::Turn, true) => {
            format!("the robot turns {size:.1} mrad further left than predicted")
        }
        (Aspect::Turn, false) => {
            format!("the robot turns {size:.1} mrad further right than predicted")
        }
        (Aspect::Ahead, true) => {
            format!("the robot gets {size:.1} mm further ahead than predicted")
        }
        (Aspect::Ahead, false) => format!("the robot stays {size:.1} mm behind what is predicted"),
        (Aspect::Left, true) => format!("the robot drifts {size:.1} mm to the left"),
        (Aspect::Left, false) => format!("the robot drifts {size:.1} mm to the right"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_is_no_number_is_not_taken_for_places_that_were_not_measured() {
        let rms = |rms: f64| Rms { rms, noise: 1e-3, noise_high: 2e-3 };
        for bad in [f64::NAN, f64::INFINITY] {
            for [position_m, heading_rad] in [[rms(bad), rms(1e-3)], [rms(1e-3), rms(bad)]] {
                let said = sentence(false, &position_m, &heading_rad, &[]);
                assert!(said.starts_with("The model predicts no track"), "{said}");
            }
        }
        let unseen = sentence(true, &rms(0.0), &rms(0.0), &[]);
        assert!(unseen.starts_with("No places were measured"), "{unseen}");
    }
}
