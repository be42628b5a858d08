//! XLSX workbooks: the numbers that pandas reads, what is refused, and that no damage makes the reader panic.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod damage;
mod oracle;

use std::io::{Cursor, Write};

use hysteron_io::{IoError, ReadOptions, contents_of_bytes, read_input_output_bytes, read_record_bytes};
use hysteron_model::record::TimeBase;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// A workbook of one sheet with these cells, each a reference and its content in XML.
fn workbook(dimension: &str, cells: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let mut add = |name: &str, text: &str| {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        zip.start_file(name, options).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    };
    let relations = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    let package = "http://schemas.openxmlformats.org/package/2006/relationships";
    add(
        "_rels/.rels",
        &format!(
            "<Relationships xmlns=\"{package}\"><Relationship Id=\"r1\" Type=\"{relations}/officeDocument\" \
             Target=\"xl/workbook.xml\"/></Relationships>"
        ),
    );
    add(
        "xl/workbook.xml",
        &format!(
            "<workbook xmlns=\"{main}\" xmlns:r=\"{relations}\"><sheets>\
             <sheet name=\"run\" sheetId=\"1\" r:id=\"r1\"/></sheets></workbook>"
        ),
    );
    add(
        "xl/_rels/workbook.xml.rels",
        &format!(
            "<Relationships xmlns=\"{package}\"><Relationship Id=\"r1\" Type=\"{relations}/worksheet\" \
             Target=\"worksheets/sheet1.xml\"/></Relationships>"
        ),
    );
    let mut rows = String::new();
    let mut last = String::new();
    for (reference, content) in cells {
        let row = reference.trim_start_matches(|c: char| c.is_ascii_alphabetic());
        if row != last {
            rows += if last.is_empty() { "" } else { "</row>" };
            rows += &format!("<row r=\"{row}\">");
            last = row.to_owned();
        }
        let kind = if content.starts_with("<is>") { " t=\"inlineStr\"" } else { "" };
        rows += &format!("<c r=\"{reference}\"{kind}>{content}</c>");
    }
    add(
        "xl/worksheets/sheet1.xml",
        &format!(
            "<worksheet xmlns=\"{main}\"><dimension \
             ref=\"{dimension}\"/><sheetData>{rows}</row></sheetData></worksheet>"
        ),
    );
    zip.finish().unwrap().into_inner()
}

const HEADER: [(&str, &str); 3] =
    [("A1", "<is><t>t_s</t></is>"), ("B1", "<is><t>u_V</t></is>"), ("C1", "<is><t>y_um</t></is>")];
const ROWS: [(&str, &str); 6] = [
    ("A2", "<v>0</v>"),
    ("B2", "<v>1.5</v>"),
    ("C2", "<v>-2</v>"),
    ("A3", "<v>0.5</v>"),
    ("B3", "<v>2.5</v>"),
    ("C3", "<v>1e-3</v>"),
];

fn loop_of_two() -> Vec<u8> {
    workbook("A1:C3", &[&HEADER[..], &ROWS[..]].concat())
}

#[test]
fn the_values_are_those_that_pandas_and_openpyxl_read() {
    let Some((_folder, cases)) = oracle::written_by("xlsx.py") else { return };
    assert!(cases.len() >= 150, "{} files", cases.len());
    assert!(oracle::compare(&cases) >= 2 * cases.len());
    eprintln!("{} files", cases.len());
}

#[test]
fn columns_that_are_named_with_their_units_need_no_choice() {
    let outcome = read_input_output_bytes("run.xlsx", &loop_of_two(), &ReadOptions::default()).unwrap();
    assert_eq!((outcome.data.u, outcome.data.y), (vec![1.5, 2.5], vec![-2.0, 1e-3]));
    let record = read_record_bytes("run", &loop_of_two(), &ReadOptions::default()).unwrap();
    assert_eq!(record.time, TimeBase::uniform(2.0));
}

#[test]
fn a_sheet_that_promises_all_cells_there_can_be_is_read() {
    let bytes = workbook("A1:XFD1048576", &[&HEADER[..], &ROWS[..], &[("XFD1048576", "<v>1</v>")]].concat());
    let record = read_record_bytes("run.xlsx", &bytes, &ReadOptions::default()).unwrap();
    assert_eq!(record.channels[0].samples, [1.5, 2.5]);
}

#[test]
fn a_column_with_text_or_gaps_is_refused_where_it_is_chosen() {
    let mut cells = [&HEADER[..], &ROWS[..]].concat();
    cells[5] = ("C2", "<is><t>broken</t></is>");
    let refusal =
        read_record_bytes("run.xlsx", &workbook("A1:C3", &cells), &ReadOptions::default()).unwrap_err();
    assert!(matches!(refusal, IoError::ArrayType { .. }), "{refusal}");
    assert!(refusal.to_string().contains("`broken` in row 2"), "{refusal}");
    cells.remove(5);
    let refusal =
        read_record_bytes("run.xlsx", &workbook("A1:C3", &cells), &ReadOptions::default()).unwrap_err();
    assert!(refusal.to_string().contains("gaps (above row 3)"), "{refusal}");
}

#[test]
fn columns_without_header_are_called_by_their_letters() {
    let listed = contents_of_bytes("run.xlsx", &workbook("A1:C3", &ROWS), &ReadOptions::default()).unwrap();
    let paths: Vec<&str> = listed.iter().map(|content| content.path.as_str()).collect();
    assert_eq!(paths, ["run!A", "run!B", "run!C"]);
}

#[test]
fn a_file_that_unpacks_to_more_than_allowed_is_refused() {
    let options = ReadOptions { max_bytes: 2000, ..ReadOptions::default() };
    let many: Vec<(&str, &str)> = std::iter::repeat_n(("A2", "<v>1</v>"), 1000).collect();
    let refusal = read_record_bytes("run.xlsx", &workbook("A1:A2", &many), &options).unwrap_err();
    assert!(refusal.to_string().contains("max_bytes"), "{refusal}");
    // 300 MB of spaces in a file of 300 kB.
    let spaces = " ".repeat(300 << 20);
    let bytes = workbook("A1:A2", &[("A2", &spaces)]);
    assert!(bytes.len() < 1 << 20);
    let refusal = read_record_bytes("run.xlsx", &bytes, &ReadOptions::default()).unwrap_err();
    assert!(refusal.to_string().contains("larger than 268435456 bytes"), "{refusal}");
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    damage::survive("run.xlsx", &[&loop_of_two()], 1000, 21);
}
