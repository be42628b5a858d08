//! Pages and figures to files, each written completely or not at all.

use std::path::Path;

use hysteron_io::atomic_file::{AtomicWriteError, write_atomically};

use crate::figure::Figure;
use crate::page::Page;

/// Writes a page to `path`; an existing file is replaced in one step.
///
/// # Errors
/// [`AtomicWriteError`] names the file and the step that failed; what `path` held before is untouched.
pub fn write_page(path: &Path, page: &Page) -> Result<(), AtomicWriteError> {
    write_atomically(path, page.to_html().as_bytes())
}

/// Every figure of a page as a file: its name, `STEM-01-TITLE.svg` …, and its content, in the order of the
/// page.
pub fn figure_files(stem: &str, page: &Page) -> Vec<(String, String)> {
    let file = |(i, figure): (usize, &Figure)| {
        let name = format!("{}-{:02}-{}.svg", file_name(stem), i + 1, file_name(&figure.title));
        (name, figure.to_svg())
    };
    page.figures().into_iter().enumerate().map(file).collect()
}

/// Lower-case letters and digits of `text` joined by `-`, at most 48 of them; `figure` when there are none.
fn file_name(text: &str) -> String {
    let mut name = String::new();
    for c in text.chars() {
        if c.is_ascii_alphanumeric() {
            name.push(c.to_ascii_lowercase());
        } else if !name.is_empty() && !name.ends_with('-') {
            name.push('-');
        }
        if name.len() >= 48 {
            break;
        }
    }
    let name = name.trim_end_matches('-');
    if name.is_empty() { "figure".to_owned() } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, Panel};
    use crate::page::Section;

    #[test]
    fn titles_become_file_names_that_stay_in_their_folder() {
        assert_eq!(file_name("Figure 8. Loops at 10 Hz (µm)"), "figure-8-loops-at-10-hz-m");
        assert_eq!(file_name("../../etc/passwd"), "etc-passwd");
        assert_eq!(file_name("…"), "figure");
    }

    #[test]
    fn a_page_and_its_figures_are_written_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let figure = Figure::new("Loop").panel(Panel::new(Axis::linear("u", "V"), Axis::linear("y", "µm")));
        let page = Page::new("Stack").section(Section::new("Loop").block(figure));
        let path = folder.path().join("report.html");
        write_page(&path, &Page::new("before")).unwrap();
        write_page(&path, &page).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), page.to_html());
        let figures = figure_files("stack", &page);
        assert_eq!(figures[0].0, "stack-01-loop.svg");
        assert!(figures[0].1.starts_with("<svg"));
    }

    #[test]
    fn a_folder_that_does_not_exist_is_named_in_the_message() {
        let error = write_page(Path::new("no/such/folder/report.html"), &Page::new("x")).unwrap_err();
        assert!(error.to_string().contains("no/such/folder"), "{error}");
    }
}
