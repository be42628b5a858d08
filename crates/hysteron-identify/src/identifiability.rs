//! Identifiability of the parameters of a joint fit, and the record that would determine the others, in plain
//! words.

use super::RecordFacts;
use super::facts::amplitudes;
use super::joint::Covariance;
use super::parameter::{Parameter, ParameterRole};
use super::result::Identification;
use super::{Finding, FindingKind};
use hysteron_model::Advice;
use hysteron_model::dynamics::ParameterKind;
use hysteron_model::hysteresis::{HysteresisForm, Place};
use hysteron_numeric::display::short;

/// A standard error above this share of the parameter's scale leaves it undetermined.
const UNDETERMINED: f64 = 0.5;
/// Two estimates with a correlation above this are hardly distinguishable.
const INSEPARABLE: f64 = 0.99;
/// Condition number of the Jacobian with unit columns above which the whole fit is sensitive to the noise.
const ILL_CONDITIONED: f64 = 1e6;
/// A delay is determined where its error is below this share of the fastest period.
const SHARE_OF_PERIOD: f64 = 0.05;
/// Loops that reach less than this share of saturation are nearly straight.
const SHARE_OF_SATURATION: f64 = 0.05;
/// Share of the stroke at which a nonlinear term of the polynomial matters.
const SHARE_OF_STROKE: f64 = 0.02;
/// Frequency recommended for a further record, over that of the fastest drive, where the sample rate allows
/// it.
const FASTER: f64 = 3.0;
/// Highest recommended drive frequency, as a share of the sample rate.
const BELOW_NYQUIST: f64 = 0.2;
/// Recommended duration of a creep record, over the longest one so far.
const LONGER: f64 = 5.0;

/// Findings on identifiability from the covariance of a joint fit.
pub(super) fn verdict(
    facts: &[RecordFacts],
    result: &Identification,
    covariance: &Covariance,
) -> Vec<Finding> {
    let advisor = Advisor::new(facts, result);
    let mut findings = Vec::new();
    let mut say = |text: String, advice| {
        findings.push(Finding { advice, ..Finding::new(FindingKind::Advice, "identifiability", text) });
    };
    // The initial memory of a record is no property of the device, and b, c₀, c₁ duplicate other parameters.
    let of_device = |p: &&Parameter| {
        !p.held && !matches!(p.role, ParameterRole::Memory(_) | ParameterRole::Equation13(_))
    };
    let straight = far_from_saturation(result, advisor.range_v);
    let is_explained = |p: &Parameter| straight && advisor.is_combined_by_straight_loops(p);
    if let Some((size, rates)) = straight.then(|| advisor.size_and_rates()) {
        let (help, advice) = advisor.help(&[&size]);
        say(
            format!(
                "The loops are far from where the hysteresis would saturate: the records determine the \
                 products of {size} with {}, and linear − {size}, but not {size}, {} or linear by itself. \
                 Within the range of these records that is enough. {help}",
                listed(&rates),
                rates.join(", ")
            ),
            advice,
        );
    }
    let mut unknown: Vec<(&str, String)> = Vec::new();
    for p in result.parameters.iter().filter(of_device).filter(|p| !is_explained(p)) {
        let place = covariance.names.iter().position(|name| *name == p.name);
        let why = match p.std_error {
            Some(error) if error / advisor.scale(p) > UNDETERMINED => {
                format!("({} ± {})", short(p.value), short(error))
            }
            Some(_) => continue,
            None if !on_edge(result, p) && place.is_some_and(|place| covariance.undetermined[place]) => {
                format!("({} is one of many values that fit equally well)", short(p.value))
            }
            None => "(on the edge of its range)".to_owned(),
        };
        unknown.push((&p.name, why));
    }
    let help_for = |(name, _): &(&str, String)| advisor.help(&[name]).0;
    for alike in unknown.chunk_by(|a, b| help_for(a) == help_for(b)) {
        let names: Vec<&str> = alike.iter().map(|(name, _)| *name).collect();
        let told = condensed(&names, |index| format!("{} {}", names[index], alike[index].1));
        let (help, advice) = advisor.help(&names);
        let text = match alike {
            [(name, why)] => format!("{name} is not determined by these records {why}. {help}"),
            _ => format!("{} are not determined by these records. {help}", listed(&told)),
        };
        say(text, advice);
    }
    for group in inseparable(covariance) {
        let names: Vec<&str> = group.names.iter().map(String::as_str).collect();
        let (help, advice) = advisor.help(&names);
        say(
            format!(
                "{} are hardly distinguishable by these records (correlation {:.4}): their errors compensate \
                 each other, so that none is meaningful alone. {help}",
                listed(&condensed(&names, |index| names[index].to_owned())),
                group.correlation
            ),
            advice,
        );
    }
    if covariance.condition_number > ILL_CONDITIONED {
        say(
            format!(
                "The estimates as a whole are sensitive to noise (condition number {}): remove parameters, \
                 or hold those known of the device.",
                short(covariance.condition_number)
            ),
            Some(Advice::Hold { parameter: None }),
        );
    }
    if findings.is_empty() {
        findings.push(Finding {
            kind: FindingKind::Verdict,
            topic: "identifiability".into(),
            advice: None,
            text: format!(
                "These records distinguish the parameters from one another (condition number {:.0}; largest \
                 correlation {}).",
                covariance.condition_number,
                most_correlated(covariance)
            ),
        });
    }
    findings
}

