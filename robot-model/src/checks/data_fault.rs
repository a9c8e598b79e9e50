//! What can be wrong with the data of a run or of all runs: each a transformation that would mend it.

/// One of the wheels, or both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wheel {
    /// The left one.
    Left,
    /// The right one.
    Right,
    /// Both alike.
    Both,
}

/// How the axes of measured poses differ from ours: x forward, y to the left, headings in radians,
/// counter-clockwise from x towards y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Axes {
    /// x has the wrong sign, and headings have not.
    XMirrored,
    /// y has the wrong sign, and headings have not.
    YMirrored,
    /// The columns x and y are exchanged, and headings are ours.
    Exchanged,
    /// Ours is `sign * unit * heading - turned_rad`.
    Heading {
        /// In degrees: the unit is pi / 180, else 1.
        degrees: bool,
        /// Clockwise: the sign is -1, else 1.
        negated: bool,
        /// Counter-clockwise positive, -pi..pi \[rad\].
        turned_rad: f64,
    },
    /// Positions and headings both turned about the origin. A frame of its own shows only where the first pose of
    /// each run is in ours.
    Frame {
        /// Counter-clockwise positive \[rad\].
        turned_rad: f64,
    },
}

/// Something that is wrong with the data, not with the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DataFault {
    /// The encoders of left and right are exchanged; with headings, y to the right and headings clockwise are the
    /// same.
    WheelsExchanged,
    /// A wheel counts up when it rolls backwards.
    CountsReversed {
        /// Which.
        wheel: Wheel,
    },
    /// A wheel turned this many times as far as it counted.
    Counts {
        /// Which.
        wheel: Wheel,
        /// How many times.
        times: f64,
    },
    /// The robot went and turned this many times as far as its wheels rolled: the radius, or the counts of a turn.
    Radius {
        /// How many times.
        times: f64,
    },
    /// The track is this many times as wide.
    Track {
        /// How many times.
        times: f64,
    },
    /// Both the radius and the track are this many times as long.
    Lengths {
        /// How many times.
        times: f64,
    },
    /// Positions are in a smaller unit than metres.
    Positions {
        /// How many of it make a metre.
        per_m: f64,
    },
    /// Poses have other axes.
    Axes {
        /// Which.
        axes: Axes,
        /// Only the poses after the first of each run: the first is a mark on the floor, and was not measured.
        after_first: bool,
    },
    /// A counter wrapped around.
    CounterWraps {
        /// Whose.
        wheel: Wheel,
        /// At the first sample after it \[s\].
        t_s: f64,
        /// Bits of the counter.
        bits: u32,
        /// How often.
        times: usize,
    },
    /// A counter restarted from zero.
    CounterReset {
        /// Whose.
        wheel: Wheel,
        /// At the first sample after it \[s\].
        t_s: f64,
    },
    /// A count jumped as no wheel rolls: a corrupt row, or lost counts.
    CountsJump {
        /// Whose.
        wheel: Wheel,
        /// At the first sample after it \[s\].
        t_s: f64,
        /// How far the wheel would have rolled \[m\].
        rolled_m: f64,
    },
    /// From one pose to the next the tracker lost its place.
    TrackerJump {
        /// At the first pose after it \[s\].
        t_s: f64,
        /// How far \[m\].
        by_m: f64,
    },
    /// The tracker repeated one pose while the robot went on.
    TrackerFrozen {
        /// The first repeated pose \[s\].
        from_s: f64,
        /// The last one \[s\].
        to_s: f64,
    },
    /// Measured poses are repeated until there is a new one.
    PosesHeld {
        /// Between two new ones \[s\].
        every_s: f64,
    },
    /// Counts are repeated until there are new ones.
    CountsHeld {
        /// Between two new ones \[s\].
        every_s: f64,
    },
    /// The last pose of a run is far from where the wheels led from the first one.
    LastPose {
        /// When it was measured \[s\].
        t_s: f64,
        /// How far, if its position is \[m\].
        position_m: Option<f64>,
        /// How far, if its heading is, counter-clockwise positive \[rad\].
        heading_rad: Option<f64>,
    },
    /// The poses of a run lie far from where the wheels led, and nothing known explains it.
    Unknown,
}

/// Something that is wrong with the data, with its evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct DataHypothesis {
    /// What.
    pub what: DataFault,
    /// The run that it is wrong in; `None`: in all runs, or in the robot's data sheet.
    pub run: Option<String>,
    /// What would mend these runs as well, so that the tracks cannot tell it from [`DataHypothesis::what`].
    pub or: Vec<DataFault>,
    /// The distance (rms) of the measured poses from the best track of a robot whose radius, ratio of radii and track
    /// width are free within limits; a radian of heading counts as a track width. As the data are \[m\].
    pub error_m: f64,
    /// The same with this mended \[m\].
    pub mended_m: f64,
    /// The next best explanation, and the error with that mended instead \[m\].
    pub next: Option<(DataFault, f64)>,
}

impl DataFault {
    /// Whether runs can be fitted all the same: a single pose, or values that come late.
    pub fn is_minor(&self) -> bool {
        matches!(
            self,
            Self::CountsJump { .. }
                | Self::PosesHeld { .. }
                | Self::CountsHeld { .. }
                | Self::LastPose { .. }
                | Self::Unknown
        )
    }
}
