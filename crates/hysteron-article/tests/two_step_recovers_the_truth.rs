//! Promise: on data of its own class, two-step identification returns the truth; it can be interrupted and
//! resumed to the same bits, and threads change nothing.
//!
//! "Returns the truth" holds for each block on data that the other does not touch: the slow record of the
//! dynamic tests is simulated *without* dynamics, so the bias of the two-step way cannot show there. Where
//! both blocks act in both records, as in every measurement, the parameters come back biased: the test of the
//! article's own plant shows by how much.

#![allow(clippy::unwrap_used, clippy::panic)] // a test may fail
use hysteron_article::printed::{EQ_13, TABLE_2};
use hysteron_identify::{
    CampaignRecord, Choice, DynamicsChoice, Event, IdentifyError, Method, Options, RecordRole, Searches,
    StaticFit, Watch, identify,
};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, SecondOrder, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::model_file::{Document, ModelFile, SignalUnits, read};
use hysteron_model::record::{ChannelChoice, InputOutput, InterSample, TimeBase};
use hysteron_optimize::{Algorithm, DeAbcOptions, DeOptions, Problem};
use hysteron_rig::excitation::SweepLaw;
use hysteron_rig::{CampaignPlan, Role, Truth, run_campaign};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// The article's way.
fn two_step() -> Options {
    Options { method: Method::TwoStep, ..Options::default() }
}

fn record(name: &str, rate: f64, u: Vec<f64>, y: Vec<f64>) -> CampaignRecord {
    CampaignRecord { data: InputOutput::new(name, TimeBase::uniform(rate), u, y).unwrap(), role: None }
}

fn truth(dynamics: Dynamics, delay_s: f64) -> Model {
    Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![3.2, -0.02], 1.1, 0.35, 0.08, 1.0).unwrap()),
        dynamics,
        offset: -7.5,
        delay_s,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    }
}

/// 0 … 10 V at 1 Hz, growing amplitude, 200 Hz.
fn slow_drive() -> Vec<f64> {
    (0..600).map(|k| (1.0 + k as f64 / 300.0) / 3.0 * 5.0 * (1.0 - (TAU * k as f64 / 200.0).cos())).collect()
}

fn sweep(rate: f64, seconds: f64) -> Vec<f64> {
    (0..(rate * seconds) as usize)
        .map(|k| {
            let t = k as f64 / rate;
            5.0 - 5.0 * (TAU * (t + 0.5 * 99.0 / seconds * t * t)).cos()
        })
        .collect()
}

fn static_campaign() -> Vec<CampaignRecord> {
    let u = slow_drive();
    let y = truth(Dynamics::None, 0.0).simulate(&u, Some(200.0), &Start::Rest { voltage_v: 0.0 }).unwrap();
    vec![record("loop", 200.0, u, y)]
}

fn block(model: &Model) -> BoucWen {
    BoucWen::of(&model.hysteresis).unwrap()
}

fn assert_close(found: f64, truth: f64, relative: f64, name: &str) {
    assert!((found - truth).abs() <= relative * truth.abs(), "{name}: {found} instead of {truth}");
}

#[test]
fn static_parameters_come_back_from_noise_free_loops() {
    let found = identify(&static_campaign(), &two_step(), &Watch::silent(), None).unwrap();
    let b = block(&found.model);
    assert_eq!(b.polynomial.len(), 2, "degree chosen");
    for (name, x, t) in [
        ("linear", b.polynomial[0], 3.2),
        ("quadratic", b.polynomial[1], -0.02),
        ("alpha", b.alpha, 1.1),
        ("beta", b.beta, 0.35),
        ("gamma", b.gamma, 0.08),
        ("offset", found.model.offset, -7.5),
    ] {
        assert_close(x, t, 1e-6, name);
    }
}

#[test]
fn population_methods_search_all_parameters_as_the_article_does() {
    let options = Options {
        algorithm: Some(Algorithm::De(DeOptions::default())),
        generations: 60,
        degree: Choice::Given(2),
        ..two_step()
    };
    let found = identify(&static_campaign(), &options, &Watch::silent(), None).unwrap();
    let search = &found.searches[0];
    assert_eq!(search.outcome.best.len(), 5, "quadratic, linear, α, β, γ");
    assert_eq!(search.outcome.evaluations, 61 * 50);
    assert!(found.records[0].scores.fit_percent.unwrap() > 95.0);
}

