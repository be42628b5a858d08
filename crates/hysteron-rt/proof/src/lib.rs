//! Every entry to `hysteron-rt`'s arithmetic, with a panic handler that cannot be linked.
//!
//! Building shows that nothing needs `std` (a second panic handler would be error E0152); linking an entry
//! shows that the optimiser found no way from it to a panic. Run by `run.sh`.
#![no_std]

use core::panic::PanicInfo;

use hysteron_rt::{
    BoucWen, BoucWenState, Branch, BrokenLine, Compensated, Compensator, Drive, Dual, Feedback, FilteredLms,
    FitMonitor, HeldBack, Hysteresis, IncrementMemory, LANES, Law, Limits, Line, Linear, LmsFilter,
    LmsMemory, LmsSettings, Model, MonitorSettings, Nlms, NlmsSettings, Observer, Operator, Plane, PlayBank,
    PolePair, Real, RealPoles, Rls, RlsSettings, Sections, SectionsMemory, SidedPlays, Sides, Turn, Turns,
};

unsafe extern "C" {
    /// Defined nowhere.
    fn hysteron_rt_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never reached; the program does not link where it could be.
    unsafe { hysteron_rt_can_panic() }
}

/// α, β, γ, n.
type Parameters<T> = [T; 4];

#[inline(always)]
fn step<T: Real>([alpha, beta, gamma, n]: Parameters<T>, state: &mut BoucWenState<T>, u: T) -> bool {
    match BoucWen::new(alpha, beta, gamma, n) {
        Ok(operator) => operator.step(state, u).is_ok(),
        Err(_) => false,
    }
}

#[inline(always)]
fn simulate<T: Real, const N: usize>(
    [alpha, beta, gamma, n]: Parameters<T>,
    state: &mut BoucWenState<T>,
    u: &[T; N],
    out: &mut [T; N],
    every: usize,
) -> bool {
    match BoucWen::new(alpha, beta, gamma, n) {
        Ok(operator) => {
            operator.simulate(state, u, out).is_ok() && operator.simulate_every(every, state, u, out).is_ok()
        }
        Err(_) => false,
    }
}

/// One step each with the derivatives with respect to the shape, the exponent and the start, then a record of
/// them.
#[inline(always)]
fn sensitivities<T: Real, const N: usize>(
    [alpha, beta, gamma, n]: Parameters<T>,
    (shape, all): &mut (Dual<T, 3>, Dual<T, 4>),
    u: &[T; N],
    out: &mut [Dual<T, 3>; N],
) -> bool {
    let Ok(operator) = BoucWen::new(alpha, beta, gamma, n) else { return false };
    let Some(&first) = u.first() else { return false };
    match (operator.advance_with_shape(*shape, first), operator.advance_with_sensitivities(*all, first)) {
        (Ok(next_shape), Ok(next_all)) => (*shape, *all) = (next_shape, next_all),
        _ => return false,
    }
    let mut slots = out.iter_mut();
    let record = operator.simulate_with_shape((first, *shape), u, |z| {
        if let Some(slot) = slots.next() {
            *slot = z;
        }
    });
    record.is_ok() && operator.simulate_with_sensitivities((first, *all), u, |z| *all = z).is_ok()
}

/// A bank of any number of plays: one move, and the voltage that the next one has to reach for an output.
#[inline(always)]
fn plays<T: Real>(thresholds: &[T], weights: &[T], states: &mut [T], slope: T, u: &mut T) -> bool {
    let Ok(bank) = PlayBank::new(thresholds, weights) else { return false };
    let Ok(sum) = bank.step(states, *u) else { return false };
    match bank.inverse(slope, states, sum) {
        Ok(next) => *u = next,
        Err(_) => return false,
    }
    bank.piece(states, sum, |u| slope * u * u).is_ok_and(|piece| piece.low.is_some())
}

