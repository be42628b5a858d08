//! Options are data: as JSON and back they are the same, and what is left out is the default.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron::{Cut, Limits, Precision, Prepare, ReadOptions, Rename, Scoring, Target, Turns};
use hysteron_identify::frequency_response::empirical::EmpiricalOptions;
use hysteron_identify::online::{FollowMethod, FollowOptions, Term};
use hysteron_identify::{Options, coupled, modes, oscillator};
use hysteron_io::ResponseOptions;
use hysteron_model::compensator::{CompensatorOptions, Prediction};
use hysteron_model::invert::InverseOptions;
use hysteron_model::realise::RealiseOptions;
use hysteron_model::record::ChannelChoice;
use hysteron_model::tracking::TrackOptions;
use hysteron_model::{Memory, Start};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

fn comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(options: T) {
    let text = serde_json::to_string(&options).unwrap();
    assert_eq!(serde_json::from_str::<T>(&text).unwrap(), options, "{text}");
}

/// And an empty object is the default.
fn defaults<T: Serialize + DeserializeOwned + PartialEq + Debug + Default>() {
    comes_back(T::default());
    assert_eq!(serde_json::from_str::<T>("{}").unwrap(), T::default());
    assert!(serde_json::from_str::<T>(r#"{"no_such_option": 1}"#).is_err());
}

#[test]
fn options_come_back() {
    defaults::<Options>();
    defaults::<oscillator::Options>();
    defaults::<modes::Options>();
    defaults::<coupled::Options>();
    defaults::<Scoring>();
    defaults::<CompensatorOptions>();
    defaults::<RealiseOptions>();
    defaults::<TrackOptions>();
    defaults::<ChannelChoice>();
    defaults::<EmpiricalOptions>();
    defaults::<ReadOptions>();
    defaults::<Cut>();
    defaults::<Turns>();
    defaults::<Prepare>();
    defaults::<ResponseOptions>();
    comes_back(Prediction::Band { highest_hz: 30.0, noise: 1e-3 });
    comes_back(FollowOptions {
        method: FollowMethod::LeastSquares { memory_s: Some(2.0) },
        terms: vec![Term::Offset, Term::Power(2), Term::Creep { lag_s: 10.0 }],
        noise: 0.01,
        every: None,
        run_length: 1e6,
        reopen: true,
    });
    let cut = Cut {
        from_s: Some(0.1),
        to_s: None,
        conditions: ["segment=2..7", "f=..3", "mode=ramp"].map(|text| text.parse().unwrap()).to_vec(),
        turns: Some("1:5".parse().unwrap()),
    };
    comes_back(cut.clone());
    let rename: Rename = "ch1=u_V".parse().unwrap();
    comes_back(ReadOptions { rename: vec![rename], cut, ..ReadOptions::default() });
    comes_back(Prepare {
        scales: vec!["y=2.5um/V".parse().unwrap()],
        remove_mean: vec!["u".into()],
        detrend: vec!["y".into()],
        sample_rate_hz: Some(500.0),
    });
    comes_back(Target::C { float: Precision::F32 });
    comes_back(Target::Fmu);
    comes_back(Target::Matlab);
    comes_back(Target::Simulink { float: Precision::F64 });
}

#[test]
fn a_rate_without_limit_is_null() {
    for limits in [Limits::range(0.0, 10.0), Limits::range(0.0, 10.0).slew(5e3)] {
        comes_back(limits);
    }
    comes_back(InverseOptions { start: Start::PERIODIC, ..InverseOptions::within([0.0, 10.0]) });
    let text = serde_json::to_string(&Limits::range(0.0, 10.0)).unwrap();
    assert_eq!(text, r#"{"low":0.0,"high":10.0,"slew_v_per_s":null}"#);
}

#[test]
fn starts_come_back() {
    let remembering = Start::Remembering { voltage_v: 1.5, memory: Memory::VirginAt(0.0) };
    for start in [Start::AsIdentified, Start::ZERO, remembering, Start::settled(200), Start::PERIODIC] {
        comes_back::<Start>(start);
    }
}
