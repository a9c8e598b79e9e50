//! What a column can hold, and in which units.

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Quantity {
    Time,
    LeftCounts,
    RightCounts,
    LeftAngle,
    RightAngle,
    LeftTravel,
    RightTravel,
    X,
    Y,
    Z,
    Heading,
    QuaternionX,
    QuaternionY,
    QuaternionZ,
    QuaternionW,
}

/// Units that a number can be in, with what makes an SI unit of one.
const TIMES: &[(&str, f64)] = &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
const LENGTHS: &[(&str, f64)] =
    &[("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)];
const ANGLES: &[(&str, f64)] =
    &[("rad", 1.0), ("deg", std::f64::consts::PI / 180.0), ("rev", std::f64::consts::TAU)];

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::Time,
        Self::LeftCounts,
        Self::RightCounts,
        Self::LeftAngle,
        Self::RightAngle,
        Self::LeftTravel,
        Self::RightTravel,
        Self::X,
        Self::Y,
        Self::Z,
        Self::Heading,
        Self::QuaternionX,
        Self::QuaternionY,
        Self::QuaternionZ,
        Self::QuaternionW,
    ];

    /// Whether it is one of a wheel.
    pub const fn is_wheel(self) -> bool {
        matches!(
            self,
            Self::LeftCounts
                | Self::RightCounts
                | Self::LeftAngle
                | Self::RightAngle
                | Self::LeftTravel
                | Self::RightTravel
        )
    }

    /// Its name in `--map`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Time => "t_s",
            Self::LeftCounts => "left_counts",
            Self::RightCounts => "right_counts",
            Self::LeftAngle => "left_rad",
            Self::RightAngle => "right_rad",
            Self::LeftTravel => "left_m",
            Self::RightTravel => "right_m",
            Self::X => "x_m",
            Self::Y => "y_m",
            Self::Z => "z_m",
            Self::Heading => "heading_rad",
            Self::QuaternionX => "qx",
            Self::QuaternionY => "qy",
            Self::QuaternionZ => "qz",
            Self::QuaternionW => "qw",
        }
    }

    /// Names that loggers give to such a column, in small letters, without a unit.
    pub(super) const fn usual_names(self) -> &'static [&'static str] {
        match self {
            Self::Time => &["t", "time", "timestamp", "stamp", "seconds", "__time"],
            Self::LeftCounts => {
                &["left_ticks", "left_encoder", "encoder_left", "enc_left", "enc_l", "ticks_left"]
            }
            Self::RightCounts => &[
                "right_ticks",
                "right_encoder",
                "encoder_right",
                "enc_right",
                "enc_r",
                "ticks_right",
            ],
            Self::LeftAngle => &["left_angle", "left_position", "left_wheel", "left_wheel_joint"],
            Self::RightAngle => {
                &["right_angle", "right_position", "right_wheel", "right_wheel_joint"]
            }
            Self::LeftTravel => &["left_travel", "left_distance"],
            Self::RightTravel => &["right_travel", "right_distance"],
            Self::X => &[
                "x",
                "px",
                "pos_x",
                "position_x",
                "tx",
                "p_rs_r_x",
                "pose.position.x",
                "position.x",
            ],
            Self::Y => &[
                "y",
                "py",
                "pos_y",
                "position_y",
                "ty",
                "p_rs_r_y",
                "pose.position.y",
                "position.y",
            ],
            Self::Z => &[
                "z",
                "pz",
                "pos_z",
                "position_z",
                "tz",
                "p_rs_r_z",
                "pose.position.z",
                "position.z",
            ],
            Self::Heading => &["heading", "yaw", "theta", "psi"],
            Self::QuaternionX => &["q_x", "q_rs_x", "pose.orientation.x", "orientation.x"],
            Self::QuaternionY => &["q_y", "q_rs_y", "pose.orientation.y", "orientation.y"],
            Self::QuaternionZ => &["q_z", "q_rs_z", "pose.orientation.z", "orientation.z"],
            Self::QuaternionW => &["q_w", "q_rs_w", "pose.orientation.w", "orientation.w"],
        }
    }

    /// Units that it can be in.
    pub(super) const fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Time => TIMES,
            Self::LeftTravel | Self::RightTravel | Self::X | Self::Y | Self::Z => LENGTHS,
            Self::LeftAngle | Self::RightAngle | Self::Heading => ANGLES,
            _ => &[],
        }
    }

    /// What makes an SI unit of this one.
    pub(super) fn factor(self, unit: &str) -> Option<f64> {
        self.units().iter().find(|(name, _)| *name == unit).map(|(_, factor)| *factor)
    }
}
