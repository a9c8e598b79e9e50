//! What speaks for an effect of a chosen model, in words.

use robot_model::explain::model::{CHANCE, Verdict};

use super::{lacking, p_text};

/// What speaks for an effect, given all others of a model.
pub fn verdict(verdict: &Verdict) -> String {
    if let Some(need) = verdict.lacking {
        format!("nothing shows it: {}", lacking(need))
    } else if verdict.implausible {
        "not believable: no robot has such a value".to_owned()
    } else if verdict.cross_validated_gain <= 0.0 {
        "no better than chance: runs that were held out get no better".to_owned()
    } else if let Some(kind) = verdict.worse_kind {
        format!("not to be trusted: fitted to the other kinds, it makes {} runs worse", kind.name())
    } else if verdict.p_value >= CHANCE {
        format!("no better than chance: {}", p_text(verdict.p_value))
    } else if verdict.spoils_tracks {
        "not to be trusted: with it tracks of runs held out are predicted worse".to_owned()
    } else if verdict.one_run_alone {
        format!(
            "better, in the one run that shows it: chance gives as much with {}",
            p_text(verdict.p_value)
        )
    } else {
        format!("better: chance gives as much with {}", p_text(verdict.p_value))
    }
}

#[cfg(test)]
mod tests {
    use robot_model::effect::Need;

    use super::*;

    #[test]
    fn what_runs_cannot_show_is_said_of_an_effect_that_was_asked_for() {
        let shown = Verdict {
            p_value: 1e-9,
            cross_validated_gain: 9.0,
            dispersion: 1.0,
            implausible: false,
            worse_kind: None,
            spoils_tracks: false,
            one_run_alone: false,
            lacking: None,
        };
        assert_eq!(verdict(&shown), "better: chance gives as much with p = 1e-9");
        let hidden = Verdict { lacking: Some(Need::Load), ..shown };
        let text = "nothing shows it: no run carries a load (payload_kg in robot.toml)";
        assert_eq!(verdict(&hidden), text);
    }
}
