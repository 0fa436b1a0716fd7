//! LU factorization of a matrix of blocks, of which only those are stored that are not zero.

use fearless_simd::{Simd, SimdBase, SimdFrom, dispatch, f64x4};
use underbrush_recording::vector::level;

/// Entries of a block that are computed side by side.
pub const LANES: usize = 4;

/// Neighbouring entries.
pub type Lanes = [f64; LANES];

/// The rows and columns of one block on the diagonal.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// Its first row and column.
    start: usize,
    size: usize,
    /// The lanes of a row: its size, rounded up.
    width: usize,
    /// Where the values of its rows begin.
    base: usize,
}

/// A square matrix with a symmetric pattern of blocks. The factorization does not pivot.
#[derive(Clone, Debug, Default)]
pub struct BlockMatrix {
    blocks: Vec<Block>,
    /// Row by row, where the values of each block begin; `None` where all are zero, also in the factors.
    places: Vec<Option<usize>>,
    /// The rows of each block, column by column. The diagonal is here.
    lower: Vec<Lanes>,
    /// The columns of each block, row by row. Within a block on the diagonal, an entry counts only above the diagonal here,
    /// and only below it in `lower`.
    upper: Vec<Lanes>,
    /// What a block of the factorization is computed from: where the values of its own row are, those of the other row, and
    /// their number.
    terms: Vec<(usize, usize, usize)>,
}

impl BlockMatrix {
    /// Sets the sizes of the blocks and the pairs that are not zero beside the diagonal. All values must then be cleared.
    pub fn reset(&mut self, sizes: impl IntoIterator<Item = usize>, pairs: impl IntoIterator<Item = [usize; 2]>) {
        self.blocks.clear();
        let mut start = 0;
        for size in sizes {
            self.blocks.push(Block { start, size, width: size.div_ceil(LANES), base: 0 });
            start += size;
        }
        let count = self.blocks.len();
        self.places.clear();
        self.places.resize(count * count, None);
        for [a, b] in pairs {
            self.places[a.max(b) * count + a.min(b)] = Some(0);
        }
        let mut end = 0;
        for own in 0..count {
            self.blocks[own].base = end;
            for other in 0..=own {
                let has = |row: usize, column: usize| self.places[row * count + column].is_some();
                if own == other || has(own, other) || (0..other).any(|before| has(own, before) && has(other, before)) {
                    self.places[own * count + other] = Some(end);
                    end += self.blocks[other].size * self.blocks[own].width;
                }
            }
        }
        self.lower.resize(end, [0.0; LANES]);
        self.upper.resize(end, [0.0; LANES]);
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.lower.fill([0.0; LANES]);
        self.upper.fill([0.0; LANES]);
    }

    /// The lanes of a block's rows.
    pub fn width(&self, block: usize) -> usize {
        self.blocks[block].width
    }

    #[inline(always)]
    fn place(&self, own: usize, other: usize) -> Option<usize> {
        self.places[own * self.blocks.len() + other]
    }

    /// For each index of the block `other`: the entries of this column in the rows of the block `own`, and the entries of this row in
    /// the columns of `own`. Zeros fill the last lanes. `other` is the same block or an earlier one. If all entries are zero, there
    /// are no items.
    #[inline(always)]
    pub fn rows_mut(&mut self, own: usize, other: usize) -> impl Iterator<Item = [&mut [Lanes]; 2]> {
        let width = self.width(own);
        let range = self.place(own, other).map_or(0..0, |from| from..from + self.blocks[other].size * width);
        let lower = self.lower[range.clone()].chunks_exact_mut(width.max(1));
        lower.zip(self.upper[range].chunks_exact_mut(width.max(1))).map(|(lower, upper)| [lower, upper])
    }

    /// An entry of the diagonal.
    pub fn diagonal_mut(&mut self, index: usize) -> Option<&mut f64> {
        let own = self.blocks.partition_point(|block| block.start <= index) - 1;
        let at = index - self.blocks[own].start;
        let from = self.place(own, own)? + at * self.width(own);
        self.lower[from..].as_flattened_mut().get_mut(at)
    }

    /// Replaces the matrix by its factors: L with ones on its diagonal below, U above, and the reciprocals of U's
    /// diagonal on the diagonal. Returns whether all of U's diagonal is positive, as it is for a positive definite
    /// matrix.
    pub fn factorize(&mut self) -> bool {
        let mut terms = std::mem::take(&mut self.terms);
        let is_positive = dispatch!(level(), simd => self.factorize_with(simd, &mut terms));
        self.terms = terms;
        is_positive
    }

