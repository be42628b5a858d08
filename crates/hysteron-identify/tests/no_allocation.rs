//! Promise: one evaluation of a candidate allocates nothing.

// A counting allocator is the only way to see it, and implementing one is unsafe.
#![allow(unsafe_code)]
#![allow(clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use hysteron_model::dynamics::delay::delay_linear;
use hysteron_model::dynamics::{
    Arx, Creep, DynamicForm, DynamicsError, InterSample, Linearised, Modes, Sampling, Scheme, SecondOrder,
    SimulationPlan, TransferFunction, stability,
};

use hysteron_identify::online::{Adapter, Estimator, Row};
use hysteron_model::Start;
use hysteron_model::hysteresis::{
    ColumnKernel, ColumnSensitivities, Dahl, DeadZonePlays, Duhem, GeneralisedPlays, JilesAtherton,
    KrasnoselskiiPokrovskii, MaxwellSlip, OneSidedPlays, PrandtlIshlinskii, Preisach, RateDependentPlays,
    Sensitivities, SongDerKiureghian, UnitShape,
};
use hysteron_rt::{FitMonitor, MonitorSettings, Rls, RlsSettings, Unexcited};

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on unchanged to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's promise is the one `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> usize {
    let before = COUNT.with(Cell::get);
    work();
    COUNT.with(Cell::get) - before
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1u8; 100]))), 1);
}

#[test]
fn a_candidate_allocates_nothing() {
    let mut tf = TransferFunction::article_eq13();
    let unstable =
        SecondOrder { damping: -0.5, ..tf.second_order().unwrap() }.to_transfer_function().unwrap();
    for samples in [1_000, 1_009, 10_000] {
        let input: Vec<f64> = (0..samples).map(|k| (f64::from(k) * 0.01).sin()).collect();
        let mut output = vec![0.0; input.len()];
        for scheme in Scheme::ALL {
            for initial in [Start::AsIdentified, Start::ZERO, Start::PERIODIC] {
                let plan = SimulationPlan::new(input.len(), 1e4, scheme, initial).unwrap();
                let mut workspace = plan.workspace();
                let spectrum = plan.transform(&input).unwrap();
                // The first unstable candidate makes the plan's table for the verdict of the damping schemes.
                assert!(plan.simulate(&unstable, &input, &mut workspace, &mut output).is_err());
                let words = tf.second_order().unwrap();
                let count = allocations(|| {
                    words.write_to(&mut tf).unwrap();
                    plan.simulate_spectrum(&tf, &spectrum, &mut workspace, &mut output).unwrap();
                    plan.simulate(&tf, &input, &mut workspace, &mut output).unwrap();
                    let refused = plan.simulate(&unstable, &input, &mut workspace, &mut output);
                    assert!(matches!(refused, Err(DynamicsError::Unstable { .. })));
                });
                assert_eq!(count, 0, "{scheme} {initial:?}");
            }
        }
        let arx = Arx { a: vec![-0.9], b: vec![0.05, 0.05] };
        let count = allocations(|| {
            assert!(stability(&tf).is_stable());
            delay_linear(&input, 1.3e-4, 1e4, 0.0, &mut output).unwrap();
            arx.simulate(&input, Start::AsIdentified, &mut output).unwrap();
        });
        assert_eq!(count, 0);
    }
}

#[test]
fn a_hysteresis_pass_allocates_nothing() {
    let u: Vec<f64> = (0..1_000).map(|k| 5.0 * (f64::from(k) * 0.01).sin()).collect();
    let mut zeta = vec![0.0; 500];
    for n in [1.0, 1.5, 2.0] {
        let shape = UnitShape { beta: 0.2, gamma: 0.1, n };
        for start in [Start::Rest { voltage_v: 0.0 }, Start::PERIODIC] {
            for exponent in [false, true] {
                let mut out = Sensitivities::default();
                shape.simulate_with_sensitivities(2, &u, start, exponent, &mut out).unwrap();
                let count = allocations(|| {
                    shape.simulate_every(2, &u, start, &mut zeta).unwrap();
                    shape.simulate_with_sensitivities(2, &u, start, exponent, &mut out).unwrap();
                });
                assert_eq!(count, 0, "n {n}, {start:?}");
            }
        }
    }
}

