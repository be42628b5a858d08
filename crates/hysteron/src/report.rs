//! Report of a result as a page.

use std::path::Path;

use hysteron_report::page::Page;
use hysteron_report::write_page;

use crate::Error;

/// A self-contained HTML page: works offline, prints on A4.
#[derive(Clone, Debug)]
pub struct Report(pub(crate) Page);

impl Report {
    /// The page as HTML.
    pub fn to_html(&self) -> String {
        self.0.to_html()
    }

    /// Writes the page; an existing file is replaced in one step.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        Ok(write_page(path.as_ref(), &self.0)?)
    }
}
