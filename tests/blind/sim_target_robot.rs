//! How is a robot of the benchmark recorded? By the procedure of `beeline campaign record`, in this process.

use campaign::plan::{CampaignPlan, PlanSettings};
use campaign::{Campaign, CampaignWriter, Run, RunFacts};
use futures_lite::future;
use host_cli::campaign_recorder::samples::{columns, robot_file};
use host_cli::campaign_recorder::{RunOutcome, record_run};
use host_cli::error::Error;
use host_cli::pose_source::camera::Camera;
use host_cli::pose_source::{DriveOrSkip, Mark, PoseSource};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim_target::instruments::GyroParameters;
use sim_target::plant::{MotorParameters, PlantParameters};
use sim_target::scenario::{HiddenEffect, PlacementParameters};
use sim_target::{Options, Scenario, SimTarget};

use super::case::Kind;

/// Telemetry period of the benchmark's campaigns \[ms\]: a wheel at 0.35 m/s makes a tenth of a turn in it.
pub const PERIOD_MS: u16 = 50;
/// Rate of its camera \[Hz\].
const CAMERA_HZ: f64 = 10.0;

/// Stiffness of a sound robot's tyres, relative to the standard robot's.
const HARD: f64 = 6.0;
/// Relaxation length, relative to the standard robot's: the same deflection at less slip.
const LONG: f64 = 4.0;
/// Rolling resistance, relative to the standard robot's.
const EASY: f64 = 0.25;
/// Hard tyres vibrate faster \[us\].
const SUBSTEP_US: u32 = 200;
/// Readings of the gyro, where there is one \[Hz\].
const GYRO_HZ: f64 = 20.0;

/// The usual campaign with one load, on a floor of 3 m.
pub fn plan() -> CampaignPlan {
    let settings = PlanSettings { payload_kg: 3.0, ..PlanSettings::default() };
    CampaignPlan::usual(&settings).expect("the usual floor is large enough")
}

/// A sound robot of nominal size, no two alike: its own tyres and caster have no effect that its campaign can detect.
///
/// Those of the standard robot have: its narrow rubber rings slip by 0.8 % per m/s^2, which is an effect of the
/// catalogue (traction_slip), and their rolling resistance makes the wheels appear 0.05 % too small. So a sound robot
/// has stiff tyres that roll easily.
pub fn sound(seed: u64, kind: Kind, effects: &[HiddenEffect]) -> Scenario {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut plant = PlantParameters { substep_us: SUBSTEP_US, ..PlantParameters::default() };
    plant.tyre.longitudinal_stiffness_n_per_m *= HARD;
    plant.tyre.lateral_stiffness_n_per_m *= HARD;
    plant.tyre.relaxation_length_m *= LONG;
    plant.tyre.rolling_resistance *= EASY;
    plant.caster.rolling_resistance *= EASY;
    let mut vary = |value: &mut f64| *value *= 1.0 + rng.random_range(-0.1..=0.1);
    vary(&mut plant.body.mass_kg);
    vary(&mut plant.body.yaw_inertia_kgm2);
    let mut vary_motor = |motor: &mut MotorParameters| {
        vary(&mut motor.resistance_ohm);
        vary(&mut motor.torque_constant_nm_per_a);
        vary(&mut motor.coulomb_torque_nm);
        vary(&mut motor.viscous_torque_nms);
    };
    vary_motor(&mut plant.motor.left);
    vary_motor(&mut plant.motor.right);
    vary(&mut plant.floor.friction);
    plant.encoder = plant
        .encoder
        .map(|encoder| sim_target::plant::EncoderParameters { phase: None, ..encoder });
    let mut scenario = Scenario { name: "sound".into(), seed, plant, ..Scenario::default() };
    scenario.camera.rate_hz = CAMERA_HZ;
    // Placed by hand on a mark: to a centimetre and a degree.
    let placement = scenario.placement;
    scenario.placement =
        PlacementParameters { heading_sigma_rad: 0.02, position_sigma_m: 0.01, ..placement };
    // Every other robot has a gyro, and so has every robot whose gyro is at fault.
    let gyro_is_hidden = effects.iter().any(|effect| effect.id().starts_with("gyro_"));
    if rng.random_bool(0.5) || gyro_is_hidden {
        scenario.gyro = Some(GyroParameters { rate_hz: GYRO_HZ, ..GyroParameters::default() });
    }
    if kind == Kind::Nuisance {
        scenario.placement =
            PlacementParameters { heading_sigma_rad: 0.1, position_sigma_m: 0.05, ..placement };
        scenario.camera.position_sigma_m = 0.001 * rng.random_range(0.5..=2.0);
        scenario.camera.heading_sigma_rad = 0.002 * rng.random_range(0.5..=2.0);
        // Known, and subtracted by whoever writes the recording.
        scenario.camera.delay_s = rng.random_range(0.01..=0.12);
    }
    scenario
}