/// Five parameters by both estimators, and the monitor on what they leave.
#[inline(always)]
fn online<T: Real>(
    (least_squares, gradient, monitor): (RlsSettings<T, 5>, NlmsSettings<T, 5>, MonitorSettings<T>),
    samples: &[([T; 5], T)],
    out: &mut [T; 5],
) -> bool {
    let (Ok(mut rls), Ok(mut nlms)) = (Rls::new(least_squares), Nlms::new(gradient)) else { return false };
    let Ok(mut monitor) = FitMonitor::new(monitor) else { return false };
    for (regressors, output) in samples {
        let Ok(residual) = rls.step(regressors, *output) else { return false };
        match monitor.step(residual.normalised()) {
            Ok(Some(misfit)) => {
                *out = [monitor.delay(misfit).unwrap_or(rls.deviation(regressors)); 5];
                monitor.reset();
                rls.reopen();
            }
            Ok(None) => *out = rls.covariance(samples.len()).unwrap_or(*rls.parameters()),
            Err(_) => rls.reset(),
        }
        if nlms.step(regressors, *output).is_err() {
            nlms.reset();
        }
    }
    nlms.predict(out) < rls.predict(out)
}

/// What an operator is made of.
#[allow(missing_docs)]
pub enum Numbers<'a, T> {
    States(&'a [BoucWen<T>], &'a mut [IncrementMemory<T>]),
    Branch(Branch<T>, &'a [T], &'a mut [IncrementMemory<T>]),
    Plays([&'a [T]; 2], &'a mut [T]),
    SidedPlays(Sides<T>, [&'a [T]; 5], &'a mut [T]),
    Plane([T; 2], usize, &'a [T], &'a mut [Turn<T>]),
}

/// Every operator.
#[inline(always)]
fn operator<T: Real>(numbers: Numbers<'_, T>) -> Option<Operator<'_, T>> {
    Some(match numbers {
        Numbers::States(laws, memory) => Operator::States { laws, memory },
        Numbers::Branch(law, weights, memory) => Operator::Branch { law, weights, memory },
        Numbers::Plays([thresholds, weights], states) => {
            Operator::Plays { bank: PlayBank::new(thresholds, weights).ok()?, states }
        }
        Numbers::SidedPlays(sides, [thresholds, weights, shares, corners, slopes], states) => {
            let mut plays = SidedPlays::new(sides, thresholds, weights).ok()?;
            if !slopes.is_empty() {
                plays = plays.with_line(BrokenLine::new(shares, corners, slopes).ok()?).ok()?;
            }
            Operator::SidedPlays { plays, states }
        }
        Numbers::Plane(range, intervals, everett, turns) => {
            Operator::Plane { plane: Plane::new(range, intervals, everett).ok()?, turns: Turns::new(turns) }
        }
    })
}

/// Coefficients of a model: polynomial, taps, real poles, pairs, gain at rest and offset.
type Coefficients<'a, T> = (&'a [T], &'a [T], &'a [RealPoles<T>], &'a [PolePair<T>], T, T);

/// Memory of a dynamic block: real poles, pairs, delay.
type Memory<'a, T> = (&'a mut [Compensated<T, LANES>], &'a mut [Compensated<T, 2>], &'a mut [T]);

/// Room for a saved state.
const SAVED: usize = 4096;

/// A model with any operator along voltages, from rest, with means and without, saved and restored.
#[inline(always)]
fn model<T: Real>(
    (polynomial, taps, real, pairs, rest_gain, offset): Coefficients<'_, T>,
    operator: Operator<'_, T>,
    (real_memory, pair_memory, delay): Memory<'_, T>,
    u: &[T],
    out: &mut [T],
) -> bool {
    let Ok(hysteresis) = Hysteresis::new(polynomial, operator) else { return false };
    let sections = Sections { taps, real, pairs, rest_gain };
    let memory = SectionsMemory { real: real_memory, pairs: pair_memory, delay };
    let Ok(dynamics) = Linear::new(sections, memory) else { return false };
    let Ok(mut model) = Model::new(hysteresis, dynamics, offset) else { return false };
    let Some(&first) = u.first() else { return false };
    if model.start_at(first, offset).is_err() {
        return false;
    }
    let mut run = |model: &mut Model<'_, T>| {
        for (slot, &u) in out.iter_mut().zip(u) {
            match model.step(u) {
                Ok(y) => *slot = y,
                Err(_) => return false,
            }
        }
        true
    };
    if !run(&mut model) || model.trim(rest_gain, offset).is_err() {
        return false;
    }
    let mut bytes = [0; SAVED];
    let Some(bytes) = bytes.get_mut(..model.saved_bytes()) else { return false };
    if model.save(1, bytes).is_err() || model.restore(1, bytes).is_err() {
        return false;
    }
    match model.with_means() {
        Ok(mut model) => run(&mut model),
        Err(_) => false,
    }
}

