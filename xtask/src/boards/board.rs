//! What is known of a board: its name, its files, and where each line goes.

/// What a line is for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    LeftEncoderA,
    LeftEncoderB,
    RightEncoderA,
    RightEncoderB,
    LeftA,
    LeftB,
    LeftC,
    RightA,
    RightB,
    RightC,
    Enable,
    Fault,
    Stop,
    Supply,
}

/// One line between the board and the robot.
pub(super) struct Pin {
    pub(super) role: Role,
    /// The chip's name of it.
    pub(super) pin: &'static str,
    /// Where it is on the board.
    pub(super) place: &'static str,
}

/// A board as its page shows it.
pub(super) struct Board {
    /// Its name in its user manual.
    pub(super) name: &'static str,
    /// Of its page, its picture and, with underscores, its binary.
    pub(super) file: &'static str,
    /// Files beside its binary in which its pins are named.
    pub(super) sources: &'static [&'static str],
    pub(super) pins: [Pin; 14],
    /// A ground pin.
    pub(super) ground: &'static str,
    /// How the computer reaches it.
    pub(super) link: &'static str,
}
