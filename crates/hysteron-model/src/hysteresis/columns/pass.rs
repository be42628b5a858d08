//! Columns over a record: plain, in the steady state, and with derivatives.

use hysteron_numeric::Stop;
use hysteron_rt::{Dual, Scalar};

use super::super::outputs;
use super::super::pass::{Every, at_rest};
use super::super::{DriveGrid, HysteresisError};
use super::ColumnKernel;
use super::rows::Rows;
use crate::record::{Pace, range_of};
use crate::start::Start;

/// K columns and their derivatives at every `factor`-th sample of a drive. The buffers are kept between
/// calls.
#[derive(Clone, Debug, Default)]
pub struct ColumnSensitivities {
    /// The columns.
    pub columns: Vec<Vec<f64>>,
    /// Their derivatives with respect to each shape parameter; empty for columns that do not depend on it
    /// ([`ColumnKernel::first_shaped`]).
    pub d_shape: Vec<Vec<Vec<f64>>>,
    /// Their derivatives with respect to the voltage at which the device was virgin, 0 beyond their end: a
    /// steady state has no free start, and memory is wiped out.
    pub d_start: Vec<Vec<f64>>,
    /// The K columns before the first sample, at the rest voltage; 0 for a steady state.
    pub rest: Vec<f64>,
    /// Their derivatives with respect to each shape parameter.
    pub d_shape_rest: Vec<Vec<f64>>,
    /// Their derivatives with respect to the voltage at which the device was virgin.
    pub d_start_rest: Vec<f64>,
    /// Ends the pass early.
    pub stop: Option<Stop>,
    /// Shape parameters without derivatives in `d_shape`.
    pub(in crate::hysteresis) left_out: Vec<bool>,
}

/// Samples between two checks of the stop.
const LOOK: usize = 1 << 12;
/// Samples between two checks whether the derivatives change anymore.
const SETTLED: usize = 64;
/// Periods simulated at most to find a steady state.
const PERIODS: usize = 200;

/// A drive, with its paces where given ([`DriveGrid::paces`]).
type Paced<'a> = (&'a [f64], Option<&'a [Pace]>);

/// Sets the pace of the move to sample `index`.
#[inline(always)]
fn pace<K: ColumnKernel, S: Scalar<Real = f64>>(
    state: &mut K::State<S>,
    paces: Option<&[Pace]>,
    index: usize,
) {
    if let Some(&pace) = paces.and_then(|paces| paces.get(index)) {
        K::paced(state, pace);
    }
}

/// Checks the stop at every [`LOOK`]th sample.
#[inline(always)]
fn look(stop: Option<&Stop>, index: usize) -> Result<(), HysteresisError> {
    if index.is_multiple_of(LOOK) { outputs::look(stop) } else { Ok(()) }
}

/// Checks shape and lengths; returns the number of output samples.
fn check<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    grid: DriveGrid<'_>,
    u: &[f64],
) -> Result<usize, HysteresisError> {
    let expected = kernel.shape_names().len();
    if shape.len() != expected {
        return Err(HysteresisError::ShapeCount { expected, found: shape.len() });
    }
    kernel.check(shape)?;
    if grid.factor == 0 {
        return Err(HysteresisError::Factor);
    }
    if let Some(paces) = grid.paces {
        check_length(u.len(), paces.len())?;
        let is_sound = |pace: &Pace| pace.rate.is_finite() && pace.interval_s.is_finite();
        if let Some(index) = paces.iter().position(|pace| !is_sound(pace)) {
            return Err(HysteresisError::Drive { index });
        }
    }
    match u.iter().position(|u| !u.is_finite()) {
        Some(index) => Err(HysteresisError::Drive { index }),
        None => Ok(u.len().div_ceil(grid.factor)),
    }
}

fn check_length(expected: usize, found: usize) -> Result<(), HysteresisError> {
    if found == expected { Ok(()) } else { Err(HysteresisError::Lengths { expected, found }) }
}

/// The voltage of the virgin state that a run begins with.
fn virgin_voltage(u: &[f64], at_rest: Option<(f64, Option<f64>)>) -> Result<f64, HysteresisError> {
    match at_rest {
        Some((rest, memory)) => {
            let virgin = memory.unwrap_or(rest);
            if virgin.is_finite() && rest.is_finite() {
                Ok(virgin)
            } else {
                Err(HysteresisError::Drive { index: 0 })
            }
        }
        None => {
            let (low, high) = range_of(u);
            Ok(0.5 * low + 0.5 * high)
        }
    }
}

