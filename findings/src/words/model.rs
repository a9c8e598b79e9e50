//! The verdict on an effect of a chosen model, in words.

use robot_model::explain::model::{CHANCE, EffectVerdict};

use super::lacking;
use crate::quantity::p_value;

/// The verdict on an effect, given all others of a model.
pub fn verdict(verdict: &EffectVerdict) -> String {
    if let Some(need) = verdict.lacking {
        format!("these runs cannot show it: {}", lacking(need))
    } else if verdict.implausible {
        "implausible: its value is outside the plausible range".to_owned()
    } else if verdict.cross_validated_gain <= 0.0 {
        "not significant: it does not improve the cross-validated prediction".to_owned()
    } else if let Some(kind) = verdict.worse_kind {
        format!(
            "unreliable: fitted to the other kinds of runs, it predicts {} runs worse",
            kind.name()
        )
    } else if verdict.p_value >= CHANCE {
        format!("not significant: {}", p_value(verdict.p_value))
    } else if verdict.spoils_tracks {
        "unreliable: with it the cross-validated tracks get worse".to_owned()
    } else if verdict.one_run_alone {
        format!("significant, but only one run shows it: {}", p_value(verdict.p_value))
    } else {
        format!("significant: {}", p_value(verdict.p_value))
    }
}

#[cfg(test)]
mod tests {
    use robot_model::effect::Need;

    use super::*;

    #[test]
    fn what_runs_cannot_show_is_said_of_an_effect_that_was_added() {
        let shown = EffectVerdict {
            p_value: 1e-9,
            cross_validated_gain: 9.0,
            dispersion: 1.0,
            implausible: false,
            worse_kind: None,
            spoils_tracks: false,
            one_run_alone: false,
            lacking: None,
        };
        assert_eq!(verdict(&shown), "significant: p = 1e-9");
        let hidden = EffectVerdict { lacking: Some(Need::Load), ..shown };
        let text = "these runs cannot show it: no run carries a load (payload_kg in robot.toml)";
        assert_eq!(verdict(&hidden), text);
    }
}
