//! Findings of a fit about the device, and parameters that the records leave undetermined, in plain words.

use super::defaults::beside_wide_moves;
use super::facts::amplitudes;
use super::joint::{Smoothing, excess_if_held};
use super::options::{Choice, Method, Options, RecordRole};
use super::parameter::ParameterRole;
use super::precision::{precision, still_improving};
use super::result::{Identification, RecordFit};
use super::treatment::treatment;
use super::{Finding, FindingKind};
use super::{IdentifyError, RecordFacts, identifiability};
use hysteron_model::Advice;
use hysteron_model::dynamics::{Dynamics, Stability, TransferFunction, stability};
use hysteron_model::hysteresis::{Hysteresis, Invertibility, Place, TimedDrive};
use hysteron_model::model::FAR_FROM_REST;
use hysteron_model::record::{
    LoopSense, Timing, follow_each_other, implausible_units, loop_shape, range_of, turning_points,
};
use hysteron_numeric::display::short;

/// Appends a finding.
pub(crate) fn say<'a>(
    findings: &'a mut Vec<Finding>,
    kind: FindingKind,
    topic: &'static str,
    text: String,
) -> &'a mut Finding {
    let last = findings.len();
    findings.push(Finding::new(kind, topic, text));
    &mut findings[last]
}

/// Every record must be explained as well as `options` demand.
///
/// # Errors
/// [`IdentifyError::ModelClass`] where a record is explained worse than `options` demand.
pub(super) fn require_fit(
    fits: &[RecordFit],
    facts: &[RecordFacts],
    options: &Options,
) -> Result<(), IdentifyError> {
    let worst = fits
        .iter()
        .min_by(|a, b| a.fit_percent().total_cmp(&b.fit_percent()))
        .filter(|worst| worst.fit_percent() < options.least_fit_percent);
    let Some(worst) = worst else { return Ok(()) };
    let because = facts.iter().find(|f| f.data.name == worst.data.name).map(why_no_fit);
    Err(IdentifyError::ModelClass {
        record: worst.data.name.clone(),
        fit_percent: worst.fit_percent(),
        need: options.least_fit_percent,
        because: because.unwrap_or_default(),
    })
}

/// Possible reason why the model class cannot describe a record.
pub(super) fn why_no_fit(facts: &RecordFacts) -> String {
    let (u, y) = (&facts.data.u, &facts.data.y);
    let threshold = 0.1;
    let reversals = |x: &[f64]| {
        let (low, high) = range_of(x);
        turning_points(x, threshold * (high - low)).len()
    };
    let (of_u, of_y) = (reversals(u), reversals(y));
    let unit = |u: &hysteron_model::record::Unit| {
        if u.symbol().is_empty() { "no unit".to_owned() } else { u.to_string() }
    };
    if of_y >= 2 * of_u.max(1) {
        format!(
            "The output reverses {of_y} times while the input reverses {of_u} times: a butterfly loop, as of \
             a ferroelectric driven through its polarisation reversal, or a response that something else \
             drives too"
        )
    } else {
        format!(
            "The output ({}) is not a loop over the input ({}) that follows its last turning points: the \
             record may carry dynamics of its own, belong to a linear device, be driven by further inputs, \
             saturate, or have its dynamics inside the hysteresis",
            unit(&facts.data.y_unit),
            unit(&facts.data.u_unit)
        )
    }
}

/// Delay identified for a linearly interpolated drive, where the rule between samples was not tested and a
/// zero-order hold would change the delay by more than its standard error.
fn delay_of_a_held_drive(options: &Options, result: &Identification) -> Option<String> {
    let excess_s = excess_if_held(options, result)?;
    let delay = result.parameters.iter().find(|p| p.role == ParameterRole::Delay)?;
    (excess_s > delay.std_error?).then(|| {
        let reason = match result.model.dynamics {
            Dynamics::None => "a model without dynamics does",
            _ => "records sampled this finely do",
        };
        format!(
            "The inter-sample behaviour of the drive was not tested: {reason} not determine it. It is taken \
             to be {}. If each sample is held until the next, the delay of {} s is up to {} s too long; \
             its interval covers that. Give the rule where it is known.",
            result.model.inter_sample,
            short(delay.value),
            short(excess_s)
        )
    })
}