/// Passes the columns at every `factor`-th sample to `put`; returns the state at the last sample.
pub(in crate::hysteresis) fn simulate<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    grid: DriveGrid<'_>,
    u: &[f64],
    start: Start<f64>,
    stop: Option<&Stop>,
    put: impl FnMut(&Rows<f64>),
) -> Result<K::State<f64>, HysteresisError> {
    check(kernel, shape, grid, u)?;
    let at_rest = at_rest(start, u)?;
    let mut state = kernel.virgin(shape, virgin_voltage(u, at_rest)?);
    match at_rest {
        Some((_, None)) => {}
        Some((rest, Some(_))) => kernel.advance(shape, &mut state, rest)?,
        None => {
            K::preceded(&mut state, u.last().copied());
            settle(kernel, shape, (u, grid.paces), &mut state)?;
        }
    }
    let from = Beginning::of_record(kernel, grid)?;
    write(kernel, shape, &mut state, (from, stop), (u, grid.paces), put)?;
    Ok(state)
}

/// [`simulate`] into one column after the other.
pub(super) fn simulate_into<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    grid: DriveGrid<'_>,
    u: &[f64],
    start: Start<f64>,
    out: &mut [f64],
) -> Result<K::State<f64>, HysteresisError> {
    let samples = check(kernel, shape, grid, u)?;
    check_length(samples * kernel.columns(), out.len())?;
    simulate(kernel, shape, grid, u, start, None, scatter(out, samples))
}

/// Writes rows into columns.
pub(in crate::hysteresis) fn put_into(columns: &mut [Vec<f64>]) -> impl FnMut(&Rows<f64>) {
    move |rows| {
        for (index, column) in columns.iter_mut().enumerate() {
            rows.put(index, column, |value| value);
        }
    }
}

/// Writes rows into columns stored one after the other.
fn scatter(out: &mut [f64], samples: usize) -> impl FnMut(&Rows<f64>) {
    move |rows| {
        for (index, column) in out.chunks_exact_mut(samples.max(1)).enumerate() {
            rows.put(index, column, |value| value);
        }
    }
}

pub(super) fn continue_from<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    state: &mut K::State<f64>,
    grid: DriveGrid<'_>,
    u: &[f64],
    out: &mut [f64],
) -> Result<(), HysteresisError> {
    let samples = check(kernel, shape, grid, u)?;
    check_length(samples * kernel.columns(), out.len())?;
    let put = scatter(out, samples);
    write(kernel, shape, state, (Beginning::of_record(kernel, grid)?, None), (u, grid.paces), put)
}

/// Where a pass begins: at this voltage, with these rows.
struct Beginning {
    index: usize,
    every: Every,
    rows: Rows<f64>,
}

impl Beginning {
    fn of_record<K: ColumnKernel>(kernel: &K, grid: DriveGrid<'_>) -> Result<Self, HysteresisError> {
        Ok(Self { index: 0, every: Every::new(grid.factor)?, rows: Rows::new(kernel.columns(), 0.0) })
    }
}

fn write<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    state: &mut K::State<f64>,
    (from, stop): (Beginning, Option<&Stop>),
    (u, paces): Paced<'_>,
    mut put: impl FnMut(&Rows<f64>),
) -> Result<(), HysteresisError> {
    let Beginning { index: first, mut every, mut rows } = from;
    for (index, &u) in u.iter().enumerate().skip(first) {
        look(stop, index)?;
        pace::<K, f64>(state, paces, index);
        kernel.advance(shape, state, u).map_err(|error| error.at_sample(index))?;
        if every.take() {
            let row = rows.next();
            kernel.read(shape, state, row);
            if !row.iter().all(|value| value.is_finite()) {
                return Err(HysteresisError::Overflow { index });
            }
            if rows.is_full() {
                put(&rows);
                rows.clear();
            }
        }
    }
    put(&rows);
    Ok(())
}

/// One period without output.
fn run<K: ColumnKernel, S: Scalar<Real = f64>>(
    kernel: &K,
    shape: &[S],
    state: &mut K::State<S>,
    (u, paces): Paced<'_>,
    mut seen: impl FnMut(&[S]),
) -> Result<(), HysteresisError> {
    for (index, &u) in u.iter().enumerate() {
        pace::<K, S>(state, paces, index);
        kernel.advance(shape, state, u).map_err(|error| error.at_sample(index))?;
        seen(K::relaxing(state));
    }
    Ok(())
}

