//! Free parameters of a search, and the columns of their derivatives.

use hysteron_model::axes::ScheduledModes;
use hysteron_numeric::{Forcing, LANES, Target};

/// Parameters that are freed together, in the order of the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Group {
    Transition,
    Input,
    StrainInput,
    Stress,
    Coefficients,
    Output,
    Feedthrough,
    StrainFeedthrough,
    TransitionSlopes,
    OutputSlopes,
    FeedthroughSlopes,
}

impl Group {
    /// True if the trajectory of the states depends on it.
    fn is_dynamic(self) -> bool {
        self <= Self::Coefficients
    }

    /// The group whose columns times S are those of this one.
    fn base(self) -> Option<Self> {
        match self {
            Self::TransitionSlopes => Some(Self::Transition),
            Self::OutputSlopes => Some(Self::Output),
            Self::FeedthroughSlopes => Some(Self::Feedthrough),
            _ => None,
        }
    }

    fn values(self, model: &ScheduledModes) -> Vec<&[f64]> {
        let feedback = model.feedback.as_ref();
        match self {
            Self::Transition => vec![&model.transition],
            Self::Input => vec![&model.input],
            Self::StrainInput => vec![&model.strain_input],
            Self::Stress => feedback.map(|f| f.stress_rows.as_slice()).into_iter().collect(),
            Self::Coefficients => feedback.map_or_else(Vec::new, |f| {
                std::iter::once(&f.drive).chain(&f.stress).map(|law| law.coefficients.as_slice()).collect()
            }),
            Self::Output => vec![&model.output],
            Self::Feedthrough => vec![&model.feedthrough],
            Self::StrainFeedthrough => vec![&model.strain_feedthrough],
            Self::TransitionSlopes => vec![&model.transition_slopes],
            Self::OutputSlopes => vec![&model.output_slopes],
            Self::FeedthroughSlopes => vec![&model.feedthrough_slopes],
        }
    }

    fn values_mut(self, model: &mut ScheduledModes) -> Vec<&mut [f64]> {
        let feedback = model.feedback.as_mut();
        match self {
            Self::Transition => vec![&mut model.transition],
            Self::Input => vec![&mut model.input],
            Self::StrainInput => vec![&mut model.strain_input],
            Self::Stress => feedback.map(|f| f.stress_rows.as_mut_slice()).into_iter().collect(),
            Self::Coefficients => feedback.map_or_else(Vec::new, |f| {
                std::iter::once(&mut f.drive)
                    .chain(&mut f.stress)
                    .map(|law| law.coefficients.as_mut_slice())
                    .collect()
            }),
            Self::Output => vec![&mut model.output],
            Self::Feedthrough => vec![&mut model.feedthrough],
            Self::StrainFeedthrough => vec![&mut model.strain_feedthrough],
            Self::TransitionSlopes => vec![&mut model.transition_slopes],
            Self::OutputSlopes => vec![&mut model.output_slopes],
            Self::FeedthroughSlopes => vec![&mut model.feedthrough_slopes],
        }
    }

    fn len(self, model: &ScheduledModes) -> usize {
        self.values(model).iter().map(|part| part.len()).sum()
    }
}

/// A parameter's column: index of its base column, and multiplication by S.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Column {
    pub base: usize,
    pub scheduled: bool,
}

/// The free parameters of a search.
///
/// Base columns: the dynamic ones, by forward sensitivities along the trajectory; then, output by output,
/// those of its rows of C, D and D_h, which are the signals x, u and w themselves. Columns of slopes are base
/// columns times S.
#[derive(Clone, Debug)]
pub(super) struct Freedom {
    groups: Vec<Group>,
    /// Every free parameter, in the order of the groups.
    pub columns: Vec<Column>,
    /// Number of dynamic base columns.
    pub dynamic: usize,
    /// Signals of a trajectory's row that are the columns of an output's own parameters.
    pub own: Vec<usize>,
    /// Direct actions of the dynamic columns, block by block of [`LANES`].
    pub blocks: Vec<Vec<Forcing>>,
}

