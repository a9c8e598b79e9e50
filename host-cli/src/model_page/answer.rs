//! What the page is answered, as JSON: lengths in metres, angles in radians, as everywhere.

use campaign::model::ModelFile;
use robot_model::compare::{Component, Curve, Path};
use robot_model::effect::{Facts, Parameter, Role};
use robot_model::explain::model::{Model, ModelEffect};
use serde_json::{Value, json};

use crate::escape::seen;
use crate::{json as shared, words};

/// A drawn path has at most so many points; errors are computed from all.
const POINTS_MAX: usize = 240;

/// What holds whatever the model: the robot, its runs as they were measured, the catalogue.
pub fn campaign(
    robot: &str,
    folder: &str,
    (model, in_use): (&ModelFile, &[&str]),
    paths: &[Path],
) -> Value {
    let run = |path: &Path| {
        json!({
            "name": path.run,
            "kind": path.kind.name(),
            "held_out": path.held_out,
            "measured": points(&path.measured_m),
        })
    };
    let catalogue = model.catalogue();
    json!({
        "robot": seen(robot),
        "folder": seen(folder),
        "model": model.effects.iter().map(|entry| entry.id()).collect::<Vec<_>>(),
        "in_use": in_use,
        "runs": paths.iter().map(run).collect::<Vec<_>>(),
        "catalogue": catalogue.iter().map(|effect| facts(&effect.facts())).collect::<Vec<_>>(),
    })
}

/// One effect of the catalogue.
pub fn facts(facts: &Facts<'_>) -> Value {
    let parameter = |parameter: &Parameter| {
        json!({
            "name": parameter.name,
            "unit": parameter.unit,
            "low": parameter.low,
            "high": parameter.high,
            "shape": parameter.role == Role::Shape,
        })
    };
    json!({
        "id": facts.id,
        "name": facts.name,
        "equation": facts.equation,
        "signature": facts.signature,
        "shown_by": facts.shown_by,
        "compensation": facts.compensation,
        "parameters": facts.parameters.iter().map(parameter).collect::<Vec<_>>(),
    })
}

/// A fitted model, and what it leaves.
pub fn fitted(model: &Model, paths: &[Path], curves: &[Curve]) -> Value {
    let effect = |effect: &ModelEffect| {
        json!({
            "id": effect.effect,
            "parameters": shared::parameters(&effect.parameters),
            "p_value": effect.verdict.p_value,
            "better": effect.verdict.better(),
            "verdict": words::verdict(&effect.verdict),
        })
    };
    let held_out = model.held_out.as_ref();
    json!({
        "effects": model.effects.iter().map(effect).collect::<Vec<_>>(),
        "errors": {
            "fitted": shared::errors(&model.errors.fitted),
            "cross_validated": shared::errors(&model.errors.cross_validated),
            "held_out": held_out.map(|errors| shared::errors(&errors.model)),
        },
        "runs": runs(paths),
        "curves": curves.iter().map(curve).collect::<Vec<_>>(),
    })
}

/// A model at values set by hand, and what it leaves: nothing is fitted, so nothing is cross-validated.
pub fn by_hand(effects: Value, paths: &[Path], curves: &[Curve]) -> Value {
    let errors = |held_out: bool| {
        let rms_m = rms_m(paths.iter().filter(|path| path.held_out == held_out));
        rms_m.map(|rms_m| json!({"position_rms_m": rms_m}))
    };
    json!({
        "by_hand": true,
        "effects": effects,
        "errors": {"fitted": errors(false), "cross_validated": null, "held_out": errors(true)},
        "runs": runs(paths),
        "curves": curves.iter().map(curve).collect::<Vec<_>>(),
    })
}

fn runs(paths: &[Path]) -> Vec<Value> {
    let run = |path: &Path| {
        json!({
            "rms_m": rms_m([path].into_iter()),
            "predicted": points(&path.predicted_m),
            "way": points(&path.way_m),
        })
    };
    paths.iter().map(run).collect()
}

/// Root of the mean squared distance between measured and predicted places \[m\]; `None` without any.
fn rms_m<'a>(paths: impl Iterator<Item = &'a Path>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for path in paths {
        for ([ax, ay], [bx, by]) in path.measured_m.iter().zip(&path.predicted_m) {
            let square = (ax - bx).powi(2) + (ay - by).powi(2);
            if square.is_finite() {
                sum += square;
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| (sum / count).sqrt())
}

/// Points of a path, to a hundredth of a millimetre; `null` where none was measured.
fn points(points: &[[f64; 2]]) -> Vec<Value> {
    let every = points.len().div_ceil(POINTS_MAX).max(1);
    let last = points.len().saturating_sub(1);
    let kept = points.iter().enumerate().filter(|(k, _)| k % every == 0 || *k == last);
    let round = |metres: f64| (metres * 1e5).round() / 1e5;
    kept.map(|(_, [x, y])| json!([round(*x), round(*y)])).collect()
}

fn curve(curve: &Curve) -> Value {
    let (component, unit) = match curve.component {
        Component::Ahead => ("ahead", "mm/m too far ahead"),
        Component::Left => ("left", "mm/m of drift to the left"),
        Component::Turn => ("turn", "mrad/m of turn to the left"),
    };
    json!({
        "axis": words::axis(curve.axis),
        "component": component,
        "unit": unit,
        "chi": curve.chi,
        "bins": curve.bins.iter().map(|bin| json!([bin.at, bin.drift.per_m, bin.drift.sigma])).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use robot_model::recording::RunKind;

    use super::*;

    #[test]
    fn long_paths_are_thinned_and_keep_their_ends_and_their_error() {
        let straight =
            |off: f64| -> Vec<[f64; 2]> { (0..1000).map(|k| [f64::from(k), off]).collect() };
        let path = Path {
            run: "a".into(),
            kind: RunKind::Straight,
            held_out: false,
            measured_m: straight(0.0),
            predicted_m: straight(0.003),
            way_m: Vec::new(),
        };
        let answer = runs(std::slice::from_ref(&path));
        let predicted = answer[0]["predicted"].as_array().unwrap();
        assert!(predicted.len() <= POINTS_MAX + 1, "{}", predicted.len());
        assert_eq!(predicted.last().unwrap(), &json!([999.0, 0.003]));
        assert!((answer[0]["rms_m"].as_f64().unwrap() - 0.003).abs() < 1e-12);
        assert_eq!(rms_m(std::iter::empty()), None);
    }
}
