//! Delimiters, quotes and decimal marks.

/// Splits a line into fields, trimmed and unquoted. Quotes protect delimiters; a doubled quote inside is one
/// quote.
///
/// # Errors
/// The number of the column (from 1) whose quote is not closed.
pub(crate) fn split_fields(line: &[u8], delimiter: u8) -> Result<Vec<Vec<u8>>, usize> {
    let mut fields = Vec::new();
    let mut field = Vec::new();
    let (mut quoted, mut at) = (false, 0);
    while let Some(&byte) = line.get(at) {
        match byte {
            b'"' if quoted && line.get(at + 1) == Some(&b'"') => {
                field.push(b'"');
                at += 1;
            }
            b'"' if quoted => quoted = false,
            b'"' if field.trim_ascii().is_empty() => {
                field.clear();
                quoted = true;
            }
            _ if byte == delimiter && !quoted => fields.push(std::mem::take(&mut field)),
            _ => field.push(byte),
        }
        at += 1;
    }
    fields.push(field);
    if quoted {
        return Err(fields.len());
    }
    for field in &mut fields {
        *field = field.trim_ascii().to_vec();
    }
    Ok(fields)
}

/// Delimiter of a file, from its header and its first line of data: the first of tab, semicolon, comma that
/// cuts both into the same number (at least 2) of fields; else the one that cuts the header into most.
pub(crate) fn detect_delimiter(header: &[u8], first_row: &[u8]) -> u8 {
    let count = |line: &[u8], d: u8| split_fields(line, d).map_or_else(|column| column, |f| f.len());
    let candidates = [b'\t', b';', b','];
    for d in candidates {
        let n = count(header, d);
        if n >= 2 && n == count(first_row, d) {
            return d;
        }
    }
    let mut best = b',';
    for d in candidates {
        if count(header, d) > count(header, best) {
            best = d;
        }
    }
    best
}

/// Delimiter named by a spreadsheet's first line `sep=;`.
pub(crate) fn declared_delimiter(line: &[u8]) -> Option<u8> {
    match line.strip_prefix(b"sep=")? {
        [delimiter] if matches!(delimiter, b',' | b';' | b'\t') => Some(*delimiter),
        _ => None,
    }
}

/// Number written with a decimal point or a decimal comma; `None` where it is neither.
pub(crate) fn loosely_number(field: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(field).ok()?.trim();
    text.parse().ok().or_else(|| match text.matches(',').count() {
        1 if !text.contains('.') => text.replace(',', ".").parse().ok(),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(line: &str, d: u8) -> Vec<String> {
        split_fields(line.as_bytes(), d).unwrap().into_iter().map(|f| String::from_utf8(f).unwrap()).collect()
    }

    #[test]
    fn fields_are_trimmed_and_unquoted() {
        assert_eq!(split("a, b ,c", b','), ["a", "b", "c"]);
        assert_eq!(split("\"u, V\";\"say \"\"x\"\"\" ; 3", b';'), ["u, V", "say \"x\"", "3"]);
        assert_eq!(split("1,,", b','), ["1", "", ""]);
        assert_eq!(split_fields(b"1,\"2", b','), Err(2));
    }

    #[test]
    fn delimiters_are_detected() {
        assert_eq!(detect_delimiter(b"t_s,u_V", b"0,1"), b',');
        assert_eq!(detect_delimiter(b"t_s;u_V", b"0,5;1,5"), b';');
        assert_eq!(detect_delimiter(b"t_s\tu_V", b"0,5\t1,5"), b'\t');
        assert_eq!(detect_delimiter(b"\"a;b\",c", b"1,2"), b',');
        assert_eq!(detect_delimiter(b"t_s,u_V", b"0,1,5"), b',');
        assert_eq!(declared_delimiter(b"sep=;"), Some(b';'));
        assert_eq!(declared_delimiter(b"sep=x"), None);
    }
}