/// DC gain that differs from the gain at the lowest frequency of the records.
fn extrapolated_to_rest(g: &TransferFunction, lowest_hz: f64) -> Option<String> {
    let over = g.dc_gain_over(lowest_hz);
    (over.is_finite() && over.max(1.0 / over) > FAR_FROM_REST).then(|| {
        format!(
            "At rest the model's gain is {} times that at {} Hz, the lowest frequency of these records: it \
             is extrapolated there. Do not use it for slower motion or levels that are held. Add a slow \
             record, or one with held levels; or take another hysteresis family: what the loop misses goes \
             into the dynamics.",
            short_share(over),
            short(lowest_hz)
        )
    })
}

/// Whether a parameter ended at the lower limit of its range, and that limit is 0 or next to it.
fn ends_at_zero(range: &hysteron_optimize::Range, x: f64) -> bool {
    range.to_unit(x) < 1e-4 && (0.0..=1e-4 * range.high).contains(&range.low)
}

/// Whether 0 is a legitimate value of a parameter: of the delay, and of a shape number per unit of the drive,
/// at which a branch is straight.
fn may_be_zero(result: &Identification, name: &str) -> bool {
    let form = result.model.hysteresis.form();
    let is_rate = |place: Place| {
        let numbers = form.model_numbers();
        numbers.iter().any(|number| number.place == place && number.unit.input < 0)
    };
    let named = result.parameters.iter().find(|p| p.name == name);
    named.is_some_and(|p| match p.role {
        ParameterRole::Delay => true,
        ParameterRole::Hysteresis(place @ Place::Shape(_)) => is_rate(place),
        _ => false,
    })
}

/// Two digits.
fn short_share(x: f64) -> String {
    short(format!("{x:.1e}").parse().unwrap_or(x))
}

/// Finding on the roughness penalty of the weights of a plane and the held-out error that chose it.
fn drawn_together(Smoothing { share, left_out, left_out_without }: Smoothing) -> String {
    let without = short(left_out_without);
    if share == 0.0 {
        return format!(
            "The weights have no roughness penalty: cross-validation on parts of the records chose none \
             (weighted error {without})."
        );
    }
    format!(
        "The weights are smoothed by a roughness penalty ({} of the one that weighs as much as the records), \
         chosen by cross-validation on parts of the records: weighted error {} instead of {without}.",
        short(share),
        short(left_out),
    )
}

