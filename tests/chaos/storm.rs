//! What happens to hosts, server, robot and line during a session.

use std::rc::Rc;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Encoder, Hello};
use sim_target::plant::PlantFault;
use sim_target::{Nor, Testbed, now_us, sleep_until_us};

use super::host::{Done, Fate, Laboratory};
use super::network::Weather;

/// A session's storm.
pub struct Storm {
    pub laboratory: Laboratory,
    pub testbed: Testbed,
    /// A planted fault: the flash, and what it holds again after a power cut.
    pub rewind: Option<(Nor, Nor)>,
    pub fates: Vec<Rc<Fate>>,
    pub until_us: u64,
}

impl Storm {
    /// One event after another, until the session is over.
    pub async fn rage(self, seed: u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        if rng.random_bool(0.7) {
            self.laboratory.network.borrow_mut().weather = Weather::draw(&mut rng);
        }
        while now_us() < self.until_us {
            sleep_until_us(now_us() + rng.random_range(50_000..1_500_000)).await;
            self.strike(&mut rng).await;
        }
    }

    async fn strike(&self, rng: &mut ChaCha8Rng) {
        let fate = self.fates[rng.random_range(0..self.fates.len())].clone();
        let count = |what: fn(&mut Done)| self.laboratory.count(what);
        match rng.random_range(0..12) {
            0 => {
                fate.killed.set(true);
                if let Some(link) = fate.link.take() {
                    link.borrow_mut().end(rng.random_bool(0.5));
                }
                count(|done| done.kills += 1);
            }
            1 => {
                fate.stalled_until_us.set(now_us() + rng.random_range(1_000..3_000_000));
                count(|done| done.stalls += 1);
            }
            2 => self.set_clock(&fate, rng),
            3 => {
                self.laboratory.network.borrow_mut().kill_server(rng.random_range(0..800_000));
                count(|done| done.servers += 1);
            }
            4 | 5 => {
                // Often while something is being saved: that takes a few milliseconds.
                for _ in 0..rng.random_range(1..3) {
                    self.laboratory.judge.borrow_mut().restarts();
                    if let Some((nor, earlier)) = &self.rewind {
                        nor.put_back(earlier);
                    }
                    self.testbed.cut_power();
                    sleep_until_us(now_us() + rng.random_range(100..20_000)).await;
                    count(|done| done.restarts += 1);
                }
            }
            6 => self.laboratory.network.borrow_mut().weather = Weather::draw(rng),
            7 => self.laboratory.network.borrow_mut().weather = Weather::default(),
            8 => self.replay(rng).await,
            9 => self.noise(rng).await,
            10 => {
                self.testbed.inject(PlantFault::EmergencyStop);
                sleep_until_us(now_us() + 100_000).await;
                mend(&self.testbed);
            }
            _ => {}
        }
    }

    /// The computer slept, with or without its clock; or somebody set that.
    fn set_clock(&self, fate: &Fate, rng: &mut ChaCha8Rng) {
        let us = rng.random_range(1_000..20_000_000);
        if rng.random_bool(0.5) {
            // The clock stood while the computer slept.
            let us = us.min(2_000_000);
            fate.stalled_until_us.set(now_us() + us);
            fate.ahead_us.set(fate.ahead_us.get() - us as i64);
        } else {
            fate.ahead_us.set(fate.ahead_us.get() + us as i64);
        }
    }

    /// Somebody sends again what was said before.
    async fn replay(&self, rng: &mut ChaCha8Rng) {
        let recorded = self.laboratory.network.borrow().recorded.clone();
        if recorded.is_empty() {
            return;
        }
        let from = rng.random_range(0..recorded.len());
        for frame in recorded[from..].iter().take(60) {
            self.laboratory.network.borrow_mut().intrude(frame);
            sleep_until_us(now_us() + rng.random_range(100..3_000)).await;
        }
        self.laboratory.network.borrow_mut().recorded.clear();
    }

    /// Somebody who knows nothing, or wants in.
    async fn noise(&self, rng: &mut ChaCha8Rng) {
        let mut encoder = Encoder::new();
        for _ in 0..rng.random_range(1..200) {
            let mut bytes = [0; 60];
            rng.fill_bytes(&mut bytes);
            bytes[59] = 0;
            let hello = encoder.hello(Hello::of_this_build(rng.random_range(0..8)));
            let frame = if rng.random_bool(0.5) { &bytes[..] } else { &hello[..] };
            self.laboratory.network.borrow_mut().intrude(frame);
            sleep_until_us(now_us() + rng.random_range(50..2_000)).await;
        }
    }
}

/// The button is out again.
pub fn mend(testbed: &Testbed) {
    testbed.mend(PlantFault::EmergencyStop);
}
