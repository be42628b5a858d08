//! Selection of the input and output channels.

use crate::advice::{Advice, ColumnRole};
use crate::{Finding, FindingKind};
use serde::{Deserialize, Serialize};

use super::{Channel, InputOutput, Quantity, Record, RecordError, TimeBase, Unit};

/// Channels to use, by bare name (`u`) or header (`u_V`); `None`: by the rules of [`Record::select`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ChannelChoice {
    /// Input channel.
    pub input: Option<String>,
    /// Output channel.
    pub output: Option<String>,
}

/// The channels a [`ChannelChoice`] means in one record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// Index of the input channel.
    pub input: usize,
    /// Index of the output channel.
    pub output: usize,
    /// Choices made automatically, and doubts about them.
    pub notes: Vec<Finding>,
}

/// One channel alone: a drive to simulate, a reference to follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Samples, voltages in V, lengths in µm.
    pub samples: Vec<f64>,
    /// Their unit.
    pub unit: Unit,
    /// Name of the channel.
    pub name: String,
    /// When the samples were taken.
    pub time: TimeBase,
    /// Choices made automatically.
    pub notes: Vec<Finding>,
}

impl Signal {
    /// Samples at a rate \[Hz\], in a unit written as in column headers (`V`, `um`).
    pub fn uniform(samples: Vec<f64>, sample_rate_hz: f64, unit: &str) -> Self {
        let time = TimeBase::uniform(sample_rate_hz);
        Self { samples, unit: Unit::new(unit), name: "signal".to_owned(), time, notes: Vec::new() }
    }
}

/// A drive to simulate, with the output measured with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Driven {
    /// The drive.
    pub drive: Signal,
    /// The record of drive and measured output, where [`Record::select`] finds one.
    pub measured: Option<InputOutput>,
}

#[derive(Clone, Copy, PartialEq)]
enum Role {
    Input,
    Output,
    Reference,
}

impl Role {
    fn column(self) -> ColumnRole {
        match self {
            Role::Input => ColumnRole::Input,
            Role::Output => ColumnRole::Output,
            Role::Reference => ColumnRole::Reference,
        }
    }

    fn letter(self) -> char {
        match self {
            Role::Input => 'u',
            Role::Output => 'y',
            Role::Reference => 'r',
        }
    }

    fn words(self) -> &'static [&'static str] {
        match self {
            Role::Input => &["input", "voltage", "drive", "command"],
            Role::Output => &["output", "displacement", "position", "stroke"],
            Role::Reference => &["reference", "target", "setpoint", "trajectory"],
        }
    }

    fn has_unit(self, unit: &Unit) -> bool {
        match self {
            Role::Input => unit.base().0 == Quantity::Voltage,
            Role::Output | Role::Reference => {
                matches!(unit.base().0, Quantity::Length | Quantity::Angle)
            }
        }
    }

    fn expected(self) -> &'static str {
        match self {
            Role::Input => "a channel named `u…` or one in volts",
            Role::Output => "a channel named `y…` or one in a unit of length or angle",
            Role::Reference => {
                "a channel named `r…`, `reference` or `target`, or one in a unit of length or angle"
            }
        }
    }
}

