//! Titles of pages: of which device and which records they speak.

/// `a.csv`, `a.csv and b.csv`, `a.csv and 4 other records`.
pub(crate) fn of_records<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    match names[..] {
        [] => String::new(),
        [one] => one.to_owned(),
        [one, other] => format!("{one} and {other}"),
        [one, ..] => format!("{one} and {} other records", names.len() - 1),
    }
}

/// Device, where it has a name, then the records, then `what` was made of them.
pub(crate) fn title<'a>(
    device: Option<&str>,
    records: impl IntoIterator<Item = &'a str>,
    what: &str,
) -> String {
    let subject = [device.unwrap_or_default().to_owned(), of_records(records)];
    let subject: Vec<String> = subject.into_iter().filter(|part| !part.is_empty()).collect();
    if subject.is_empty() { what.to_owned() } else { format!("{}: {what}", subject.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_names_device_records_and_subject() {
        assert_eq!(title(Some("P-885"), ["a.csv"], "a lag"), "P-885, a.csv: a lag");
        assert_eq!(title(None, ["a", "b"], "a lag"), "a and b: a lag");
        assert_eq!(title(None, ["a", "b", "c"], "a lag"), "a and 2 other records: a lag");
        assert_eq!(title(None, [], "a lag"), "a lag");
    }
}
