//! Saved states in the runtime: what is restored goes on with the same bits, and other bytes change nothing.

#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron_rt::{
    Compensated, Feedback, HeldBack, Hysteresis, Linear, Model, Observer, Operator, RealPoles, SavedError,
    Sections, SectionsMemory, StateLaw,
};

const LAG: [RealPoles<f64>; 1] = [RealPoles { gain: [0.1, 0.01, 0.0, 0.0], weight: [0.7, 0.3, 0.0, 0.0] }];
const MARK: u64 = 0x1234_5678_9abc_def0;

/// Memory of a lag behind a hysteresis with a delay of two samples.
struct Memory {
    law: [StateLaw<f64>; 1],
    z: [hysteron_rt::IncrementMemory<f64>; 1],
    real: [Compensated<f64, 4>; 1],
    delay: [f64; 2],
}

impl Memory {
    fn new() -> Self {
        Self {
            law: [StateLaw::new(0.08, 0.05, 0.01, 1.0).unwrap()],
            z: [hysteron_rt::IncrementMemory::new(0.0)],
            real: [Compensated::zero()],
            delay: [0.0; 2],
        }
    }

    fn model(&mut self) -> Model<'_, f64> {
        let operator = Operator::States { laws: &self.law, memory: &mut self.z };
        let sections = Sections { taps: &[0.1], real: &LAG, pairs: &[], rest_gain: 1.1 };
        let memory = SectionsMemory { real: &mut self.real, pairs: &mut [], delay: &mut self.delay };
        let hysteresis = Hysteresis::new(&[0.3], operator).unwrap();
        Model::new(hysteresis, Linear::new(sections, memory).unwrap(), 2.0).unwrap()
    }
}

fn drive(k: usize) -> f64 {
    40.0 + 30.0 * (0.21 * k as f64).sin()
}

#[test]
fn a_trimmed_model_goes_on_with_the_same_bits() {
    let (mut memory, mut other) = (Memory::new(), Memory::new());
    let (mut model, mut twin) = (memory.model(), other.model());
    model.trim(1.5, -3.0).unwrap();
    for k in 0..57 {
        model.step(drive(k)).unwrap();
    }
    let mut bytes = vec![0; model.saved_bytes()];
    model.save(MARK, &mut bytes).unwrap();
    twin.restore(MARK, &bytes).unwrap();
    for k in 57..200 {
        assert_eq!(model.step(drive(k)).unwrap().to_bits(), twin.step(drive(k)).unwrap().to_bits());
    }
}

#[test]
fn other_bytes_are_refused_and_change_nothing() {
    let (mut memory, mut other) = (Memory::new(), Memory::new());
    let (mut model, mut twin) = (memory.model(), other.model());
    let mut bytes = vec![0; model.saved_bytes()];
    model.step(50.0).unwrap();
    model.save(MARK, &mut bytes).unwrap();
    let expected = bytes.len();
    let found = expected - 1;
    assert_eq!(model.save(MARK, &mut bytes[1..]), Err(SavedError::Length { expected, found }));
    assert_eq!(twin.restore(MARK, &bytes[1..]), Err(SavedError::Length { expected, found }));
    assert_eq!(twin.restore(MARK + 1, &bytes), Err(SavedError::Foreign));
    for k in 0..expected {
        let mut changed = bytes.clone();
        changed[k] ^= 0x10;
        let refused = if k < 12 { SavedError::Foreign } else { SavedError::Damaged };
        assert_eq!(twin.restore(MARK, &changed), Err(refused), "{k}");
    }
    let mut untouched = Memory::new();
    let mut untouched = untouched.model();
    assert_eq!(twin.step(10.0).unwrap().to_bits(), untouched.step(10.0).unwrap().to_bits());
}

#[test]
fn an_observer_and_a_feedback_law_go_on_with_the_same_bits() {
    let (mut memory, mut other) = (Memory::new(), Memory::new());
    let mut observer = Observer::new(memory.model(), 0.2).unwrap();
    let mut twin = Observer::new(other.model(), 0.2).unwrap();
    let mut states = [[Compensated::zero()]; 2];
    let [mut law, mut second] = states.each_mut().map(|real| {
        let sections = Sections { taps: &[0.0], real: &LAG, pairs: &[], rest_gain: 1.0 };
        let memory = SectionsMemory { real, pairs: &mut [], delay: &mut [] };
        Feedback::new(0.4, 0.02, Linear::new(sections, memory).unwrap()).unwrap()
    });
    for k in 0..60 {
        observer.step(drive(k), 20.0 + 0.3 * drive(k)).unwrap();
        law.step(0.1 * drive(k) - 4.0, HeldBack::No);
    }
    let mut bytes = vec![0; observer.saved_bytes()];
    observer.save(MARK, &mut bytes).unwrap();
    twin.restore(MARK, &bytes).unwrap();
    let mut bytes = vec![0; law.saved_bytes()];
    law.save(MARK, &mut bytes).unwrap();
    second.restore(MARK, &bytes).unwrap();
    for k in 60..120 {
        let own = observer.step(drive(k), 20.0 + 0.3 * drive(k)).unwrap();
        assert_eq!(own, twin.step(drive(k), 20.0 + 0.3 * drive(k)).unwrap());
        let error = 0.1 * drive(k) - 4.0;
        assert_eq!(law.step(error, HeldBack::Above).to_bits(), second.step(error, HeldBack::Above).to_bits());
    }
}

#[test]
fn trims_that_are_none_are_refused() {
    let mut memory = Memory::new();
    let mut model = memory.model();
    for (gain, offset) in [(0.0, 1.0), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
        assert!(model.trim(gain, offset).is_err());
    }
    assert_eq!(model.offset(), 2.0);
}