impl Freedom {
    /// Frees these groups. Slopes need their base.
    pub(super) fn new(model: &ScheduledModes, groups: &[Group]) -> Self {
        let mut groups = groups.to_vec();
        groups.sort();
        let dynamic: usize = groups.iter().filter(|g| g.is_dynamic()).map(|g| g.len(model)).sum();
        let (n, x) = (model.inputs, model.states());
        let mut own = Vec::new();
        let mut offsets = Vec::new();
        for group in &groups {
            let signals = match group {
                Group::Output => 0..x,
                Group::Feedthrough => x..x + n,
                Group::StrainFeedthrough => x + n..x + 2 * n,
                _ => continue,
            };
            offsets.push((*group, own.len(), signals.len()));
            own.extend(signals);
        }
        let mut columns = Vec::new();
        for group in &groups {
            let place = group.base().unwrap_or(*group);
            let scheduled = place != *group;
            let base = |i: usize| match offsets.iter().find(|(g, ..)| *g == place) {
                Some((_, offset, width)) => dynamic + i / width * own.len() + offset + i % width,
                None => {
                    let before = groups.iter().take_while(|g| **g < place);
                    before.map(|g| g.len(model)).sum::<usize>() + i
                }
            };
            columns.extend((0..group.len(model)).map(|i| Column { base: base(i), scheduled }));
        }
        let mut freedom = Self { groups, columns, dynamic, own, blocks: Vec::new() };
        freedom.blocks = freedom.forcing(model);
        freedom
    }

    /// Base columns.
    pub(super) fn base_columns(&self, outputs: usize) -> usize {
        self.dynamic + outputs * self.own.len()
    }

    /// Groups of the free parameters with their columns.
    pub(super) fn places(&self, model: &ScheduledModes) -> Vec<(Group, std::ops::Range<usize>)> {
        let mut first = 0;
        let place = |group: &Group| {
            let columns = first..first + group.len(model);
            first = columns.end;
            (*group, columns)
        };
        self.groups.iter().map(place).collect()
    }

    /// Values of the free parameters.
    pub(super) fn values(&self, model: &ScheduledModes) -> Vec<f64> {
        self.groups.iter().flat_map(|group| group.values(model)).flatten().copied().collect()
    }

    /// The model after a parameter step.
    pub(super) fn moved(&self, model: &ScheduledModes, step: &[f64]) -> ScheduledModes {
        let mut moved = model.clone();
        let mut steps = step.iter();
        for group in &self.groups {
            for part in group.values_mut(&mut moved) {
                part.iter_mut().zip(&mut steps).for_each(|(value, step)| *value += step);
            }
        }
        moved
    }

    /// Direct actions of every dynamic parameter, block by block.
    fn forcing(&self, model: &ScheduledModes) -> Vec<Vec<Forcing>> {
        let (n, x, modes) = (model.inputs, model.states(), model.modes);
        let (u, w, terms) = (x, x + n, x + 2 * n);
        let mut blocks = vec![Vec::new(); self.dynamic.div_ceil(LANES)];
        let mut column = 0;
        let mut act = |column: usize, target, signal, factor| {
            if let Some(block) = blocks.get_mut(column / LANES) {
                block.push(Forcing { target, lane: column % LANES, signal, factor });
            }
        };
        for group in self.groups.iter().filter(|g| g.is_dynamic()) {
            let length = group.len(model);
            for i in 0..length {
                let at = column + i;
                match group {
                    // q⁺ = (a + ib) q: ∂/∂a is q, ∂/∂b is iq.
                    Group::Transition if i < 2 * modes => {
                        let (re, im) = (i / 2 * 2, i / 2 * 2 + 1);
                        let (to_re, to_im) =
                            if i % 2 == 0 { ((re, 1.0), (im, 1.0)) } else { ((im, -1.0), (re, 1.0)) };
                        act(at, Target::State(re), to_re.0, to_re.1);
                        act(at, Target::State(im), to_im.0, to_im.1);
                    }
                    Group::Transition => act(at, Target::State(i), i, 1.0),
                    Group::Input => act(at, Target::State(i / n), u + i % n, 1.0),
                    Group::StrainInput => act(at, Target::State(i / n), w + i % n, 1.0),
                    Group::Stress => {
                        let (row, place) = (i / (x + n), i % (x + n));
                        act(at, Target::Channel(n + row), if place < x { place } else { u + place - x }, 1.0);
                    }
                    _ => {
                        let count = length / (n + 1);
                        let (law, term) = (i / count, i % count);
                        if law == 0 {
                            for actuator in 0..n {
                                act(at, Target::Strain(actuator), terms + actuator * count + term, 1.0);
                            }
                        } else {
                            let actuator = law - 1;
                            act(at, Target::Strain(actuator), terms + (n + actuator) * count + term, 1.0);
                        }
                    }
                }
            }
            column += length;
        }
        blocks
    }
}
