//! Plays side by side, several columns of their sums abreast.

use hysteron_numeric::{InstructionSet, Pass, run_pass};

/// Columns abreast.
const ABREAST: usize = 8;
type Abreast = [f64; ABREAST];
/// Samples whose sums stay in the first-level cache before they are written column by column.
pub(in crate::hysteresis) const STRETCH: usize = 64;

/// The plays, in groups of [`ABREAST`] intervals between knots; within a group the first play of every
/// interval, then the second, and so on. Places beyond the last interval have no share in any column.
#[derive(Clone, Debug)]
pub(super) struct PlaysAbreast {
    /// Plays in an interval between knots.
    parts: usize,
    columns: usize,
    thresholds: Vec<Abreast>,
    /// Shares in the columns of the knots below and above.
    shares: [Vec<Abreast>; 2],
    states: Vec<Abreast>,
    /// 1 for plays that the drive has not yet moved away from the memory, 0 for the others.
    still: Vec<Abreast>,
    are_some_still: bool,
    /// Sums over the last stretch: of the plays, and of those still at the memory.
    sums: [Sums; 2],
    set: InstructionSet,
}

/// Sums over a stretch: one row a sample, its groups one after the other.
#[derive(Clone, Debug, Default)]
struct Sums {
    below: Vec<Abreast>,
    above: Vec<Abreast>,
}

impl Sums {
    /// Sums of one group.
    #[inline(always)]
    fn push(&mut self, values: &[Abreast], (below, above): (&[Abreast], &[Abreast])) {
        let [mut of_below, mut of_above] = [[0.0; ABREAST]; 2];
        for (values, (below, above)) in values.iter().zip(below.iter().zip(above)) {
            for lane in 0..ABREAST {
                of_below[lane] += below[lane] * values[lane];
                of_above[lane] += above[lane] * values[lane];
            }
        }
        self.below.push(of_below);
        self.above.push(of_above);
    }

    fn clear(&mut self) {
        self.below.clear();
        self.above.clear();
    }

    /// Value of a column of several in every row.
    fn of_column(&self, column: usize, columns: usize) -> impl Iterator<Item = f64> {
        let groups = columns.div_ceil(ABREAST);
        let place = |column: usize| (column / ABREAST, column % ABREAST);
        let ((group, lane), (next_group, next_lane)) = (place(column), place(column + 1));
        let rows = self.above.chunks_exact(groups).zip(self.below.chunks_exact(groups));
        // The interval above the last knot is empty.
        rows.map(move |(above, below)| {
            above[group][lane] + below.get(next_group).map_or(0.0, |below| below[next_lane])
        })
    }
}

impl PlaysAbreast {
    /// Plays of `parts` to an interval, in ascending order, all at `voltage`: at a memory or virgin.
    pub(super) fn new(
        parts: usize,
        (thresholds, shares): (&[f64], &[[f64; 2]]),
        (voltage, is_memory): (f64, bool),
    ) -> Self {
        let columns = thresholds.len() / parts.max(1);
        let arranged = |of: &dyn Fn(usize) -> f64| -> Vec<Abreast> {
            let group = |group: usize| {
                let lane = move |part: usize, lane: usize| {
                    let interval = group * ABREAST + lane;
                    if interval < columns { of(interval * parts + part) } else { 0.0 }
                };
                (0..parts).map(move |part| std::array::from_fn(|at| lane(part, at)))
            };
            (0..columns.div_ceil(ABREAST)).flat_map(group).collect()
        };
        let thresholds = arranged(&|play| thresholds[play]);
        let shares = [0, 1].map(|side| arranged(&|play| shares[play][side]));
        let states = vec![[voltage; ABREAST]; thresholds.len()];
        let still = if is_memory { arranged(&|_| 1.0) } else { Vec::new() };
        let set = InstructionSet::detected();
        let sums = [Sums::default(), Sums::default()];
        Self { parts, columns, thresholds, shares, states, still, are_some_still: is_memory, sums, set }
    }