impl Record {
    /// Decides which channel is the input and which the output.
    ///
    /// A named channel is taken (exactly as written; else ignoring case). Otherwise, for the input, the first
    /// rule that a channel meets decides: (1) the channel `u`; (2) channels `u…` (`u1`, `u_cmd`); (3)
    /// `input`, `voltage`, `drive`, `command`; (4) channels in a unit of voltage. For the output likewise:
    /// `y`; `y…`; `output`, `displacement`, `position`, `stroke`; channels in a unit of length or angle.
    /// Where several channels meet a rule, a command is preferred to its measurement for the input (`u_cmd`
    /// to `u_meas`, stated in the notes; the measured one may be chosen), a measurement for the output; else
    /// it is an error. Where no channel meets a rule for the input and, of more than two, one is in a unit of
    /// length or angle and one in a unit of force or torque, the displacement is the input and the force the
    /// output, as of a damper. Where no channel meets a rule and there are exactly two, the first is the input and
    /// the second the output (noted).
    ///
    /// # Errors
    /// [`RecordError::NoSuchChannel`], [`RecordError::AmbiguousChannel`], [`RecordError::NoCandidate`],
    /// [`RecordError::OnlyOneChannel`], [`RecordError::SameChannel`], [`RecordError::WrongUnit`] (time as
    /// input or output).
    pub fn select(&self, choice: &ChannelChoice) -> Result<Selection, RecordError> {
        let mut notes = Vec::new();
        let named_input = self.named(choice.input.as_deref(), Role::Input)?;
        let named_output = self.named(choice.output.as_deref(), Role::Output)?;
        if let [only] = self.channels.as_slice() {
            return Err(RecordError::OnlyOneChannel { record: self.name.clone(), channel: only.label() });
        }
        let two = self.channels.len() == 2;
        let (input, output) = match (named_input, named_output) {
            (Some(input), Some(output)) => (input, output),
            (Some(input), None) if two => (input, 1 - input),
            (None, Some(output)) if two => (1 - output, output),
            (Some(input), None) => (input, self.guess(Role::Output, Some(input), &mut notes)?),
            (None, Some(output)) => (self.guess(Role::Input, Some(output), &mut notes)?, output),
            (None, None) if two => self.guess_of_two(&mut notes)?,
            (None, None) => match self.force_over_displacement() {
                Some(pair) => pair,
                None => {
                    let input = self.guess(Role::Input, None, &mut notes)?;
                    (input, self.guess(Role::Output, Some(input), &mut notes)?)
                }
            },
        };
        if input == output {
            return Err(RecordError::SameChannel {
                record: self.name.clone(),
                channel: self.channels[input].name.clone(),
            });
        }
        self.check_units(input, output, &mut notes)?;
        Ok(Selection { input, output, notes })
    }

    /// Displacement and force of a record of a damper, see [`Record::select`].
    fn force_over_displacement(&self) -> Option<(usize, usize)> {
        let quiet = &mut Vec::new();
        if self.guess(Role::Input, None, quiet).is_ok() {
            return None;
        }
        let displacements = self.positions(|c| Role::Output.has_unit(&c.unit));
        let forces = self.positions(|c| c.unit.is_force());
        match (displacements.as_slice(), forces.as_slice()) {
            ([displacement], [force]) => Some((*displacement, *force)),
            _ => None,
        }
    }

    /// True if names and units determine which channel is the input and which the output, each by a rule of
    /// [`Record::select`].
    pub fn names_input_and_output(&self) -> bool {
        let mut notes = Vec::new();
        if self.channels.len() > 2 && self.force_over_displacement().is_some() {
            return true;
        }
        let input = self.guess(Role::Input, None, &mut notes);
        input.is_ok_and(|input| self.guess(Role::Output, Some(input), &mut notes).is_ok())
    }

    /// Input and output by [`Record::select`], voltages in V, lengths in µm, angles in µrad; other units as
    /// they are.
    ///
    /// # Errors
    /// Those of [`Record::select`] and [`Record::check`].
    pub fn input_output(&self, choice: &ChannelChoice) -> Result<InputOutput, RecordError> {
        self.check()?;
        let selection = self.select(choice)?;
        Ok(self.selected(&selection))
    }

    /// The channels of a [`Selection`] made on this record.
    fn selected(&self, selection: &Selection) -> InputOutput {
        let (input, output) = (&self.channels[selection.input], &self.channels[selection.output]);
        let (u, u_unit) = in_base_unit(input);
        let (y, y_unit) = in_base_unit(output);
        InputOutput {
            name: self.name.clone(),
            time: self.time.clone(),
            u,
            y,
            rate: None,
            valid: self.valid.clone(),
            input: input.name.clone(),
            output: output.name.clone(),
            u_unit,
            y_unit,
            source: self.source.clone(),
        }
    }

    /// The input channel alone, by the same rules; a record with one channel has it as its input whatever its
    /// name.
    ///
    /// # Errors
    /// Those of [`Record::select`] for the input, and [`Record::check`].
    pub fn drive(&self, input: Option<&str>) -> Result<Signal, RecordError> {
        self.alone(input, Role::Input)
    }

    /// [`Record::drive`] with the output measured beside it, if there is one.
    ///
    /// # Errors
    /// Those of [`Record::drive`].
    pub fn driven(&self, input: Option<&str>) -> Result<Driven, RecordError> {
        let drive = self.drive(input)?;
        let choice = ChannelChoice { input: input.map(str::to_owned), output: None };
        let measured = self.input_output(&choice).ok().filter(|measured| measured.u == drive.samples);
        Ok(Driven { drive, measured })
    }

