//! What many robots say about one parameter.

use robot_model::fleet::{Judgement, RobotJudged};
use serde_json::{Value, json};

/// A parameter over all robots of a kind; `name` is what a robot of a number is called.
pub fn judgement(judgement: &Judgement, name: impl Fn(usize) -> Value) -> Value {
    let robot = |one: &RobotJudged| {
        let trend = one.trend.map(|trend| {
            json!({
                "per_day": trend.per_day,
                "sigma": trend.sigma,
                "p_value": trend.p_value,
                "is_there": trend.is_there,
            })
        });
        json!({
            "robot": name(one.robot),
            "campaigns": one.campaigns,
            "mean": one.mean,
            "sigma": one.sigma,
            "trend": trend,
            "is_unlike": one.is_unlike,
        })
    };
    json!({
        "mean": judgement.mean,
        "mean_sigma": judgement.mean_sigma,
        "spread": judgement.spread,
        "alike": judgement.alike,
        "is_common": judgement.is_common,
        "robots": judgement.robots.iter().map(robot).collect::<Vec<_>>(),
    })
}