/// One relaxing number on the way to its steady state.
#[derive(Clone, Copy, Debug)]
struct Search {
    at: f64,
    /// (number, its change over a period) one period before.
    before: Option<(f64, f64)>,
    /// Largest size of the number within the period.
    size: f64,
}

/// Brings `state` to the steady state at the last sample of u. Wiping-out memory reaches it after one period;
/// each relaxing number by the secant method on its change over a period.
fn settle<K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    drive: Paced<'_>,
    state: &mut K::State<f64>,
) -> Result<(), HysteresisError> {
    run(kernel, shape, state, drive, |_| {})?;
    let mut searches: Vec<Search> =
        K::relaxing(state).iter().map(|&at| Search { at, before: None, size: 0.0 }).collect();
    if searches.is_empty() || drive.0.is_empty() {
        return Ok(());
    }
    let mut worst = f64::INFINITY;
    for _ in 0..PERIODS {
        for (number, search) in K::relaxing(state).iter_mut().zip(&mut searches) {
            *number = search.at;
            search.size = search.at.abs();
        }
        run(kernel, shape, state, drive, |numbers| {
            for (search, number) in searches.iter_mut().zip(numbers) {
                search.size = search.size.max(number.abs());
            }
        })?;
        worst = 0.0;
        let mut settled = true;
        for (&number, search) in K::relaxing(state).iter().zip(&mut searches) {
            let change = number - search.at;
            if change.abs() > 1e-13 * search.size || change.is_nan() {
                settled = false;
            }
            worst = change.abs().max(worst);
            let secant = match search.before {
                Some((at, before)) if change.abs() < before.abs() => {
                    search.at - change * (search.at - at) / (change - before)
                }
                _ => number,
            };
            search.before = Some((search.at, change));
            search.at = if secant.is_finite() { secant } else { number };
        }
        if settled {
            return Ok(());
        }
    }
    Err(HysteresisError::NotSettled { periods: PERIODS, change: worst })
}

/// [`simulate`] in duals: the partials are θ, then the start.
pub(in crate::hysteresis) fn differentiate<const P: usize, K: ColumnKernel>(
    kernel: &K,
    shape: &[f64],
    grid: DriveGrid<'_>,
    u: &[f64],
    start: Start<f64>,
    out: &mut ColumnSensitivities,
) -> Result<(), HysteresisError> {
    let samples = check(kernel, shape, grid, u)?;
    let drive = (u, grid.paces);
    let columns = kernel.columns();
    out.resize(shape.len(), (kernel.first_shaped(), columns), samples)?;
    let is_wanted = |index: usize| out.left_out.get(index) != Some(&true);
    let duals: [Dual<f64, P>; P] = std::array::from_fn(|index| match shape.get(index) {
        Some(&value) if is_wanted(index) => Dual::variable(value, index),
        other => Dual::constant(other.copied().unwrap_or(0.0)),
    });
    let ahead = if (0..shape.len()).any(is_wanted) { Vec::new() } else { reaches_ahead(u) };
    let duals = duals.get(..shape.len()).unwrap_or(&duals);
    let at_rest = at_rest(start, u)?;
    let voltage = virgin_voltage(u, at_rest)?;
    let mut row = vec![Dual::constant(0.0); columns];
    let free = match at_rest {
        None => Dual::constant(voltage),
        Some(_) => Dual::variable(voltage, shape.len()),
    };
    let mut state = kernel.virgin(duals, free);
    if let Some((rest, Some(_))) = at_rest {
        kernel.advance(duals, &mut state, rest)?;
    }
    if at_rest.is_none() {
        K::preceded(&mut state, u.last().copied());
        run(kernel, duals, &mut state, drive, |_| {})?;
        if !K::relaxing(&mut state).is_empty() {
            let mut settled = kernel.virgin(shape, voltage);
            settle(kernel, shape, drive, &mut settled)?;
            close_period(kernel, duals, &mut state, drive, K::relaxing(&mut settled))?;
        }
    } else {
        kernel.read(duals, &state, &mut row);
    }
    out.put_rest(&row, shape.len());
    let mut every = Every::new(grid.factor)?;
    let mut rows = Rows::new(columns, Dual::constant(0.0));
    for (index, &u) in u.iter().enumerate() {
        look(out.stop.as_ref(), index)?;
        if index.is_multiple_of(SETTLED)
            && let Some(&reach) = ahead.get(index / SETTLED)
            && let Some(mut settled) = kernel.with_derivatives_constant(shape, &state, reach)
        {
            out.put(&rows, shape.len());
            kernel.read(duals, &state, &mut row);
            out.put_constant(&row, (rows.end(), samples), shape.len());
            let from = Beginning { index, every, rows: Rows::starting_at(rows.end(), columns, 0.0) };
            let ColumnSensitivities { columns, stop, .. } = out;
            return write(kernel, shape, &mut settled, (from, stop.as_ref()), drive, put_into(columns));
        }
        pace::<K, _>(&mut state, grid.paces, index);
        kernel.advance(duals, &mut state, u).map_err(|error| error.at_sample(index))?;
        for number in K::relaxing(&mut state) {
            *number = number.without_vanished(0);
        }
        if every.take() {
            let row = rows.next();
            kernel.read(duals, &state, row);
            if !row.iter().all(|value| value.magnitude().is_finite()) {
                return Err(HysteresisError::Overflow { index });
            }
            if rows.is_full() {
                out.put(&rows, shape.len());
                rows.clear();
            }
        }
    }
    out.put(&rows, shape.len());
    Ok(())
}