/// Gains of a law and its ring: recent, real poles, pairs, reference, ring.
type Gains<'a, T> = (&'a [T], &'a [[T; LANES]], &'a [[T; 2]], &'a [T], &'a mut [T]);

/// A compensator with any operator along references, in mid-stroke, against what an observer of its model
/// finds.
#[inline(always)]
fn compensator<T: Real>(
    (hysteresis, dynamics): (Hysteresis<'_, T>, Linear<'_, T>),
    (recent, real, pairs, reference, ring): Gains<'_, T>,
    limits: Limits<T>,
    observer: Option<&mut Observer<'_, T>>,
    measured: &[T],
    out: &mut [Drive<T>],
) -> bool {
    let law = Law { recent, real, pairs, reference };
    let Ok(mut compensator) = Compensator::new(hysteresis, dynamics, law, ring, limits, T::of(0.0)) else {
        return false;
    };
    let Some(&first) = measured.first() else { return false };
    if compensator.rest_after(first, limits.low).is_err() || compensator.measured_at_rest(first).is_err() {
        return false;
    }
    let Some(observer) = observer else {
        for (slot, &r) in out.iter_mut().zip(measured) {
            compensator.know(r);
            *slot = compensator.step(r);
        }
        let mut bytes = [0; SAVED];
        let Some(bytes) = bytes.get_mut(..compensator.saved_bytes()) else { return false };
        return compensator.save(2, bytes).is_ok()
            && compensator.restore(2, bytes).is_ok()
            && compensator.displacement() < compensator.voltage();
    };
    if observer.rest_after(first, first, first).is_err() {
        return false;
    }
    for (slot, &r) in out.iter_mut().zip(measured) {
        let Ok(observed) = observer.step(compensator.voltage(), r) else { return false };
        *slot = compensator.step_against(r, observed.disturbance);
    }
    true
}

/// Feedback and weights that adapt along readings, through a line.
#[inline(always)]
fn controller<T: Real>(
    dynamics: Linear<'_, T>,
    [proportional, integral, offset, slope]: [T; 4],
    limits: Limits<T>,
    (filter, memory, settings): Adapting<'_, T>,
    measured: &[T],
    out: &mut [Drive<T>],
) -> bool {
    let Ok(mut feedback) = Feedback::new(proportional, integral, dynamics) else { return false };
    let Ok(mut line) = Line::new(offset, slope, limits, limits.low) else { return false };
    let Ok(mut lms) = FilteredLms::new(filter, memory, settings) else { return false };
    let mut held = HeldBack::No;
    for (slot, &y) in out.iter_mut().zip(measured) {
        let before = line.voltage();
        let drive = line.step(feedback.step(y, held) + lms.step(y, y));
        held = HeldBack::of(drive, before, line.limits());
        *slot = drive;
    }
    feedback.rest();
    lms.weights().len() > 1
}

type Adapting<'a, T> = (LmsFilter<'a, T>, LmsMemory<'a, T>, LmsSettings<T>);