pub(super) fn write(facts: &[RecordFacts], options: &Options, result: &mut Identification) {
    let mut findings = Vec::new();
    let fitted_statically: Vec<(&RecordFacts, &RecordFit)> =
        facts.iter().zip(&result.records).filter(|(_, r)| r.role == RecordRole::QuasiStatic).collect();

    if let Some((_, fit)) = fitted_statically.first() {
        let sense = match loop_shape(&fit.data.u, &fit.data.y).and_then(|shape| shape.sense) {
            Some(LoopSense::CounterClockwise) => {
                "counter-clockwise: the output lags the input, as real actuators do"
            }
            Some(LoopSense::Clockwise) => {
                "clockwise: the output leads the input. Check the sign and the order of the channels"
            }
            None => "too narrow to have a sense",
        };
        say(&mut findings, FindingKind::Verdict, "loop sense", format!("The measured loop runs {sense}."));
    }
    let records: Vec<_> = facts.iter().map(|f| &f.data).collect();
    if !options.continued && follow_each_other(&records) {
        let text = "The stamps of these records follow each other. If they are parts of one run, take them \
                    as such: memory, creep and offset then carry over from part to part.";
        findings.push(
            Finding::new(FindingKind::Advice, "one run", text.to_owned()).with_advice(Advice::ContinueRun),
        );
    }
    // An interrupted fit skips the verdict, which may simulate every record.
    if !result.cancelled {
        let spans = result.records.iter().map(|fit| range_of(&fit.data.u));
        let span = spans.fold((f64::MAX, f64::MIN), |(low, high), (l, h)| (low.min(l), high.max(h)));
        let unit = facts.first().map_or_else(String::new, |f| f.data.u_unit.to_string());
        let drives: Vec<TimedDrive<'_>> =
            result.records.iter().map(|fit| (fit.data.u.as_slice(), Timing::from(&fit.data.time))).collect();
        say(
            &mut findings,
            FindingKind::Verdict,
            "admissibility",
            verdict(&result.model.hysteresis, &drives, span, &unit),
        );
    }
    if let Some(between) = &result.structure.between {
        between.say(&mut findings, excess_if_held(options, result));
    } else if let Some(text) = delay_of_a_held_drive(options, result) {
        say(&mut findings, FindingKind::Advice, "between samples", text);
    }
    if let Some(smoothing) = result.structure.smoothing {
        say(&mut findings, FindingKind::Verdict, "weights", drawn_together(smoothing));
    }
    if let Dynamics::Fractional(g) | Dynamics::Integer(g) = &result.model.dynamics {
        let text = match stability(g) {
            Stability::Stable => "Dynamic block: stable.".to_owned(),
            Stability::Integrating { .. } => {
                "Dynamic block: integrating, its gain at zero frequency is infinite; a constant input drives \
                 it away."
                    .to_owned()
            }
            Stability::Marginal { frequency_hz } => {
                format!("Dynamic block: undamped at {frequency_hz:.4} Hz, on the edge of stability.")
            }
            Stability::Unstable { poles } => {
                format!("Dynamic block: unstable, {poles} pole(s) in the right half-plane. Do not use it.")
            }
        };
        say(&mut findings, FindingKind::Verdict, "stability", text);
        if let Some(text) = result.excited_hz.and_then(|(lowest_hz, _)| extrapolated_to_rest(g, lowest_hz)) {
            say(&mut findings, FindingKind::Advice, "rest", text).advise(Advice::OtherHysteresis);
        }
    }

    let family = result.model.hysteresis.form().description();
    if amplitudes(fitted_statically.iter().map(|(f, _)| f.drive())) <= 1 && !fitted_statically.is_empty() {
        say(
            &mut findings,
            FindingKind::Advice,
            "amplitudes",
            format!(
                "All loops have the same amplitude: {}, and models cannot be ranked. Minor loops are \
                 extrapolated. Add a record with loops of half and a quarter of the amplitude.",
                family.undetermined_by_one_loop()
            ),
        );
    }
    if let Some((small, wide)) = beside_wide_moves(facts) {
        let unit = result.records.first().map_or("", |r| r.data.u_unit.symbol());
        let told = say(
            &mut findings,
            FindingKind::Verdict,
            "amplitudes",
            format!(
                "The records combine oscillations of {} {unit} with moves of {} {unit} amplitude: residuals \
                 are weighted by the stroke of their segment, so that small motion counts as much as wide \
                 motion, whatever its duration.{}",
                short(small),
                short(wide),
                if family.small_loops_drift() {
                    " The small loops of this family do not close: the model drifts where the device \
                     does not."
                } else {
                    ""
                }
            ),
        );
        if family.small_loops_drift() {
            told.advise(Advice::OtherHysteresis);
        }
    }
    let dynamic = result.records.iter().any(|r| r.role == RecordRole::Dynamic);
    if !dynamic {
        let frequency = facts.iter().map(RecordFacts::highest_frequency_hz).fold(0.0, f64::max);
        let at = if frequency > 0.0 { format!(" at about {frequency:.3} Hz") } else { String::new() };
        let shift = match (&result.model.dynamics, result.structure.delay_and_lag_from_start) {
            (Dynamics::Integer(_), true) => {
                "Delay and lag come from its start from rest alone (in steady state they cannot be \
                 distinguished from loop width); resonances, creep and everything faster are not determined."
            }
            (_, true) => "The delay comes from its start from rest alone.",
            _ if matches!(options.delay_s, Choice::Given(d) if d > 0.0) => {
                "The given delay is taken as the whole time shift; the remainder is loop width."
            }
            _ => "Delay, resonances and creep are not determined: a delay would be fitted as loop width.",
        };
        say(
            &mut findings,
            FindingKind::Advice,
            "frequencies",
            format!(
                "The records hold slow drive only{at}: they do not determine the frequency dependence of the \
                 loop. {shift} Add a sweep up to the highest frequency of use."
            ),
        );
    }
    if result.method == Method::TwoStep
        && fitted_statically.iter().any(|(f, _)| f.highest_frequency_hz() > 0.0)
    {
        say(
            &mut findings,
            FindingKind::Advice,
            "two steps",
            "The blocks were identified one after the other: dynamics in the quasi-static records bias the \
             hysteresis parameters, and the standard errors do not include that bias (it can be many of \
             them)."
                .into(),
        );
    }
    match &result.covariance {
        Some(covariance) => findings.extend(identifiability::verdict(facts, result, covariance)),
        None => findings.extend(precision(result)),
    }
    for (search, bounds) in result.searches.iter().zip(&result.bounds) {
        for (x, range) in search.outcome.best.iter().zip(&bounds.ranges) {
            let at = range.to_unit(*x);
            if ends_at_zero(range, *x) && may_be_zero(result, &range.name) {
                say(
                    &mut findings,
                    FindingKind::Warning,
                    "search range",
                    format!(
                        "{} is zero, its lower limit: the other parameters account for its effect.",
                        range.name
                    ),
                );
            } else if !(1e-4..=1.0 - 1e-4).contains(&at) {
                say(
                    &mut findings,
                    FindingKind::Warning,
                    "search range",
                    format!(
                        "{} = {} ended on the edge of its search range {} … {}; widen it if the device may \
                         lie outside.",
                        range.name,
                        short(*x),
                        short(range.low),
                        short(range.high),
                    ),
                )
                .advise(Advice::Widen { parameter: range.name.clone() });
            }
        }
    }
    for fit in &result.records {
        if fit.scores.fit_percent.is_some_and(|fit| fit < 90.0) {
            say(
                &mut findings,
                FindingKind::Warning,
                "fit",
                format!(
                    "Record '{}' is described poorly (fit {:.1} %): the model class misses something in it.",
                    fit.data.name,
                    fit.scores.fit_percent.unwrap_or(0.0)
                ),
            );
        }
    }
    for search in &result.searches {
        if let Some(text) = still_improving(search) {
            say(&mut findings, FindingKind::Warning, "search", text).advise(Advice::SearchLonger);
        }
    }
    for facts in facts {
        let fastest_hz = Some(facts.highest_frequency_hz());
        for text in implausible_units(&facts.data, fastest_hz) {
            say(
                &mut findings,
                FindingKind::Warning,
                "units",
                format!("Record '{}': {text}", facts.data.name),
            );
        }
    }
    if result.cancelled {
        say(
            &mut findings,
            FindingKind::Warning,
            "search",
            "The search was interrupted: this is the best model so far.".into(),
        );
    }
    result.findings = findings;
    result.treatment = treatment(facts, options, result);
}

