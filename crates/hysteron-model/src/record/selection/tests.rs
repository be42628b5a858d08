use super::*;

fn record(headers: &[&str]) -> Record {
    let channels = headers
        .iter()
        .enumerate()
        .map(|(i, h)| {
            let (name, unit) = super::super::split_header(h);
            Channel { name, unit, samples: vec![i as f64, i as f64 + 1.0, i as f64 + 2.0] }
        })
        .collect();
    Record::new("bench.csv", TimeBase::uniform(100.0), channels).unwrap()
}

fn chosen(headers: &[&str], input: Option<&str>, output: Option<&str>) -> (String, String, usize) {
    let choice = ChannelChoice { input: input.map(str::to_string), output: output.map(str::to_string) };
    let r = record(headers);
    let s = r.select(&choice).unwrap();
    (r.channels[s.input].header(), r.channels[s.output].header(), s.notes.len())
}

fn refused(headers: &[&str], input: Option<&str>, output: Option<&str>) -> RecordError {
    let choice = ChannelChoice { input: input.map(str::to_string), output: output.map(str::to_string) };
    record(headers).select(&choice).unwrap_err()
}

#[test]
fn default_rules_pick_the_channels_a_reader_would() {
    for (headers, input, output, notes) in [
        (&["u_V", "y_um"][..], "u_V", "y_um", 0),
        (&["y_um", "u_V"], "u_V", "y_um", 0),
        (&["u", "y"], "u", "y", 0),
        (&["u_N", "y_m"], "u_N", "y_m", 0),
        (&["u_V", "y_um", "segment"], "u_V", "y_um", 0),
        (&["u_V", "half_fringe_count", "dy_um"], "u_V", "dy_um", 0),
        (&["u_cmd_V", "u_meas_V", "y_mm", "i_meas_mA"], "u_cmd_V", "y_mm", 1),
        (&["H_A_per_m", "B_T"], "H_A_per_m", "B_T", 1),
        (&["Voltage [V]", "Displacement [um]", "T_degC"], "Voltage_V", "Displacement_um", 0),
        (&["amp_mV", "stage_urad", "B_T"], "amp_mV", "stage_urad", 0),
    ] {
        assert_eq!(
            chosen(headers, None, None),
            (input.to_string(), output.to_string(), notes),
            "{headers:?}"
        );
    }
}

#[test]
fn a_choice_overrules_by_bare_name_by_header_and_ignoring_case() {
    let headers = ["u_cmd_V", "u_meas_V", "y_mm"];
    assert_eq!(chosen(&headers, Some("u_meas"), None).0, "u_meas_V");
    assert_eq!(chosen(&headers, Some("u_meas_V"), Some("Y_MM")).0, "u_meas_V");
    assert_eq!(chosen(&["H_A_per_m", "B_T"], Some("B"), None).1, "H_A_per_m");
    assert_eq!(chosen(&["H_A_per_m", "B_T"], None, Some("H")).0, "B_T");
}

#[test]
fn several_axes_are_an_error_that_lists_them_and_advises_the_first() {
    let headers = ["u1_V", "u2_V", "u3_V", "y1_nm", "y2_nm", "y3_nm"];
    let choose = |role, example: &str| Some(Advice::ChooseColumn { role, example: Some(example.to_owned()) });
    let error = refused(&headers, None, None);
    for part in ["bench.csv", "`u1` (V), `u2` (V), `u3` (V)", "input"] {
        assert!(error.to_string().contains(part), "{error}");
    }
    assert_eq!(error.advice(), choose(ColumnRole::Input, "u1_V"));
    let error = refused(&headers, Some("u2"), None);
    assert!(error.to_string().contains("`y1` (nm), `y2` (nm), `y3` (nm)"), "{error}");
    assert_eq!(error.advice(), choose(ColumnRole::Output, "y1_nm"));
    assert_eq!(chosen(&headers, Some("u2"), Some("y3_nm")), ("u2_V".to_string(), "y3_nm".to_string(), 0));
}

#[test]
fn missing_and_equal_channels_are_named() {
    let text = refused(&["u_V", "y_um"], Some("x"), None).to_string();
    assert!(text.contains("no channel `x`") && text.contains("`u` (V), `y` (µm)"), "{text}");
    assert!(matches!(refused(&["u_V", "y_um"], Some("u"), Some("u")), RecordError::SameChannel { .. }));
    let text = refused(&["photodiode_V"], None, None).to_string();
    assert!(text.contains("only one channel") && text.contains("`photodiode` (V)"), "{text}");
    assert!(matches!(
        refused(&["a", "b", "c"], None, None),
        RecordError::NoCandidate { role: ColumnRole::Input, .. }
    ));
}

#[test]
fn a_force_beside_a_displacement_and_its_rate_is_the_output() {
    assert_eq!(chosen(&["x_mm", "v_mm_per_s", "F_kN"], None, None), ("x_mm".into(), "F_kN".into(), 0));
    assert_eq!(
        chosen(&["torque_Nm", "angle_deg", "i_A"], None, None),
        ("angle_deg".into(), "torque_Nm".into(), 0)
    );
    // A drive is one, whatever stands beside it.
    assert_eq!(chosen(&["u_V", "x_mm", "F_N"], None, None).0, "u_V");
    assert!(matches!(refused(&["x_mm", "z_mm", "F_N"], None, None), RecordError::NoCandidate { .. }));
}

#[test]
fn wrong_units_are_refused_or_noted() {
    let text = refused(&["u_V", "y_ms"], None, None).to_string();
    for part in ["`y_ms`", "in ms", "output", "length"] {
        assert!(text.contains(part), "{text}");
    }
    let r = record(&["u_V", "y_V"]);
    let notes = r.select(&ChannelChoice::default()).unwrap().notes;
    assert_eq!(notes[0].advice, Some(Advice::ScaleColumn { column: "y".to_owned() }));
    let r = record(&["u_um", "y_V"]);
    let notes = r.select(&ChannelChoice::default()).unwrap().notes;
    assert!(notes[0].text.contains("swapped"), "{notes:?}");
}

#[test]
fn units_are_converted_on_the_way_into_a_fit() {
    let io = record(&["u_mV", "y_nm"]).input_output(&ChannelChoice::default()).unwrap();
    assert_eq!(io.u, [0.0, 1e-3, 2e-3]);
    assert_eq!(io.y, [1e-3, 2e-3, 3e-3]);
    assert_eq!((io.u_unit.symbol(), io.y_unit.symbol()), ("V", "um"));
    let io = record(&["u_N", "y_mrad"]).input_output(&ChannelChoice::default()).unwrap();
    assert_eq!(io.y, [1e3, 2e3, 3e3]);
    assert_eq!((io.u_unit.symbol(), io.y_unit.symbol()), ("N", "urad"));
}

#[test]
fn the_drive_beside_a_displacement_is_the_other_channel() {
    assert_eq!(record(&["x_mm", "F_N"]).drive(None).unwrap().name, "F");
}

#[test]
fn a_drive_alone_is_enough_for_a_simulation() {
    let drive = record(&["photodiode_mV"]).drive(None).unwrap();
    assert_eq!((drive.samples[1], drive.unit.symbol()), (1e-3, "V"));
    assert!(matches!(
        record(&["u1_V", "u2_V"]).drive(None).unwrap_err(),
        RecordError::AmbiguousChannel { .. }
    ));
}
