//! Adds the rows of the filter up to normal equations.

use std::sync::Arc;

use crate::estimation::blocks::block_of;
use crate::estimation::ekf::{FilterObserver, Innovation};
use crate::estimation::normal_equations::NormalEquations;

/// So many rows are added to the matrix at once: it is read and written once for all of them, which takes longer than
/// the arithmetic.
const AT_ONCE: usize = 4;

/// Adds rows up, in the block that their step belongs to.
pub(crate) struct RowAdder {
    columns: usize,
    steps: usize,
    blocks: Vec<Block>,
}

/// The sums of one block. Of J'J, the lower triangle alone, column by column.
#[derive(Clone)]
struct Block {
    sums: NormalEquations,
    /// Rows that are not in J'J yet.
    waiting: [Vec<f64>; AT_ONCE],
    waits: usize,
}

impl RowAdder {
    /// For rows of so many columns, of a run of so many steps that is cut into blocks.
    pub fn new(columns: usize, steps: usize, blocks: usize) -> Self {
        let block = Block {
            sums: NormalEquations::zeros(columns),
            waiting: core::array::from_fn(|_| vec![0.0; columns]),
            waits: 0,
        };
        Self { columns, steps, blocks: vec![block; blocks] }
    }

    /// The sums of each block.
    pub fn sums(self) -> Vec<NormalEquations> {
        let finished = self.blocks.into_iter().map(|mut block| {
            block.add_waiting();
            Arc::make_mut(&mut block.sums.gram).fill_upper_triangle_with_lower_triangle();
            block.sums
        });
        finished.collect()
    }
}

impl FilterObserver for RowAdder {
    fn row(&mut self, innovation: Innovation, row: &[f64]) {
        debug_assert_eq!(row.len(), self.columns);
        let index = block_of(innovation.step, self.steps, self.blocks.len());
        let block = &mut self.blocks[index];
        let residual = innovation.value / innovation.variance.sqrt();
        for (right, a) in block.sums.right.iter_mut().zip(row) {
            *right += a * residual;
        }
        block.sums.squares += residual * residual;
        block.sums.rows += 1.0;
        block.waiting[block.waits].copy_from_slice(row);
        block.waits += 1;
        if block.waits == AT_ONCE {
            block.add_waiting();
        }
    }
}

impl Block {
    /// Adds the waiting rows to J'J.
    fn add_waiting(&mut self) {
        for row in &mut self.waiting[self.waits..] {
            row.fill(0.0);
        }
        self.waits = 0;
        let [a, b, c, d] = &self.waiting;
        let columns = a.len().max(1);
        let gram = Arc::make_mut(&mut self.sums.gram).as_mut_slice();
        for (j, below) in gram.chunks_exact_mut(columns).enumerate() {
            let by = [a[j], b[j], c[j], d[j]];
            if by == [0.0; AT_ONCE] {
                continue;
            }
            let rows = a[j..].iter().zip(&b[j..]).zip(&c[j..]).zip(&d[j..]);
            for (slot, (((a, b), c), d)) in below[j..].iter_mut().zip(rows) {
                *slot += (a * by[0] + b * by[1]) + (c * by[2] + d * by[3]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    #[test]
    fn rows_of_any_number_give_the_sums_of_their_products() {
        for count in 0..11_usize {
            let mut adder = RowAdder::new(3, 10, 2);
            let rows: Vec<[f64; 3]> =
                (0..count).map(|k| [k as f64, 1.0, if k % 3 == 0 { 0.0 } else { -2.0 }]).collect();
            for (step, row) in rows.iter().enumerate() {
                adder.row(Innovation { step, value: 2.0, variance: 4.0 }, row);
            }
            let blocks = adder.sums();
            for (index, block) in blocks.iter().enumerate() {
                let own = &rows[count.min(5 * index)..count.min(if index == 0 { 5 } else { 11 })];
                let product = |i: usize, j: usize| own.iter().map(|row| row[i] * row[j]).sum();
                assert_eq!(*block.gram, DMatrix::from_fn(3, 3, product), "{count} rows");
                let right = DVector::from_fn(3, |i, _| own.iter().map(|row| row[i]).sum());
                assert_eq!(block.right, right);
                assert_eq!((block.squares, block.rows), (own.len() as f64, own.len() as f64));
            }
        }
    }
}
