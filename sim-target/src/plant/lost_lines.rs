//! Lines of a disc that are too thin for the counter's input filter.

/// The largest share of its width that a thin line may lack.
const THINNEST: f64 = 0.8;

/// Each line j has a width w_j as a share of the pitch's: 1 for a good line, and 1 - 0.8 u for a thin one,
/// u between 0 and 1, by the line's own number. At p counts a second its level lasts w_j / p, and
///
/// ```text
/// w_j / p < T_filter                              (1)
/// ```
///
/// is lost. So nothing is lost below p = 0.2 / T_filter, and from there on a share that grows in
/// proportion to the excess: share of thin lines x (p T_filter - 0.2) / 0.8.
#[derive(Clone, Copy, Debug)]
pub(super) struct LostLines {
    filter_s: f64,
    thin_share: f64,
    lines: i64,
}

impl LostLines {
    /// None if every line is counted.
    pub fn new(filter_s: f64, thin_share: f64, counts_per_rev: f64) -> Option<Self> {
        (filter_s > 0.0 && thin_share > 0.0).then_some(Self {
            filter_s,
            thin_share,
            lines: counts_per_rev.round().max(1.0) as i64,
        })
    }

    /// How many counts between two positions are lost, with the sign of the motion.
    #[inline]
    pub fn between(&self, from: f64, to: f64, span_s: f64) -> i64 {
        let filtered_width = self.filter_s * (to - from).abs() / span_s;
        if filtered_width <= 1.0 - THINNEST {
            return 0;
        }
        let (first, last) = (from.floor() as i64, to.floor() as i64);
        let (low, high) = (first.min(last), first.max(last));
        let lost = (low + 1..=high).filter(|&edge| self.width(edge) < filtered_width).count();
        (last - first).signum() * lost as i64
    }

    /// Width of a line as a share of the pitch's.
    fn width(&self, edge: i64) -> f64 {
        let luck = scattered(edge.rem_euclid(self.lines) as u64);
        if luck < self.thin_share { 1.0 - THINNEST * luck / self.thin_share } else { 1.0 }
    }
}

/// A pseudo-random number from 0 to 1 for each line (splitmix64, Steele et al. 2014).
fn scattered(line: u64) -> f64 {
    let mut z = line.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
