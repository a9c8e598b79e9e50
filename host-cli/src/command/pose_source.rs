//! Which source measures the robot, by the options of a calibration, a run or a campaign.

use crate::cli::{CalibrateArgs, CampaignRecordArgs, Measure};
use crate::error::{Error, Result};
use crate::pose_source::bench::Bench;
use crate::pose_source::camera::Camera;
use crate::pose_source::gyro_log::GyroLog;
use crate::pose_source::none::NoPoses;
use crate::pose_source::ruler::Ruler;
use crate::pose_source::tape::Tape;
use crate::pose_source::track_file::TrackFile;
use crate::pose_source::with_gyro::WithGyro;
use crate::pose_source::{PoseSource, Sigma};

/// The source that measures unless the user chooses another.
fn usual(bench: Option<&Bench>) -> Measure {
    match bench {
        Some(_) => Measure::Camera,
        None => Measure::Ask,
    }
}

/// The source that measures a calibration.
pub(super) fn of_calibration(
    args: &CalibrateArgs,
    bench: Option<Bench>,
) -> Result<Box<dyn PoseSource>> {
    let measure = args.measure.clone().unwrap_or(usual(bench.as_ref()));
    let confirm = !args.yes;
    match (measure, bench) {
        (Measure::Camera, Some(bench)) => Ok(Box::new(Camera::new(bench))),
        (Measure::Ruler, Some(bench)) => Ok(Box::new(Ruler::new(bench))),
        (Measure::Camera | Measure::Ruler, None) => {
            Err(Error::new("camera and ruler belong to the simulator in this process (--port sim)")
                .hint("--measure ask, or --measure track:FILE"))
        }
        (Measure::NoPoses, _) => Err(Error::new("a calibration needs a measurement")
            .hint("--measure ask, or --measure track:FILE")),
        (Measure::Ask, bench) => {
            // In virtual time a person would have to read what nobody sees.
            let bench = bench.filter(|bench| !bench.is_own());
            Ok(Box::new(Tape::new(confirm, Sigma::of_ruler(args.ruler.m), bench)))
        }
        (Measure::Track(path), _) => {
            let (position_m, heading_rad) = (args.position_sigma.m, args.heading_sigma.rad);
            let noise = Some(Sigma { position_m, heading_rad });
            Ok(Box::new(TrackFile { path, noise, confirm }))
        }
    }
}

/// The source that measures a single run: the simulator's camera, or none.
pub(super) fn of_run(bench: Option<Bench>) -> Box<dyn PoseSource> {
    match bench {
        Some(bench) => Box::new(Camera::new(bench)),
        None => Box::new(NoPoses { confirm: false }),
    }
}

/// The source that measures the runs of a campaign.
pub(super) fn of_campaign(
    args: &CampaignRecordArgs,
    bench: Option<Bench>,
) -> Result<Box<dyn PoseSource>> {
    match &args.gyro {
        None => poses_of_campaign(args, bench),
        Some(_) if bench.is_some() => {
            Err(Error::new("a simulated robot has its own gyro, defined in its scenario")
                .hint("leave out --gyro, and add a section [gyro] to the scenario"))
        }
        Some(path) => {
            Ok(Box::new(WithGyro::new(poses_of_campaign(args, bench)?, GyroLog::new(path))))
        }
    }
}

fn poses_of_campaign(
    args: &CampaignRecordArgs,
    bench: Option<Bench>,
) -> Result<Box<dyn PoseSource>> {
    let measure = args.measure.clone().unwrap_or(usual(bench.as_ref()));
    let confirm = !args.yes;
    match (measure, bench) {
        (Measure::Camera, Some(bench)) => Ok(Box::new(Camera::new(bench))),
        (Measure::Camera, None) => {
            Err(Error::new("the camera belongs to the simulator in this process (--port sim)")
                .hint("--measure track:FILE, ask or none"))
        }
        (Measure::Ruler, _) => {
            Err(Error::new("a campaign needs more than a ruler at the end of a run")
                .hint("--measure camera, track:FILE, ask or none"))
        }
        (Measure::Ask, bench) => {
            let sigma = Sigma {
                position_m: args.position_sigma.map_or(Sigma::TAPE.position_m, |sigma| sigma.m),
                heading_rad: args.heading_sigma.map_or(Sigma::TAPE.heading_rad, |sigma| sigma.rad),
            };
            Ok(Box::new(Tape::new(confirm, sigma, bench)))
        }
        (Measure::NoPoses, _) => Ok(Box::new(NoPoses { confirm })),
        (Measure::Track(path), _) => Ok(Box::new(TrackFile { path, noise: None, confirm })),
    }
}
