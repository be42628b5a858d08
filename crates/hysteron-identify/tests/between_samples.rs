//! What the drive does between its samples is told by the records, and the delay that follows from it is
//! right.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron_identify::{CampaignRecord, Choice, DynamicsChoice, FindingKind, Options, Watch, identify};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::record::{InputOutput, InterSample, TimeBase, Unit};
use std::f64::consts::TAU;

const RATE: f64 = 1000.0;
const FINER: usize = 20;
const DELAY_S: f64 = 0.8e-3;

/// A stage of 150 Hz behind a loop, computed on a grid 20 times as fine.
fn stage(rule: InterSample) -> Model {
    let w = TAU * 150.0;
    let denominator = vec![Term::new(1.0, 0.0), Term::new(0.2 / w, 1.0), Term::new(1.0 / (w * w), 2.0)];
    Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![0.4], 0.08, 0.3, 0.1, 1.0).unwrap()),
        dynamics: Dynamics::Integer(TransferFunction::new(vec![Term::new(1.0, 0.0)], denominator).unwrap()),
        offset: 0.0,
        delay_s: DELAY_S,
        scheme: Scheme::BandLimited,
        // A held drive jumps; the others run on between points of the grid.
        inter_sample: if rule == InterSample::Hold { rule } else { InterSample::Linear },
        sample_rate_hz: None,
    }
}

/// A record of 2 s whose drive, `u` at the samples and smooth between them, is what `rule` makes of the
/// samples.
fn record(name: &str, rule: InterSample, u: impl Fn(f64) -> f64) -> CampaignRecord {
    let samples = 2000;
    let fine: Vec<f64> = (0..samples * FINER)
        .map(|k| {
            let (at, share) = (k / FINER, (k % FINER) as f64 / FINER as f64);
            let sample = |k: usize| u(k as f64 / RATE);
            match rule {
                InterSample::Hold => sample(at),
                InterSample::Linear => sample(at) + share * (sample(at + 1) - sample(at)),
                InterSample::BandLimited => u(k as f64 / (RATE * FINER as f64)),
            }
        })
        .collect();
    let y = stage(rule).simulate(&fine, Some(RATE * FINER as f64), &Start::Rest { voltage_v: 0.0 }).unwrap();
    // White noise of 1 nm, by a linear congruence.
    let mut state = 1u64;
    let mut noise = || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1u64 << 53) as f64;
        }
        1e-3 * sum
    };
    let pick = |x: &[f64]| x.iter().step_by(FINER).copied().collect::<Vec<f64>>();
    let y = pick(&y).into_iter().map(|y| y + noise()).collect();
    let mut data = InputOutput::new(name, TimeBase::uniform(RATE), pick(&fine), y).unwrap();
    (data.u_unit, data.y_unit) = (Unit::new("V"), Unit::new("um"));
    CampaignRecord { data, role: None }
}

#[test]
fn the_rule_is_told_and_the_delay_is_right() {
    for rule in InterSample::ALL {
        let loops = |t: f64| 5.0 * (1.0 - (TAU * t).cos()) * (1.0 - 0.2 * t);
        // Sines up to 90 Hz: eleven samples a cycle.
        let sines = |t: f64| {
            let lines = [7.0, 13.0, 29.0, 41.0, 61.0, 90.0];
            5.0 + lines
                .iter()
                .enumerate()
                .map(|(k, f)| 0.8 * ((TAU * f * t + k as f64).sin() - (k as f64).sin()))
                .sum::<f64>()
                - 5.0 * (-30.0 * t).exp()
        };
        let campaign = [record("loops", rule, loops), record("sines", rule, sines)];
        let options =
            Options { dynamics: DynamicsChoice::Integer, n: Choice::Given(1.0), ..Options::default() };
        let found = identify(&campaign, &options, &Watch::silent(), None).unwrap();
        assert_eq!(found.model.inter_sample, rule, "{:?}", found.structure.between);
        let delay = found.parameters.iter().find(|p| p.name == "delay").unwrap();
        let error = delay.std_error.unwrap();
        let off = (delay.value - DELAY_S).abs();
        println!("{rule}: {:.1} standard errors, {:.1e} s", off / error, error);
        assert!(off < 4.0 * error && error < 2e-5, "{rule}: {delay:?}");
        let told = found.findings.iter().find(|f| f.topic == "between samples").unwrap();
        assert!(told.kind == FindingKind::Verdict && told.text.contains(rule.name()), "{told:?}");
    }
}

#[test]
fn the_interval_of_the_delay_holds_for_a_held_drive_that_the_records_do_not_show() {
    let loops = |t: f64| 5.0 * (1.0 - (TAU * t).cos()) * (1.0 - 0.2 * t);
    // 125 samples a cycle.
    let sines = |t: f64| 4.0 * (1.0 - (TAU * 8.0 * t).cos()) * (1.0 - 0.3 * t);
    let campaign = [record("loops", InterSample::Hold, loops), record("sines", InterSample::Hold, sines)];
    let found = |inter_sample| {
        let options = Options {
            dynamics: DynamicsChoice::Integer,
            n: Choice::Given(1.0),
            inter_sample,
            ..Options::default()
        };
        let found = identify(&campaign, &options, &Watch::silent(), None).unwrap();
        let interval = found.parameters.iter().find(|p| p.name == "delay").unwrap().interval.unwrap();
        (interval, found.findings.into_iter().find(|f| f.topic == "between samples"))
    };
    let (open, advice) = found(Choice::Auto);
    let advice = advice.unwrap();
    assert!(advice.kind == FindingKind::Advice && advice.text.contains("0.00053 s too long"), "{advice:?}");
    assert!(open.low < DELAY_S && DELAY_S < open.high, "{open:?}");
    // Given straight lines, the delay is known, and wrong by half a sample.
    let (given, advice) = found(Choice::Given(InterSample::Linear));
    assert_eq!(advice, None);
    assert!(
        given.low > DELAY_S && given.high == open.high && given.low - open.low < 0.54 / RATE,
        "{given:?}"
    );
}
