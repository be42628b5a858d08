//! One pass of the Bouc–Wen operator over a drive, with or without derivatives.

use hysteron_numeric::{InstructionSet, Relaxations};
use hysteron_rt::{BoucWen, Dual, SimulateError, StepError};

/// z along `u` from z at the voltage of `start`; `sink` receives each sample's value in turn. Returns the
/// last. The partials are those of [`BoucWen::simulate_with_shape`]: β, γ, then any others z comes with.
///
/// # Errors
/// Those of [`BoucWen::simulate_with_shape`].
pub(super) fn pass<const P: usize>(
    operator: &BoucWen<f64>,
    start: (f64, Dual<f64, P>),
    u: &[f64],
    sink: impl FnMut(Dual<f64, P>),
) -> Result<Dual<f64, P>, SimulateError<f64>> {
    let bounded = operator.beta() >= operator.gamma().abs();
    let finite = start.0.is_finite() && u.iter().all(|u| u.is_finite());
    if operator.n() != 1.0 || operator.alpha() == 0.0 || !bounded || !finite {
        return operator.simulate_with_shape(start, u, sink);
    }
    let end = relax(operator, start, u, sink)?;
    if end.value.is_finite() && end.partials.iter().all(|p| p.is_finite()) {
        return Ok(end);
    }
    // A non-finite value persists; single steps then locate it.
    operator.simulate_with_shape(start, u, |_| {})?;
    Err(SimulateError::Step { index: u.len().saturating_sub(1), cause: StepError::Overflow })
}

/// n = 1 in the bounded class, where both rates κ = β ± γ are ≥ 0.
///
/// The relaxations of a row of moves are computed at once by vector code, for the present sign of z
/// ([`BoucWen::advance_on_one_side`]). The sample on which z changes sign is done by
/// [`BoucWen::advance_with_shape`], and a new row begun behind it, about as long as the sign lasted.
fn relax<const P: usize>(
    operator: &BoucWen<f64>,
    (mut u_last, mut z): (f64, Dual<f64, P>),
    mut u: &[f64],
    mut sink: impl FnMut(Dual<f64, P>),
) -> Result<Dual<f64, P>, SimulateError<f64>> {
    let (beta, gamma) = (operator.beta(), operator.gamma());
    let set = InstructionSet::detected();
    let samples = u.len();
    let mut row = Relaxations::new();
    let mut ahead = Relaxations::MOST;
    while !u.is_empty() {
        let sign = if z.value < 0.0 { -1.0 } else { 1.0 };
        let count = u.len().min(ahead);
        let mut from = u_last;
        for (du, &to) in row.moves.iter_mut().zip(u).take(count) {
            *du = to - from;
            from = to;
        }
        row.compute(set, (beta + sign * gamma, beta - sign * gamma), count, P > 0);
        let mut done = 0;
        let moves = row.moves.iter().zip(&row.decay).zip(row.reach.iter().zip(&row.slope)).take(count);
        for ((&du, &decay), (&reach, &slope)) in moves {
            done += 1;
            if let Some(end) = operator.advance_on_one_side(sign, z, du, [decay, reach, slope]) {
                z = end;
                sink(z);
                continue;
            }
            let index = samples - u.len() + done - 1;
            z = operator.advance_with_shape(z, du).map_err(|cause| SimulateError::Step { index, cause })?;
            sink(z);
            break;
        }
        ahead = (2 * done).min(Relaxations::MOST);
        let (seen, left) = u.split_at(done);
        u_last = seen.last().copied().unwrap_or(u_last);
        u = left;
    }
    Ok(z)
}