#[test]
fn a_pass_of_plays_and_its_inverse_allocate_nothing() {
    let u: Vec<f64> = (0..1_000).map(|k| 5.0 * (f64::from(k) * 0.01).sin()).collect();
    let (mut v, mut back, mut plays) = (vec![0.0; 1_000], vec![0.0; 1_000], vec![0.0; 3]);
    let model = PrandtlIshlinskii::new(vec![1.0, 0.02], vec![0.5, 1.0, 2.0], vec![0.4, 0.3, -0.2]).unwrap();
    let inverse = model.step_inverse([-6.0, 6.0]).unwrap();
    for start in [Start::Rest { voltage_v: 0.0 }, Start::PERIODIC] {
        let count = allocations(|| {
            model.simulate_every(2, &u, start, &mut plays, &mut v[..500]).unwrap();
            model.resume(&u, &mut plays, &mut v).unwrap();
            model.simulate(&u, Start::Rest { voltage_v: 0.0 }, &mut plays, &mut v).unwrap();
            plays.fill(0.0);
            inverse.follow(&v, &mut plays, &mut back).unwrap();
        });
        assert_eq!(count, 0, "{start:?}");
    }
}

#[test]
fn a_response_and_its_derivatives_allocate_nothing() {
    let form = DynamicForm { modes: Modes::TwoFractional, creep: Creep::Fractional };
    costs_nothing(form, &[320.0, 0.62, 1.94, 1.05, 710.0, 0.21, 1.87, 0.93, 0.7, 0.08, 0.12]);
    // The most terms that are kept on the stack.
    let form = DynamicForm { modes: Modes::FractionalFreeLowest, creep: Creep::Logarithmic };
    // From zero, since G(0) is infinite.
    costs_nothing(form, &[320.0, 0.62, 1.94, 1.05, 0.03, 0.02, 0.1]);
}

fn costs_nothing(form: DynamicForm, p: &[f64]) {
    let mut tf = form.transfer_function(p).unwrap();
    let mut linearised = Linearised::new();
    form.linearise(p, &mut linearised).unwrap();
    let input: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 0.01).sin()).collect();
    let mut output = vec![0.0; input.len()];
    for scheme in Scheme::ALL {
        for (delay, reconstruction) in
            InterSample::ALL.into_iter().flat_map(|delay| InterSample::ALL.map(|other| (delay, other)))
        {
            let sampling = Sampling { delay, reconstruction };
            let plan = SimulationPlan::new(input.len(), 1e4, scheme, Start::ZERO).unwrap();
            let (mut workspace, mut response) = (plan.workspace(), plan.empty_response(p.len()));
            let mut spectrum = plan.transform(&input).unwrap();
            // The first makes the table of the reconstruction.
            plan.response(&tf, 0.0, sampling, &mut response).unwrap();
            let count = allocations(|| {
                form.write_to(p, &mut tf).unwrap();
                plan.response(&tf, 2.3e-4, sampling, &mut response).unwrap();
                plan.apply(&response, &spectrum, &mut workspace, &mut output).unwrap();
                form.linearise(p, &mut linearised).unwrap();
                plan.response_with_tangents(&linearised, 2.3e-4, sampling, &mut response).unwrap();
                plan.transform_into(&input, &mut workspace, &mut spectrum).unwrap();
                for which in 0..response.tangents() {
                    plan.apply_tangent(&response, which, &spectrum, &mut workspace, &mut output).unwrap();
                }
            });
            assert_eq!(count, 0, "{scheme} {sampling:?}");
        }
    }
}

/// Allocations of a family over a loop driven in so many samples.
fn of_family<K: ColumnKernel>(kernel: &K, shape: &[f64], samples: u32) -> usize {
    let phase = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(samples);
    let u: Vec<f64> = (0..samples).map(|k| 4.0 * (3.0 * phase(k)).sin() + (7.0 * phase(k)).sin()).collect();
    let mut out = vec![0.0; kernel.columns() * u.len()];
    let mut all = ColumnSensitivities::default();
    let start = Start::Rest { voltage_v: 0.0 };
    kernel.simulate_with_sensitivities(shape, 1, &u, start, &mut all).unwrap();
    allocations(|| {
        kernel.simulate_every(shape, 1, &u, start, &mut out).unwrap();
        kernel.simulate_every(shape, 1, &u, Start::PERIODIC, &mut out).unwrap();
        kernel.simulate_with_sensitivities(shape, 1, &u, start, &mut all).unwrap();
    })
}

