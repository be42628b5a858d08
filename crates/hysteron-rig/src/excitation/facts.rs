//! Properties common to all waveforms.

use proptest::prelude::*;

use super::*;
use crate::RigError;
use hysteron_model::record::TimeBase;

fn sine(frequency_hz: f64) -> Waveform {
    Waveform::Sine { frequency_hz, periods: 2.0 }
}

fn parameter_of(result: Result<Excitation, RigError>) -> &'static str {
    match result {
        Err(RigError::Waveform { parameter, .. } | RigError::EmptyWaveform { parameter, .. }) => parameter,
        other => panic!("{other:?}"),
    }
}

#[test]
fn lead_in_and_lead_out_join_rest_and_waveform_without_a_step() {
    let spec = ExcitationSpec {
        soft_start_s: 0.2,
        soft_end_s: 0.1,
        ..ExcitationSpec::new(1000.0, 2.0, 8.0, sine(10.0))
    };
    let drive = spec.generate().unwrap();
    assert_eq!((drive.samples_v.len(), drive.lead_in_samples, drive.lead_out_samples), (500, 200, 100));
    assert_eq!((drive.samples_v[0], drive.samples_v[200], drive.samples_v[499]), (0.0, 2.0, 0.0));
    assert!((drive.samples_v[100] - 1.0).abs() < 1e-12);
    // The sine's own slew is 3 V·2π·10 Hz; the steepest ramp's, 2 V·π/2/0.1 s, is below it.
    let slew = drive.max_slew_v_per_s();
    assert!((slew / (3.0 * std::f64::consts::TAU * 10.0) - 1.0).abs() < 1e-3, "{slew}");
    assert!((drive.crest_factor() - 2f64.sqrt()).abs() < 1e-6);
}

#[test]
fn the_record_has_the_drive_in_volts_from_time_zero() {
    let drive = ExcitationSpec::new(500.0, 0.0, 10.0, sine(5.0)).generate().unwrap();
    let record = drive.to_record();
    assert_eq!(record.name, "sine");
    assert_eq!(record.time, TimeBase::Uniform { start_s: 0.0, sample_rate_hz: 500.0, jitter_samples: 0.0 });
    assert_eq!((record.channels[0].name.as_str(), record.channels[0].unit.symbol()), ("u", "V"));
    assert_eq!(record.channels[0].samples, drive.samples_v);
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    let with = |waveform| ExcitationSpec::new(1000.0, 0.0, 10.0, waveform).generate();
    assert_eq!(parameter_of(with(sine(500.0))), "frequency_hz");
    assert_eq!(parameter_of(with(sine(f64::NAN))), "frequency_hz");
    assert_eq!(parameter_of(ExcitationSpec::new(1000.0, 5.0, 5.0, sine(1.0)).generate()), "high_v");
    assert_eq!(parameter_of(ExcitationSpec::new(0.0, 0.0, 5.0, sine(1.0)).generate()), "sample_rate_hz");
    let nested = |amplitudes| Waveform::NestedLoops { frequency_hz: 1.0, amplitudes, periods_each: 1 };
    assert_eq!(parameter_of(with(nested(vec![]))), "amplitudes");
    assert_eq!(parameter_of(with(nested(vec![1.0, 1.5]))), "amplitudes");
    let raster = |return_fraction, turnaround_fraction| Waveform::Raster {
        line_hz: 10.0,
        lines: 3,
        return_fraction,
        turnaround_fraction,
    };
    assert_eq!(parameter_of(with(raster(1.0, 0.0))), "return_fraction");
    assert_eq!(parameter_of(with(raster(0.2, 0.3))), "turnaround_fraction");
    let multisine = |period_s| Waveform::Multisine {
        low_hz: 1.0,
        high_hz: 100.0,
        period_s,
        periods: 1,
        lines: Lines::Full,
        phases: Phases::Random,
    };
    assert_eq!(parameter_of(with(multisine(1.00037))), "period_s");
    assert_eq!(parameter_of(with(multisine(0.001))), "period_s");
    let error = with(Waveform::Sine { frequency_hz: 1e-6, periods: 1e6 }).unwrap_err();
    assert!(matches!(error, RigError::TooLong { .. }), "{error}");
}

#[test]
fn specifications_are_json_with_defaults_and_no_unknown_keys() {
    let text = r#"{"sample_rate_hz": 1000, "low_v": 0, "high_v": 10,
        "waveform": {"kind": "multisine", "low_hz": 1, "high_hz": 50, "period_s": 1, "periods": 2,
                     "lines": {"odd_with_detection": {"group": 3}}}}"#;
    let spec: ExcitationSpec = serde_json::from_str(text).unwrap();
    assert_eq!(spec.generate().unwrap().samples_v.len(), 2000);
    let again = serde_json::to_string(&spec).unwrap();
    assert_eq!(serde_json::from_str::<ExcitationSpec>(&again).unwrap(), spec);
    let unknown = text.replace("\"periods\": 2", "\"periods\": 2, \"speed\": 1");
    assert!(serde_json::from_str::<ExcitationSpec>(&unknown).is_err());
}

