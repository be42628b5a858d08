//! What `inspect` says about measured records whose properties are known from their descriptions.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::path::{Path, PathBuf};

use hysteron_io::{ReadOptions, read_record};
use hysteron_model::record::{
    ChannelChoice, DelayFinding, ExcitationKind, Inspection, LoopSense, NoiseMethod, WaveShape, inspect,
};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn inspected(path: &Path) -> Inspection {
    let record = read_record(path, &ReadOptions::default()).unwrap();
    inspect(&record.input_output(&ChannelChoice::default()).unwrap())
}

/// Inspects a file of the public data, if it is on this machine.
fn public(name: &str) -> Option<Inspection> {
    let folder =
        std::env::var_os("HYSTERON_DATA").map_or_else(|| repository().join("../shared/data"), PathBuf::from);
    let path = folder.join(name);
    if !path.is_file() {
        println!("skipped: no {}; set HYSTERON_DATA to the public data", path.display());
        return None;
    }
    Some(inspected(&path))
}

fn words(found: &Inspection) -> String {
    found.findings.iter().map(|f| f.text.clone() + "\n").collect()
}

#[test]
fn the_shipped_record_of_a_real_stack() {
    let found = inspected(&repository().join("examples/piezo-p885-200hz/identification_1hz.csv"));
    assert_eq!((found.samples, found.sample_rate_hz), (8027, Some(200.0)));
    let ExcitationKind::Wave { frequency, shape, turning_levels } = found.kind else {
        panic!("{:?}", found.kind)
    };
    assert!((frequency * 200.0 - 1.0).abs() < 1e-6);
    assert_eq!((shape, turning_levels), (WaveShape::Sine, 2));
    let periods = found.periods.unwrap();
    assert_eq!((periods.period_samples, periods.count), (200.0, 40));
    assert!((1..=5).contains(&periods.settling), "{}", periods.settling);
    // From the mean loop of periods 3 to 40, crossing 1.8 V on straight lines between samples (computed
    // apart): 10.188 µm.
    let shape = found.loop_shape.unwrap();
    assert_eq!(shape.sense, Some(LoopSense::CounterClockwise));
    assert!((shape.opening - 10.19).abs() < 0.05, "{}", shape.opening);
    assert!((shape.stroke - 45.6).abs() < 0.3, "{}", shape.stroke);
    assert!(!shape.butterfly && shape.gain > 0.0);
    // The description: loops repeat within 0.08 µm.
    let floor = found.noise_floor.unwrap();
    assert!(matches!(floor.method, NoiseMethod::PeriodRepeats { pairs } if pairs >= 34));
    assert!(floor.rms > 0.04 && floor.rms < 0.08, "{}", floor.rms);
    assert_eq!((found.input_clipping.total(), found.output_clipping.total()), (0, 0));
    // About two samples (at most 10 ms) of dead time and delay, a lag of 13 to 14 ms.
    let Some(DelayFinding::FromStartUp(start)) = found.delay else { panic!("{:?}", found.delay) };
    assert!(!start.rest_recorded);
    assert!(start.delay_s > 0.002 && start.delay_s < 0.010, "{start:?}");
    assert!(start.lag_s > 0.012 && start.lag_s < 0.015, "{start:?}");
    let text = words(&found);
    assert!(text.contains("cannot be determined from this record"), "{text}");
    assert!(found.findings.iter().all(|f| !f.is_warning()), "{text}");
}

#[test]
fn a_record_with_rest_a_jump_and_a_ringing_sine() {
    let Some(found) = public("piezo-sine-1hz/sine_1hz_150v.csv") else { return };
    let periods = found.periods.unwrap();
    assert_eq!((periods.period_samples, periods.count), (5000.0, 6));
    assert!((periods.start as i64 - 16286).abs() <= 1, "{}", periods.start);
    // The description: opening at u = 0 5.75 µm, 14.6 % of the stroke; noise 0.049 µm.
    let shape = found.loop_shape.unwrap();
    assert!((shape.opening - 5.75).abs() < 0.03, "{}", shape.opening);
    assert!((shape.opening_percent - 14.6).abs() < 0.1, "{}", shape.opening_percent);
    let floor = found.noise_floor.unwrap();
    assert!((floor.rms - 0.049).abs() < 0.004, "{}", floor.rms);
}

#[test]
fn butterflies_are_called_so_and_other_loops_are_not() {
    for volts in [1300, 1400, 1500, 1600] {
        let Some(found) = public(&format!("secondary-loops/butterfly_{volts}V.csv")) else { return };
        assert!(found.loop_shape.unwrap().butterfly, "{volts} V");
        assert!(words(&found).contains("butterfly"), "{volts} V");
    }
    for name in [
        "secondary-loops/steel_bh_10Hz.csv",
        "secondary-loops/steel_bh_100Hz.csv",
        "secondary-loops/steel_bh_200Hz.csv",
    ] {
        let Some(found) = public(name) else { return };
        let shape = found.loop_shape.unwrap();
        assert!(!shape.butterfly, "{name}");
        assert_eq!(shape.sense, Some(LoopSense::CounterClockwise), "{name}");
    }
}

#[test]
fn a_slow_loop_of_events() {
    let Some(found) = public("piezo-michelson-quasistatic/loop_0_100.csv") else { return };
    assert!(matches!(found.kind, ExcitationKind::Ramps { .. }));
    // The description: opening 7.4 µm, 30 % of the stroke, resolution 0.16 µm.
    let shape = found.loop_shape.unwrap();
    assert!((shape.opening - 7.4).abs() < 0.1 && (shape.opening_percent - 30.0).abs() < 0.5, "{shape:?}");
    assert!((found.output_step.unwrap() - 0.158).abs() < 1e-3);
    assert!(found.findings.iter().any(|f| f.is_warning() && f.text.contains("not uniform")));
}

#[test]
fn benchmark_signals_are_recognised() {
    let Some(found) = public("boucwen-benchmark/train_multisine.csv") else { return };
    assert!(matches!(found.kind, ExcitationKind::Broadband { .. }));
    let periods = found.periods.unwrap();
    assert_eq!((periods.period_samples, periods.count), (8192.0, 5));
    // The description: output noise about 7e-6 m rms.
    let floor = found.noise_floor.unwrap();
    assert!((floor.rms - 7.0).abs() < 1.0, "{}", floor.rms);
    let Some(found) = public("boucwen-benchmark/test_sinesweep.csv") else { return };
    let ExcitationKind::Sweep { .. } = found.kind else { panic!("{:?}", found.kind) };
    let Some(found) = public("fractional-proc/validation.csv") else { return };
    assert_eq!(found.kind, ExcitationKind::Steps { levels: 4 });
    // The description: noise 0.0033.
    assert!((found.noise_floor.unwrap().rms - 0.0033).abs() < 0.0004);
}

#[test]
fn blocks_of_several_amplitudes_do_not_pass_for_repeats() {
    for name in ["sine_0p5Hz", "sine_1p5Hz", "sine_3p5Hz", "sine_5p5Hz", "sine_7p5Hz"] {
        let Some(found) = public(&format!("hasel-multifreq/{name}.csv")) else { return };
        assert_eq!(found.periods, None, "{name}");
        let ExcitationKind::Wave { turning_levels, .. } = found.kind else {
            panic!("{name}: {:?}", found.kind)
        };
        assert!(turning_levels > 5, "{name}: {turning_levels}");
        assert_eq!(found.input_clipping.total(), 0, "{name}");
    }
    let Some(found) = public("hasel-multifreq/steps.csv") else { return };
    assert_eq!(found.kind, ExcitationKind::Steps { levels: 17 });
}