#[test]
fn delay_and_lag_come_back_from_a_start_from_rest() {
    let lag = TransferFunction::new(
        vec![Term { coefficient: 1.0, order: 0.0 }],
        vec![Term { coefficient: 1.0, order: 0.0 }, Term { coefficient: 0.02, order: 1.0 }],
    )
    .unwrap();
    let model = truth(Dynamics::Integer(lag), 0.011);
    let u: Vec<f64> = (0..800).map(|k| 5.0 + 5.0 * (TAU * k as f64 / 200.0).sin()).collect();
    let y = model.simulate(&u, Some(200.0), &Start::Rest { voltage_v: 0.0 }).unwrap();
    let campaign = [record("started", 200.0, u, y)];
    let found = identify(&campaign, &two_step(), &Watch::silent(), None).unwrap();
    assert_eq!(found.records[0].start, Start::Rest { voltage_v: 0.0 });
    assert_close(found.model.delay_s, 0.011, 1e-4, "delay");
    let Dynamics::Integer(g) = &found.model.dynamics else { panic!("{:?}", found.model.dynamics) };
    assert_close(g.denominator[1].coefficient, 0.02, 1e-4, "lag");
    assert_close(block(&found.model).beta, 0.35, 1e-3, "beta");
    assert!(found.records[0].scores.rmse < 1e-4, "the fit and the model's own simulation agree");
}

/// A sweep through both blocks, and a slow loop of the hysteresis alone: the ideal case of the two-step way.
fn dynamic_campaign(form: SecondOrder, delay_s: f64, scheme: Scheme) -> Vec<CampaignRecord> {
    let mut model = truth(Dynamics::Fractional(form.to_transfer_function().unwrap()), delay_s);
    model.scheme = scheme;
    let start = Start::Rest { voltage_v: 0.0 };
    let slow = slow_drive();
    let fast = sweep(5000.0, 1.5);
    let y_slow = truth(Dynamics::None, 0.0).simulate(&slow, Some(200.0), &start).unwrap();
    let y_fast = model.simulate(&fast, Some(5000.0), &start).unwrap();
    vec![record("sweep", 5000.0, fast, y_fast), record("loop", 200.0, slow, y_slow)]
}

const FORM: SecondOrder = SecondOrder {
    gain: 0.96,
    natural_frequency_hz: 330.0,
    damping: 0.4,
    alpha2: 2.04,
    alpha1: 1.05,
    alpha0: 0.0,
};

#[test]
fn fractional_orders_and_coefficients_come_back_at_once() {
    for scheme in [Scheme::Tustin, Scheme::GrunwaldLetnikov, Scheme::Bdf2] {
        let campaign = dynamic_campaign(FORM, 0.00013, scheme);
        let options = Options { scheme: Choice::Given(scheme), ..two_step() };
        let found = identify(&campaign, &options, &Watch::silent(), None).unwrap();
        assert_eq!(found.records[0].role, RecordRole::Dynamic, "the sweep is recognised");
        assert_eq!(found.records[1].role, RecordRole::QuasiStatic);
        let Dynamics::Fractional(g) = &found.model.dynamics else { panic!("not fractional") };
        let form = g.second_order().unwrap();
        assert_close(form.gain, FORM.gain, 1e-4, "gain");
        assert_close(form.natural_frequency_hz, FORM.natural_frequency_hz, 1e-2, "natural frequency");
        assert_close(form.alpha2, FORM.alpha2, 1e-2, "α₂");
        assert_close(form.alpha1, FORM.alpha1, 2e-2, "α₁");
        assert_close(found.model.delay_s, 0.00013, 2e-2, "delay");
        assert!(found.records[0].scores.rmse < 1e-4, "{scheme:?}: {}", found.records[0].scores.rmse);
    }
}

