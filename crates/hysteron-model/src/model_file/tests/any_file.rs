//! Any model, any bytes: written files are read back, invalid ones are refused.

use super::*;

/// Every number that a file may hold, zero and the smallest among them.
fn number() -> impl Strategy<Value = f64> {
    let any = prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO;
    any.prop_map(|x| if x.abs() > 1e100 { x * 1e-209 } else { x })
}

proptest! {
    /// Any numbers come back bit for bit.
    #[test]
    fn numbers_survive_the_file_bit_for_bit(
        polynomial in prop::collection::vec(number(), 1..9),
        alpha in number(),
        offset in number(),
        n in 1.0..20.0_f64,
        delay_s in 0.0..10.0_f64,
        coefficient in number().prop_filter("not 0", |x| *x != 0.0),
        orders in prop::collection::btree_set(0_u32..4_000_000_000, 1..6),
        rate in 1e-9..1e12_f64,
    ) {
        let denominator = orders.iter().map(|&o| term(coefficient, f64::from(o) / 7e8)).collect();
        let model = Model {
            hysteresis: ArticleOperator { polynomial, alpha, beta: offset, gamma: -alpha, n }.into(),
            dynamics: Dynamics::Fractional(TransferFunction {
                numerator: vec![term(coefficient, 0.0)],
                denominator,
            }),
            offset,
            delay_s,
            scheme: Scheme::BandLimited,
            inter_sample: InterSample::Linear,
            sample_rate_hz: Some(rate),
        };
        let file = ModelFile::from_model(&model, SignalUnits::default());
        let text = file.to_json().unwrap();
        let again = read(&text).unwrap();
        prop_assert_eq!(&again, &file);
        // Equality of f64 confuses 0 and −0: compare the texts as well.
        prop_assert_eq!(again.to_json().unwrap(), text);
        prop_assert_eq!(again.to_model().unwrap(), model);
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(parsed(&bytes).is_err());
    }

    /// A valid file with a few bytes overwritten, cut or repeated is read or refused, and what is read is
    /// sound.
    #[test]
    fn mutated_files_never_panic_and_never_pass_unsound(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0_u8..4), 1..6),
    ) {
        let mut bytes = complete().to_json().unwrap().into_bytes();
        for (at, byte, edit) in edits {
            let at = at.index(bytes.len());
            match edit {
                0 => bytes[at] = byte,
                1 => { bytes.remove(at); }
                2 => bytes.insert(at, b"0123456789-+.eE\"{}[],:"[usize::from(byte) % 22]),
                _ => bytes.swap(at, 0),
            }
        }
        if let Ok(file) = parsed(&bytes) {
            prop_assert!(file.to_model().is_ok());
            prop_assert_eq!(parsed(file.to_json().unwrap().as_bytes()).unwrap(), file);
        }
    }
}

#[test]
fn every_family_survives_writing_and_reading() {
    for hysteresis in examples([-1.0, 9.2], 10.0, 2.0).unwrap() {
        let family = hysteresis.form().description();
        let kind = family.name();
        let model = Model { hysteresis, ..article() };
        let text = ModelFile::from_model(&model, SignalUnits::default()).to_json().unwrap();
        assert!(text.contains(&format!("\"kind\": \"{kind}\"")), "{text}");
        assert_eq!(read(&text).unwrap().to_model().unwrap(), model, "{kind}");
        // A weight less: another member of the family, or none.
        let short = text.replace(&format!("\"{}\"", family.weight_name(0)), "\"weight_0\"");
        assert!(read(&short).is_err(), "{kind}");
        let unit = text.replacen("\"unit\": \"um/V\"", "\"unit\": \"s\"", 2);
        assert!(matches!(read(&unit), Err(ModelFileError::WrongUnit { .. })), "{kind}");
    }
}

#[test]
fn shape_numbers_that_a_family_cannot_have_are_refused() {
    for hysteresis in examples([0.0, 10.0], 10.0, 2.0).unwrap() {
        let model = Model { hysteresis, ..article() };
        let mut file = ModelFile::from_model(&model, SignalUnits::default());
        // The ends of a grid, where the family has one.
        if let Some(high) = file.number_mut("high") {
            high.value = -1.0;
            assert!(matches!(file.check(), Err(ModelFileError::Shape { .. })), "{:?}", file.check());
        }
    }
}

/// What takes memory and time to be realised is limited where it is read.
#[test]
fn a_file_asks_for_no_more_than_the_stated_limits() {
    let with = |change: fn(&mut ModelFile)| {
        let mut file = complete();
        change(&mut file);
        file.check().unwrap_err().to_string()
    };
    let terms = |kind, count: u32| {
        let mut file = complete();
        file.dynamics.kind = kind;
        let entry =
            |k| TermEntry { order: Quantity::new(f64::from(k), "1"), coefficient: Quantity::new(1.0, "1") };
        file.dynamics.denominator = (0..count).map(entry).collect();
        file.check().unwrap_err().to_string()
    };
    assert_eq!(
        terms(DynamicsKind::Fractional, 65),
        "dynamics.denominator: expected at most 64 terms, found 65 terms"
    );
    assert_eq!(
        terms(DynamicsKind::Arx, 4097),
        "dynamics.denominator: expected at most 4096 terms, found 4097 terms"
    );
    let large = with(|file| file.offset.value = -2e100);
    assert_eq!(large, "offset.value: expected a magnitude of at most 1e100, found -2e100");
    let fast = with(|file| file.sample_rate_hz = Some(1e13));
    assert_eq!(fast, "sample_rate_hz: expected a rate from 1e-9 to 1e12 Hz, found 1e13");
}
