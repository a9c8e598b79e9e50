//! Drives a robot straight by one turn of its wheels, and prints how far they went.
//!
//! cargo run --example drive -p host-link -- tcp:127.0.0.1:7700

use host_link::motion::{Motion, RecordOptions, drive};
use shared_proto::WheelPair;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let address = std::env::args().nth(1).ok_or("usage: drive ADDRESS, such as /dev/ttyACM0")?;
    let mut session = host_link::connect(&address.parse()?)?;
    let one_turn = Motion { distance: WheelPair::both(1.0), ..Motion::PAPER };

    let (config, recording) = host_link::block_on(async {
        session.open().await?;
        let config = session.read_config().await?;
        let recording =
            drive(&mut session, &one_turn, RecordOptions::default(), &mut |_| ()).await?;
        host_link::Result::Ok((config, recording))
    })?;

    let frames = &recording.telemetry;
    let (first, last) = frames.first().zip(frames.last()).ok_or("no telemetry")?;
    let (before, after) = (first.wheels, last.wheels);
    let left = (after.left.counts - before.left.counts) as f64 / config.encoder.left.counts_per_rev;
    let right =
        (after.right.counts - before.right.counts) as f64 / config.encoder.right.counts_per_rev;
    println!("{} telemetry frames", frames.len());
    println!("left encoder {left:.2} rev, right encoder {right:.2} rev");
    Ok(())
}