/// The names in words, three or more of consecutive numbers as `weight_1 to weight_12`; `one` formats a
/// single name.
fn condensed(names: &[&str], one: impl Fn(usize) -> String) -> Vec<String> {
    let numbered = |name: &str| {
        let (stem, number) = name.rsplit_once('_')?;
        Some((stem.to_owned(), number.parse::<usize>().ok()?))
    };
    let follows = |before: &str, after: &str| {
        numbered(before).is_some_and(|(stem, number)| numbered(after) == Some((stem, number + 1)))
    };
    let mut told = Vec::new();
    let mut first = 0;
    for run in names.chunk_by(|before, after| follows(before, after)) {
        match run {
            [from, _, .., to] => told.push(format!("{from} to {to}")),
            _ => told.extend((first..first + run.len()).map(&one)),
        }
        first += run.len();
    }
    told
}

/// True if the search ended with the parameter at a bound.
fn on_edge(result: &Identification, p: &Parameter) -> bool {
    let mut ranges = result.bounds.iter().flat_map(|bounds| &bounds.ranges);
    ranges.any(|range| range.name == p.name && range.is_end(p.value))
}

/// True if every loop is far from saturation of the operator.
fn far_from_saturation(result: &Identification, range_v: f64) -> bool {
    let operator = &result.model.hysteresis;
    let family = operator.form().description();
    let share = family.share_of_saturation(operator.own_shape(), operator.weights(), range_v);
    share.is_some_and(|share| share < SHARE_OF_SATURATION)
}

/// Strongly correlated parameters.
struct Group {
    names: Vec<String>,
    /// The strongest correlation among them.
    correlation: f64,
}

/// Correlation of two estimates; 0 unless both have a standard error.
fn correlation(covariance: &Covariance, i: usize, j: usize) -> f64 {
    match (covariance.std_error(i), covariance.std_error(j)) {
        (Some(a), Some(b)) => covariance.matrix[(i, j)] / (a * b),
        _ => 0.0,
    }
}

/// Groups of parameters joined by correlations above [`INSEPARABLE`].
fn inseparable(covariance: &Covariance) -> Vec<Group> {
    let count = covariance.names.len();
    let mut taken = vec![false; count];
    let mut groups = Vec::new();
    for first in 0..count {
        let mut members = vec![first];
        let mut strongest = 0.0f64;
        let mut next = 0;
        while !taken[first] && next < members.len() {
            for j in 0..count {
                let c = correlation(covariance, members[next], j);
                if j != members[next] && c.abs() > INSEPARABLE {
                    if c.abs() > strongest.abs() {
                        strongest = c;
                    }
                    if !members.contains(&j) {
                        members.push(j);
                    }
                }
            }
            next += 1;
        }
        if members.len() > 1 {
            members.sort_unstable();
            for &m in &members {
                taken[m] = true;
            }
            let names = members.iter().map(|&m| covariance.names[m].clone()).collect();
            groups.push(Group { names, correlation: strongest });
        }
    }
    groups
}

fn most_correlated(covariance: &Covariance) -> String {
    let mut strongest = (0.0f64, 0, 0);
    for i in 0..covariance.names.len() {
        for j in 0..i {
            let c = correlation(covariance, i, j);
            if c.abs() > strongest.0.abs() {
                strongest = (c, j, i);
            }
        }
    }
    let (c, i, j) = strongest;
    format!("{c:.3} between {} and {}", covariance.names[i], covariance.names[j])
}