/// Records a campaign.
pub fn record(scenario: &Scenario, plan: &CampaignPlan, period_ms: u16) -> Result<Campaign, Error> {
    let mut target = SimTarget::new(scenario, Options::default())
        .map_err(|error| Error::new(format_args!("no flash: {error}")))?;
    let testbed = target.testbed();
    let mut session = sim_link::session(&target.host_wire(), 1, "sim");
    target.run(future::or(
        async {
            session.open().await?;
            let config = session.read_config().await?;
            let mut camera = Camera::new(testbed);
            let robot = robot_file(&config, camera.noise());
            let mut campaign =
                Campaign { robot, runs: Vec::new(), copies: Vec::new(), warnings: Vec::new() };
            for (index, run) in plan.runs.iter().enumerate() {
                if camera.place(&session.clock(), Mark::Run(run)).await? == DriveOrSkip::Skip {
                    continue;
                }
                let ran = record_run(
                    &mut session,
                    &mut camera,
                    &config,
                    plan,
                    run,
                    period_ms,
                    &mut |_| (),
                )
                .await?;
                let RunOutcome::Recorded(recorded) = ran else { continue };
                let name = format!("{:02}_{}", index + 1, run.name);
                let facts = RunFacts {
                    name: name.clone(),
                    started_s: Some(recorded.started_us as f64 * 1e-6),
                    payload_kg: (run.payload_kg > 0.0).then_some(run.payload_kg),
                    held_out: run.held_out,
                    ..RunFacts::default()
                };
                campaign.robot.runs.push(facts.clone());
                campaign.runs.push(Run { name, facts, rows: recorded.rows });
            }
            Ok(campaign)
        },
        std::future::pending(),
    ))
}

/// Writes a campaign to a folder, as `beeline campaign record` would.
pub fn keep(campaign: &Campaign, folder: &std::path::Path) -> Result<(), Error> {
    let robot = campaign::RobotFile { runs: Vec::new(), ..campaign.robot.clone() };
    let writer = CampaignWriter::open(folder, &robot)?;
    for run in &campaign.runs {
        let name = run.name.trim_start_matches(|c: char| c.is_ascii_digit() || c == '_');
        let gyro = run.rows.iter().any(|row| row.gyro_z_rad_s.is_some());
        let mut file = writer.start_run(name, &columns(true, gyro))?;
        for row in &run.rows {
            file.push(row)?;
        }
        file.finish(run.facts.clone())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_holds_all_of_its_pieces() {
        let mut plan = plan();
        plan.runs.retain(|run| run.pieces.len() > 1);
        plan.runs.truncate(1);
        let planned_s = plan.runs[0].duration_s(0.372, plan.acceleration_mps2);
        let campaign =
            record(&sound(3, Kind::Nothing, &[]), &plan, PERIOD_MS).expect("a sound robot drives");
        let rows = &campaign.runs[0].rows;
        let spans_s = rows[rows.len() - 1].t_s - rows[0].t_s;
        assert!(spans_s > 0.9 * planned_s, "{spans_s} s of {planned_s} s");
        let left: Vec<f64> = rows.iter().filter_map(|row| row.counts.left).collect();
        let most = left.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // Out, and back to the start: both ways are in the recording.
        let (out, back) = (most - left[0], most - left[left.len() - 1]);
        assert!(out > 1000.0 && back > 0.95 * out, "{out} counts out, {back} back");
    }
}