fn any_waveform() -> impl Strategy<Value = Waveform> {
    let hz = || 0.5..200.0f64;
    prop_oneof![
        (hz(), 0.1..5.0f64).prop_map(|(frequency_hz, periods)| Waveform::Sine { frequency_hz, periods }),
        (hz(), 0.1..5.0f64).prop_map(|(frequency_hz, periods)| Waveform::Triangle { frequency_hz, periods }),
        (prop::collection::vec((hz(), 0.01..9.0f64, -400.0..400.0f64), 1..5), 0.01..1.0f64).prop_map(
            |(tones, duration_s)| Waveform::Sines {
                tones: tones
                    .into_iter()
                    .map(|(frequency_hz, amplitude, phase_deg)| Tone { frequency_hz, amplitude, phase_deg })
                    .collect(),
                duration_s,
            }
        ),
        (hz(), prop::collection::vec(0.01..=1.0f64, 1..6), 1..4u32).prop_map(
            |(frequency_hz, amplitudes, periods_each)| Waveform::NestedLoops {
                frequency_hz,
                amplitudes,
                periods_each
            }
        ),
        (1..12u32, 0.02..1.0f64).prop_map(|(curves, ramp_s)| Waveform::ReversalCurves { curves, ramp_s }),
        (1..9u32, 0.001..0.2f64, 0.0..0.1f64).prop_map(|(steps, hold_s, transition_s)| Waveform::Staircase {
            steps,
            hold_s,
            transition_s
        }),
        (hz(), 1..5u32, 0.05..0.95f64, 0.0..1.0f64).prop_map(|(line_hz, lines, back, part)| {
            Waveform::Raster {
                line_hz,
                lines,
                return_fraction: back,
                turnaround_fraction: part * back.min(1.0 - back),
            }
        }),
        (hz(), 0.5..20.0f64, 0.05..0.99f64).prop_map(|(frequency_hz, cycles, ratio)| Waveform::Decaying {
            frequency_hz,
            cycles,
            ratio
        }),
        (hz(), hz(), 0.01..1.0f64, any::<bool>()).prop_map(|(start_hz, end_hz, duration_s, linear)| {
            let law = if linear { SweepLaw::Linear } else { SweepLaw::Logarithmic };
            Waveform::Sweep { law, start_hz, end_hz, duration_s }
        }),
        (1.0..20.0f64, 10.0..200.0f64, any::<bool>()).prop_map(|(low_hz, span, random)| {
            Waveform::Multisine {
                low_hz,
                high_hz: low_hz + span,
                period_s: 0.5,
                periods: 2,
                lines: Lines::OddWithDetection { group: 2 },
                phases: if random { Phases::Random } else { Phases::Schroeder },
            }
        }),
        (0.0..20.0f64, 20.0..200.0f64, 0.1..1.0f64).prop_map(|(low_hz, span, duration_s)| Waveform::Random {
            low_hz,
            high_hz: low_hz + span,
            duration_s
        }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn no_waveform_leaves_its_range_or_its_duration(
        waveform in any_waveform(),
        low_v in -20.0..5.0f64,
        range_v in 0.1..40.0f64,
        lead_s in 0.0..0.1f64,
        seed in any::<u64>(),
    ) {
        let fs = 2000.0;
        let spec = ExcitationSpec {
            seed,
            soft_start_s: lead_s,
            soft_end_s: lead_s,
            ..ExcitationSpec::new(fs, low_v, low_v + range_v, waveform)
        };
        let drive = match spec.generate() {
            Ok(drive) => drive,
            // A few of the drawn combinations are too short for a sample or for their lines.
            Err(RigError::Waveform { .. }) => return Ok(()),
            Err(other) => return Err(TestCaseError::fail(other.to_string())),
        };
        let proper = &drive.samples_v[drive.lead_in_samples..drive.samples_v.len() - drive.lead_out_samples];
        prop_assert!(!proper.is_empty());
        prop_assert!(proper.iter().all(|u| (low_v..=low_v + range_v).contains(u)));
        // Leads stay between 0 V and the waveform.
        let limits = AmplifierLimits {
            low_v: low_v.min(0.0),
            high_v: (low_v + range_v).max(0.0),
            slew_v_per_s: Some((drive.max_slew_v_per_s() * (1.0 + 1e-9)).max(1e-9)),
            current_a: None,
            capacitance_f: None,
        };
        prop_assert!(limits.check(&drive).is_ok());
        let expected = spec.waveform.duration_s() * fs;
        // Reversal curves and staircases round each of their legs to whole samples.
        let legs = match &spec.waveform {
            Waveform::ReversalCurves { curves, .. } => f64::from(2 * curves + 2),
            Waveform::Staircase { steps, .. } => f64::from(4 * steps + 1),
            _ => 1.5,
        };
        prop_assert!(
            (proper.len() as f64 - expected).abs() <= legs,
            "{} samples, expected {expected}",
            proper.len()
        );
        prop_assert_eq!(spec.generate().unwrap(), drive);
    }
}