/// `a and b`, `a, b and c`.
fn listed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Recommends the record that would determine a parameter.
struct Advisor<'a> {
    family: HysteresisForm,
    parameters: &'a [Parameter],
    amplitudes: usize,
    fastest_hz: f64,
    rate_hz: f64,
    range_v: f64,
    /// Unit of the drive, with a space before it.
    unit: String,
    longest_s: f64,
}

/// True if slow motion determines the parameter of the dynamics.
fn is_slow(kind: ParameterKind) -> bool {
    match kind {
        ParameterKind::LowestOrder
        | ParameterKind::CreepSize
        | ParameterKind::CreepOrder
        | ParameterKind::CreepPerDecade
        | ParameterKind::CreepStart
        | ParameterKind::CreepShare(_)
        | ParameterKind::CreepTime(_) => true,
        ParameterKind::NaturalFrequency(_)
        | ParameterKind::Damping(_)
        | ParameterKind::HighestOrder(_)
        | ParameterKind::MiddleOrder(_)
        | ParameterKind::Share(_)
        | ParameterKind::Lag => false,
    }
}

impl<'a> Advisor<'a> {
    fn new(facts: &[RecordFacts], result: &'a Identification) -> Self {
        let most = |of: &dyn Fn(&RecordFacts) -> f64| facts.iter().map(of).fold(0.0, f64::max);
        let rate = |f: &RecordFacts| f.data.sample_rate_hz().unwrap_or(0.0);
        Self {
            family: result.model.hysteresis.form(),
            parameters: &result.parameters,
            amplitudes: amplitudes(facts.iter().map(RecordFacts::drive)),
            fastest_hz: most(&RecordFacts::highest_frequency_hz),
            rate_hz: most(&rate),
            range_v: most(&RecordFacts::range_v),
            unit: facts.first().map_or_else(String::new, |f| f.data.u_unit.spaced()),
            longest_s: most(&RecordFacts::duration_s),
        }
    }

    /// Absolute values of the parameters that have one of these roles.
    fn sizes(&self, has: impl Fn(ParameterRole) -> bool) -> impl Iterator<Item = f64> {
        self.parameters.iter().filter(move |p| has(p.role)).map(|p| p.value.abs())
    }

    /// Scale that the standard error of a parameter is compared with: its value, or the size at which it
    /// would matter compared with the others.
    fn scale(&self, p: &Parameter) -> f64 {
        let beside = match p.role {
            ParameterRole::Hysteresis(Place::Shape(index)) => self.largest_beside(index),
            ParameterRole::Delay => SHARE_OF_PERIOD / UNDETERMINED / self.fastest_hz.max(f64::MIN_POSITIVE),
            ParameterRole::Polynomial(power @ 2..) => {
                let linear = self.sizes(|role| role == ParameterRole::Polynomial(1)).fold(0.0, f64::max);
                SHARE_OF_STROKE * linear / self.range_v.powi(power as i32 - 1)
            }
            _ => 0.0,
        };
        p.value.abs().max(beside)
    }

    /// Largest of the shape numbers that shape the branches of a loop only together with this one, so that 0
    /// is a legitimate value of each.
    fn largest_beside(&self, index: usize) -> f64 {
        let together = self.family.description().shapes_together_with(index);
        let has = |role| matches!(role, ParameterRole::Hysteresis(Place::Shape(k)) if together.contains(&k));
        self.sizes(has).fold(0.0, f64::max)
    }

    /// Whether loops far from saturation determine the parameter in a product or difference alone.
    fn is_combined_by_straight_loops(&self, p: &Parameter) -> bool {
        let (size, rates) = self.size_and_rates();
        p.role == ParameterRole::Polynomial(1) || p.name == size || rates.contains(&p.name)
    }

    /// Name of the size of the loop, and of the rates at which its branches bend.
    fn size_and_rates(&self) -> (String, Vec<String>) {
        let numbers = self.family.model_numbers();
        let rates = numbers.into_iter().filter(|number| number.unit.falls_with_exponent);
        (
            self.family.weight_names().into_iter().next().unwrap_or_default(),
            rates.map(|number| number.name).collect(),
        )
    }

