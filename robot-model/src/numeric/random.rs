//! Random numbers that are the same on every machine.

/// A small generator (splitmix64): one seed, one sequence, on every machine.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform in (0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 + 1e-17
    }

    /// Normal with mean 0 and sigma 1 (Box-Muller), for tests.
    #[cfg(test)]
    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (core::f64::consts::TAU * self.uniform()).cos()
    }

    /// Two independent numbers, normal with mean 0 and sigma 1 (the polar method of Marsaglia).
    pub(crate) fn two_normals(&mut self) -> [f64; 2] {
        loop {
            let [x, y] = [(); 2].map(|()| 2.0 * self.uniform() - 1.0);
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                let factor = (-2.0 * square.ln() / square).sqrt();
                return [x * factor, y * factor];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_normals_have_mean_0_variance_1_kurtosis_3_and_no_correlation() {
        let mut random = Random::new(7);
        const COUNT: usize = 200_000;
        let drawn: Vec<[f64; 2]> = (0..COUNT).map(|_| random.two_normals()).collect();
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| drawn.iter().map(of).sum::<f64>() / COUNT as f64;
        // Five standard errors of each.
        let within = |value: f64, expected: f64, sigma: f64| {
            let limit = 5.0 * sigma / (COUNT as f64).sqrt();
            assert!((value - expected).abs() < limit, "{value} instead of {expected}");
        };
        for i in 0..2 {
            within(mean(&|pair| pair[i]), 0.0, 1.0);
            within(mean(&|pair| pair[i].powi(2)), 1.0, 2.0_f64.sqrt());
            within(mean(&|pair| pair[i].powi(4)), 3.0, 96.0_f64.sqrt());
        }
        within(mean(&|[x, y]| x * y), 0.0, 1.0);
    }
}
