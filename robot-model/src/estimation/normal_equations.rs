//! Normal equations: sums of whitened rows (r, J) about one point of all parameters.
//!
//! ```text
//! A = J'J,  b = J'r,  c = r'r;      chi^2(d) = c - 2 b'd + d'A d                     (1)
//! ```

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

/// Equation (1) of some rows.
#[derive(Clone, Debug)]
pub(crate) struct NormalEquations {
    /// A. Shared: a copy about another point has the same.
    pub gram: Arc<DMatrix<f64>>,
    pub right: DVector<f64>,
    pub squares: f64,
    pub rows: f64,
}

impl NormalEquations {
    pub fn zeros(columns: usize) -> Self {
        Self {
            gram: Arc::new(DMatrix::zeros(columns, columns)),
            right: DVector::zeros(columns),
            squares: 0.0,
            rows: 0.0,
        }
    }

    pub fn add(&mut self, other: &Self) {
        *Arc::make_mut(&mut self.gram) += &*other.gram;
        self.right += &other.right;
        self.squares += other.squares;
        self.rows += other.rows;
    }

    /// The same sums about a point that differs in one column by `delta`.
    pub fn shift(&mut self, column: usize, delta: f64) {
        self.squares += delta * (delta * self.gram[(column, column)] - 2.0 * self.right[column]);
        self.right -= self.gram.column(column) * delta;
    }
}

/// Sums as in (1), of which a fit asks the columns that it needs.
pub(crate) trait Sums {
    fn gram(&self, row: usize, column: usize) -> f64;
    fn right(&self, row: usize) -> f64;
    fn squares(&self) -> f64;

    /// chi^2 of (1) after moving these columns by `delta`.
    fn chi_squared(&self, columns: &[usize], delta: &DVector<f64>) -> f64 {
        let linear: f64 = columns.iter().zip(delta).map(|(i, d)| self.right(*i) * d).sum();
        self.squares() - 2.0 * linear + self.quadratic(columns, delta)
    }

    /// d'A d of (1): how far apart predictions are that differ by `delta`, in sigmas squared.
    fn quadratic(&self, columns: &[usize], delta: &DVector<f64>) -> f64 {
        let mut sum = 0.0;
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                sum += delta[i] * self.gram(*a, *b) * delta[j];
            }
        }
        sum
    }
}

impl Sums for NormalEquations {
    fn gram(&self, row: usize, column: usize) -> f64 {
        self.gram[(row, column)]
    }

    fn right(&self, row: usize) -> f64 {
        self.right[row]
    }

    fn squares(&self) -> f64 {
        self.squares
    }
}

/// Some sums less a few others. Taken column by column when asked for: a copy of all columns for each run that is left
/// out takes longer than the fit.
pub(crate) struct EquationsWithout<'a, S> {
    all: &'a NormalEquations,
    less: Vec<&'a S>,
}

impl<'a, S: Sums> EquationsWithout<'a, S> {
    pub fn new(all: &'a NormalEquations, less: Vec<&'a S>) -> Self {
        Self { all, less }
    }
}

impl<S: Sums> Sums for EquationsWithout<'_, S> {
    fn gram(&self, row: usize, column: usize) -> f64 {
        self.less
            .iter()
            .fold(self.all.gram[(row, column)], |sum, less| sum - less.gram(row, column))
    }

    fn right(&self, row: usize) -> f64 {
        self.less.iter().fold(self.all.right[row], |sum, less| sum - less.right(row))
    }

    fn squares(&self) -> f64 {
        self.less.iter().fold(self.all.squares, |sum, less| sum - less.squares())
    }
}

/// Other sums about a point that is moved in some columns.
pub(crate) struct Moved<'a, S> {
    pub sums: &'a S,
    pub columns: &'a [usize],
    pub delta: &'a DVector<f64>,
}

impl<S: Sums> Sums for Moved<'_, S> {
    fn gram(&self, row: usize, column: usize) -> f64 {
        self.sums.gram(row, column)
    }

    fn right(&self, row: usize) -> f64 {
        let moved = self.columns.iter().zip(self.delta);
        self.sums.right(row) - moved.map(|(j, d)| self.sums.gram(row, *j) * d).sum::<f64>()
    }

    fn squares(&self) -> f64 {
        self.sums.chi_squared(self.columns, self.delta)
    }
}

/// Some columns of other sums, added up once: for those of many folds, which are asked often.
pub(crate) struct Columns {
    /// Where each column stands here.
    places: Vec<usize>,
    sums: NormalEquations,
}

impl Columns {
    pub fn of(sums: &impl Sums, columns: &[usize]) -> Self {
        let mut places = vec![usize::MAX; columns.iter().max().map_or(0, |last| last + 1)];
        for (place, column) in columns.iter().enumerate() {
            places[*column] = place;
        }
        let n = columns.len();
        let mut gram =
            DMatrix::from_fn(
                n,
                n,
                |i, j| if i < j { 0.0 } else { sums.gram(columns[i], columns[j]) },
            );
        gram.fill_upper_triangle_with_lower_triangle();
        let right = DVector::from_fn(n, |i, _| sums.right(columns[i]));
        let sums =
            NormalEquations { gram: Arc::new(gram), right, squares: sums.squares(), rows: 0.0 };
        Self { places, sums }
    }
}

impl Sums for Columns {
    fn gram(&self, row: usize, column: usize) -> f64 {
        self.sums.gram[(self.places[row], self.places[column])]
    }

    fn right(&self, row: usize) -> f64 {
        self.sums.right[self.places[row]]
    }

    fn squares(&self) -> f64 {
        self.sums.squares
    }
}
