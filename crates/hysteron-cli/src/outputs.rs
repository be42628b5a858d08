//! Output files of one command, written together: when one fails, none is there, and what was there stays.

use std::path::{Path, PathBuf};

use hysteron_io::{Batch, IoError};
use hysteron_model::Model;
use hysteron_model::record::Record;
use hysteron_report::figure_files;
use hysteron_report::page::Page;

use crate::console;
use crate::failure::Failure;
use crate::output::cannot_write;

/// Files that are to appear together, and what is said when they have.
#[derive(Default)]
pub struct Outputs {
    batch: Batch,
    added: usize,
    said: Vec<String>,
}

impl Outputs {
    /// Adds a file; `what` names its content, e.g. `the report`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, what: &str, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        let added = self.batch.add(path, bytes);
        added.map_err(|e| self.nothing_written(cannot_write(what, path, e)))?;
        self.added += 1;
        Ok(())
    }

    /// Adds a record, in the format of the file's extension.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add_record(&mut self, what: &str, path: &Path, record: &Record) -> Result<(), Failure> {
        let added = self.batch.add_record(path, record);
        added.map_err(|e| {
            self.nothing_written(match e {
                IoError::Write(e) => cannot_write(what, path, e),
                e => Failure::new(format!("cannot write {what} to {}", path.display())).because(e),
            })
        })?;
        self.added += 1;
        Ok(())
    }

    /// Adds a model file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add_model(&mut self, path: &Path, model: &Model) -> Result<(), Failure> {
        let failure = || Failure::new(format!("cannot write the model to {}", path.display()));
        let text = model.to_json().map_err(|e| self.nothing_written(failure().because(e)))?;
        self.add("the model", path, text.as_bytes())
    }

    /// Adds every figure of a page; the folder is made.
    ///
    /// # Errors
    /// If the folder cannot be made or a figure not written.
    pub fn add_figures(&mut self, folder: &Path, stem: &str, page: &Page) -> Result<(), Failure> {
        let failure = || Failure::new(format!("cannot write the figures to {}", folder.display()));
        std::fs::create_dir_all(folder).map_err(|e| self.nothing_written(failure().because(e)))?;
        let figures = figure_files(stem, page);
        for (name, svg) in &figures {
            self.add("the figures", &folder.join(name), svg.as_bytes())?;
        }
        self.tell(format!("{} figures written to {}", figures.len(), folder.display()));
        Ok(())
    }

    /// Keeps a message until all files are there.
    pub fn tell(&mut self, message: impl Into<String>) {
        self.said.push(message.into());
    }

    /// Gives all files their names, and says so.
    ///
    /// # Errors
    /// If that cannot be done; the message names the file, and those that are there nevertheless.
    pub fn finish(self) -> Result<(), Failure> {
        let others = self.added > 1;
        self.batch.finish().map_err(|e| {
            let path = e.source.path.clone();
            let failure = cannot_write("the result", &path, e.source);
            if others { failure.because_also(what_is_there(&e.written)) } else { failure }
        })?;
        for message in &self.said {
            console::message(message);
        }
        Ok(())
    }

    fn nothing_written(&self, failure: Failure) -> Failure {
        if self.added > 0 { failure.because_also(what_is_there(&[])) } else { failure }
    }
}

fn what_is_there(written: &[PathBuf]) -> String {
    if written.is_empty() {
        return "none of the files of this result was written, and what was there stays".to_owned();
    }
    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    format!("written were {}, and nothing else", names.join(", "))
}