    /// True if all states are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.states.as_flattened().iter().all(|state| state.is_finite())
    }

    /// Takes the plays at a memory that no drive between `low` and `high` moves out of the sums; which these
    /// are, in the order of the plays, and their sums in every column with the derivatives with respect to
    /// the memory.
    pub(super) fn without_standing(&mut self, (low, high): (f64, f64)) -> (Vec<bool>, [Vec<f64>; 2]) {
        let stands = |threshold: f64, state: f64| state + threshold >= high && state - threshold <= low;
        let (mut standing, mut sums) = (Vec::new(), [0, 1].map(|_| vec![0.0; self.columns]));
        for interval in 0..if self.still.is_empty() { 0 } else { self.columns } {
            let (group, lane) = (interval / ABREAST, interval % ABREAST);
            for place in group * self.parts..(group + 1) * self.parts {
                let state = self.states[place][lane];
                standing.push(stands(self.thresholds[place][lane], state));
                if !standing.last().is_some_and(|stands| *stands) {
                    continue;
                }
                // Without a share in any column; wherever it goes, it is the same for every memory.
                self.states[place][lane] = low;
                let still = std::mem::take(&mut self.still[place][lane]);
                let shares = self.shares.each_mut().map(|shares| std::mem::take(&mut shares[place][lane]));
                for (column, share) in [interval.checked_sub(1), Some(interval)].into_iter().zip(shares) {
                    if let Some(column) = column {
                        sums[0][column] += share * state;
                        sums[1][column] += share * still;
                    }
                }
            }
        }
        (standing, sums)
    }

    /// States of the plays.
    pub(super) fn states(&self) -> &[f64] {
        self.states.as_flattened()
    }

    /// True if the drive has not yet moved some of the plays away from the memory.
    pub(super) fn are_some_still(&self) -> bool {
        self.are_some_still
    }

    /// Moves the plays through `u`, with sums over at most [`STRETCH`] samples: every `factor`-th, the first
    /// one first.
    pub(super) fn advance(&mut self, u: &[f64], factor: usize) {
        self.sums.iter_mut().for_each(Sums::clear);
        run_pass(self.set, Moves { bank: self, u, factor });
        self.are_some_still &= self.still.as_flattened().contains(&1.0);
    }

    /// Values of a column over the last stretch.
    pub(super) fn values(&self, column: usize) -> impl Iterator<Item = f64> {
        self.sums[0].of_column(column, self.columns)
    }

    /// Derivatives of a column with respect to the memory over the last stretch; none where no play was still
    /// there.
    pub(super) fn by_memory(&self, column: usize) -> impl Iterator<Item = f64> {
        self.sums[1].of_column(column, self.columns)
    }
}

/// State of a play after a move to `u`: max(u − r, min(u + r, F)), by comparisons: the largest of two numbers is
/// more than one instruction.
#[inline(always)]
fn moved(threshold: f64, state: f64, u: f64) -> f64 {
    let [low, high] = [u - threshold, u + threshold];
    let below = if state > high { high } else { state };
    if below < low { low } else { below }
}

/// Moves through `u`, with sums at every `factor`-th sample, the first one first.
struct Moves<'a> {
    bank: &'a mut PlaysAbreast,
    u: &'a [f64],
    factor: usize,
}

impl Pass for Moves<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { bank, u, factor } = self;
        let PlaysAbreast { parts, thresholds, shares: [below, above], states, still, sums, .. } = bank;
        let [sums, sums_of_still] = sums;
        for (index, &u) in u.iter().enumerate() {
            let is_kept = index.is_multiple_of(factor);
            let groups = states.chunks_exact_mut(*parts).zip(thresholds.chunks_exact(*parts));
            for (group, (states, thresholds)) in groups.enumerate() {
                let of_group = group * *parts..(group + 1) * *parts;
                let (below, above) = (&below[of_group.clone()], &above[of_group.clone()]);
                if bank.are_some_still {
                    let still = &mut still[of_group];
                    let plays = states.as_flattened().iter().zip(thresholds.as_flattened());
                    for (still, (&state, &threshold)) in still.as_flattened_mut().iter_mut().zip(plays) {
                        *still = if moved(threshold, state, u) == state { *still } else { 0.0 };
                    }
                    if is_kept {
                        sums_of_still.push(still, (below, above));
                    }
                }
                let plays = states.as_flattened_mut().iter_mut().zip(thresholds.as_flattened());
                for (state, &threshold) in plays {
                    *state = moved(threshold, *state, u);
                }
                if is_kept {
                    sums.push(states, (below, above));
                }
            }
        }
    }
}
