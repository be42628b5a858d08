//! Promise: on a simulated bench outside the class (plays, bias-dependent) the band of a new measurement holds
//! records of another kind, which the band of the class does not; it comes from the model file, and says where
//! it does not hold or rests on other devices.

#![allow(clippy::unwrap_used, clippy::panic)] // a test may fail
use hysteron_identify::misfit::Misfit;
use hysteron_identify::{
    CampaignRecord, Choice, DynamicsChoice, FamilyChoice, Identification, Options, PredictionBand, Watch,
    identify,
};
use hysteron_model::Start;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::model_file::{Document, Maker, ModelFile, read};
use hysteron_model::record::{ChannelChoice, InputOutput, Timing};
use hysteron_model::validate::{Scoring, score};
use hysteron_rig::excitation::{Excitation, ExcitationSpec, SweepLaw, Waveform};
use hysteron_rig::{Truth, measure};

const RATE_HZ: f64 = 2000.0;

fn drive(waveform: Waveform) -> Excitation {
    let spec = ExcitationSpec { soft_start_s: 0.2, ..ExcitationSpec::new(RATE_HZ, 0.0, 100.0, waveform) };
    spec.generate().unwrap()
}

fn nested_loops() -> Excitation {
    let amplitudes = vec![1.0, 0.75, 0.5, 0.25];
    drive(Waveform::NestedLoops { frequency_hz: 1.5, amplitudes, periods_each: 1 })
}

fn sweep() -> Excitation {
    let law = SweepLaw::Logarithmic;
    drive(Waveform::Sweep { law, start_hz: 1.0, end_hz: 100.0, duration_s: 2.0 })
}

fn random() -> Excitation {
    drive(Waveform::Random { low_hz: 0.0, high_hz: 100.0, duration_s: 2.0 })
}

fn answer(truth: &Truth, drive: &Excitation, stream: usize) -> InputOutput {
    measure(truth, drive, 3, stream).unwrap().record.input_output(&ChannelChoice::default()).unwrap()
}

fn fitted(records: Vec<InputOutput>) -> (Identification, ModelFile) {
    let records: Vec<_> = records.into_iter().map(|data| CampaignRecord { data, role: None }).collect();
    let options = Options {
        hysteresis: FamilyChoice::Given(HysteresisForm::default()),
        degree: Choice::Given(3),
        n: Choice::Given(1.0),
        dynamics: DynamicsChoice::Integer,
        ..Options::default()
    };
    let found = identify(&records, &options, &Watch::silent(), None).unwrap();
    let text = found.model_file(&options, &Maker::default()).to_json().unwrap();
    let Document::Hammerstein(file) = read(text.as_bytes()).unwrap() else { panic!("{text}") };
    (found, *file)
}

/// Share of a record within the band of a measurement.
fn inside(file: &ModelFile, record: &InputOutput) -> f64 {
    let start = Start::Rest { voltage_v: record.u[0] };
    let simulated = file.to_model().unwrap().simulate(&record.u, Some(RATE_HZ), &start).unwrap();
    let offset = score(record, &simulated, &Scoring::default()).unwrap().offset;
    let half = PredictionBand::of_file(file, &record.u, &record.time, &start).unwrap().of_measurement();
    let errors = record.y.iter().zip(&simulated).map(|(y, m)| (y - m - offset).abs());
    errors.zip(&half).filter(|(e, h)| e <= *h).count() as f64 / half.len() as f64
}

#[test]
fn a_device_outside_the_class_is_within_its_band_on_a_record_of_another_kind() {
    let truth = Truth::default();
    let (found, file) = fitted(vec![answer(&truth, &nested_loops(), 0), answer(&truth, &sweep(), 1)]);
    let Misfit::Outside(misfit) = found.misfit() else { panic!("{:?}", found.misfit()) };
    assert!(misfit.explained > 0.3 && !misfit.one_amplitude, "{}", misfit.explained);
    let unseen = answer(&truth, &random(), 2);
    let mut class = file.clone();
    class.misfit = None;
    let (by_misfit, by_class) = (inside(&file, &unseen), inside(&class, &unseen));
    println!("within the band: {by_misfit:.3} with the misfit, {by_class:.3} by the class");
    assert!(by_misfit > 0.9 && by_misfit > by_class, "{by_misfit} {by_class}");

    let times_s: Vec<f64> = (0..100).map(|k| f64::from(k * k)).collect();
    let start = Start::AsIdentified;
    let stamped = PredictionBand::of_file(&file, &unseen.u[..100], Timing::Stamps(&times_s), &start).unwrap();
    assert!(stamped.misfit.is_none() && stamped.findings[0].text.contains("uniform sample rate"));

    let (one, _) = fitted(vec![answer(&truth, &sweep(), 1)]);
    let told = one.misfit().findings();
    assert!(told.iter().any(|finding| finding.text.contains("Add nested loops")), "{told:?}");
}
