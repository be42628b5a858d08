//! Bouc–Wen: one column ζ.

use super::super::outputs::Columns;
use super::super::{HysteresisError, UnitShape};
use crate::start::Start;

/// Index of n among the shape numbers.
const N: usize = 2;

pub(super) fn run(
    shape: UnitShape,
    factor: usize,
    u: &[f64],
    start: Start<f64>,
    wanted: Option<&[bool]>,
    out: &mut Columns,
) -> Result<(), HysteresisError> {
    let samples = if factor == 0 { return Err(HysteresisError::Factor) } else { u.len().div_ceil(factor) };
    match wanted {
        None => {
            out.resize(1, samples, &[], false)?;
            shape.simulate_every(factor, u, start, &mut out.values[0])?;
        }
        Some(wanted) => {
            // β' and γ' come at no cost.
            let exponent = wanted.get(N) == Some(&true);
            let pairs = [(0, 0), (1, 0), (N, 0)];
            out.resize(1, samples, &pairs[..if exponent { 3 } else { 2 }], true)?;
            let Columns { values, partials, by_memory, sensitivities, .. } = &mut *out;
            shape.simulate_with_sensitivities(factor, u, start, exponent, sensitivities)?;
            std::mem::swap(&mut values[0], &mut sensitivities.zeta);
            std::mem::swap(&mut by_memory[0], &mut sensitivities.d_start);
            let own = [&mut sensitivities.d_beta, &mut sensitivities.d_gamma, &mut sensitivities.d_n];
            partials.iter_mut().zip(own).for_each(|(to, from)| std::mem::swap(&mut to.values, from));
        }
    }
    if let Start::Remembering { memory, .. } = start {
        out.rest[0] = memory;
        out.rest_by_memory[0] = 1.0;
    }
    Ok(())
}
