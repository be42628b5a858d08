//! Model files: as bytes, and whole files with some of their values changed.

use std::path::Path;
use std::sync::LazyLock;

use hysteron_model::Model;
use hysteron_model::Start;
use hysteron_model::axes::AxesRecord;
use hysteron_model::model::Signals;
use hysteron_model::realise::{RealiseOptions, realise};
use hysteron_model::record::{InputOutput, TimeBase, Unit};
use serde_json::{Value, json};

use crate::numbers::Bytes;

const SAMPLES: usize = 16;

/// Whole model files, one of every kind.
static FILES: LazyLock<Vec<Value>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/model");
    let mut paths: Vec<_> =
        std::fs::read_dir(&folder).expect("the corpus is there").flatten().map(|e| e.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "json"));
    paths.sort();
    let read = |path| serde_json::from_slice(&std::fs::read(path).expect("a file of the corpus"));
    paths.iter().map(|path| read(path).expect("a model file")).collect()
});

pub fn file(data: &[u8]) {
    if let Ok(model) = Model::from_json(data) {
        use_it(&model, data);
    }
}

/// Which file, then how values in it change.
pub fn numbers(data: &[u8]) {
    let mut bytes = Bytes(data);
    let mut file = FILES[usize::from(bytes.byte()) % FILES.len()].clone();
    for _ in 0..8 {
        if bytes.is_empty() {
            break;
        }
        let which = u16::from_le_bytes([bytes.byte(), bytes.byte()]);
        change(&mut file, usize::from(which), &mut bytes);
    }
    let text = file.to_string();
    if let Ok(model) = Model::from_json(text.as_bytes()) {
        use_it(&model, data);
    }
}

/// Changes the `which`-th value of those below, counted around.
fn change(value: &mut Value, which: usize, bytes: &mut Bytes<'_>) {
    let mut left = which % count(value);
    if let Some(found) = nth(value, &mut left) {
        let kind = bytes.byte();
        let around = found.as_f64().unwrap_or(1.0);
        match (kind % 8, &mut *found) {
            (0, _) => *found = Value::Null,
            (1, Value::Array(list)) => {
                if let Some(last) = list.last().cloned() {
                    list.extend(std::iter::repeat_n(last, usize::from(kind / 8)));
                }
            }
            (2, Value::Array(list)) => drop(list.pop()),
            (2, Value::Object(map)) => {
                let name = map.keys().nth(usize::from(kind / 8)).cloned();
                name.and_then(|name| map.remove(&name));
            }
            (3, Value::String(text)) => text.push(char::from(bytes.byte())),
            (4, _) => *found = json!(i64::from(bytes.byte()) - 128),
            _ => *found = json!(bytes.number(around)),
        }
    }
}

fn count(value: &Value) -> usize {
    match value {
        Value::Array(list) => 1 + list.iter().map(count).sum::<usize>(),
        Value::Object(map) => 1 + map.values().map(count).sum::<usize>(),
        _ => 1,
    }
}

fn nth<'v>(value: &'v mut Value, left: &mut usize) -> Option<&'v mut Value> {
    if *left == 0 {
        return Some(value);
    }
    *left -= 1;
    match value {
        Value::Array(list) => list.iter_mut().find_map(|value| nth(value, left)),
        Value::Object(map) => map.values_mut().find_map(|value| nth(value, left)),
        _ => None,
    }
}

/// A model that was read is written and read the same, and simulates to finite numbers or is refused.
fn use_it(model: &Model, data: &[u8]) {
    let text = model.to_json().expect("a model that was read is written");
    let again = match Model::from_json(text.as_bytes()) {
        Ok(again) => again,
        Err(e) => panic!("what was written is refused: {e}"),
    };
    assert_eq!(again.to_json().expect("as before"), text);
    if let Ok(found) = model.simulate(&signals(model), Start::AsIdentified) {
        assert!(found.outputs.iter().flatten().all(|y| y.is_finite()), "the simulation is not finite");
    }
    // Takes longer than all else together: one in 64, by no byte of its own, or all that is kept would have it.
    let sum = data.iter().fold(0, |sum: u8, byte| sum.wrapping_mul(31).wrapping_add(*byte));
    if sum % 64 == 1
        && let Model::Hammerstein(body) = model
    {
        let rate = model.sample_rate_hz().unwrap_or(1e4);
        if let Ok(found) = realise(body.law(), rate, &RealiseOptions::default()) {
            assert!(found.sample_rate_hz == rate);
        }
    }
}

fn signals(model: &Model) -> Signals {
    let range = model.valid_range().map_or([0.0, 10.0], |range| [range.input.low, range.input.high]);
    let rate = model.sample_rate_hz().unwrap_or(1e4);
    let time = TimeBase::uniform(rate);
    let u: Vec<f64> = (0..SAMPLES).map(|k| range[0] + (range[1] - range[0]) * (k % 7) as f64 / 6.0).collect();
    let units = model.units();
    let (u_unit, y_unit) = (Unit::new(&units.input), Unit::new(&units.output));
    match model.channels() {
        Some((inputs, outputs)) => Signals::Several(AxesRecord {
            name: "drive".into(),
            time,
            sample_rate_hz: rate,
            u: vec![u; inputs.len()],
            y: Vec::new(),
            valid: None,
            inputs: inputs.to_vec(),
            outputs: outputs.to_vec(),
            u_unit,
            y_unit,
            source: None,
        }),
        None => Signals::Single(InputOutput {
            name: "drive".into(),
            time,
            u,
            y: Vec::new(),
            rate: None,
            valid: None,
            input: "u".into(),
            output: "y".into(),
            u_unit,
            y_unit,
            source: None,
        }),
    }
}
