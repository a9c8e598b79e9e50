//! Effects hidden in a robot, for a blind test: the tested program has to find the effect.
//!
//! An effect is a mechanism of the plant or of an instrument, never an equation of a model. Ids in the
//! catalogue are those of `robot-model`; the other effects are in no catalogue.

mod apply;
#[cfg(test)]
mod tests;

use core::fmt;
use core::str::FromStr;

/// A run that shows an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShownBy {
    /// Straight there, and straight back in reverse.
    OutAndBack,
    /// A turn on the spot.
    Spin,
    /// Part of a circle.
    Arc,
    /// Four sides and four turns on the spot.
    Square,
}

macro_rules! effects {
    ($($(#[$doc:meta])* $name:ident = $id:literal, $catalogue:literal, $shown:ident;)*) => {
        /// Something that can be wrong with a robot.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum HiddenEffect {
            $($(#[$doc])* $name,)*
        }

        impl HiddenEffect {
            /// All of them, the catalogue's first.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Its name in files.
            pub fn id(self) -> &'static str {
                match self { $(Self::$name => $id,)* }
            }

            /// True if the catalogue of model effects lists this effect.
            pub fn is_in_catalogue(self) -> bool {
                match self { $(Self::$name => $catalogue,)* }
            }

            /// A run that shows the effect.
            pub fn shown_by(self) -> ShownBy {
                match self { $(Self::$name => ShownBy::$shown,)* }
            }
        }
    };
}

effects! {
    /// Unequal radii.
    WheelRadiusRatio = "wheel_radius_ratio", true, OutAndBack;
    /// Both radii off.
    WheelRadiusScale = "wheel_radius_scale", true, OutAndBack;
    /// A narrower or wider track.
    TrackWidth = "track_width", true, Spin;
    /// Wide tyres that scrub in a turn, and a caster that drags.
    Scrub = "scrub", true, Spin;
    /// Tyres that creep sideways under a side force, as on a film.
    SideSlip = "side_slip", true, Arc;
    /// Tyres that are soft along the way.
    TractionSlip = "traction_slip", true, OutAndBack;
    /// A high centre of mass on tyres that give.
    TurnLoadTransfer = "turn_load_transfer", true, Arc;
    /// Tyres that grow as they spin.
    SpeedGrowth = "speed_growth", true, OutAndBack;
    /// Rims off their hubs.
    WheelEccentricity = "wheel_eccentricity", true, OutAndBack;
    /// Encoder discs off their shafts.
    EncoderEccentricity = "encoder_eccentricity", true, OutAndBack;
    /// Thin lines that an input filter swallows at speed.
    LostCounts = "lost_counts", true, OutAndBack;
    /// Gears with play, the encoder on the motor's side.
    Backlash = "backlash", true, OutAndBack;
    /// A caster with a long fork on a stiff pivot.
    CasterKick = "caster_kick", true, OutAndBack;
    /// A twisted cable from above.
    HeadingPull = "heading_pull", true, OutAndBack;
    /// A wheel that slides along its axle to one side in left turns, to the other in right ones.
    TurnAsymmetry = "turn_asymmetry", true, Spin;
    /// A sloping floor.
    Slope = "slope", true, OutAndBack;
    /// A carpet whose pile leans over under the tyres.
    CarpetDrift = "carpet_drift", true, OutAndBack;
    /// Cold wheels that warm up over the campaign.
    ThermalDrift = "thermal_drift", true, OutAndBack;
    /// Tyres that give under a payload, which each run sets.
    Payload = "payload", true, OutAndBack;
    /// A camera that stamps a picture's arrival.
    MeasurementDelay = "measurement_delay", true, OutAndBack;
    /// A marker that is not on the axle's midpoint.
    MarkerOffset = "marker_offset", true, Spin;
    /// A gyro that reads something at rest.
    GyroBias = "gyro_bias", true, Spin;
    /// A gyro that reads too much or too little.
    GyroScale = "gyro_scale", true, Spin;

    /// Tyres that roll decimetres before a force has built up.
    RelaxationLength = "relaxation_length", false, Square;
    /// One wheel slips on its shaft under a high torque.
    SetScrewSlip = "set_screw_slip", false, OutAndBack;
    /// Oil on one wheel's path.
    WetPatch = "wet_patch", false, OutAndBack;
    /// Both wheels wobble on bent axle ends.
    BentAxle = "bent_axle", false, OutAndBack;
    /// Something drags over the floor at one side.
    DraggingBrush = "dragging_brush", false, OutAndBack;
    /// Magnets that are not round: two errors a turn.
    MagneticEncoder = "magnetic_encoder", false, OutAndBack;
    /// A gear with uneven teeth between one encoder and its wheel.
    GearRipple = "gear_ripple", false, OutAndBack;
    /// A lens that bends straight lines.
    LensDistortion = "lens_distortion", false, OutAndBack;
    /// Dropped pictures, replaced by old ones under fresh stamps.
    StaleFrames = "stale_frames", false, OutAndBack;
    /// A cable under the carpet, on one wheel's path.
    FloorBump = "floor_bump", false, OutAndBack;
    /// A caster whose pivot is nearly stuck.
    StickyCaster = "sticky_caster", false, Square;
    /// One wheel stood on one spot for too long.
    FlatSpot = "flat_spot", false, OutAndBack;
    /// Sidewalls that give under a side force while they roll.
    SoftSidewalls = "soft_sidewalls", false, Arc;
    /// A cable that pulls sideways.
    TetherPull = "tether_pull", false, OutAndBack;
}

impl fmt::Display for HiddenEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

impl FromStr for HiddenEffect {
    type Err = String;

    fn from_str(id: &str) -> Result<Self, String> {
        Self::ALL.iter().copied().find(|effect| effect.id() == id).ok_or_else(|| {
            let ids: Vec<_> = Self::ALL.iter().map(|effect| effect.id()).collect();
            format!("no hidden effect `{id}`; there are {}", ids.join(", "))
        })
    }
}
