//! Frequency responses from files: what is read, what is refused and how.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::path::{Path, PathBuf};

use hysteron_io::{IoError, ResponseOptions, read_frequency_response, read_frequency_response_bytes};
use hysteron_model::record::FrequencyResponse;
use hysteron_numeric::Complex64;
use proptest::prelude::*;

fn read(text: &str, response: Option<&str>, over: Option<&str>) -> Result<FrequencyResponse, IoError> {
    let named = |name: Option<&str>| name.map(str::to_owned);
    let options = ResponseOptions { response: named(response), over: named(over), max_bytes: None };
    read_frequency_response_bytes("frf.csv", text.as_bytes(), &options)
}

#[test]
fn every_form_of_a_complex_number_is_read_to_the_same_value() {
    // 2i at 1 Hz and −0.5 at 10 Hz.
    for text in [
        "f_Hz,re,im\n1,0,2\n10,-0.5,0\n",
        "freq_kHz,real,imag\n0.001,0,2\n0.01,-0.5,0\n",
        "omega_rad_per_s,re,im\n6.283185307179586,0,2\n62.83185307179586,-0.5,0\n",
        "frequency,magnitude,phase_deg\n1,2,90\n10,0.5,-180\n",
        "f,abs,phase\n1,2,90\n10,0.5,180\n",
        "f_Hz,mag_dB,phase_rad\n1,6.020599913279624,1.5707963267948966\n\
         10,-6.020599913279624,3.141592653589793\n",
        "f [Hz];magnitude [dB];phase [deg]\n10;-6,020599913279624;180\n1;6,020599913279624;90\n",
        "f_Hz,note,im,re\n10,7,0,-0.5\n1,8,2,0\n",
    ] {
        let found = read(text, None, None).unwrap();
        assert!((found.frequency_hz[0] - 1.0).abs() < 1e-12 && (found.frequency_hz[1] - 10.0).abs() < 1e-12);
        let expected = [Complex64::new(0.0, 2.0), Complex64::new(-0.5, 0.0)];
        for (value, expected) in found.values.iter().zip(expected) {
            assert!((value - expected).norm() < 1e-14, "{text}: {value}");
        }
        assert!(found.std_dev.is_none() && found.source.is_some());
    }
}

#[test]
fn units_uncertainties_and_several_responses_are_told_apart() {
    let text =
        "f_Hz,stage_re_um_per_V,stage_im_um_per_V,stage_std,amp_re,amp_im\n2,4,0,0.1,2,0\n1,0,6,0.2,3,0\n";
    let stage = read(text, Some("stage"), None).unwrap();
    assert_eq!((stage.name.as_str(), stage.unit.as_str()), ("stage", "um_per_V"));
    assert_eq!(stage.std_dev, Some(vec![0.2, 0.1]));
    let ratio = read(text, Some("stage"), Some("amp")).unwrap();
    assert_eq!(ratio.values, [Complex64::new(0.0, 2.0), Complex64::new(2.0, 0.0)]);
    assert_eq!(ratio.name, "stage over amp");
}

#[test]
fn unusable_files_are_refused_with_the_place_and_the_remedy() {
    let two = "f_Hz,a_re,a_im,b_re,b_im\n1,1,1,1,1\n2,1,1,1,1\n";
    for (text, response, parts) in [
        ("t_s,u_V,y_um\n0,1,2\n", None, &["line 1", "no frequency", "f_Hz,re,im"][..]),
        ("f_Hz,magnitude\n1,2\n", None, &["line 1", "no complex response", "magnitude and phase"]),
        ("f_Hz,re\n1,2\n", None, &["no complex response", "real and imaginary"]),
        (two, None, &["2 responses", "`a`, `b`", "ChooseResponse"]),
        (two, Some("c"), &["no response `c`", "`a`, `b`"]),
        ("f_Hz,re,im\n1,2,3\n0,2,3\n", None, &["line 3, column 1 (`f_Hz`)", "found `0`", "above 0"]),
        ("f_Hz,re,im\n1,2,3\n2,x,3\n", None, &["line 3, column 2 (`re`)", "found `x`, expected a number"]),
        ("f_Hz,re,im\n1,2,3\n2,NaN,3\n", None, &["line 3, column 2 (`re`)", "not a finite number"]),
        ("f_Hz,re,im\n1,2,3\n1,2,3\n", None, &["two lines at 1 Hz"]),
        ("f_Hz,re,im,std\n1,2,3,0\n2,2,3,1\n", None, &["1 Hz", "standard deviation is 0"]),
        ("f_Hz,re,im\n", None, &["has a header (line 1)"]),
        ("", None, &["is empty"]),
    ] {
        let error = read(text, response, None).unwrap_err();
        let message = format!("{error} [{:?}]", error.advice());
        for part in parts.iter().chain(&["frf.csv"]) {
            assert!(message.contains(part), "{text:?}: {part:?} is not in {message}");
        }
    }
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = read_frequency_response_bytes("x", &bytes, &ResponseOptions::default());
    }

    #[test]
    fn arbitrary_tables_never_panic_and_what_is_accepted_is_sound(
        header in "(f|f_Hz|omega_rad_per_s|é)[,;\t](re|mag|magnitude_dB|İ_re|a_re)[,;\t]\
            (im|phase|phase_rad|İ_im|a_im)([,;\t](std|sigma|x))?",
        rows in "([-+0-9.e]{0,5}[,;\t][-+0-9.e]{0,5}[,;\t][-+0-9.e]{0,5}([,;\t][0-9.]{0,3})?\r?\n){0,5}",
        name in prop::option::of("[a-z]{0,2}"),
    ) {
        let text = format!("{header}\n{rows}");
        match read(&text, name.as_deref(), name.as_deref()) {
            Ok(response) => prop_assert!(response.check().is_ok()),
            Err(err) => prop_assert!(err.to_string().contains("frf.csv") && err.to_string().len() < 2000),
        }
    }
}

#[test]
fn the_measured_stage_over_its_amplifier_reads_as_described() {
    let folder = std::env::var_os("HYSTERON_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let file = folder.join("piezo-npxy100a-frf/frf_x_axis.csv");
    if !file.exists() {
        println!("skipped: no file {}; set HYSTERON_DATA to the public data", file.display());
        return;
    }
    let options =
        ResponseOptions { response: Some("stage".into()), over: Some("ampV".into()), max_bytes: None };
    let found = read_frequency_response(&file, &options).unwrap();
    assert_eq!((found.len(), found.range_hz().0.round()), (302, 1.0));
    let low = found.band(1.0, 30.0);
    assert_eq!(low.len(), 50);
    // Practically constant phase, as its description says.
    assert!(low.phase_deg().iter().all(|p| (-5.2..-4.3).contains(p)), "{:?}", low.phase_deg());
}
