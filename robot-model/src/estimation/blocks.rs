//! How is a run cut into blocks, where it is cross-validated by itself?

/// The block of a step, in a run that is cut into so many blocks of equal length.
pub(crate) fn block_of(step: usize, steps: usize, blocks: usize) -> usize {
    (step * blocks / steps.max(1)).min(blocks - 1)
}
