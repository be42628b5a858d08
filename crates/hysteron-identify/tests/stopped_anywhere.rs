//! Promise: a fit stopped at any of its checks hands out the best model so far, as soon as there is one.
#![allow(clippy::unwrap_used, clippy::panic)] // a test may fail

use std::ops::ControlFlow;

use hysteron_identify::{
    CampaignRecord, DynamicsChoice, Event, FamilyChoice, Identification, IdentifyError, Method, Options,
    RecordRole, Stop, Watch, identify,
};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis, HysteresisForm};
use hysteron_model::record::{InputOutput, InterSample, TimeBase};

const RATE_HZ: f64 = 2000.0;

/// Loops that grow, between 0 and 10 V.
fn drive(hz: f64, samples: usize) -> Vec<f64> {
    let at = |k: usize| {
        let growth = 0.3 + 0.7 * k as f64 / samples as f64;
        5.0 - 5.0 * growth * (std::f64::consts::TAU * hz * k as f64 / RATE_HZ).cos()
    };
    (0..samples).map(at).collect()
}

/// A slow and a fast record of a simulated device: Bouc–Wen, a resonance at 300 Hz, a delay of 0.2 ms.
fn campaign() -> Vec<CampaignRecord> {
    let hysteresis = BoucWen { polynomial: vec![2.0, 0.003], alpha: -0.8, beta: 0.3, gamma: 0.05, n: 1.0 };
    let omega = std::f64::consts::TAU * 300.0;
    let term = |coefficient, order| Term { coefficient, order };
    let g = TransferFunction::new(
        vec![term(1.0, 0.0)],
        vec![term(1.0, 0.0), term(2.0 * 0.2 / omega, 1.0), term(1.0 / (omega * omega), 2.0)],
    );
    let device = Model {
        hysteresis: Hysteresis::from(hysteresis),
        dynamics: Dynamics::Integer(g.unwrap()),
        offset: 0.4,
        delay_s: 2e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(RATE_HZ),
    };
    let record = |name: &str, hz: f64, samples: usize, role: RecordRole| {
        let u = drive(hz, samples);
        let mut y = device.simulate(&u, Some(RATE_HZ), &Start::Rest { voltage_v: u[0] }).unwrap();
        y.iter_mut().enumerate().for_each(|(k, y)| *y += 0.005 * (1.7 * (k * k) as f64).sin());
        let data = InputOutput::new(name, TimeBase::uniform(RATE_HZ), u, y).unwrap();
        CampaignRecord { data, role: Some(role) }
    };
    vec![record("slow", 4.0, 800, RecordRole::QuasiStatic), record("fast", 90.0, 500, RecordRole::Dynamic)]
}

/// Outcome of a fit that requests its own stop.
struct Stopped {
    outcome: Result<Identification, IdentifyError>,
    /// The watch was shown a model before the stop.
    had_model: bool,
    checks: usize,
}

/// The fit, stopped after so many checks, on one thread: every run makes the same checks.
fn stopped_after(checks: usize, campaign: &[CampaignRecord], options: &Options) -> Stopped {
    let stop = Stop::after(checks);
    let mut had_model = false;
    let watch = Watch::new(|event: &Event<'_>| {
        had_model |= event.model().is_some();
        ControlFlow::Continue(())
    })
    .stopped_by(&stop);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let outcome = pool.install(|| identify(campaign, options, &watch, None));
    drop(watch);
    Stopped { outcome, had_model, checks: stop.checks() }
}

/// Stops the fit at this many moments, spread over its whole length.
fn keeps_its_model(stops: usize, options: &Options) {
    let campaign = campaign();
    let whole = stopped_after(usize::MAX, &campaign, options);
    let checks = whole.checks;
    assert!(!whole.outcome.unwrap().cancelled && checks > stops, "{checks} checks");
    let mut kept = 0;
    for stop in 0..stops {
        let after = (2 * stop + 1) * checks / (2 * stops);
        let stopped = stopped_after(after, &campaign, options);
        match stopped.outcome {
            Ok(found) => {
                assert!(found.cancelled, "after {after} of {checks} checks: the fit counts as whole");
                let u = &campaign[1].data.u;
                let y = found.model.simulate(u, Some(RATE_HZ), &Start::Rest { voltage_v: u[0] }).unwrap();
                assert!(y.iter().all(|y| y.is_finite()), "after {after} of {checks} checks");
                kept += 1;
            }
            // Nothing to keep yet.
            Err(IdentifyError::Stopped) if !stopped.had_model => {}
            Err(e) => panic!("after {after} of {checks} checks: {e}"),
        }
    }
    assert!(2 * kept > stops, "{kept} of {stops} stops had a model");
}

fn family(name: &str, elements: usize) -> Options {
    let form = name.parse::<HysteresisForm>().unwrap();
    Options {
        hysteresis: FamilyChoice::Given(form.with_elements(elements).unwrap()),
        dynamics: DynamicsChoice::Integer,
        ..Options::default()
    }
}

#[test]
fn no_option() {
    keeps_its_model(8, &Options::default());
}

#[test]
fn modes() {
    keeps_its_model(8, &Options { dynamics: DynamicsChoice::Modes, order: 5, ..Options::default() });
}

#[test]
fn static_model() {
    keeps_its_model(8, &Options { dynamics: DynamicsChoice::None, ..Options::default() });
}

#[test]
fn two_steps() {
    keeps_its_model(
        8,
        &Options { method: Method::TwoStep, dynamics: DynamicsChoice::Integer, ..Options::default() },
    );
}

#[test]
fn plays() {
    keeps_its_model(8, &family("prandtl-ishlinskii", 6));
}

#[test]
fn plays_with_dead_zones() {
    keeps_its_model(8, &family("dead-zone-plays", 4));
}

#[test]
fn planes() {
    keeps_its_model(8, &family("preisach", 4));
}