    #[inline(always)]
    fn factorize_with<S: Simd>(&mut self, simd: S, terms: &mut Vec<(usize, usize, usize)>) -> bool {
        for own in 0..self.blocks.len() {
            for other in 0..own {
                if let Some(place) = self.place(own, other) {
                    self.find_terms(own, other, terms);
                    self.eliminate(simd, own, other, place, terms);
                }
            }
            self.find_terms(own, own, terms);
            if !self.factorize_diagonal(simd, own, terms) {
                return false;
            }
        }
        true
    }

    /// Both rows have values in these blocks before `other`.
    fn find_terms(&self, own: usize, other: usize, terms: &mut Vec<(usize, usize, usize)>) {
        terms.clear();
        let places = |before| self.place(own, before).zip(self.place(other, before));
        let common = (0..other).filter_map(|before| places(before).map(|(mine, theirs)| (mine, theirs, before)));
        terms.extend(common.map(|(mine, theirs, before)| (mine, theirs, self.blocks[before].size)));
    }

    /// Computes the factors in a block beside the diagonal.
    #[inline(always)]
    fn eliminate<S: Simd>(&mut self, simd: S, own: usize, other: usize, place: usize, terms: &[(usize, usize, usize)]) {
        let (width, base) = (self.blocks[own].width, self.blocks[own].base);
        let Block { size, width: stride, .. } = self.blocks[other];
        let Some(diagonal) = self.place(other, other) else { return };
        let (lower_above, lower) = self.lower.split_at_mut(base);
        let (upper_above, upper) = self.upper.split_at_mut(base);
        for column in 0..size {
            let inverse = lower_above[diagonal + column * stride + column / LANES][column % LANES];
            for at in 0..width {
                let mut sums = [f64x4::splat(simd, 0.0); 2];
                for (mine, theirs, count) in terms.iter().copied().chain([(place, diagonal, column)]) {
                    let (mine, theirs) = (mine - base..mine - base + count * width, theirs..theirs + count * stride);
                    let factors = [&upper_above[theirs.clone()], &lower_above[theirs]];
                    let entries = [&lower[mine.clone()], &upper[mine]];
                    add_rows(simd, &mut sums, factors, (stride, column), entries, (width, at));
                }
                let here = place - base + column * width + at;
                lower[here] = ((f64x4::simd_from(simd, lower[here]) - sums[0]) * inverse).into();
                upper[here] = (f64x4::simd_from(simd, upper[here]) - sums[1]).into();
            }
        }
    }

    /// Computes the factors in a block on the diagonal.
    #[inline(always)]
    fn factorize_diagonal<S: Simd>(&mut self, simd: S, own: usize, terms: &[(usize, usize, usize)]) -> bool {
        let Block { size, width, .. } = self.blocks[own];
        let Some(place) = self.place(own, own) else { return false };
        let (lower, upper) = (&mut self.lower, &mut self.upper);
        for row in 0..size {
            let here = place + row * width;
            // Entries of earlier rows and columns are not needed.
            for at in row / LANES..width {
                let mut sums = [f64x4::splat(simd, 0.0); 2];
                for (mine, _, count) in terms.iter().copied().chain([(place, place, row)]) {
                    let [lower, upper] = [&*lower, &*upper].map(|values| &values[mine..mine + count * width]);
                    add_rows(simd, &mut sums, [upper, lower], (width, row), [lower, upper], (width, at));
                }
                for (values, sum) in [&mut *lower, &mut *upper].into_iter().zip(sums) {
                    values[here + at] = (f64x4::simd_from(simd, values[here + at]) - sum).into();
                }
            }
            let entries = lower[here..here + width].as_flattened_mut();
            let pivot = entries[row];
            if pivot <= 0.0 {
                return false;
            }
            let inverse = 1.0 / pivot;
            entries[row + 1..size].iter_mut().for_each(|entry| *entry *= inverse);
            entries[row] = inverse;
        }
        true
    }

    /// Solves for the right-hand side `x` in place. The matrix must have been factorized.
    pub fn solve(&self, x: &mut [f64]) {
        for (own, block) in self.blocks.iter().enumerate() {
            let (before, right) = x.split_at_mut(block.start);
            for (entries, at) in self.row(own) {
                subtract(right, before[at], block.entries(&self.lower, entries));
            }
            for (row, entries) in self.on_diagonal(own) {
                let (above, below) = right.split_at_mut(row + 1);
                subtract(below, above[row], &block.entries(&self.lower, entries)[row + 1..]);
            }
        }
        for (own, block) in self.blocks.iter().enumerate().rev() {
            let (before, right) = x.split_at_mut(block.start);
            for (row, entries) in self.on_diagonal(own).rev() {
                let known = dot(&block.entries(&self.upper, entries)[row + 1..], &right[row + 1..]);
                right[row] = (right[row] - known) * block.entries(&self.lower, entries)[row];
            }
            for (entries, at) in self.row(own) {
                before[at] -= dot(block.entries(&self.upper, entries), right);
            }
        }
    }

