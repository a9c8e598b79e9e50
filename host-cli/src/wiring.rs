//! Which wheel turns, and which way, when the robot means one of them: what its own check cannot see.
//!
//! A motor that turns backwards with an encoder that counts backwards, and two sides that are exchanged with all their
//! wires, follow their setpoints. Only somebody who looks at the wheels can tell.

use serde_json::{Value, json};
use shared_proto::{Config, Wheel, WheelPair};

/// A wheel that rolls less than this is not seen to turn \[m\].
const SEEN_M: f64 = 0.01;

/// What somebody saw when the robot meant one wheel to roll ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// This wheel rolled ahead.
    Ahead(Wheel),
    /// This wheel rolled back.
    Back(Wheel),
    /// None turned.
    Nothing,
}

impl Seen {
    /// An answer in words or letters.
    pub fn parse(answer: &str) -> Option<Self> {
        match answer.to_lowercase().as_str() {
            "la" | "left ahead" => Some(Self::Ahead(Wheel::Left)),
            "lb" | "left back" => Some(Self::Back(Wheel::Left)),
            "ra" | "right ahead" => Some(Self::Ahead(Wheel::Right)),
            "rb" | "right back" => Some(Self::Back(Wheel::Right)),
            "n" | "none" => Some(Self::Nothing),
            _ => None,
        }
    }

    /// What a simulated robot shows whose wheels rolled so far \[m\].
    pub fn of_ways(ways: WheelPair<f64>) -> Self {
        let wheel = if ways.left.abs() > ways.right.abs() { Wheel::Left } else { Wheel::Right };
        match *ways.get(wheel) {
            way if way.abs() < SEEN_M => Self::Nothing,
            way if way < 0.0 => Self::Back(wheel),
            _ => Self::Ahead(wheel),
        }
    }

    /// The answer in letters.
    pub fn letters(self) -> &'static str {
        match self {
            Self::Ahead(Wheel::Left) => "la",
            Self::Back(Wheel::Left) => "lb",
            Self::Ahead(Wheel::Right) => "ra",
            Self::Back(Wheel::Right) => "rb",
            Self::Nothing => "n",
        }
    }

    fn wheel(self) -> Option<Wheel> {
        match self {
            Self::Ahead(wheel) | Self::Back(wheel) => Some(wheel),
            Self::Nothing => None,
        }
    }
}

/// What is wired how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wiring {
    /// Each wheel rolls as the robot means it.
    Right,
    /// The motors and encoders of these wheels are reversed, both of each.
    Reversed(WheelPair<bool>),
    /// Left is right, with motors and encoders. Those that the robot takes for left and right may be reversed besides.
    Exchanged(WheelPair<bool>),
    /// The same wheel turned both times.
    OneWheel(Wheel),
    /// No wheel turned when this one was meant, although its count moved.
    NoWheel(Wheel),
}

impl Wiring {
    /// Of what was seen when the left wheel was meant, and the right one.
    pub fn of(seen: WheelPair<Seen>) -> Self {
        let (Some(left), Some(right)) = (seen.left.wheel(), seen.right.wheel()) else {
            let still = if seen.left == Seen::Nothing { Wheel::Left } else { Wheel::Right };
            return Self::NoWheel(still);
        };
        let reversed = seen.map(|seen| matches!(seen, Seen::Back(_)));
        match (left, right) {
            (Wheel::Left, Wheel::Right) if !reversed.any(|reversed| reversed) => Self::Right,
            (Wheel::Left, Wheel::Right) => Self::Reversed(reversed),
            (Wheel::Right, Wheel::Left) => Self::Exchanged(reversed),
            _ => Self::OneWheel(left),
        }
    }

    /// For programs.
    pub fn to_json(self) -> Value {
        match self {
            Self::Right => json!({"wiring": "right"}),
            Self::Reversed(reversed) => json!({"wiring": "reversed", "reversed": reversed}),
            Self::Exchanged(reversed) => json!({"wiring": "exchanged", "reversed": reversed}),
            Self::OneWheel(wheel) => json!({"wiring": "one wheel", "wheel": wheel.name()}),
            Self::NoWheel(wheel) => json!({"wiring": "no wheel", "wheel": wheel.name()}),
        }
    }
}

/// The configuration in which the motors and encoders of these wheels are the other way round. The loop stays as it is.
pub fn turned_round(config: &Config, wheels: WheelPair<bool>) -> Config {
    let mut config = config.clone();
    for wheel in Wheel::BOTH.into_iter().filter(|wheel| *wheels.get(*wheel)) {
        config.motor.get_mut(wheel).reversed ^= true;
        config.encoder.get_mut(wheel).reversed ^= true;
    }
    config
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_answers_has_one_meaning() {
        use Seen::{Ahead, Back, Nothing};
        use Wheel::{Left, Right};
        let reversed = |left, right| WheelPair { left, right };
        for (left, right, wiring) in [
            (Ahead(Left), Ahead(Right), Wiring::Right),
            (Back(Left), Back(Right), Wiring::Reversed(reversed(true, true))),
            (Ahead(Left), Back(Right), Wiring::Reversed(reversed(false, true))),
            (Ahead(Right), Ahead(Left), Wiring::Exchanged(reversed(false, false))),
            (Back(Right), Back(Left), Wiring::Exchanged(reversed(true, true))),
            (Ahead(Left), Back(Left), Wiring::OneWheel(Left)),
            (Nothing, Ahead(Right), Wiring::NoWheel(Left)),
            (Back(Left), Nothing, Wiring::NoWheel(Right)),
        ] {
            assert_eq!(Wiring::of(WheelPair { left, right }), wiring, "{left:?} {right:?}");
        }
    }

    #[test]
    fn what_the_simulator_shows_is_an_answer_that_is_understood() {
        for (left, right, letters) in [
            (0.05, 0.001, "la"),
            (-0.05, 0.001, "lb"),
            (-0.002, 0.05, "ra"),
            (0.002, -0.05, "rb"),
            (0.003, -0.004, "n"),
        ] {
            let seen = Seen::of_ways(WheelPair { left, right });
            assert_eq!((seen.letters(), Seen::parse(letters)), (letters, Some(seen)));
        }
    }

    #[test]
    fn turned_round_twice_is_the_same_and_once_only_what_was_named() {
        let config = Config::default();
        let left = WheelPair { left: true, right: false };
        let turned = turned_round(&config, left);
        assert_ne!(turned.motor.left.reversed, config.motor.left.reversed);
        assert_ne!(turned.encoder.left.reversed, config.encoder.left.reversed);
        assert_eq!(turned.motor.right.reversed, config.motor.right.reversed);
        assert!(turned_round(&turned, left) == config);
    }
}
