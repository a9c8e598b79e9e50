//! One small routine that compares floating-point numbers.

/// a > b in the order of IEEE 754's totalOrder: of the two zeros the positive one is the larger, and a
/// positive NaN is above infinity, a negative one below minus infinity.
///
/// A core without double precision calls this one routine. The compiler would bring one of a hundred
/// bytes for each of `<`, `<=`, `>` and `>=`.
#[inline(never)]
pub fn is_above(a: f64, b: f64) -> bool {
    a.total_cmp(&b).is_gt()
}