/// Lowest and highest voltage from every [`SETTLED`]th sample on.
fn reaches_ahead(u: &[f64]) -> Vec<[f64; 2]> {
    let mut reach = [f64::INFINITY, f64::NEG_INFINITY];
    let blocks = u.chunks(SETTLED).rev().map(|block| {
        let (low, high) = range_of(block);
        reach = [reach[0].min(low), reach[1].max(high)];
        reach
    });
    let mut reaches: Vec<[f64; 2]> = blocks.collect();
    reaches.reverse();
    reaches
}

/// Sets the relaxing numbers of `state` to their steady values and derivatives: with m the derivative of a
/// number's value after a period with respect to that before it, ∂/∂θ of the fixed point is ∂/∂θ of the map
/// over 1 − m.
fn close_period<const P: usize, K: ColumnKernel>(
    kernel: &K,
    duals: &[Dual<f64, P>],
    state: &mut K::State<Dual<f64, P>>,
    drive: Paced<'_>,
    settled: &[f64],
) -> Result<(), HysteresisError> {
    let own = duals.len();
    for (number, &value) in K::relaxing(state).iter_mut().zip(settled) {
        *number = Dual::variable(value, own);
    }
    run(kernel, duals, state, drive, |_| {})?;
    for (number, &value) in K::relaxing(state).iter_mut().zip(settled) {
        let slope = number.partials.get(own).copied().unwrap_or(f64::NAN);
        let left = 1.0 - slope;
        if left.is_nan() || left <= f64::EPSILON * drive.0.len() as f64 {
            return Err(HysteresisError::NotContracting { slope });
        }
        let mut partials = number.partials.map(|p| p / left);
        if let Some(start) = partials.get_mut(own) {
            *start = 0.0;
        }
        *number = Dual { value, partials };
    }
    Ok(())
}

/// Derivative number `index`, 0 of those that are not carried.
fn partial<const P: usize>(value: &Dual<f64, P>, index: usize) -> f64 {
    value.partials.get(index).copied().unwrap_or(0.0)
}

impl ColumnSensitivities {
    /// Resizes every buffer, for `columns` of which the first `shaped` depends on the shape.
    fn resize(
        &mut self,
        parameters: usize,
        (shaped, columns): (usize, usize),
        samples: usize,
    ) -> Result<(), HysteresisError> {
        self.d_shape.resize(parameters, Vec::new());
        let Self { d_shape, left_out, .. } = self;
        let wanted = d_shape.iter_mut().enumerate().filter(|(index, _)| left_out.get(*index) != Some(&true));
        let wanted = wanted.map(|(_, buffers)| (shaped, buffers));
        for (first, buffers) in wanted.chain([(0, &mut self.columns)]) {
            buffers.resize(columns, Vec::new());
            let (without, with) = buffers.split_at_mut(first.min(columns));
            without.iter_mut().for_each(Vec::clear);
            for column in with {
                outputs::look(self.stop.as_ref())?;
                column.resize(samples, 0.0);
            }
        }
        self.d_start.resize(columns, Vec::new());
        self.d_start.iter_mut().for_each(Vec::clear);
        Ok(())
    }

    /// The columns before the first sample.
    fn put_rest<const P: usize>(&mut self, row: &[Dual<f64, P>], parameters: usize) {
        let fill = |buffer: &mut Vec<f64>, of: &dyn Fn(&Dual<f64, P>) -> f64| {
            buffer.clear();
            buffer.extend(row.iter().map(of));
        };
        fill(&mut self.rest, &|value| value.value);
        fill(&mut self.d_start_rest, &|value| partial(value, parameters));
        self.d_shape_rest.resize(parameters, Vec::new());
        for (index, buffer) in self.d_shape_rest.iter_mut().enumerate() {
            fill(buffer, &|value| partial(value, index));
        }
    }

