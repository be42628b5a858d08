//! Search ranges come from every segment of a record, not from its widest or slowest move.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron_identify::{CampaignRecord, Choice, DynamicsChoice, FamilyChoice, Options, Watch, identify};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{Hysteresis, HysteresisForm, PrandtlIshlinskii};
use hysteron_model::record::{InputOutput, InterSample, TimeBase, Unit};
use std::f64::consts::TAU;

/// Lag of the device \[s\], a tenth of a period of the small sine.
const LAG_S: f64 = 3.3e-4;
const SINE_HZ: f64 = 300.0;

/// A ramp of 20 V in half a second at 2 kHz, a sine of 0.1 V at 300 Hz and 30 kHz, a rest, and the ramp back.
fn record() -> CampaignRecord {
    let (mut times, mut drive) = (vec![0.0], vec![0.0]);
    let mut segment = |samples: usize, period_s: f64, u: &dyn Fn(f64) -> f64| {
        let from = times[times.len() - 1];
        for k in 1..=samples {
            times.push(from + k as f64 * period_s);
            drive.push(u(k as f64 * period_s));
        }
    };
    segment(1000, 5e-4, &|t| 40.0 * t);
    segment(2000, 1.0 / 30_000.0, &|t| 20.0 + 0.1 * (TAU * SINE_HZ * t).sin());
    segment(200, 5e-3, &|_| 20.0);
    segment(1000, 5e-4, &|t| 20.0 - 40.0 * t);
    let time = TimeBase::from_times("segments", times).unwrap();
    assert!(matches!(time, TimeBase::NonUniform { .. }));
    let term = |coefficient, order| Term { coefficient, order };
    let model = Model {
        hysteresis: Hysteresis::from(
            PrandtlIshlinskii::new(vec![0.1], vec![1.0, 3.0], vec![0.02, 0.01]).unwrap(),
        ),
        dynamics: Dynamics::Integer(TransferFunction {
            numerator: vec![term(1.0, 0.0)],
            denominator: vec![term(1.0, 0.0), term(LAG_S, 1.0)],
        }),
        offset: 0.0,
        delay_s: 0.0,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    };
    let y = model.simulate_at_own_rate(&drive, &time, &Start::Rest { voltage_v: 0.0 }).unwrap();
    let mut data = InputOutput::new("segments", time, drive, y).unwrap();
    (data.u_unit, data.y_unit) = (Unit::new("V"), Unit::new("um"));
    CampaignRecord { data, role: None }
}

#[test]
fn ranges_are_those_of_the_small_fast_sine_too() {
    let options = Options {
        // Enough that a density of them has corners near both plays of the device.
        hysteresis: FamilyChoice::Given(HysteresisForm::plays(12)),
        dynamics: DynamicsChoice::Integer,
        order: 1,
        degree: Choice::Given(1),
        ..Options::default()
    };
    let found = identify(&[record()], &options, &Watch::silent(), None).unwrap();
    let range = |name: &str| found.bounds[0].ranges.iter().find(|range| range.name == name).unwrap();
    // By the ramps alone, of 1 Hz, a lag of seconds would be sought, and a delay of 0.1 s.
    let lag = range("lag");
    assert!(lag.low < 0.01 * LAG_S && lag.high < 4.0 / SINE_HZ, "{lag:?}");
    let delay = range("delay");
    assert!(delay.high > 0.09 / SINE_HZ && delay.high < 2.0 / SINE_HZ, "{delay:?}");
    let lag_s = found.parameters.iter().find(|p| p.name == "lag").unwrap().value;
    let delay_s = found.parameters.iter().find(|p| p.name == "delay").unwrap().value;
    assert!((lag_s / LAG_S - 1.0).abs() < 0.02 && delay_s < 1e-5, "{lag_s} {delay_s}");
}
