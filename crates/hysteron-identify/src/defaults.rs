//! Default structure for records that the usual one cannot describe.
//!
//! The minor loops of the default family do not close: a small oscillation after large moves drifts for as
//! long as it lasts. And creep follows large moves but not small ones, which linear creep after the
//! hysteresis cannot describe. Plays with activated edges do both: they remember reversals, and creep
//! depending on how the drive came to rest. The residual at the small oscillations, a falling gain with a
//! small phase lag at every frequency, belongs to the dynamics: a fractional order describes it, a lag does
//! not. `hysteron-study afm` compares families and dynamics on such a device.

use hysteron_model::dynamics::Creep;
use hysteron_model::hysteresis::HysteresisForm;

use super::facts::RecordFacts;
use super::options::{Choice, DynamicsChoice, FamilyChoice, Method, Options};

/// Oscillations of less than this share of the range of the drive are small.
const SMALL: f64 = 0.1;
/// Degree of the polynomial.
const DEGREE: usize = 2;

/// Amplitude of the smallest oscillation in a record with large moves, and that of these; `None` where there
/// is none.
pub(super) fn beside_wide_moves(facts: &[RecordFacts]) -> Option<(f64, f64)> {
    let of = |facts: &RecordFacts| {
        let wide = 0.5 * facts.range_v();
        let oscillations = facts.data.segments().into_iter().filter(|s| s.gain.is_some());
        let smallest = oscillations.map(|s| s.amplitude).reduce(f64::min)?;
        (smallest < SMALL * wide).then_some((smallest, wide))
    };
    facts.iter().filter_map(of).reduce(|a, b| if b.0 < a.0 { b } else { a })
}

/// The options with open choices resolved.
pub(super) fn resolved(facts: &[RecordFacts], options: &Options) -> Options {
    let given = matches!(options.hysteresis, FamilyChoice::Given(_)) || options.start.is_some();
    let family = |form| Options { hysteresis: FamilyChoice::Given(form), ..options.clone() };
    if given || options.method != Method::Joint || beside_wide_moves(facts).is_none() {
        return family(options.family());
    }
    let degree = match options.degree {
        Choice::Auto => Choice::Given(DEGREE),
        given => given,
    };
    let plays = Options { degree, ..family(HysteresisForm::activated_plays()) };
    if options.dynamics != DynamicsChoice::Auto || options.creep != Creep::None {
        return plays;
    }
    Options { dynamics: DynamicsChoice::Fractional, ..plays }
}
