//! Is a root mean square more than noise alone gives?

/// A root mean square, beside what noise alone gives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rms {
    /// The measured one.
    pub rms: f64,
    /// What noise alone gives.
    pub noise: f64,
    /// What noise alone stays below in 99 % of such campaigns.
    pub noise_high: f64,
}

impl Rms {
    /// More than noise explains.
    pub fn beyond_noise(&self) -> bool {
        self.rms > self.noise_high
    }
}
