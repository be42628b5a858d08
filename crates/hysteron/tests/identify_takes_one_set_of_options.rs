//! Options that would count for nothing are refused before anything is fitted.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron::{Error, HysteresisForm, Identify, Kind, Task};

#[test]
fn options_beside_a_task_or_another_kind_are_refused() {
    let task = Task::of(Kind::Hammerstein);
    let both = Identify::new(&[]).task(task).seed(7).run();
    assert!(matches!(both, Err(Error::OptionsOfTask)), "{both:?}");
    let family = HysteresisForm::PrandtlIshlinskii { plays: 8 };
    let other = Identify::new(&[]).kind(Kind::Oscillator).hysteresis(family).run();
    assert!(matches!(other, Err(Error::OptionsOfKind { kind: Kind::Oscillator })), "{other:?}");
    // Without them the records are looked at.
    assert!(matches!(Identify::new(&[]).run(), Err(Error::Identify(_))));
}