    /// Where the entries of a block's rows before the diagonal are, and their columns.
    fn row(&self, own: usize) -> impl Iterator<Item = (usize, usize)> {
        let width = self.blocks[own].width;
        let stored = (0..own).filter_map(move |other| Some((self.place(own, other)?, self.blocks[other])));
        stored.flat_map(move |(place, other)| (0..other.size).map(move |at| (place + at * width, other.start + at)))
    }

    /// The rows of a block on the diagonal, and where their entries are.
    fn on_diagonal(&self, own: usize) -> impl DoubleEndedIterator<Item = (usize, usize)> {
        let Block { size, width, .. } = self.blocks[own];
        let place = self.place(own, own).unwrap_or_default();
        (0..size).map(move |row| (row, place + row * width))
    }
}

impl Block {
    /// The entries that begin at a place.
    fn entries<'a>(&self, values: &'a [Lanes], from: usize) -> &'a [f64] {
        &values[from..from + self.width].as_flattened()[..self.size]
    }
}

/// Adds to each of two sums the products of the factors in one column and the entries in some lanes, row by row. The rows of both have
/// the widths given.
#[inline(always)]
fn add_rows<S: Simd>(
    simd: S,
    sums: &mut [f64x4<S>; 2],
    factors: [&[Lanes]; 2],
    (stride, column): (usize, usize),
    entries: [&[Lanes]; 2],
    (width, at): (usize, usize),
) {
    let rows = |side: usize| factors[side].chunks_exact(stride).zip(entries[side].chunks_exact(width));
    for (first, second) in rows(0).zip(rows(1)) {
        for (sum, (factors, entries)) in sums.iter_mut().zip([first, second]) {
            *sum += f64x4::simd_from(simd, entries[at]) * factors[column / LANES][column % LANES];
        }
    }
}

/// Subtracts the multiple of some entries.
fn subtract(from: &mut [f64], factor: f64, entries: &[f64]) {
    for (value, entry) in from.iter_mut().zip(entries) {
        *value -= factor * entry;
    }
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;
    use underbrush_recording::vector::with_baseline;

    proptest! {
        /// Tests solutions against nalgebra's dense LU, for random block matrices with random sizes and patterns, and that the
        /// factors are the same with the vector instructions of every processor.
        #[test]
        fn solutions_are_those_of_the_dense_matrix(
            sizes in prop::collection::vec(1..8usize, 1..6),
            are_pairs in prop::collection::vec(prop::bool::ANY, 36),
            values in prop::collection::vec(-1.0..1.0f64, 40 * 40),
            right in prop::collection::vec(-1.0..1.0f64, 40),
        ) {
            let starts: Vec<usize> = (0..=sizes.len()).map(|end| sizes[..end].iter().sum()).collect();
            let pairs: Vec<[usize; 2]> = (0..sizes.len())
                .flat_map(|own| (0..own).map(move |other| [own, other]))
                .filter(|[own, other]| are_pairs[6 * own + other])
                .collect();
            let size = starts[sizes.len()];
            let mut dense = DMatrix::<f64>::identity(size, size) * 200.0;
            let mut matrix = BlockMatrix::default();
            matrix.reset(sizes.iter().copied(), pairs.iter().copied());
            matrix.clear();
            for [own, other] in (0..sizes.len()).map(|own| [own, own]).chain(pairs) {
                let mut rows = 0;
                for (at, [lower, upper]) in matrix.rows_mut(own, other).enumerate() {
                    rows += 1;
                    let [lower, upper] = [lower, upper].map(|lanes| lanes.as_flattened_mut());
                    for place in 0..sizes[own] {
                        let (row, column) = (starts[own] + place, starts[other] + at);
                        if row != column {
                            dense[(row, column)] = values[row * size + column];
                            dense[(column, row)] = values[column * size + row];
                        }
                        (lower[place], upper[place]) = (dense[(row, column)], dense[(column, row)]);
                    }
                }
                prop_assert_eq!(rows, sizes[other]);
            }
            for index in 0..size {
                *matrix.diagonal_mut(index).unwrap() += 1.0;
                dense[(index, index)] += 1.0;
            }
            let mut found = right[..size].to_vec();
            let mut anywhere = matrix.clone();
            prop_assert!(matrix.factorize() && with_baseline(|| anywhere.factorize()));
            prop_assert_eq!((&matrix.lower, &matrix.upper), (&anywhere.lower, &anywhere.upper));
            matrix.solve(&mut found);
            let expected = dense.lu().solve(&DVector::from_row_slice(&right[..size])).unwrap();
            for (found, expected) in found.iter().zip(expected.iter()) {
                prop_assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
}
