//! What the user is told during a calibration.

use crate::calibrate::{
    CalibrateStep, CalibrationDrive, Checks, Measurement, Settings, plausibility,
};
use crate::cli::{CalibrateArgs, Common};
use crate::command::identify::display_name;
use crate::quantity::{LengthUnit, plus_minus};
use crate::ui::{BOLD, Progress, note, paint, warn};
use crate::words;

/// Tells the user how far the calibration is.
pub(super) struct ProgressPrinter {
    quiet: bool,
    forgets: bool,
    distance: String,
    /// Drives with the old W_T.
    drives: u32,
    progress: Option<Progress>,
}

impl ProgressPrinter {
    pub(super) fn new(common: &Common, settings: &Settings, args: &CalibrateArgs) -> Self {
        let distance = format!("{}, {:.1} s", args.distance, settings.motion.duration_s());
        let forgets = common.robot_forgets();
        Self { quiet: common.json, forgets, distance, drives: 0, progress: None }
    }

    pub(super) fn print(&mut self, step: CalibrateStep<'_>) {
        if self.quiet {
            return;
        }
        match step {
            CalibrateStep::Checked(checks) => self.checked(checks),
            CalibrateStep::Driving(which, share) => {
                let title = match which {
                    CalibrationDrive::Before => "driving",
                    CalibrationDrive::Back => "driving back",
                    CalibrationDrive::After => "driving with the new W_T",
                    CalibrationDrive::Control => "driving with the old W_T once more",
                };
                self.progress.get_or_insert_with(|| Progress::new(title, false)).set(share);
            }
            CalibrateStep::Measured(which, measurement) => {
                self.progress = None;
                self.drives += u32::from(which == CalibrationDrive::Before);
                self.measured(which, measurement);
            }
            CalibrateStep::OutAndBack(both) => {
                note(format_args!(
                    "  way back   turned by {:+.1} mrad",
                    -both.back_alpha_rad * 1e3
                ));
                note(format_args!("  verdict    {}", words::out_and_back(both.verdict)));
                note(format_args!(
                    "  W_T        {}",
                    plus_minus(both.wheel_weight, both.wheel_weight_sigma)
                ));
            }
            CalibrateStep::Written(value) => {
                note(format_args!("  written    W_T {value:.6}, read back"));
                note(paint(BOLD, "Driving again"));
            }
            CalibrateStep::Saved if self.forgets => {
                note(
                    "  saved      (a simulated robot without --flash FILE forgets when this ends)",
                );
            }
            CalibrateStep::Saved => note("  saved      survives power-off"),
        }
    }

    fn checked(&self, checks: &Checks) {
        let config = &checks.config;
        note(paint(BOLD, format_args!("Calibrating {}", display_name(&checks.identity))));
        note(format_args!(
            "  link       {} requests answered, {} repeated",
            checks.asked, checks.repeated
        ));
        note(format_args!("  supply     {:.2} V", checks.supply_v));
        if checks.identity.unsaved {
            warn(
                "unsaved changes are discarded: a calibration starts from the saved configuration",
            );
        }
        note(format_args!(
            "  geometry   wheels {}, track {}, W_T {:.6}",
            LengthUnit::Cm.format(config.geometry.wheel_radius_m, 2),
            LengthUnit::Cm.format(config.geometry.track_width_m, 2),
            config.geometry.wheel_weight
        ));
        note(paint(BOLD, format_args!("Driving {}", self.distance)));
    }

    fn measured(&self, which: CalibrationDrive, measurement: &Measurement) {
        let end = measurement.run.end;
        let side = if end.lateral_offset_m < 0.0 { "right" } else { "left" };
        let off = LengthUnit::Mm.format(end.lateral_offset_m.abs(), 1);
        let heading_mrad = end.heading_rad * 1e3;
        match which {
            CalibrationDrive::Before => {
                if self.drives == 1 {
                    note("  encoders   directions agree with the motors");
                }
                note(format_args!(
                    "  before     {off} to the {side}, heading {heading_mrad:+.1} mrad"
                ));
                let weight = &measurement.wheel_weight;
                note(format_args!("  W_T        {}", plus_minus(weight.value, weight.sigma)));
                if let Some(doubt) = plausibility::doubt(weight.value) {
                    warn(doubt);
                }
            }
            // Only both ways together say something: see the verdict.
            CalibrationDrive::Back => {}
            CalibrationDrive::Control => {
                note("  a third drive, with the old W_T: two drives cannot tell");
                note(format_args!(
                    "  without    {off} to the {side}, heading {heading_mrad:+.1} mrad"
                ));
            }
            CalibrationDrive::After => {
                note(format_args!(
                    "  after      {off} to the {side}, heading {heading_mrad:+.1} mrad"
                ));
            }
        }
    }
}
