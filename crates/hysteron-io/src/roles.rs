//! Roles of the columns of a record, decided by its header and by the caller's choices.

use std::collections::HashMap;

use hysteron_model::advice::ColumnRole;
use hysteron_model::record::{Admitted, Condition, Cut, Quantity, header_of};

use crate::columns::{ColumnForm, Heading, Headings, list_arrays};
use crate::one_record::{no_channels, set_apart};
use crate::place::{FilePart, Place};
use crate::{IoError, ReadOptions};

/// Role of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    /// Time, with its factor to seconds.
    Time(f64),
    Mask,
    Channel,
    /// Texts of a condition; no channel of the record.
    Texts,
    /// Not read.
    Skipped,
}

/// Headers of the channels chosen by the options, by name or number.
#[derive(Clone, Debug)]
pub(crate) struct Chosen {
    pub input: Option<String>,
    pub output: Option<String>,
    pub reference: Option<String>,
}

/// The columns of a record.
#[derive(Debug)]
pub(crate) struct Roles {
    /// One a column.
    pub roles: Vec<Role>,
    /// Name in the record, one a column: with its path where another channel has the same name.
    pub names: Vec<String>,
    pub chosen: Chosen,
    /// Cut of the record, its columns by their headers; without the conditions on texts.
    pub cut: Cut,
    /// Columns of texts and the text that each must be.
    pub texts: Vec<(usize, String)>,
}

impl Roles {
    /// Assigns roles by a file's headers.
    pub fn new(headings: &Headings, options: &ReadOptions) -> Result<Self, IoError> {
        let columns = &headings.columns;
        let input = chosen(headings, options.input.as_deref(), ColumnRole::Input)?;
        let output = chosen(headings, options.output.as_deref(), ColumnRole::Output)?;
        let reference = chosen(headings, options.reference.as_deref(), ColumnRole::Reference)?;
        let taken = [input, output, reference];
        let left_out = options.leave_out.iter().map(|name| chosen(headings, Some(name), ColumnRole::LeftOut));
        let left_out = left_out.collect::<Result<Vec<_>, _>>()?;
        let asked_time = chosen(headings, options.time.as_deref(), ColumnRole::Time)?;
        let conditions = Conditions::new(headings, &options.cut)?;
        let apart = set_apart(headings, &[input, output, reference, asked_time], &left_out)?;
        let time = time_column(headings, asked_time, |i| !taken.contains(&Some(i)) && !apart[i])?;
        if time.is_none()
            && taken.iter().all(Option::is_none)
            && let Some((_, column)) = columns.iter().enumerate().find(|(i, c)| !apart[*i] && is_spectral(c))
        {
            let column = column.header.clone();
            return Err(IoError::FrequencyResponse { place: headings.place(), column });
        }
        let only_chosen = input.is_some() && output.is_some();
        let role = |(i, column): (usize, &Heading)| {
            if taken.contains(&Some(i)) {
                Role::Channel
            } else if left_out.contains(&Some(i)) {
                Role::Skipped
            } else if Some(i) == time {
                Role::Time(match column.unit.base() {
                    (Quantity::Time, factor) => factor,
                    _ => 1.0,
                })
            } else if apart[i] && !conditions.reads(i) {
                Role::Skipped
            } else if column.name.eq_ignore_ascii_case("valid") {
                Role::Mask
            } else if conditions.holds_text(i) {
                Role::Texts
            } else if (only_chosen && !conditions.reads(i)) || column.header.is_empty() {
                Role::Skipped
            } else {
                Role::Channel
            }
        };
        let roles: Vec<Role> = columns.iter().enumerate().map(role).collect();
        if !roles.contains(&Role::Channel) {
            return Err(no_channels(headings));
        }
        let names = channel_names(columns, &roles);
        let header =
            |i: usize| columns.get(i).zip(names.get(i)).map(|(column, name)| header_of(name, &column.unit));
        let [input, output, reference] = taken.map(|i| i.and_then(header));
        let (cut, texts) = conditions.of_record(options.cut.clone(), &roles, &input, header);
        Ok(Roles { roles, names, chosen: Chosen { input, output, reference }, cut, texts })
    }

