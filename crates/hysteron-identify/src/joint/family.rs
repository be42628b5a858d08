//! Parameters of each family of hysteresis operators in a joint fit: roles, ranges and starts.

use std::f64::consts::TAU;

use super::super::layout::{BoxBuilder, Role};
use super::super::options::Choice;
use super::super::static_step::Scales;
use super::campaign::JointMember;
use super::setup::JointSetup;
use hysteron_model::Start;
use hysteron_model::hysteresis::{DriveSpan, Search, ShapeNumber};
use hysteron_optimize::Range;

/// Exponent to start from where it is searched.
const EXPONENT: f64 = 1.2;

impl JointSetup<'_> {
    /// Roles of weights and shape numbers.
    pub(super) fn family(&self, space: &mut BoxBuilder<'_>) -> (Vec<Role>, Vec<Role>) {
        let form = self.hysteresis;
        let family = form.description();
        let demands = &self.options.demands;
        let Scales { range_v, largest_v, slope, .. } = self.scales;
        let weights = (0..form.columns()).map(|index| {
            // µm per unit of the column, which scales with a power of the drive.
            let power = 1 + family.weight_unit(index).input;
            let most = family.weight_reach() * slope.abs() * range_v.max(largest_v).powi(power);
            let range = Range::linear(&family.weight_name(index), -most, most);
            if form.is_monotone() { space.one_sided(range, slope.signum()) } else { space.projected(range) }
        });
        let weights = weights.collect();
        let shape =
            form.shape_numbers(&self.drive_span()).into_iter().map(|ShapeNumber { name, search, .. }| {
                let held = |value: f64| Role::Fixed(demands.fixed(&name).unwrap_or(value));
                match search {
                    Search::Held(value) => held(value),
                    Search::HeldUnlessBounded(value, [low, high]) => match demands.bounded(&name) {
                        Some(_) => space.searched(Range::linear(&name, low, high)),
                        None => held(value),
                    },
                    Search::Linear(low, high) => space.searched(Range::linear(&name, low, high)),
                    Search::Logarithmic(low, high) => space.searched(Range::logarithmic(&name, low, high)),
                }
            });
        let shape = shape.collect();
        (weights, shape)
    }

    /// Voltages, rates and settings from which the family derives its parameter ranges.
    fn drive_span(&self) -> DriveSpan {
        let demands = &self.options.demands;
        let fixed = demands.fixed("n");
        let (exponent, holds_exponent) = match self.options.n {
            Choice::Given(n) => (fixed.unwrap_or(n), demands.bounded("n").is_none()),
            Choice::Auto => (fixed.unwrap_or(EXPONENT), fixed.is_some()),
        };
        DriveSpan {
            stroke: self.scales.range_v,
            ends: self.span().into(),
            grid: self.grid(),
            reach: self.reach.unwrap_or_else(|| self.farthest()),
            fastest_rate: TAU * self.fastest_hz,
            exponent,
            holds_exponent,
            is_straight: self.hysteresis.weight_names().iter().all(|name| demands.fixed(name) == Some(0.0)),
        }
    }

    /// Largest half-width of a play that the drives move in a device demagnetised at its first voltage: the way
    /// from there to the farther end of the range; half of the range for a steady state.
    pub(super) fn farthest(&self) -> f64 {
        let of_member = |member: &JointMember<'_>| {
            let (low, high) = member.facts.ends;
            let first = match member.before {
                Start::Rest { voltage_v } => voltage_v,
                _ if member.before == Start::PERIODIC => 0.5 * (low + high),
                _ => member.facts.data.u[0],
            };
            (high - first).max(first - low)
        };
        self.members.iter().map(of_member).fold(0.5 * self.scales.range_v, f64::max)
    }

    /// Range of a family's grid. A plane of relays covers the range a demagnetised device needs: relays that
    /// close on the virgin curve open only far below the lowest voltage, so that a plane limited to the
    /// voltages of the records would lack them, and with them the virgin curve.
    fn grid(&self) -> [f64; 2] {
        let (low, high) = self.span();
        let is_plane = self.hysteresis.description().is_plane();
        let begins = self.members.iter().filter(|m| is_plane && m.before != Start::PERIODIC);
        let virgin = begins.filter_map(|member| match member.before {
            Start::Rest { voltage_v } => Some(voltage_v),
            _ => member.facts.data.u.first().copied(),
        });
        // Demagnetised at v, relays with α + β < 2v are closed: mirror images of the ends.
        virgin.fold([low, high], |[lowest, highest], v| {
            [lowest.min(2.0 * v - high), highest.max(2.0 * v - low)]
        })
    }

    /// Lowest and highest voltage of all records.
    fn span(&self) -> (f64, f64) {
        let spans = self.members.iter().map(|member| member.facts.ends);
        spans.fold((f64::MAX, f64::MIN), |(low, high), (l, h)| (low.min(l), high.max(h)))
    }

    /// Search range of the memory of a record.
    pub(super) fn memory_range(&self, record: usize) -> (f64, f64) {
        let ends = self.members[record].facts.ends.into();
        self.hysteresis.description().memory_range(ends, self.scales.range_v).into()
    }

    /// Shapes to start from.
    pub(super) fn shapes(&self) -> Vec<Vec<f64>> {
        self.hysteresis.starts(&self.drive_span())
    }

    /// Memory to start a record from: fresh at its first sample, or `settled` on loops like those of the
    /// record.
    pub(super) fn first_memory(&self, shape: &[f64], settled: bool, record: usize) -> f64 {
        let facts = self.members[record].facts;
        let family = self.hysteresis.description();
        family.first_memory(shape, facts.data.u[0], facts.ends.into(), self.scales.range_v, settled)
    }
}
