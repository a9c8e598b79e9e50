//! A campaign with a hidden effect for a reader to find, and its seal: the reader can look up the answer afterwards,
//! and be sure that nobody has changed it.
//!
//! ```text
//! answer = TOML text: seed, hidden effect, strength                     printed by `open`
//! seal   = SHA-256 of the answer's bytes                                in answer.toml.sealed, with the seed
//! ```

use host_cli::error::Error;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

use super::case::Kind;
use super::hidden_effects::{Hidden, inside};
use super::sim_target_robot::{PERIOD_MS, plan, record, sound};

/// A robot with something hidden in it.
#[derive(Clone, Copy, Debug)]
pub struct Mystery {
    seed: u64,
    hidden: Hidden,
}

impl Mystery {
    /// The one that this seed draws: an effect of the catalogue, one to two times as strong as typical.
    pub fn draw(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x6d79_7374_6572_7900);
        // A fault of the yaw rate sensor does not change the robot's path.
        let effects: Vec<_> =
            inside().into_iter().filter(|effect| !effect.id().starts_with("gyro_")).collect();
        let effect = *effects.choose(&mut rng).expect("the catalogue is not empty");
        let hidden = Hidden { effect, strength: rng.random_range(1.0..2.0), seed };
        Self { seed, hidden }
    }

    /// Which effect is hidden.
    pub fn hidden(&self) -> &'static str {
        self.hidden.effect.id()
    }

    /// What is hidden, as text.
    pub fn answer(&self) -> String {
        format!(
            "# What was hidden in this robot. The SHA-256 of these bytes is in answer.toml.sealed.\n\
             seed = {}\nhidden = \"{}\"\nstrength = {:.3}    # 1 is typical\n",
            self.seed,
            self.hidden.effect.id(),
            self.hidden.strength
        )
    }

    /// The seal: it fixes the answer without revealing it.
    pub fn sealed(&self) -> String {
        format!(
            "# What is hidden in this robot was drawn by this seed; `cargo run --release -p beeline-tests\n\
             # --example mystery -- open` prints it. The SHA-256 of what it prints is the seal, so nobody has\n\
             # changed it since: `... -- open | sha256sum`.\n\
             seed = {}\nsha256 = \"{}\"\n",
            self.seed,
            seal(&self.answer())
        )
    }

    /// Its campaign.
    ///
    /// # Errors
    /// If the robot cannot drive it.
    pub fn campaign(&self) -> Result<campaign::Campaign, Error> {
        let mut scenario = sound(self.seed, Kind::Nothing, &[]);
        scenario.gyro = None;
        self.hidden.hide(&mut scenario);
        let mut campaign = record(&scenario, &plan(), PERIOD_MS)?;
        campaign.robot.name = "mystery robot".into();
        Ok(campaign)
    }
}

/// SHA-256 in hexadecimal.
pub fn seal(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The seed of a sealed answer, and its seal.
///
/// # Errors
/// The field that is missing.
pub fn read_sealed(text: &str) -> Result<(u64, String), String> {
    let field = |name: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.trim().strip_prefix('='));
        line.map(|value| value.trim().trim_matches('"').to_owned())
            .ok_or(format!("it has no {name}"))
    };
    let seed = field("seed")?.parse().map_err(|_| "its seed is not a number".to_owned())?;
    Ok((seed, field("sha256")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seal_is_the_hash_of_the_answer_and_does_not_reveal_it() {
        let mystery = Mystery::draw(7);
        let (seed, sha256) = read_sealed(&mystery.sealed()).unwrap();
        assert_eq!((seed, sha256.clone()), (7, seal(&mystery.answer())));
        assert!(!mystery.sealed().contains(mystery.hidden.effect.id()));
        assert_ne!(seal(&Mystery::draw(8).answer()), sha256);
        // The standard's own example (FIPS 180-4).
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(seal("abc"), abc);
    }
}