    /// Form in which a reader has to read each column.
    pub fn wanted(&self) -> Vec<ColumnForm> {
        let wanted = |role: &Role| match role {
            Role::Skipped => ColumnForm::Nothing,
            Role::Texts => ColumnForm::Texts,
            _ => ColumnForm::Numbers,
        };
        self.roles.iter().map(wanted).collect()
    }
}

/// Columns that a cut depends on, by their numbers.
struct Conditions {
    /// One a condition.
    columns: Vec<usize>,
    /// Whether the condition asks for a text; one a condition.
    texts: Vec<Option<String>>,
    /// The column whose turns are counted, where it is named.
    turns: Option<usize>,
}

impl Conditions {
    fn new(headings: &Headings, cut: &Cut) -> Result<Self, IoError> {
        let position = |asked: &str, role| chosen(headings, Some(asked), role).map(Option::unwrap_or_default);
        let (mut columns, mut texts) = (Vec::new(), Vec::new());
        for condition in &cut.conditions {
            let column = position(&condition.column, ColumnRole::Condition)?;
            let text = match &condition.is {
                Admitted::Text(text) if headings.line.is_none() => {
                    let array = FilePart::Array(headings.header(column).into());
                    let place = Place::new(&headings.file, array);
                    return Err(IoError::TextCondition { place, text: text.clone() });
                }
                Admitted::Text(text) => Some(text.clone()),
                _ => None,
            };
            columns.push(column);
            texts.push(text);
        }
        let turns = cut.turns.as_ref().and_then(|turns| turns.column.as_deref());
        let turns = turns.map(|asked| position(asked, ColumnRole::Input)).transpose()?;
        Ok(Conditions { columns, texts, turns })
    }

    /// Whether a column is needed as numbers.
    fn reads(&self, column: usize) -> bool {
        let mut of_numbers = self.columns.iter().zip(&self.texts).filter(|(_, text)| text.is_none());
        self.turns == Some(column) || of_numbers.any(|(own, _)| *own == column)
    }

    /// Whether a column is to hold a text.
    fn holds_text(&self, column: usize) -> bool {
        self.columns.iter().zip(&self.texts).any(|(own, text)| *own == column && text.is_some())
    }

    /// The cut with the columns' headers in the record, and separately the conditions on text columns.
    fn of_record(
        self,
        mut cut: Cut,
        roles: &[Role],
        input: &Option<String>,
        header: impl Fn(usize) -> Option<String>,
    ) -> (Cut, Vec<(usize, String)>) {
        let mut of_texts = Vec::new();
        let conditions = std::mem::take(&mut cut.conditions);
        for ((condition, column), text) in conditions.into_iter().zip(self.columns).zip(self.texts) {
            match text.filter(|_| roles.get(column) == Some(&Role::Texts)) {
                Some(text) => of_texts.push((column, text)),
                // A text condition on a channel of numbers is rejected by the record.
                None => cut
                    .conditions
                    .push(Condition { column: header(column).unwrap_or_default(), is: condition.is }),
            }
        }
        if let Some(turns) = &mut cut.turns {
            turns.column = self.turns.and_then(header).or_else(|| input.clone());
        }
        (cut, of_texts)
    }
}

/// Names of a record's channels. In a file of named arrays the path distinguishes channels of one name.
fn channel_names(columns: &[Heading], roles: &[Role]) -> Vec<String> {
    let mut uses: HashMap<&str, usize> = HashMap::new();
    for (column, _) in columns.iter().zip(roles).filter(|(_, role)| **role == Role::Channel) {
        *uses.entry(&column.name).or_default() += 1;
    }
    let name = |(column, role): (&Heading, &Role)| {
        let twice = *role == Role::Channel && uses.get(column.name.as_str()).is_some_and(|&uses| uses > 1);
        if twice { format!("{}{}", column.group(), column.name) } else { column.name.clone() }
    };
    columns.iter().zip(roles).map(name).collect()
}