/// The article's Table 2 and Eq. 13 as a noise-free plant that acts as a whole in the 1 Hz loop and in the
/// sweep.
///
/// Anchors: a prototype (numpy, scipy) with a 10 s sweep at 10 kHz has x +39 %, b −39 %, α₂ −0.08. The loop
/// is the prototype's here too; the sweep is shorter and its rate lower (for a test of seconds), and the
/// dynamic block comes out at b −35 %, α₂ −0.07.
#[test]
fn where_both_blocks_act_together_the_two_step_way_is_biased_as_the_prototype_is() {
    let plan = CampaignPlan {
        sample_rate_hz: 5_000.0,
        sweep_law: SweepLaw::Linear,
        sweep_s: 2.0,
        validation_hz: Vec::new(),
        ..CampaignPlan::default()
    };
    let runs = run_campaign(&Truth::article().with_ideal_sensor(), &plan, 1).unwrap();
    let campaign: Vec<CampaignRecord> = runs
        .iter()
        .map(|r| {
            let data = r.run.record.input_output(&ChannelChoice::default()).unwrap();
            // Every fifth sample of the slow loop: the hysteresis block does not depend on the rate.
            let (step, role) =
                if r.role == Role::Sweep { (1, RecordRole::Dynamic) } else { (5, RecordRole::QuasiStatic) };
            let every = |x: &[f64]| x.iter().step_by(step).copied().collect();
            CampaignRecord {
                role: Some(role),
                ..record(&data.name, 5_000.0 / step as f64, every(&data.u), every(&data.y))
            }
        })
        .collect();
    let mut options = Options {
        dynamics: DynamicsChoice::Fractional,
        degree: Choice::Given(2),
        delay_s: Choice::Given(0.0),
        ..two_step()
    };
    options.demands.fixed = vec![("offset".into(), 0.0)];
    let found = identify(&campaign, &options, &Watch::silent(), None).unwrap();
    let Dynamics::Fractional(g) = &found.model.dynamics else { panic!("not fractional") };
    let [_, _, c2] = g.denominator.as_slice() else { panic!("not Eq. 13") };
    let percent = |found: f64, truth: f64| 100.0 * (found / truth - 1.0);
    let x = percent(block(&found.model).polynomial[1], TABLE_2.x);
    let b = percent(g.numerator[0].coefficient / c2.coefficient, EQ_13.b);
    let alpha2 = c2.order - EQ_13.alpha2;
    assert!((x - 39.2).abs() < 0.2, "x {x} %");
    assert!((-50.0..-25.0).contains(&b), "b {b} %");
    assert!((-0.11..-0.05).contains(&alpha2), "α₂ {alpha2}");
    // The fit itself is good all the same: no score tells of the bias.
    assert!(found.records.iter().all(|r| r.scores.fit_percent.unwrap() > 99.0));
}

#[test]
fn integer_and_polynomial_blocks_fit_an_integer_plant() {
    use DynamicsChoice::{Arx, BoxJenkins, Integer, OutputError, Srivc};
    let form = SecondOrder { alpha2: 2.0, alpha1: 1.0, ..FORM };
    let campaign = dynamic_campaign(form, 0.0, Scheme::Tustin);
    for dynamics in [Integer, Arx, OutputError, BoxJenkins, Srivc] {
        let options = Options { dynamics, ..two_step() };
        let found = identify(&campaign, &options, &Watch::silent(), None).unwrap();
        let fit = found.records[0].scores.fit_percent.unwrap();
        println!("{dynamics:?}: {fit}");
        assert!(fit > 99.9, "{dynamics:?}: {fit}");
        match (&found.model.dynamics, dynamics) {
            (Dynamics::Integer(_), Integer | Srivc) | (Dynamics::Arx(_), Arx | OutputError | BoxJenkins) => {}
            (other, _) => panic!("{dynamics:?} gave {other:?}"),
        }
        if matches!(dynamics, OutputError | BoxJenkins | Srivc) {
            assert!(found.findings.iter().any(|f| f.topic == "dynamic block"), "{dynamics:?}");
            let own = found.parameters.iter().filter(|p| p.block() == "dynamics");
            assert!(own.clone().count() >= 3 && own.clone().all(|p| !p.held), "{dynamics:?}");
        }
        let file = ModelFile::from_model(&found.model, SignalUnits::default());
        let Document::Hammerstein(read) = read(file.to_json().unwrap().as_bytes()).unwrap() else { panic!() };
        let read = read.to_model().unwrap();
        assert_eq!(read, found.model, "{dynamics:?}");
    }
}

#[test]
fn quasi_static_records_alone_give_no_fractional_model() {
    let options = Options { dynamics: DynamicsChoice::Fractional, ..two_step() };
    let error = identify(&static_campaign(), &options, &Watch::silent(), None).unwrap_err();
    assert!(matches!(error, IdentifyError::NoDynamicInformation { .. }), "{error}");
}

fn colony(threads: usize) -> Options {
    Options {
        algorithm: Some(Algorithm::DeAbc(DeAbcOptions::default())),
        generations: 25,
        threads: Some(threads),
        degree: Choice::Given(2),
        ..two_step()
    }
}

#[test]
fn an_interrupted_identification_goes_on_to_the_same_bits() {
    let campaign = static_campaign();
    let straight = identify(&campaign, &colony(1), &Watch::silent(), None).unwrap();
    let (mut generation, mut kept) = (0, None);
    let interrupt = Watch::new(|event: &Event<'_>| {
        if event.stage.starts_with("static block") {
            if generation == 9 {
                kept = event.searches();
                assert!(event.model().is_some(), "the model is shown as it grows");
                return ControlFlow::Break(());
            }
            generation += 1;
        }
        ControlFlow::Continue(())
    });
    let stopped = identify(&campaign, &colony(1), &interrupt, None).unwrap();
    drop(interrupt);
    assert!(stopped.cancelled);
    assert_ne!(stopped.model, straight.model);
    let json = serde_json::to_string(&stopped.resume).unwrap();
    assert_eq!(stopped.resume, kept.unwrap());
    let resume: Searches = serde_json::from_str(&json).unwrap();
    let resumed = identify(&campaign, &colony(1), &Watch::silent(), Some(resume)).unwrap();
    assert!(!resumed.cancelled);
    assert_eq!(resumed.model, straight.model);
}

