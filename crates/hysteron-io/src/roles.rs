//! What each column of a record is, decided by its header and by what the caller chose.

use hysteron_model::advice::ColumnRole;
use hysteron_model::record::{Admitted, Condition, Cut, Quantity, header_of};

use crate::columns::{Heading, Headings, Wanted, list};
use crate::place::{Part, Place};
use crate::{IoError, ReadOptions};

/// What a column is read as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    /// Time; the factor makes seconds of it.
    Time(f64),
    Mask,
    Channel,
    /// Texts that a condition asks for; no channel of the record.
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
    pub chosen: Chosen,
    /// What is cut out, its columns by their headers; without the conditions on texts.
    pub cut: Cut,
    /// Columns of texts and the text that each must be.
    pub texts: Vec<(usize, String)>,
}

impl Roles {
    /// Understands a file's headers.
    pub fn new(headings: &Headings, options: &ReadOptions) -> Result<Self, IoError> {
        let columns = &headings.columns;
        let input = chosen(headings, options.input.as_deref(), ColumnRole::Input)?;
        let output = chosen(headings, options.output.as_deref(), ColumnRole::Output)?;
        let reference = chosen(headings, options.reference.as_deref(), ColumnRole::Reference)?;
        let taken = [input, output, reference];
        let time = time_column(headings, options.time.as_deref(), taken)?;
        if time.is_none()
            && taken.iter().all(Option::is_none)
            && let Some(column) = columns.iter().find(|c| is_spectral(c))
        {
            let column = column.header.clone();
            return Err(IoError::FrequencyResponse { place: headings.place(), column });
        }
        let left_out = options.leave_out.iter().map(|name| chosen(headings, Some(name), ColumnRole::LeftOut));
        let left_out = left_out.collect::<Result<Vec<_>, _>>()?;
        let only_chosen = input.is_some() && output.is_some();
        let conditions = Conditions::new(headings, &options.cut)?;
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
            } else if column.name.eq_ignore_ascii_case("valid") {
                Role::Mask
            } else if conditions.texts.iter().any(|(text, _)| *text == i) {
                Role::Texts
            } else if (only_chosen && !conditions.read.contains(&i)) || column.header.is_empty() {
                Role::Skipped
            } else {
                Role::Channel
            }
        };
        let roles: Vec<Role> = columns.iter().enumerate().map(role).collect();
        if !roles.contains(&Role::Channel) {
            return Err(IoError::NoChannels { place: headings.place(), found: headings.list() });
        }
        let header_at =
            |i: Option<usize>| i.and_then(|i| columns.get(i)).map(|c| header_of(&c.name, &c.unit));
        let [input, output, reference] = taken.map(header_at);
        let Conditions { mut cut, texts, .. } = conditions;
        if let Some(turns) = &mut cut.turns {
            turns.column = turns.column.take().or_else(|| input.clone());
        }
        let (texts, in_channels): (Vec<_>, Vec<_>) =
            texts.into_iter().partition(|(column, _)| roles.get(*column) == Some(&Role::Texts));
        // The record says that a channel of numbers is no column of texts.
        cut.conditions.extend(in_channels.into_iter().map(|(column, text)| Condition {
            column: header_at(Some(column)).unwrap_or_default(),
            is: Admitted::Text(text),
        }));
        Ok(Roles { roles, chosen: Chosen { input, output, reference }, cut, texts })
    }

    /// What a reader has to read of each column.
    pub fn wanted(&self) -> Vec<Wanted> {
        let wanted = |role: &Role| match role {
            Role::Skipped => Wanted::Nothing,
            Role::Texts => Wanted::Texts,
            _ => Wanted::Numbers,
        };
        self.roles.iter().map(wanted).collect()
    }
}

/// Columns that a cut looks at.
struct Conditions {
    /// The cut, its columns by their headers, without the conditions on texts.
    cut: Cut,
    /// Columns that it needs as numbers.
    read: Vec<usize>,
    /// Columns that are to hold a text, and the text.
    texts: Vec<(usize, String)>,
}

impl Conditions {
    fn new(headings: &Headings, cut: &Cut) -> Result<Self, IoError> {
        let mut found = Conditions { cut: cut.clone(), read: Vec::new(), texts: Vec::new() };
        found.cut.conditions.clear();
        let position = |asked: &str, role| chosen(headings, Some(asked), role).map(Option::unwrap_or_default);
        let header =
            |i: usize| headings.columns.get(i).map(|c| header_of(&c.name, &c.unit)).unwrap_or_default();
        for condition in &cut.conditions {
            let column = position(&condition.column, ColumnRole::Condition)?;
            match &condition.is {
                Admitted::Text(text) if headings.line.is_none() => {
                    let array = Part::Array(headings.header(column).into());
                    let place = Place::new(&headings.file, array);
                    return Err(IoError::TextCondition { place, text: text.clone() });
                }
                Admitted::Text(text) => found.texts.push((column, text.clone())),
                is => {
                    found.read.push(column);
                    found.cut.conditions.push(Condition { column: header(column), is: is.clone() });
                }
            }
        }
        if let Some(turns) = &mut found.cut.turns
            && let Some(asked) = &turns.column
        {
            let column = position(asked, ColumnRole::Input)?;
            found.read.push(column);
            turns.column = Some(header(column));
        }
        Ok(found)
    }
}

/// The column chosen for a role: by header or bare name exactly, else ignoring case, else by number from 1.
pub(crate) fn chosen(
    headings: &Headings,
    asked: Option<&str>,
    role: ColumnRole,
) -> Result<Option<usize>, IoError> {
    let columns = &headings.columns;
    let Some(asked) = asked.map(str::trim) else { return Ok(None) };
    let same = |fold: &dyn Fn(&str) -> String| -> Vec<usize> {
        let asked = fold(asked);
        (0..columns.len())
            .filter(|&i| {
                let c = &columns[i];
                !c.header.is_empty()
                    && [c.header.as_str(), c.name.as_str(), header_of(&c.name, &c.unit).as_str()]
                        .iter()
                        .any(|text| fold(text) == asked)
            })
            .collect()
    };
    let mut found = same(&str::to_string);
    if found.is_empty() {
        found = same(&str::to_lowercase);
    }
    if found.is_empty()
        && let Ok(number) = asked.parse::<usize>()
        && (1..=columns.len()).contains(&number)
    {
        found.push(number - 1);
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

fn time_column(
    headings: &Headings,
    asked: Option<&str>,
    taken: [Option<usize>; 3],
) -> Result<Option<usize>, IoError> {
    let columns = &headings.columns;
    let free = |i: &usize| !taken.contains(&Some(*i));
    if let Some(index) = chosen(headings, asked, ColumnRole::Time)? {
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
    let has_time_name = |c: &Heading| {
        (is_time(c) || c.unit.symbol().is_empty())
            && ["t", "time", "timestamp"].contains(&c.name.to_lowercase().as_str())
    };
    let by_name: Vec<usize> =
        (0..columns.len()).filter(|&i| has_time_name(&columns[i])).filter(free).collect();
    if by_name.is_empty() {
        // A lone unit of time makes a time column, but never of a column that is named as an input or an output.
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
        candidates: list(candidates),
    }
}

/// Frequency, or the real or imaginary part of something.
fn is_spectral(column: &Heading) -> bool {
    let name = column.name.to_lowercase();
    ["f", "freq", "frequency", "omega"].contains(&name.as_str())
        || (["Hz", "kHz", "MHz"].contains(&column.unit.symbol()) && !name.starts_with(['u', 'y']))
}
