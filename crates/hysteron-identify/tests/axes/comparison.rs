//! A comparison of structures that was interrupted goes on, and ends with the same bits.

use std::ops::ControlFlow;

use hysteron_identify::modes::{ModesCandidate, Options, compare_modes};
use hysteron_identify::{Event, IdentifyError, Searches, Watch};

use crate::device::{HIGH, LOW, linear_device, record_of};

#[test]
fn a_resumed_comparison_takes_what_is_finished_and_ends_with_the_same_bits() {
    let device = linear_device();
    let records =
        [(LOW, 1), (LOW, 2), (HIGH, 3), (HIGH, 4)].map(|(level, seed)| record_of(&device, level, seed, 0.02));
    let candidates = ["modes2+linear", "modes3+linear"].map(|name| name.parse::<ModesCandidate>().unwrap());
    let options = Options { steps: 1, ..Options::default() };
    let whole = compare_modes(&records, &candidates, &options, &Watch::silent(), None).unwrap();
    // Stopped within the second fit of the second candidate.
    let mut kept: Option<Searches> = None;
    let watch = Watch::new(|event: &Event<'_>| {
        let Some(state) = event.searches() else { return ControlFlow::Continue(()) };
        let finished = state.modes_comparison.as_ref().map_or(0, |found| found.fits.len());
        let within = state.modes.as_ref().is_some_and(|modes| modes.iteration > 0);
        kept = Some(state);
        if finished == 4 && within { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let stopped = compare_modes(&records, &candidates, &options, &watch, None).unwrap();
    drop(watch);
    assert!(stopped.interrupted && stopped.entries.len() == 1);
    let state = serde_json::to_string(&kept.unwrap()).unwrap();
    let state: Searches = serde_json::from_str(&state).unwrap();
    let mut fits = Vec::new();
    let watch = Watch::new(|event: &Event<'_>| {
        fits.push(event.stage.to_owned());
        ControlFlow::Continue(())
    });
    let resumed = compare_modes(&records, &candidates, &options, &watch, Some(state.clone())).unwrap();
    drop(watch);
    assert_eq!(resumed.summary(), whole.summary());
    // Two fits of the second candidate are left.
    assert_eq!(fits.iter().filter(|stage| *stage == "frequency response").count(), 2, "{fits:?}");
    let other = compare_modes(&records[..3], &candidates, &options, &Watch::silent(), Some(state));
    assert!(matches!(other, Err(IdentifyError::Resume)));
}
