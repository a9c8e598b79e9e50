//! Chaos: whole sessions of hosts, server, line and robot in virtual time, in which everything breaks.
//!
//! ```text
//! seed, number -> one session:  1 to 3 hosts, killed and begun again, with procedures of every kind
//!                               a server that is killed and begins again
//!                               lines that lose, damage, repeat, delay, reorder, and send recorded frames again
//!                               a robot that its watchdog restarts, and that keeps its flash
//!              -> nothing, or the first of the invariants that did not hold
//! ```
//!
//! The real server, and clients that do not read, are tested in real time (`tests/binary/real_time/`), disks and folders at every
//! system call (`tests/binary/crash_points/`).

mod bridge;
mod host;
mod invariants;
mod plant;
mod witness;

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

use futures_lite::future;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim_target::{Lab, Options, RobotTask, Scenario, SimTarget, now_us, sleep_until_us};

use bridge::{Bridge, Weather};
pub use host::Ends;
use host::hosts;
use invariants::{Invariants, check_flash};
pub use plant::Plant;
use witness::Witness;

/// One session; an error is what did not hold.
pub fn session(seed: u64, number: u64, plant: Plant) -> Result<Ends, String> {
    let run = AssertUnwindSafe(|| run(seed, number, plant));
    catch_unwind(run).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        Err(format!("panic: {}", text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("?")))
    })
}

fn run(seed: u64, number: u64, plant: Plant) -> Result<Ends, String> {
    // Knuth's multiplier: neighbouring numbers draw nothing alike.
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ number.wrapping_mul(6_364_136_223_846_793_005));
    let scenario = Scenario { seed: rng.random(), ..Scenario::default() };
    let mut target = SimTarget::new(&scenario, Options::default()).expect("there is no file");
    let (lab, wire) = (target.lab(), target.host_wire());
    let witness = Rc::new(RefCell::new(Witness::default()));
    let bridge = Bridge::new(wire, rng.random(), Weather::draw(&mut rng), plant, witness.clone());
    let until_us = rng.random_range(2_000_000..12_000_000);
    let ends = Rc::new(RefCell::new(Ends::default()));
    let mut all = Vec::new();
    for _ in 0..rng.random_range(1..4) {
        let draws = ChaCha8Rng::seed_from_u64(rng.random());
        all.push(Box::pin(hosts(bridge.clone(), draws, until_us, ends.clone())));
    }
    let breaks = breaks(bridge.clone(), lab.clone(), witness.clone(), rng, until_us);
    let watched = watched(&bridge, &lab, &witness);
    let over = async {
        // Longer than any ramp, and than a frame that is late.
        sleep_until_us(until_us + 4_000_000).await;
        Ok(())
    };
    let hosts = async {
        for result in join_all(all).await {
            result?;
        }
        future::pending().await
    };
    let session = future::or(future::or(watched, over), future::or(hosts, breaks));
    target.run(session)?;
    check_flash(lab.flash_content().as_deref(), &witness.borrow())?;
    let ends = *ends.borrow();
    Ok(ends)
}

/// Waits for all of them at once; the first that fails ends it.
async fn join_all<F: Future<Output = Result<(), String>> + Unpin>(
    mut all: Vec<F>,
) -> Vec<Result<(), String>> {
    use std::task::Poll;
    let mut done = Vec::new();
    future::poll_fn(|context| {
        let mut index = 0;
        while index < all.len() {
            match std::pin::Pin::new(&mut all[index]).poll(context) {
                Poll::Ready(result) => {
                    done.push(result);
                    drop(all.swap_remove(index));
                }
                Poll::Pending => index += 1,
            }
        }
        match all.is_empty() || done.iter().any(Result::is_err) {
            true => Poll::Ready(std::mem::take(&mut done)),
            false => Poll::Pending,
        }
    })
    .await
}

/// Passes frames on and holds the invariants, every millisecond.
async fn watched(bridge: &Bridge, lab: &Lab, witness: &RefCell<Witness>) -> Result<(), String> {
    let mut invariants = Invariants::default();
    loop {
        bridge.pass_on();
        invariants.check(now_us(), lab, &mut witness.borrow_mut())?;
        sleep_until_us(now_us() + 1000).await;
    }
}

/// Kills and begins again the server and the robot, now and then.
async fn breaks(
    bridge: Bridge,
    lab: Lab,
    witness: Rc<RefCell<Witness>>,
    mut rng: ChaCha8Rng,
    until_us: u64,
) -> Result<(), String> {
    loop {
        let pause_us = rng.random_range(200_000..8_000_000);
        sleep_until_us(now_us() + pause_us).await;
        if now_us() > until_us {
            return future::pending().await;
        }
        if rng.random_bool(0.5) {
            bridge.set_up(false);
            let down_us = rng.random_range(1_000..1_000_000);
            sleep_until_us(now_us() + down_us).await;
            bridge.set_up(true);
        } else {
            check_flash(lab.flash_content().as_deref(), &witness.borrow())?;
            witness.borrow_mut().restart();
            lab.stop_task(RobotTask::Pid);
        }
    }
}
