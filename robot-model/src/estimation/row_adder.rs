//! Adds the rows of the filter up to normal equations.

use std::sync::Arc;

use multiversion::multiversion;
use nalgebra::DMatrix;

use crate::estimation::blocks::block_of;
use crate::estimation::ekf::{FilterObserver, Innovation};
use crate::estimation::normal_equations::NormalEquations;

/// So many rows are added to the matrix at once: it is read and written once for all of them, which takes longer than
/// the arithmetic.
const AT_ONCE: usize = 8;

/// Adds rows up, in the block that their step belongs to.
pub(crate) struct RowAdder {
    columns: usize,
    steps: usize,
    blocks: Vec<Block>,
}

/// The sums of one block.
struct Block {
    sums: NormalEquations,
    /// Rows that are not in `products` yet.
    waiting: [Vec<f64>; AT_ONCE],
    waits: usize,
    products: Products,
}

/// J'J of those columns that are not zero in all rows: a place on the floor has columns of its own, and a run comes to few.
struct Products {
    /// The columns, in the order in which they came.
    columns: Vec<usize>,
    /// Whether each column is among them.
    is_in: Vec<bool>,
    /// Their products: the lower triangle alone, column by column.
    gram: Vec<f64>,
    /// So many rows and columns fit in.
    side: usize,
    /// The waiting rows, of these columns alone.
    rows: [Vec<f64>; AT_ONCE],
}

impl RowAdder {
    /// For rows of so many columns, of a run of so many steps that is cut into blocks.
    pub fn new(columns: usize, steps: usize, blocks: usize) -> Self {
        let block = || Block {
            sums: NormalEquations::zeros(columns),
            waiting: core::array::from_fn(|_| vec![0.0; columns]),
            waits: 0,
            products: Products::new(columns),
        };
        Self { columns, steps, blocks: (0..blocks).map(|_| block()).collect() }
    }