    /// Remedy in words, and typed where it is not another record.
    fn help(&self, names: &[&str]) -> (String, Option<Advice>) {
        let roles: Vec<ParameterRole> =
            self.parameters.iter().filter(|p| names.contains(&p.name.as_str())).map(|p| p.role).collect();
        let has = |wanted: &dyn Fn(ParameterRole) -> bool| roles.iter().any(|role| wanted(*role));
        let mut help: Vec<String> = Vec::new();
        let is_memory = |role| matches!(role, ParameterRole::Memory(_));
        let is_hysteretic =
            |role| matches!(role, ParameterRole::Polynomial(_) | ParameterRole::Hysteresis(_));
        if has(&is_hysteretic) {
            help.push(if self.amplitudes <= 1 {
                "a record with loops at half and a quarter of the amplitude".into()
            } else if has(&is_memory) {
                "a record that starts from a known state (after shrinking loops, or from a rest after them)"
                    .into()
            } else {
                format!("slow loops over a wider range than {}{}", short(self.range_v), self.unit)
            });
        }
        let is_slow_motion = |role| matches!(role, ParameterRole::Dynamics(p) if is_slow(p.kind));
        let is_fast_motion = |role| match role {
            ParameterRole::Dynamics(p) => !is_slow(p.kind),
            other => other == ParameterRole::Delay,
        };
        if has(&is_fast_motion) {
            help.push(self.faster());
        }
        if has(&is_slow_motion) {
            help.push(format!(
                "a slow record, or a step and hold, longer than {} s",
                short(LONGER * self.longest_s)
            ));
        }
        if help.is_empty() {
            let name = names.first().copied().unwrap_or("NAME");
            let hold = Advice::Hold { parameter: Some(name.to_owned()) };
            let what = if names.len() > 1 { "some of them where they are" } else { "it where it is" };
            return (format!("Add loops of other amplitudes, or hold {what} known."), Some(hold));
        }
        (format!("Add {}.", help.join(", and ")), None)
    }

    /// Recommends a sweep that reaches the flank of the resonance.
    fn faster(&self) -> String {
        let first =
            |role| matches!(role, ParameterRole::Dynamics(p) if p.kind == ParameterKind::NaturalFrequency(1));
        let resonance_hz = self.sizes(first).fold(0.0, f64::max);
        let wanted = (FASTER * self.fastest_hz).min(2.0 * resonance_hz.max(self.fastest_hz));
        let possible = BELOW_NYQUIST * self.rate_hz;
        if wanted <= possible {
            format!("a sweep beyond {} Hz, up to {}", short(self.fastest_hz), short(wanted))
        } else {
            format!(
                "a sweep up to {} Hz, sampled at {} Hz or more",
                short(wanted),
                short(wanted / BELOW_NYQUIST)
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn covariance(names: &[&str], correlations: &[f64]) -> Covariance {
        let n = names.len();
        let matrix = DMatrix::from_row_slice(n, n, correlations)
            .map_with_location(|i, j, c| c * (i + 1) as f64 * (j + 1) as f64);
        Covariance {
            names: names.iter().map(|n| (*n).to_owned()).collect(),
            values: vec![1.0; n],
            matrix,
            undetermined: vec![false; n],
            condition_number: 10.0,
        }
    }

    #[test]
    fn groups_hold_everything_that_hangs_together() {
        // a with c and c with d, but not a with d; b alone.
        let c = covariance(
            &["a", "b", "c", "d"],
            &[1., 0., -0.995, 0.98, 0., 1., 0., 0., -0.995, 0., 1., -0.999, 0.98, 0., -0.999, 1.],
        );
        let groups = inseparable(&c);
        assert_eq!(groups.len(), 1);
        assert_eq!(groups[0].names, ["a", "c", "d"]);
        assert!((groups[0].correlation + 0.999).abs() < 1e-12);
        let names =
            ["linear", "weight_1", "weight_2", "weight_3", "weight_5", "creep_1", "creep_time_1", "creep_2"];
        let told = listed(&condensed(&names, |index| names[index].to_owned()));
        assert_eq!(told, "linear, weight_1 to weight_3, weight_5, creep_1, creep_time_1 and creep_2");
        assert_eq!(listed(&condensed(&names[1..3], |index| format!("{index}"))), "0 and 1");
        assert_eq!(most_correlated(&c), "-0.999 between c and d");
    }

    #[test]
    fn a_parameter_without_error_hangs_together_with_nothing() {
        let c = covariance(&["a", "b"], &[1., 0., 0., 0.]);
        assert!(inseparable(&c).is_empty());
    }
}
