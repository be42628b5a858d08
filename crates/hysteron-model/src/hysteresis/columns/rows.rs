//! Rows of columns, gathered before they are put into the columns.

/// Rows at a time.
const ROWS: usize = 16;

/// The columns at a few samples, one row after the other: writing each row directly would touch as many
/// memory locations as there are columns, at every sample.
pub(in crate::hysteresis) struct Rows<S> {
    columns: usize,
    rows: Vec<S>,
    /// Sample of the first row, and number of rows.
    first: usize,
    count: usize,
}

impl<S: Copy> Rows<S> {
    pub(super) fn new(columns: usize, zero: S) -> Self {
        Self::starting_at(0, columns, zero)
    }

    /// No rows yet; the next is of sample `first`.
    pub(super) fn starting_at(first: usize, columns: usize, zero: S) -> Self {
        Self { columns, rows: vec![zero; ROWS * columns], first, count: 0 }
    }

    /// The next row, to be read into.
    pub(super) fn next(&mut self) -> &mut [S] {
        let begin = self.count * self.columns;
        self.count += 1;
        &mut self.rows[begin..begin + self.columns]
    }

    pub(super) fn is_full(&self) -> bool {
        self.count == ROWS
    }

    /// Continues after these rows.
    pub(super) fn clear(&mut self) {
        self.first = self.end();
        self.count = 0;
    }

    /// Sample of the row after the last.
    pub(super) fn end(&self) -> usize {
        self.first + self.count
    }

    /// Sample of the first row.
    pub(super) fn first(&self) -> usize {
        self.first
    }

    /// Values of a column.
    pub(in crate::hysteresis) fn column(&self, index: usize) -> impl Iterator<Item = S> {
        self.rows.iter().skip(index).step_by(self.columns).take(self.count).copied()
    }

    /// Adds Σⱼ `weights`\[j\] Hⱼ at these samples.
    pub(in crate::hysteresis) fn add_weighted(&self, weights: &[f64], out: &mut [f64])
    where
        S: Into<f64>,
    {
        let rows = self.rows.chunks_exact(self.columns.max(1)).take(self.count);
        for (slot, row) in out.iter_mut().skip(self.first).zip(rows) {
            *slot = row.iter().zip(weights).fold(*slot, |sum, (&value, weight)| sum + weight * value.into());
        }
    }

    /// Writes `of(value)` for each value of a column into `column`.
    #[inline]
    pub(in crate::hysteresis) fn put(&self, index: usize, column: &mut [f64], of: impl Fn(S) -> f64) {
        let places = column.iter_mut().skip(self.first);
        places.zip(self.column(index)).for_each(|(place, value)| *place = of(value));
    }
}
