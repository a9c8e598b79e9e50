//! What a camera delivers.

/// A measured pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSample {
    /// The camera's stamp \[s\].
    pub t_s: f64,
    /// Along the floor's x axis \[m\].
    pub x_m: f64,
    /// Along its y axis \[m\].
    pub y_m: f64,
    /// Counter-clockwise from the x axis, not wrapped \[rad\].
    pub heading_rad: f64,
}

impl CameraSample {
    /// The stamp as time since `origin_us` \[s\], to the microsecond.
    ///
    /// Subtracted in whole microseconds: the same instants of two recordings have the same bits,
    /// however long the robot had been on.
    pub fn s_since(&self, origin_us: u64) -> f64 {
        ((self.t_s * 1e6).round() - origin_us as f64) * 1e-6
    }
}