/// Verdict on boundedness and invertibility of the hysteresis block over the voltages of the records, by
/// [`Hysteresis::invertibility`].
fn verdict(
    hysteresis: &Hysteresis,
    drives: &[TimedDrive<'_>],
    (low, high): (f64, f64),
    unit: &str,
) -> String {
    let span = format!("{} to {} {unit}", short(low), short(high));
    let span = span.trim_end();
    let name = hysteresis.form().name();
    let bounded = hysteresis.form().description().boundedness(hysteresis.own_shape(), hysteresis.weights());
    let bound = bounded.map_or_else(String::new, |verdict| format!("{verdict}; "));
    let inverse = match hysteresis.invertibility(drives) {
        Ok(Invertibility::Everywhere) => {
            format!("every move raises the output with the drive from {span}, so that it has an inverse")
        }
        Ok(found @ (Invertibility::Nowhere { .. } | Invertibility::FallsAlongDrives { .. })) => {
            format!("no inverse from {span}: {found}")
        }
        Ok(Invertibility::AlongDrives { .. }) | Err(_) => {
            "its inverse is not known to exist for every history".to_owned()
        }
    };
    format!("Hysteresis block ({name}): {bound}{inverse}.")
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_model::dynamics::Term;
    use hysteron_model::hysteresis::examples;
    use std::f64::consts::TAU;

    #[test]
    fn a_gain_at_rest_that_no_record_has_shown_is_said() {
        // 1/(1 + T s) with T = 1/(2π) s: |G| = 1/√2 at 1 Hz, 0.995 at 0.1 Hz.
        let term = |coefficient, order| Term { coefficient, order };
        let lag = TransferFunction::new(vec![term(1.0, 0.0)], vec![term(1.0, 0.0), term(1.0 / TAU, 1.0)]);
        let lag = lag.unwrap();
        assert!(extrapolated_to_rest(&lag, 1.0).unwrap().contains("1.4 times that at 1 Hz"));
        assert_eq!(extrapolated_to_rest(&lag, 0.1), None);
        let integrator = TransferFunction::new(vec![term(1.0, 0.0)], vec![term(1.0, 1.0)]).unwrap();
        assert_eq!(extrapolated_to_rest(&integrator, 1.0), None);
    }

    /// Weights of one sign and a rising polynomial are not a sufficient criterion: it is wrong
    /// for plays that widen with the rate and misses slip.
    #[test]
    fn the_verdict_on_an_inverse_is_that_of_the_inverse() {
        let drive: Vec<f64> = (0..400).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.05).cos()).collect();
        let drives = [(&drive[..], Timing::Rate(1e3))];
        let mut said_of = [0; 3];
        for operator in examples([0.0, 10.0], 50.0, 1.0).unwrap() {
            for linear in [1.0, 0.2, -0.1, -0.5] {
                let form = operator.form();
                let model = form.operator(vec![linear], operator.weights(), &operator.shape()).unwrap();
                let said = verdict(&model, &drives, (0.0, 10.0), "V");
                let (which, part) = match model.invertibility(&drives).unwrap() {
                    Invertibility::Everywhere => (0, "so that it has an inverse"),
                    Invertibility::AlongDrives { .. } => (1, "not known to exist for every history"),
                    _ => (2, "no inverse from 0 to 10 V"),
                };
                assert!(said.contains(part), "{form:?} {linear}: {said}");
                said_of[which] += 1;
            }
        }
        assert!(said_of.into_iter().all(|count| count >= 5), "{said_of:?}");
    }

    #[test]
    fn a_negative_limit_is_not_zero() {
        assert!(ends_at_zero(&hysteron_optimize::Range::linear("beta", 0.0, 3.0), 0.0));
        assert!(ends_at_zero(&hysteron_optimize::Range::linear("beta", 1e-5, 3.0), 1e-5));
        assert!(!ends_at_zero(&hysteron_optimize::Range::linear("beta", 0.0, 3.0), 0.1));
        assert!(!ends_at_zero(&hysteron_optimize::Range::linear("gamma", -3.0, 3.0), -3.0));
    }
}