    /// The reference alone (`--reference`): a channel named so, else the only one, else by the rules of
    /// [`Record::select`] with the names `r`; `r…`; `reference`, `target`, `setpoint`, `trajectory`; a unit
    /// of length or angle.
    ///
    /// # Errors
    /// Those of [`Record::drive`].
    pub fn reference(&self, reference: Option<&str>) -> Result<Signal, RecordError> {
        self.alone(reference, Role::Reference)
    }

    fn alone(&self, asked: Option<&str>, role: Role) -> Result<Signal, RecordError> {
        self.check()?;
        let mut notes = Vec::new();
        let index = self.position_alone(asked, role, &mut notes)?;
        let channel = &self.channels[index];
        self.check_not_time(channel, role)?;
        let (samples, unit) = in_base_unit(channel);
        Ok(Signal { samples, unit, name: channel.name.clone(), time: self.time.clone(), notes })
    }

    /// Index of the input channel, by the rules of [`Record::drive`], of a record not yet checked.
    pub(super) fn input_position(&self, asked: Option<&str>) -> Result<usize, RecordError> {
        self.position_alone(asked, Role::Input, &mut Vec::new())
    }

    fn position_alone(
        &self,
        asked: Option<&str>,
        role: Role,
        notes: &mut Vec<Finding>,
    ) -> Result<usize, RecordError> {
        match self.named(asked, role)? {
            Some(index) => Ok(index),
            None if self.channels.len() == 1 => Ok(0),
            None => self.guess(role, None, notes).or_else(|e| self.beside_output(role).ok_or(e)),
        }
    }

    /// The input of a record of two channels of which one is recognised as the output.
    fn beside_output(&self, role: Role) -> Option<usize> {
        if role != Role::Input || self.channels.len() != 2 {
            return None;
        }
        self.guess(Role::Output, None, &mut Vec::new()).ok().map(|output| 1 - output)
    }

    fn named(&self, asked: Option<&str>, role: Role) -> Result<Option<usize>, RecordError> {
        let Some(asked) = asked else { return Ok(None) };
        let asked = asked.trim();
        let exact = self.positions(|c| c.is_called(asked));
        let found = if exact.is_empty() {
            let lower = asked.to_lowercase();
            self.positions(|c| c.name.to_lowercase() == lower || c.header().to_lowercase() == lower)
        } else {
            exact
        };
        match found.as_slice() {
            [one] => Ok(Some(*one)),
            [] => Err(RecordError::NoSuchChannel {
                record: self.name.clone(),
                asked: asked.to_string(),
                role: role.column(),
                available: self.list(&(0..self.channels.len()).collect::<Vec<_>>()),
            }),
            several => Err(self.ambiguous(several, role)),
        }
    }

    fn guess_of_two(&self, notes: &mut Vec<Finding>) -> Result<(usize, usize), RecordError> {
        let mut quiet = Vec::new();
        let input = self.guess(Role::Input, None, &mut quiet).ok();
        let output = self.guess(Role::Output, None, &mut quiet).ok();
        match (input, output) {
            (Some(input), Some(output)) if input != output => Ok((input, output)),
            (Some(input), None) => Ok((input, 1 - input)),
            (None, Some(output)) => Ok((1 - output, output)),
            _ => {
                let text = format!(
                    "neither name nor unit says which channel drives and which responds: the first, {}, is \
                     taken as the input and the second, {}, as the output; choose others if that is wrong",
                    self.channels[0].label(),
                    self.channels[1].label()
                );
                notes.push(note(text).with_advice(Advice::ChooseColumns));
                Ok((0, 1))
            }
        }
    }

