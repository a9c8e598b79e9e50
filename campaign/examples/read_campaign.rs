//! Reads a campaign folder, and prints how long each run took and how far its wheels rolled.
//!
//! cargo run --example read_campaign -p campaign -- examples/mystery-robot

use std::path::PathBuf;

use campaign::Campaign;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("usage: read_campaign FOLDER")?);
    let (files, recordings) = Campaign::read_both(&folder)?;
    for warning in &files.warnings {
        eprintln!("warning: {warning}");
    }
    let campaign = recordings.into_model(&files, &folder)?;
    println!("{}: {} runs", files.robot.name, campaign.runs.len());
    for run in &campaign.runs {
        let (first, last) = (run.wheels[0], run.wheels[run.wheels.len() - 1]);
        let rolled_m =
            last.phi_rad.since(first.phi_rad).map(|rad| rad * campaign.robot.wheel_radius_m);
        println!(
            "{:28} {:6.1} s  left {:+.3} m  right {:+.3} m  {} poses",
            run.name,
            last.t_s - first.t_s,
            rolled_m.left,
            rolled_m.right,
            run.measured_poses.len(),
        );
    }
    Ok(())
}
