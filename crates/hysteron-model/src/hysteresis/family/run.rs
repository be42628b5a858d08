//! A kernel run into the columns of a fit.

use super::super::columns::{ColumnKernel, put_into, simulate};
use super::super::outputs::Columns;
use super::super::pass::at_rest;
use super::super::{DriveGrid, HysteresisError};
use crate::start::Start;

/// The first `fixed` numbers of `shape` are the kernel's structure, which no derivative is taken of.
pub(super) fn run<K: ColumnKernel>(
    kernel: &K,
    (shape, fixed): (&[f64], usize),
    grid: DriveGrid<'_>,
    u: &[f64],
    start: Start<f64>,
    wanted: Option<&[bool]>,
    out: &mut Columns,
) -> Result<(), HysteresisError> {
    let factor = grid.factor;
    if factor == 0 {
        return Err(HysteresisError::Factor);
    }
    let own = shape.get(fixed..).unwrap_or_default();
    let count = kernel.columns();
    let samples = u.len().div_ceil(factor);
    let is_wanted = |index: usize| wanted.is_some_and(|wanted| wanted.get(index) == Some(&true));
    let pairs: Vec<(usize, usize)> = (fixed..shape.len())
        .filter(|&index| is_wanted(index))
        .flat_map(|index| (kernel.first_shaped()..count).map(move |column| (index, column)))
        .collect();
    let free = matches!(start, Start::Remembering { .. });
    let mut all = std::mem::take(&mut out.scratch);
    if !out.by_memory.is_empty() {
        all.d_start = std::mem::take(&mut out.by_memory);
    }
    out.resize(count, samples, &pairs, false)?;
    if wanted.is_some() && (free || !pairs.is_empty()) {
        all.stop.clone_from(&out.stop);
        // The pass fills the buffers of `out`.
        std::mem::swap(&mut all.columns, &mut out.values);
        all.left_out = (fixed..shape.len()).map(|index| !is_wanted(index)).collect();
        let of_shape =
            all.left_out.iter().map(|&left_out| vec![Vec::new(); if left_out { 0 } else { count }]);
        all.d_shape = of_shape.collect();
        for partial in &mut out.partials {
            std::mem::swap(&mut all.d_shape[partial.shape - fixed][partial.column], &mut partial.values);
        }
        kernel.simulate_with_sensitivities(own, grid, u, start, &mut all)?;
        std::mem::swap(&mut all.columns, &mut out.values);
        for partial in &mut out.partials {
            let index = partial.shape - fixed;
            std::mem::swap(&mut all.d_shape[index][partial.column], &mut partial.values);
            partial.rest = all.d_shape_rest[index][partial.column];
        }
        out.rest.copy_from_slice(&all.rest);
        if free {
            out.by_memory = std::mem::take(&mut all.d_start);
            out.rest_by_memory.copy_from_slice(&all.d_start_rest);
        }
    } else {
        let values = &mut out.values;
        simulate(kernel, own, grid, u, start, out.stop.as_ref(), put_into(values))?;
        match at_rest(start, u)? {
            Some((rest, None)) => kernel.read(own, &kernel.virgin(own, rest), &mut out.rest),
            Some((rest, Some(virgin))) => {
                let mut state = kernel.virgin(own, virgin);
                kernel.step(own, &mut state, rest, &mut out.rest)?;
            }
            None => {}
        }
    }
    out.scratch = all;
    Ok(())
}