fn a_sample_costs_nothing<K: ColumnKernel>(kernel: &K, shape: &[f64]) {
    let few = of_family(kernel, shape, 300);
    assert!(few > 0);
    assert_eq!(few, of_family(kernel, shape, 3_000), "{shape:?}");
}

#[test]
fn families_of_columns_allocate_a_state_and_nothing_a_sample() {
    a_sample_costs_nothing(&Duhem { degree: 2 }, &[0.5]);
    a_sample_costs_nothing(&Dahl, &[2.0, 1.5]);
    a_sample_costs_nothing(&OneSidedPlays { thresholds: vec![0.5, 1.5] }, &[1.0]);
    a_sample_costs_nothing(&MaxwellSlip { thresholds: vec![0.5, 1.5] }, &[1.0]);
    a_sample_costs_nothing(&RateDependentPlays { thresholds: vec![0.5, 1.5], interval_s: 0.1 }, &[1.0, 0.05]);
    a_sample_costs_nothing(&DeadZonePlays::regular([-3.0, 3.0], 4), &[0.4, 1.0]);
    a_sample_costs_nothing(&GeneralisedPlays { thresholds: vec![0.2, 0.5] }, &[0.3, 0.1, 0.3, -0.1]);
    a_sample_costs_nothing(&KrasnoselskiiPokrovskii { range: [-4.0, 4.0], lines: 5 }, &[2.0]);
    a_sample_costs_nothing(&Preisach::regular([-5.0, 5.0], 6), &[]);
    a_sample_costs_nothing(&JilesAtherton, &[1.0, 1.0, 0.2, 1.0]);
    a_sample_costs_nothing(&SongDerKiureghian, &[0.5, 0.1, 0.0, 0.1, 0.0, 0.1]);
}

#[test]
fn a_sample_of_a_correction_allocates_nothing() {
    let rls = Rls::new(RlsSettings {
        start: [0.0, 1.0, 0.0],
        deviations: [0.5, 0.1, 0.05],
        noise: 0.02,
        forgetting: 0.99,
        unexcited: Unexcited::Hold,
        bounds: Some([(-1.0, 1.0), (0.9, 1.01), (-1.0, 1.0)]),
    })
    .unwrap();
    let settings = MonitorSettings { shift: Some(0.5), spread: Some(1.5), run_length: 1e3, fewest: 1 };
    let monitor = FitMonitor::new(settings).unwrap();
    let mut adapter = Adapter::new(Estimator::LeastSquares(rls), monitor, true);
    let mut alarms = 0;
    let count = allocations(|| {
        for k in 0..1000 {
            let u = (f64::from(k) * 0.1).sin();
            let row = Row { fixed: 0.0, regressors: [1.0, u, u * u] };
            alarms += usize::from(adapter.step(&row, 1.05 * u).unwrap().misfit.is_some());
        }
        assert!(adapter.step(&Row { fixed: 0.0, regressors: [f64::NAN; 3] }, 0.0).is_err());
    });
    assert_eq!(count, 0);
    // With alarms, bounds and a bad sample.
    assert!(alarms > 0);
}

#[test]
fn a_sample_of_a_realised_model_allocates_nothing() {
    use hysteron_model::dynamics::Dynamics;
    use hysteron_model::hammerstein::Model;
    use hysteron_model::hysteresis::{BoucWen, Hysteresis};
    use hysteron_model::realise::{RealiseOptions, StreamParts, realise};

    let model = Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![2.0, 0.01], 0.5, 0.1, 0.02, 1.0).unwrap()),
        dynamics: Dynamics::Fractional(TransferFunction::article_eq13()),
        offset: 0.0,
        delay_s: 3.4e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(1e4),
    };
    let realised = realise(&model, 1e4, &RealiseOptions::default()).unwrap();
    let mut parts = StreamParts::new(&realised).unwrap();
    let mut stream = parts.stream().unwrap();
    let mut last = 0.0;
    let count = allocations(|| {
        for k in 0..1000 {
            last = stream.step(f64::from(k) * 0.01).unwrap();
        }
    });
    assert_eq!(count, 0);
    assert!(last > 0.0);
}