    /// The sums of each block.
    pub fn sums(self) -> Vec<NormalEquations> {
        let finished = self.blocks.into_iter().map(|mut block| {
            block.add_waiting();
            block.products.write(Arc::make_mut(&mut block.sums.gram));
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

/// Adds rows up, and keeps them as well as long as they are not too many.
pub(crate) struct KeptRows {
    adder: RowAdder,
    innovations: Vec<Innovation>,
    /// One row after the other.
    rows: Vec<f64>,
    /// No row is kept if the rows have more numbers.
    numbers_max: usize,
    too_many: bool,
}

impl KeptRows {
    pub fn new(adder: RowAdder, numbers_max: usize) -> Self {
        Self { adder, innovations: Vec::new(), rows: Vec::new(), numbers_max, too_many: false }
    }

    /// The sums of each block; and the rows, where they are kept.
    pub fn sums(self) -> (Vec<NormalEquations>, Option<RowsOfRun>) {
        let Self { adder, innovations, rows, too_many, .. } = self;
        let kept = RowsOfRun { columns: adder.columns, innovations, rows };
        (adder.sums(), (!too_many).then_some(kept))
    }
}

impl FilterObserver for KeptRows {
    fn row(&mut self, innovation: Innovation, row: &[f64]) {
        self.adder.row(innovation, row);
        self.too_many |= self.rows.len() + row.len() > self.numbers_max;
        if self.too_many {
            (self.innovations, self.rows) = (Vec::new(), Vec::new());
        } else {
            self.innovations.push(innovation);
            self.rows.extend_from_slice(row);
        }
    }
}

/// All rows of a run.
pub(crate) struct RowsOfRun {
    columns: usize,
    innovations: Vec<Innovation>,
    rows: Vec<f64>,
}

impl RowsOfRun {
    /// The sums of each block of this adder, with these rows added.
    pub fn added_to(&self, mut adder: RowAdder) -> Vec<NormalEquations> {
        for (index, innovation) in self.innovations.iter().enumerate() {
            let row = &self.rows[index * self.columns..(index + 1) * self.columns];
            adder.row(*innovation, row);
        }
        adder.sums()
    }
}

impl Block {
    /// Adds the waiting rows to J'J.
    fn add_waiting(&mut self) {
        for row in &mut self.waiting[self.waits..] {
            row.fill(0.0);
        }
        self.waits = 0;
        self.products.add(&self.waiting);
    }
}

impl Products {
    fn new(columns: usize) -> Self {
        Self {
            columns: Vec::with_capacity(columns),
            is_in: vec![false; columns],
            gram: Vec::new(),
            side: 0,
            rows: core::array::from_fn(|_| Vec::with_capacity(columns)),
        }
    }

    fn add(&mut self, waiting: &[Vec<f64>; AT_ONCE]) {
        for (column, is_in) in self.is_in.iter_mut().enumerate() {
            if !*is_in && waiting.iter().any(|row| row[column] != 0.0) {
                *is_in = true;
                self.columns.push(column);
            }
        }
        self.make_room();
        for (row, all) in self.rows.iter_mut().zip(waiting) {
            row.clear();
            row.extend(self.columns.iter().map(|column| all[*column]));
        }
        if self.side > 0 {
            add_products(&mut self.gram, self.side, &self.rows);
        }
    }

    /// Makes the matrix larger if columns have come.
    fn make_room(&mut self) {
        let needed = self.columns.len();
        if needed <= self.side {
            return;
        }
        // Most come with the first rows, the others a few at a time.
        let side = (needed + needed / 8).min(self.is_in.len());
        let mut larger = vec![0.0; side * side];
        if self.side > 0 {
            let columns = self.gram.chunks_exact(self.side).zip(larger.chunks_exact_mut(side));
            for (from, to) in columns {
                to[..self.side].copy_from_slice(from);
            }
        }
        (self.gram, self.side) = (larger, side);
    }

    /// Writes both triangles of J'J.
    fn write(&self, all: &mut DMatrix<f64>) {
        for (j, column) in self.columns.iter().enumerate() {
            for (i, row) in self.columns.iter().enumerate().skip(j) {
                let product = self.gram[j * self.side + i];
                all[(*row, *column)] = product;
                all[(*column, *row)] = product;
            }
        }
    }
}

/// Adds the products of these rows to the lower triangle of a matrix with so long columns.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_products(gram: &mut [f64], side: usize, rows: &[Vec<f64>; AT_ONCE]) {
    let n = rows[0].len();
    let [a, b, c, d, e, f, g, h] = rows;
    for (j, column) in gram.chunks_exact_mut(side).take(n).enumerate() {
        let (a, b, c, d) = (&a[j..n], &b[j..n], &c[j..n], &d[j..n]);
        let (e, f, g, h) = (&e[j..n], &f[j..n], &g[j..n], &h[j..n]);
        let column = &mut column[j..n];
        let by = [a[0], b[0], c[0], d[0], e[0], f[0], g[0], h[0]];
        for i in 0..n - j {
            let first = (a[i] * by[0] + b[i] * by[1]) + (c[i] * by[2] + d[i] * by[3]);
            let second = (e[i] * by[4] + f[i] * by[5]) + (g[i] * by[6] + h[i] * by[7]);
            column[i] = column[i] + first + second;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

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
    #[test]
    fn rows_that_were_kept_give_the_sums_of_rows_that_come_again() {
        let rows: Vec<[f64; 3]> = (0..29).map(|k| [0.1 * k as f64, 1.0, (k % 5) as f64]).collect();
        let feed = |observer: &mut dyn FnMut(Innovation, &[f64])| {
            for (step, row) in rows.iter().enumerate() {
                observer(Innovation { step, value: 0.3, variance: 0.7 }, row);
            }
        };
        let mut again = RowAdder::new(3, 29, 4);
        feed(&mut |innovation, row| again.row(innovation, row));
        let again = again.sums();
        for (numbers_max, is_kept) in [(87, true), (86, false)] {
            let mut kept = KeptRows::new(RowAdder::new(3, 29, 1), numbers_max);
            feed(&mut |innovation, row| kept.row(innovation, row));
            let (whole, kept) = kept.sums();
            assert_eq!((whole.len(), whole[0].rows, kept.is_some()), (1, 29.0, is_kept));
            let Some(kept) = kept else { continue };
            let blocks = kept.added_to(RowAdder::new(3, 29, 4));
            for (one, other) in blocks.iter().zip(&again) {
                assert_eq!((&one.gram, &one.right), (&other.gram, &other.right));
                assert_eq!((one.squares, one.rows), (other.squares, other.rows));
            }
        }
    }
}
