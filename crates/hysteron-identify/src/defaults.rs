//! Structure by default where the records say more than the usual one can carry.
//!
//! Where small oscillations lie beside wide moves, the small loops of a Bouc–Wen model do not close: a small oscillation moves its
//! level for as long as it lasts. Plays, which remember reversals, have no such drift, and what goes on between milliseconds and
//! seconds is creep, told from the loops by their frequency. Few cycles determine few weights: those of a plane are spent on the levels
//! that single cycles leave, and miss those of the next ones; a dozen plays, drawn together by as much as cycles left out in turn ask
//! for, do not. `hysteron-study afm` compares the families on such a device.

use hysteron_model::dynamics::Creep;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::record::span;

use super::facts::RecordFacts;
use super::options::{Choice, DynamicsChoice, Method, Options};

/// Oscillations of less than this share of the range of the drive are small.
const SMALL: f64 = 0.1;
/// Plays.
const PLAYS: usize = 12;
/// Elements of the creep, and degree of the polynomial: higher ones are wrong where later drives go a little farther.
const ELEMENTS: usize = 3;
const DEGREE: usize = 3;

/// Amplitude of the smallest oscillation that lies beside wide moves in one record, and that of these; `None` where there is none.
pub(super) fn beside_wide_moves(facts: &[RecordFacts]) -> Option<(f64, f64)> {
    let of = |facts: &RecordFacts| {
        let wide = 0.5 * span(&facts.data.u);
        let oscillations = facts.data.segments().into_iter().filter(|s| s.gain.is_some());
        let smallest = oscillations.map(|s| s.amplitude).reduce(f64::min)?;
        (smallest < SMALL * wide).then_some((smallest, wide))
    };
    facts.iter().filter_map(of).reduce(|a, b| if b.0 < a.0 { b } else { a })
}

/// The options with what they leave open.
pub(super) fn resolved(facts: &[RecordFacts], options: &Options) -> Options {
    let given = matches!(options.hysteresis, Choice::Given(_)) || options.start.is_some();
    let family = |form| Options { hysteresis: Choice::Given(form), ..options.clone() };
    if given || options.method != Method::Joint || beside_wide_moves(facts).is_none() {
        return family(options.family());
    }
    let plays = family(HysteresisForm::PrandtlIshlinskii { plays: PLAYS });
    let degree = match options.degree {
        Choice::Auto => Choice::Given(DEGREE),
        given => given,
    };
    let plays = Options { degree, ..plays };
    if options.dynamics != DynamicsChoice::Auto || options.creep != Creep::None {
        return plays;
    }
    let creep = Creep::KelvinVoigt { elements: ELEMENTS };
    Options { dynamics: DynamicsChoice::Integer, order: 1, creep, ..plays }
}
