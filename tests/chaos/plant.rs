//! Faults in the world itself: each must break the invariant that it is planted for.

/// A fault planted in the world, to see the invariant that it breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plant {
    /// The server renews by itself what its host has renewed, for a second.
    ServerThatRenews,
    /// Each motion reaches the robot as one that is three times as long.
    DriveObeyedThrice,
    /// No emergency stop reaches the robot, and it answers as if one had.
    StopThatIsLost,
    /// After a session the flash holds what it held before, and the judge believes in what a robot said it saved.
    ConfigThatIsForgotten,
    /// The same of a key.
    KeyThatIsForgotten,
    /// The same in the middle of a session, with a key.
    CountThatIsForgotten,
    /// What a client does not read is kept for it without end.
    ServerThatHoards,
    /// A file of the campaign is cut short.
    FileThatIsCutShort,
    /// The line stays cut after the storm.
    LineThatStaysCut,
}