macro_rules! entries {
    (
        $t:ty, $step:ident, $simulate:ident, $sensitivities:ident, $plays:ident,
        $online:ident, $model:ident, $compensator:ident, $controller:ident
    ) => {
        #[unsafe(no_mangle)]
        #[allow(improper_ctypes_definitions)]
        pub extern "C" fn $controller(
            coefficients: Coefficients<'_, $t>,
            memory: Memory<'_, $t>,
            gains: [$t; 4],
            limits: Limits<$t>,
            adapting: Adapting<'_, $t>,
            (measured, out): (&[$t], &mut [Drive<$t>]),
        ) -> bool {
            let (_, taps, real, pairs, rest_gain, _) = coefficients;
            let (real_memory, pair_memory, delay) = memory;
            let sections = Sections { taps, real, pairs, rest_gain };
            let memory = SectionsMemory { real: real_memory, pairs: pair_memory, delay };
            let Ok(dynamics) = Linear::new(sections, memory) else { return false };
            controller(dynamics, gains, limits, adapting, measured, out)
        }

        #[unsafe(no_mangle)]
        #[allow(improper_ctypes_definitions, clippy::too_many_arguments)]
        pub extern "C" fn $compensator(
            coefficients: Coefficients<'_, $t>,
            hysteresis: Numbers<'_, $t>,
            memory: Memory<'_, $t>,
            gains: Gains<'_, $t>,
            limits: Limits<$t>,
            observed: Option<(Model<'_, $t>, $t)>,
            (measured, out): (&[$t], &mut [Drive<$t>]),
        ) -> bool {
            let Some(operator) = operator(hysteresis) else { return false };
            let (polynomial, taps, real, pairs, rest_gain, _) = coefficients;
            let (real_memory, pair_memory, delay) = memory;
            let Ok(hysteresis) = Hysteresis::new(polynomial, operator) else { return false };
            let sections = Sections { taps, real, pairs, rest_gain };
            let memory = SectionsMemory { real: real_memory, pairs: pair_memory, delay };
            let Ok(dynamics) = Linear::new(sections, memory) else { return false };
            let mut observer = match observed {
                None => None,
                Some((model, gain)) => match Observer::new(model, gain) {
                    Ok(observer) => Some(observer),
                    Err(_) => return false,
                },
            };
            compensator((hysteresis, dynamics), gains, limits, observer.as_mut(), measured, out)
        }

        #[unsafe(no_mangle)]
        #[allow(improper_ctypes_definitions)]
        pub extern "C" fn $model(
            coefficients: Coefficients<'_, $t>,
            hysteresis: Numbers<'_, $t>,
            memory: Memory<'_, $t>,
            u: &[$t],
            out: &mut [$t],
        ) -> bool {
            let Some(operator) = operator(hysteresis) else { return false };
            model(coefficients, operator, memory, u, out)
        }

        #[unsafe(no_mangle)]
        #[allow(improper_ctypes_definitions)]
        pub extern "C" fn $step(parameters: &Parameters<$t>, state: &mut BoucWenState<$t>, u: $t) -> bool {
            step(*parameters, state, u)
        }

        #[unsafe(no_mangle)]
        #[allow(improper_ctypes_definitions)]
        pub extern "C" fn $simulate(
            parameters: &Parameters<$t>,
            state: &mut BoucWenState<$t>,
            u: &[$t; 64],
            out: &mut [$t; 64],
            every: usize,
        ) -> bool {
            simulate(*parameters, state, u, out, every)
        }

        #[unsafe(no_mangle)]
        #[allow(improper_ctypes_definitions)]
        pub extern "C" fn $sensitivities(
            parameters: &Parameters<$t>,
            partials: &mut (Dual<$t, 3>, Dual<$t, 4>),
            u: &[$t; 64],
            out: &mut [Dual<$t, 3>; 64],
        ) -> bool {
            sensitivities(*parameters, partials, u, out)
        }

        #[unsafe(no_mangle)]
        #[allow(improper_ctypes_definitions)]
        pub extern "C" fn $plays(
            thresholds: &[$t],
            weights: &[$t],
            states: &mut [$t],
            slope: $t,
            u: &mut $t,
        ) -> bool {
            plays(thresholds, weights, states, slope, u)
        }

        #[unsafe(no_mangle)]
        #[allow(improper_ctypes_definitions)]
        pub extern "C" fn $online(
            settings: &(RlsSettings<$t, 5>, NlmsSettings<$t, 5>, MonitorSettings<$t>),
            samples: &[([$t; 5], $t)],
            out: &mut [$t; 5],
        ) -> bool {
            online(*settings, samples, out)
        }
    };
}

entries!(
    f32,
    proof_step_f32,
    proof_simulate_f32,
    proof_sensitivities_f32,
    proof_plays_f32,
    proof_online_f32,
    proof_model_f32,
    proof_compensator_f32,
    proof_controller_f32
);
entries!(
    f64,
    proof_step_f64,
    proof_simulate_f64,
    proof_sensitivities_f64,
    proof_plays_f64,
    proof_online_f64,
    proof_model_f64,
    proof_compensator_f64,
    proof_controller_f64
);

/// Negative control: an index that may be out of range.
#[cfg(feature = "panicking")]
#[unsafe(no_mangle)]
pub extern "C" fn proof_panicking(parameters: &Parameters<f64>, index: usize) -> f64 {
    parameters[index]
}