    fn guess(
        &self,
        role: Role,
        taken: Option<usize>,
        notes: &mut Vec<Finding>,
    ) -> Result<usize, RecordError> {
        let letter = role.letter();
        let lower: Vec<String> = self.channels.iter().map(|c| c.name.to_lowercase()).collect();
        let is_time = |i: usize| self.channels[i].unit.base().0 == Quantity::Time;
        let rules: [&dyn Fn(usize) -> bool; 4] = [
            &|i| lower[i].len() == 1 && lower[i].starts_with(letter),
            &|i| {
                lower[i]
                    .strip_prefix(letter)
                    .is_some_and(|rest| rest.starts_with(|c: char| !c.is_alphabetic()))
            },
            &|i| role.words().contains(&lower[i].as_str()),
            &|i| role.has_unit(&self.channels[i].unit),
        ];
        for rule in rules {
            let found: Vec<usize> =
                (0..self.channels.len()).filter(|&i| Some(i) != taken && !is_time(i) && rule(i)).collect();
            match found.as_slice() {
                [] => continue,
                [one] => return Ok(*one),
                several => {
                    let preferred: Vec<usize> =
                        several.iter().copied().filter(|&i| is_preferred(&lower[i], role)).collect();
                    return match preferred.as_slice() {
                        [one] => {
                            let others: Vec<usize> = several.iter().copied().filter(|i| i != one).collect();
                            let text = format!(
                                "{} is taken as the {}, not {}; choose another if that is wrong",
                                self.channels[*one].label(),
                                role.column(),
                                self.list(&others)
                            );
                            let advice = Advice::ChooseColumn { role: role.column(), example: None };
                            notes.push(note(text).with_advice(advice));
                            Ok(*one)
                        }
                        _ => Err(self.ambiguous(several, role)),
                    };
                }
            }
        }
        Err(RecordError::NoCandidate {
            record: self.name.clone(),
            role: role.column(),
            expected: role.expected(),
            available: self.list(&(0..self.channels.len()).collect::<Vec<_>>()),
        })
    }

    fn check_units(&self, input: usize, output: usize, notes: &mut Vec<Finding>) -> Result<(), RecordError> {
        let (u, y) = (&self.channels[input], &self.channels[output]);
        self.check_not_time(u, Role::Input)?;
        self.check_not_time(y, Role::Output)?;
        let is_position = |c: &Channel| Role::Output.has_unit(&c.unit);
        let is_voltage = |c: &Channel| Role::Input.has_unit(&c.unit);
        if is_position(u) && is_voltage(y) {
            notes.push(note(format!(
                "the input {} is a position and the output {} a voltage: are the two swapped?",
                u.label(),
                y.label()
            )));
        } else if is_voltage(y) {
            let text = format!(
                "the output {} is in volts: if that is a sensor signal, scale it to µm or µrad",
                y.label()
            );
            notes.push(note(text).with_advice(Advice::ScaleColumn { column: y.name.clone() }));
        } else if is_position(u) && !y.unit.is_force() {
            notes.push(note(format!("the input {} is a position, not a drive voltage", u.label())));
        }
        Ok(())
    }

    fn check_not_time(&self, channel: &Channel, role: Role) -> Result<(), RecordError> {
        if channel.unit.base().0 != Quantity::Time {
            return Ok(());
        }
        Err(RecordError::WrongUnit {
            record: self.name.clone(),
            role: role.column(),
            channel: channel.header(),
            unit: channel.unit.to_string(),
            expected: match role {
                Role::Input => "a voltage (V, mV, kV)",
                Role::Output | Role::Reference => "a length (nm, µm, mm, m) or an angle (µrad, mrad)",
            },
        })
    }

    fn positions(&self, accept: impl Fn(&Channel) -> bool) -> Vec<usize> {
        (0..self.channels.len()).filter(|&i| accept(&self.channels[i])).collect()
    }

    fn ambiguous(&self, several: &[usize], role: Role) -> RecordError {
        RecordError::AmbiguousChannel {
            record: self.name.clone(),
            role: role.column(),
            candidates: self.list(several),
            first: several.first().map(|&i| self.channels[i].header()).unwrap_or_default(),
        }
    }

    fn list(&self, indices: &[usize]) -> String {
        indices.iter().map(|&i| self.channels[i].label()).collect::<Vec<_>>().join(", ")
    }
}

fn note(text: String) -> Finding {
    Finding::new(FindingKind::Verdict, "channels", text)
}

/// Of several inputs the command, of several outputs the measurement.
fn is_preferred(lower_name: &str, role: Role) -> bool {
    let marks: &[&str] = match role {
        Role::Input => &["_cmd", "_command"],
        Role::Output => &["_meas", "_measured"],
        Role::Reference => &["_ref", "_reference", "_target"],
    };
    marks.iter().any(|m| lower_name.ends_with(m))
}

pub(super) fn in_base_unit(channel: &Channel) -> (Vec<f64>, Unit) {
    let (quantity, factor) = channel.unit.base();
    let samples = if quantity == Quantity::Other || factor == 1.0 {
        channel.samples.clone()
    } else {
        channel.samples.iter().map(|x| x * factor).collect()
    };
    (samples, channel.unit.base_unit())
}

#[cfg(test)]
mod tests;
