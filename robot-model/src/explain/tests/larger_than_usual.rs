//! Robots that are smaller, softer or of cheaper gears than most, or with a tracker far from the middle: an effect that is
//! larger than usual is there all the same, and is named.

use crate::estimation::errors::displacement_m;
use crate::explain::explain;
use crate::explain::model_errors::errors;
use crate::tests::synthetic::{NOISE, ROBOT, campaign, full_plan, term};

/// Each at two to ten times the spread of usual values.
const LARGE: [(&str, &[f64]); 7] = [
    ("heading_pull", &[0.1]),
    ("marker_offset", &[0.65, 0.1]),
    ("payload", &[0.03]),
    ("backlash", &[0.26, 0.24, 0.12]),
    ("carpet_drift", &[0.1, -0.09]),
    ("scrub", &[0.35]),
    ("turn_asymmetry", &[0.12]),
];

#[test]
fn what_is_larger_than_usual_is_named_and_hardly_anything_else() {
    let mut extras = 0;
    for (seed, (id, values)) in LARGE.into_iter().enumerate() {
        let seed = 700 + seed as u64;
        let sound = campaign(&full_plan(), &[], seed).prepare().unwrap();
        let noise = errors(&sound, &NOISE, &[]).cross_validated;
        let answer = explain(&campaign(&full_plan(), &[term(id, values)], seed)).unwrap();
        let first = answer.steps.first().unwrap_or_else(|| panic!("{id}: {answer:?}"));
        assert!(first.class.iter().any(|member| member == id), "{id}: {:?}", answer.steps);
        extras += answer.steps[1..].iter().filter(|step| step.matters).count();
        let of = |errors| displacement_m(errors, ROBOT.track_width_m);
        let times = of(&answer.steps.last().unwrap().cross_validated) / of(&noise);
        println!("{id}: {times:.2}");
        assert!(times < 1.25, "{id}: {times} times the noise is left");
    }
    // At 5 % false alarms, seven campaigns have more than one of them in one of 23 such sets.
    assert!(extras <= 1, "{extras} extras");
}
