//! What measures a calibration, by its options.

use sim_target::Lab;

use crate::calibrate::Instrument;
use crate::cli::{CalibrateArgs, Measure};
use crate::error::{Error, Result};

pub(super) fn instrument(args: &CalibrateArgs, lab: Option<Lab>) -> Result<Instrument> {
    let measure = args.measure.clone().unwrap_or(match lab {
        Some(_) => Measure::Camera,
        None => Measure::Ask,
    });
    let confirm = !args.yes;
    match (measure, lab) {
        (Measure::Camera, Some(lab)) => Ok(Instrument::Camera(lab, 0)),
        (Measure::Ruler, Some(lab)) => Ok(Instrument::Ruler(lab)),
        (Measure::Camera | Measure::Ruler, None) => {
            Err(Error::new("camera and ruler belong to the simulator in this process (--port sim)")
                .hint("--measure ask, or --measure track:FILE"))
        }
        (Measure::Nobody, _) => Err(Error::new("a calibration needs a measurement")
            .hint("--measure ask, or --measure track:FILE")),
        (Measure::Ask, _) => Ok(Instrument::Person { resolution_m: args.ruler.m, confirm }),
        (Measure::Track(path), _) => Ok(Instrument::TrackFile {
            path,
            position_sigma_m: args.position_sigma.m,
            heading_sigma_rad: args.heading_sigma.rad,
            confirm,
            seen: 0,
        }),
    }
}
