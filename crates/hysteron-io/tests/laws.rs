//! Laws: what is written reads back; no input, however broken, panics.
#![allow(clippy::unwrap_used)]

use hysteron_io::{IoError, ReadOptions, read_record, read_record_bytes, write_csv, write_csv_to};
use hysteron_model::record::{Channel, Record, RecordError, TimeBase};
use proptest::prelude::*;

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO)
            .prop_map(|x| if x.abs() > 1e100 { x * 1e-209 } else { x }),
        4 => -1e3..1e3f64,
        1 => (-1000i32..1000).prop_map(f64::from),
    ]
}

fn time_base(n: usize) -> impl Strategy<Value = TimeBase> {
    prop_oneof![
        Just(TimeBase::Unknown),
        (-100.0..100.0f64, 0.01..1e5f64).prop_map(|(start_s, sample_rate_hz)| TimeBase::Uniform {
            start_s,
            sample_rate_hz,
            jitter_samples: 0.0
        }),
        // Steps of 0 and 1 in turn of a random kind are never a grid.
        prop::collection::vec(0.0..1.0f64, n).prop_map(move |steps| {
            let mut t = 0.0;
            let mut times_s: Vec<f64> = steps
                .iter()
                .map(|dt| {
                    t += dt;
                    t
                })
                .collect();
            times_s[n - 1] += 10.0 * n as f64;
            TimeBase::NonUniform { times_s }
        }),
    ]
}

fn record() -> impl Strategy<Value = Record> {
    (3usize..40, 1usize..4).prop_flat_map(|(n, channels)| {
        let units = prop::sample::select(vec!["V", "um", "", "counts", "A_per_m"]);
        (
            time_base(n),
            prop::collection::vec((units, prop::collection::vec(finite(), n)), channels),
            prop::option::of(prop::collection::vec(any::<bool>(), n)),
        )
            .prop_map(|(time, columns, valid)| Record {
                name: "r.csv".to_string(),
                time,
                channels: columns
                    .into_iter()
                    .enumerate()
                    .map(|(i, (unit, samples))| Channel::new(&format!("c{i}, \"q\" x"), unit, samples))
                    .collect(),
                valid,
                source: None,
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_record_written_reads_back_to_the_same_numbers(record in record()) {
        let mut bytes = Vec::new();
        write_csv_to(&mut bytes, &record).unwrap();
        let back = read_record_bytes("r.csv", &bytes, &ReadOptions::default()).unwrap();
        prop_assert_eq!(&back.channels, &record.channels);
        prop_assert_eq!(&back.valid, &record.valid);
        match (&record.time, &back.time) {
            (
                TimeBase::Uniform { start_s, sample_rate_hz, .. },
                TimeBase::Uniform { start_s: start, sample_rate_hz: rate, jitter_samples },
            ) => {
                // A start of 100 s at 1e5 Hz leaves 1.4e-14 s · 1e5 Hz = 1.4e-9 samples to the stamps'
                // rounding.
                prop_assert!(*jitter_samples < 1e-8, "{}", jitter_samples);
                prop_assert_eq!(start, start_s);
                prop_assert!((rate / sample_rate_hz - 1.0).abs() * record.len() as f64 <= 1.01e-6);
            }
            (a, b) => prop_assert_eq!(a, b),
        }
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = read_record_bytes("x", &bytes, &ReadOptions::default());
    }

    #[test]
    fn arbitrary_tables_never_panic_and_what_is_accepted_is_sound(
        text in "(#? ?[tuyfv\"][_ \\[(]?[sVµum]{0,2}[\\])]?[,;\t]){1,4}[a-z]{0,5}\r?\n([-+0-9.,;\t\" \
                 enaif#%]{0,24}\r?\n){0,6}",
        rate in prop::option::of(prop_oneof![Just(f64::NAN), -1.0..1e4f64]),
        column in prop::option::of("[tuy1-5]"),
    ) {
        let options = ReadOptions { sample_rate_hz: rate, input: column, ..ReadOptions::default() };
        match read_record_bytes("x.csv", text.as_bytes(), &options) {
            Ok(record) => prop_assert_eq!(record.check(), Ok(())),
            Err(err) => {
                let message = err.to_string();
                prop_assert!(message.contains("x.csv"), "{}", message);
                prop_assert!(message.len() < 2000, "{}", message);
            }
        }
    }
}

#[test]
fn a_file_written_is_complete_and_an_unsound_record_writes_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.csv");
    let record = Record::new(
        "out.csv",
        TimeBase::uniform(200.0),
        vec![Channel::new("u", "V", vec![0.1, 0.2, 1e-9]), Channel::new("y", "um", vec![1.0, 2e20, -0.0])],
    )
    .unwrap();
    write_csv(&path, &record).unwrap();
    assert_eq!(
        std::fs::read_to_string(&path).unwrap(),
        "t_s,u_V,y_um\n0,0.1,1\n0.005,0.2,2e20\n0.01,1e-9,-0\n"
    );
    let back = read_record(&path, &ReadOptions::default()).unwrap();
    assert_eq!((&back.channels, &back.name), (&record.channels, &record.name));

    let mut broken = record;
    broken.channels[0].samples.pop();
    let other = folder.path().join("broken.csv");
    let err = write_csv(&other, &broken).unwrap_err();
    assert!(
        matches!(&err, IoError::Record { source, .. }
            if matches!(**source, RecordError::LengthMismatch { .. })),
        "{err}"
    );
    assert!(!other.exists());
}