    /// Derivatives with respect to the start that stay as in `row` from one sample to the end.
    fn put_constant<const P: usize>(
        &mut self,
        row: &[Dual<f64, P>],
        (from, end): (usize, usize),
        parameters: usize,
    ) {
        for (column, value) in self.d_start.iter_mut().zip(row) {
            let by_start = partial(value, parameters);
            if by_start != 0.0 {
                column.resize(from, 0.0);
                column.resize(end, by_start);
            }
        }
    }

    fn put<const P: usize>(&mut self, rows: &Rows<Dual<f64, P>>, parameters: usize) {
        for (index, column) in self.columns.iter_mut().enumerate() {
            rows.put(index, column, |value| value.value);
        }
        for (parameter, columns) in self.d_shape.iter_mut().enumerate() {
            for (index, column) in columns.iter_mut().enumerate() {
                rows.put(index, column, |value| partial(&value, parameter));
            }
        }
        for (index, column) in self.d_start.iter_mut().enumerate() {
            for (row, value) in rows.column(index).enumerate() {
                let by_start = partial(&value, parameters);
                if by_start != 0.0 {
                    column.resize(rows.first() + row, 0.0);
                    column.push(by_start);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::{KrasnoselskiiPokrovskii, Preisach};

    /// All samples in duals, whatever has settled.
    fn in_duals<const P: usize, K: ColumnKernel>(
        kernel: &K,
        shape: &[f64],
        u: &[f64],
        rest: f64,
    ) -> Vec<Vec<Dual<f64, P>>> {
        let duals: Vec<Dual<f64, P>> = shape.iter().map(|&value| Dual::constant(value)).collect();
        let mut state = kernel.virgin(&duals, Dual::variable(rest, shape.len()));
        let mut columns = vec![Vec::new(); kernel.columns()];
        let mut row = vec![Dual::constant(0.0); kernel.columns()];
        for &u in u {
            kernel.advance(&duals, &mut state, u).unwrap();
            kernel.read(&duals, &state, &mut row);
            columns.iter_mut().zip(&row).for_each(|(column, value)| column.push(*value));
        }
        let (low, high) = range_of(u);
        assert!(kernel.with_derivatives_constant(shape, &state, [low, high]).is_some(), "never settles");
        columns
    }

    fn agree<const P: usize, K: ColumnKernel>(kernel: &K, shape: &[f64], u: &[f64], rest: f64) {
        let expected = in_duals::<P, K>(kernel, shape, u, rest);
        let mut out = ColumnSensitivities { left_out: vec![true; shape.len()], ..Default::default() };
        let start = Start::Rest { voltage_v: rest };
        differentiate::<P, K>(kernel, shape, DriveGrid::from(1), u, start, &mut out).unwrap();
        for ((expected, found), by_start) in expected.iter().zip(&out.columns).zip(&out.d_start) {
            for (index, (expected, found)) in expected.iter().zip(found).enumerate() {
                assert_eq!(expected.value, *found, "sample {index}");
                let by_start = by_start.get(index).copied().unwrap_or(0.0);
                assert!((expected.partials[shape.len()] - by_start).abs() < 1e-10, "sample {index}");
            }
        }
    }

    #[test]
    fn settled_derivatives_continue_as_in_duals() {
        let wave = |k: usize, reach: f64| 5.0 + reach * (k as f64 * 0.071).sin();
        // Growing loops reach the virgin antidiagonal again; the last ones do not.
        let growing = (0..500).map(|k| wave(k, 0.01 * k as f64));
        let steady: Vec<f64> = growing.chain((500..900).map(|k| wave(k, 4.0 - 1e-3 * k as f64))).collect();
        let alike: Vec<f64> = (0..900).map(|k| wave(k % 177, 4.9)).collect();
        for u in [steady, alike] {
            for rest in [5.0, 2.7] {
                // Within the plane, and beyond it.
                for range in [[0.0, 10.0], [-6.0, 13.0]] {
                    agree::<1, _>(&Preisach::regular(range, 9), &[], &u, rest);
                    agree::<2, _>(&KrasnoselskiiPokrovskii { range, lines: 8 }, &[1.3], &u, rest);
                }
            }
        }
    }
}