#[test]
fn threads_do_not_change_the_result() {
    let campaign = static_campaign();
    let one = identify(&campaign, &colony(1), &Watch::silent(), None).unwrap();
    let three = identify(&campaign, &colony(3), &Watch::silent(), None).unwrap();
    assert_eq!(one.model, three.model);
}

#[test]
fn the_start_of_a_long_record_is_told_from_part_of_its_samples() {
    let rate = 4000.0;
    let u: Vec<f64> = (0..12_000).map(|k| 5.0 + 5.0 * (TAU * k as f64 / rate).sin()).collect();
    for start in [Start::settled(4000), Start::Rest { voltage_v: 0.0 }] {
        let y = truth(Dynamics::None, 0.0).simulate(&u, Some(rate), &start).unwrap();
        let options = Options {
            dynamics: DynamicsChoice::None,
            degree: Choice::Given(2),
            delay_s: Choice::Given(0.0),
            ..two_step()
        };
        let campaign = [record("loop", rate, u.clone(), y)];
        let found = identify(&campaign, &options, &Watch::silent(), None).unwrap();
        assert_eq!(found.records[0].start, start);
        assert!(found.records[0].scores.rmse < 1e-6, "{start:?}: {}", found.records[0].scores.rmse);
    }
}

#[test]
fn demands_are_honoured() {
    let mut options = Options { degree: Choice::Given(2), ..two_step() };
    options.demands.fixed = vec![("gamma".into(), 0.1)];
    options.demands.bounded = vec![("linear".into(), 3.0, 3.1)];
    let found = identify(&static_campaign(), &options, &Watch::silent(), None).unwrap();
    let b = block(&found.model);
    assert_eq!(b.gamma, 0.1);
    assert!((3.0..=3.1).contains(&b.polynomial[0]));
    options.demands.fixed = vec![("gama".into(), 0.1)];
    let error = identify(&static_campaign(), &options, &Watch::silent(), None).unwrap_err();
    assert!(error.to_string().contains("no parameter 'gama'"), "{error}");
}

#[test]
fn a_constant_input_is_refused_by_name() {
    let campaign = [record("flat", 100.0, vec![1.0; 50], (0..50).map(f64::from).collect())];
    let error = identify(&campaign, &two_step(), &Watch::silent(), None).unwrap_err();
    assert!(error.to_string().contains("record 'flat': the input is constant"), "{error}");
}

#[test]
fn a_held_offset_is_kept_and_not_estimated() {
    let held = |offset: f64| {
        let mut options =
            Options { degree: Choice::Given(2), least_fit_percent: f64::NEG_INFINITY, ..two_step() };
        options.demands.fixed = vec![("offset".into(), offset)];
        identify(&static_campaign(), &options, &Watch::silent(), None).unwrap()
    };
    // The truth's sensor stands at −7.5 µm.
    let right = held(-7.5);
    assert_eq!(right.model.offset, -7.5);
    assert_close(block(&right.model).alpha, 1.1, 1e-6, "alpha");
    let wrong = held(0.0);
    assert_eq!(wrong.model.offset, 0.0);
    assert!(wrong.searches[0].outcome.cost > 1e3 * right.searches[0].outcome.cost.max(1e-9));
    let mut options = two_step();
    options.demands.bounded = vec![("offset".into(), -8.0, 0.0)];
    let error = identify(&static_campaign(), &options, &Watch::silent(), None).unwrap_err();
    assert!(error.to_string().contains("'offset'"), "{error}");
}

#[test]
fn the_bare_static_problem_is_that_of_the_identification() {
    let campaign = static_campaign();
    let options = Options { degree: Choice::Given(2), ..two_step() };
    let start = Start::Rest { voltage_v: campaign[0].data.u[0] };
    let problem = StaticFit::new(&campaign[0].data, &start, &options).unwrap();
    let names: Vec<&str> = problem.bounds().ranges.iter().map(|r| r.name.as_str()).collect();
    assert_eq!(names, ["linear", "quadratic", "alpha", "beta", "gamma"]);
    let x = [3.2, -0.02, 1.1, 0.35, 0.08];
    assert!(
        problem.cost(&x, &mut problem.workspace()) < 1e-12,
        "no residual at the truth, offset eliminated"
    );
    assert_eq!(problem.operator(&x).unwrap().polynomial, [3.2, -0.02]);
    let free = Options { degree: Choice::Auto, ..options };
    assert!(StaticFit::new(&campaign[0].data, &start, &free).is_err());
}
