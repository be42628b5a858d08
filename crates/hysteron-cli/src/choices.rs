//! Flags that take one of a closed set of the library, by its name.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Parses the name of one of `values`; help and completion list the names with their summaries.
pub fn one_of<T: Copy + Send + Sync + 'static>(
    values: impl IntoIterator<Item = T>,
    name: fn(T) -> &'static str,
    summary: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let values: Vec<T> = values.into_iter().collect();
    let possible = values.iter().map(|&value| PossibleValue::new(name(value)).help(summary(value)));
    PossibleValuesParser::new(possible.collect::<Vec<_>>()).try_map(move |given| {
        values.iter().find(|&&value| name(value) == given).copied().ok_or("expected one of the names")
    })
}