/// The column chosen for a role: by header or bare name exactly, else ignoring case, else by number from 1.
pub(crate) fn chosen(
    headings: &Headings,
    asked: Option<&str>,
    role: ColumnRole,
) -> Result<Option<usize>, IoError> {
    let columns = &headings.columns;
    let Some(asked) = asked.map(str::trim) else { return Ok(None) };
    let mut found = Vec::new();
    let folds: [&dyn Fn(&str) -> String; 2] = [&str::to_string, &str::to_lowercase];
    for fold in folds {
        let wanted = fold(asked);
        for is_meant in [Heading::is_called, Heading::ends_in] {
            if found.is_empty() {
                let named = columns.iter().enumerate().filter(|(_, column)| !column.header.is_empty());
                found = named.filter(|(_, c)| is_meant(c, &wanted, fold)).map(|(i, _)| i).collect();
            }
        }
    }
    if found.is_empty()
        && let Ok(number) = asked.parse::<usize>()
        && (1..=columns.len()).contains(&number)
    {
        found.push(number - 1);
    }
    // A path within an array that is listed but not read.
    if found.is_empty() {
        found.extend(columns.iter().position(|column| column.is_unreadable() && column.holds(asked)));
    }
    match found.as_slice() {
        [one] => Ok(Some(*one)),
        [] => Err(IoError::NoSuchColumn {
            place: headings.place(),
            asked: asked.to_string(),
            role,
            available: headings.list(),
        }),
        several => Err(ambiguous(headings, several, asked, role)),
    }
}

/// The time column: the one asked for, else one by name or unit among those that are free.
fn time_column(
    headings: &Headings,
    asked: Option<usize>,
    is_free: impl Fn(usize) -> bool,
) -> Result<Option<usize>, IoError> {
    let columns = &headings.columns;
    let free = |i: &usize| is_free(*i);
    if let Some(index) = asked {
        let column = &columns[index];
        if !column.unit.symbol().is_empty() && column.unit.base().0 != Quantity::Time {
            return Err(IoError::NotTime {
                place: headings.place(),
                name: column.header.clone(),
                unit: column.unit.to_string(),
            });
        }
        return Ok(Some(index));
    }
    let is_time = |c: &Heading| c.unit.base().0 == Quantity::Time;
    let by_name: Vec<usize> =
        (0..columns.len()).filter(|&i| columns[i].is_named_as_time()).filter(free).collect();
    if by_name.is_empty() {
        // A lone unit of time makes a time column, but never of a column that is named as an input or an
        // output.
        let by_unit: Vec<usize> = (0..columns.len())
            .filter(|&i| is_time(&columns[i]) && !columns[i].name.starts_with(['u', 'y', 'U', 'Y']))
            .filter(free)
            .collect();
        return Ok(match by_unit.as_slice() {
            [one] => Some(*one),
            _ => None,
        });
    }
    match by_name.as_slice() {
        [one] => Ok(Some(*one)),
        several => Err(ambiguous(headings, several, "time", ColumnRole::Time)),
    }
}

fn ambiguous(headings: &Headings, several: &[usize], asked: &str, role: ColumnRole) -> IoError {
    let candidates = several.iter().filter_map(|&i| headings.columns.get(i));
    IoError::AmbiguousColumn {
        place: headings.place(),
        asked: asked.to_string(),
        role,
        candidates: list_arrays(candidates),
    }
}

/// Frequency, or the real or imaginary part of something.
fn is_spectral(column: &Heading) -> bool {
    let name = column.name.to_lowercase();
    ["f", "freq", "frequency", "omega"].contains(&name.as_str())
        || (["Hz", "kHz", "MHz"].contains(&column.unit.symbol()) && !name.starts_with(['u', 'y']))
}
