//! Files of one result, written together: each beside its place first, all named at the end, so that a full
//! disk leaves either all of them or none.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use hysteron_model::record::Record;

use crate::IoError;
use crate::atomic_file::{AtomicWriteError, OPENING, Target, named, staged, write_atomically};
use crate::write::produce;

/// Files that are to appear together.
#[derive(Debug, Default)]
pub struct Batch(Vec<Staged>);

#[derive(Debug)]
enum Staged {
    File {
        path: PathBuf,
        folder: PathBuf,
        place: PathBuf,
        temporary: tempfile::NamedTempFile,
    },
    /// A device, pipe or descriptor: what goes there cannot be taken back.
    Direct {
        path: PathBuf,
        bytes: Vec<u8>,
    },
}

/// Files of which one could not be given its name, or be written to a device.
#[derive(Debug, thiserror::Error)]
#[error("{source}")]
#[non_exhaustive]
pub struct BatchError {
    /// The file, and what failed.
    #[source]
    pub source: AtomicWriteError,
    /// Those that were written before; none of the others was touched.
    pub written: Vec<PathBuf>,
}

impl Batch {
    /// Adds a file with its content. Nothing has its name yet.
    ///
    /// # Errors
    /// Those of [`write_atomically`].
    pub fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<(), AtomicWriteError> {
        self.add_with(path, |out| out.write_all(bytes))
    }

    /// Adds a record, in the format of its file's extension ([`write_record`](crate::write_record)).
    ///
    /// # Errors
    /// Those of [`write_record`](crate::write_record).
    pub fn add_record(&mut self, path: &Path, record: &Record) -> Result<(), IoError> {
        produce(path, record, |content| self.add_with(path, content))
    }

    /// Like [`Self::add`], for content that is produced piece by piece.
    fn add_with(
        &mut self,
        path: &Path,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), AtomicWriteError> {
        let failed = |action| move |source| AtomicWriteError { path: path.to_path_buf(), action, source };
        let target = Target::of(path).map_err(failed(OPENING))?;
        let path = path.to_path_buf();
        self.0.push(match target {
            Target::File { folder, path: place } => {
                let temporary = staged(&path, &folder, content)?;
                Staged::File { path, folder, place, temporary }
            }
            Target::Stream(_) | Target::Descriptor(_) => {
                let mut bytes = Vec::new();
                content(&mut bytes).map_err(failed("writing"))?;
                Staged::Direct { path, bytes }
            }
        });
        Ok(())
    }

    /// Gives all files their names, and writes what goes to a device or a pipe before.
    ///
    /// # Errors
    /// Those of [`write_atomically`]: a device that is full. The files have their names or not, all of them,
    /// unless the operating system refuses a later rename in a folder in which it made a file; the error says
    /// which were written.
    pub fn finish(self) -> Result<(), BatchError> {
        let (files, streams): (Vec<Staged>, Vec<Staged>) =
            self.0.into_iter().partition(|staged| matches!(staged, Staged::File { .. }));
        let mut written = Vec::new();
        for staged in streams.into_iter().chain(files) {
            let (path, done) = match staged {
                Staged::Direct { path, bytes } => {
                    let done = write_atomically(&path, &bytes);
                    (path, done)
                }
                Staged::File { path, folder, place, temporary } => {
                    let done = named(&path, &folder, place, temporary);
                    (path, done)
                }
            };
            match done {
                Ok(()) => written.push(path),
                Err(source) => return Err(BatchError { source, written }),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use hysteron_model::record::{Channel, TimeBase, Unit};

    use super::*;

    #[test]
    fn a_batch_is_written_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        write_atomically(&path("model"), b"old").unwrap();
        let mut batch = Batch::default();
        batch.add(&path("model"), b"new").unwrap();
        let err = batch.add(&path("no/report"), b"page").unwrap_err();
        assert!(err.to_string().contains("no/report"), "{err}");
        drop(batch);
        assert_eq!(std::fs::read(path("model")).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside it");
        let mut batch = Batch::default();
        batch.add(&path("model"), b"new").unwrap();
        batch.add(&path("report"), b"page").unwrap();
        batch.finish().unwrap();
        assert_eq!(std::fs::read(path("model")).unwrap(), b"new");
        assert_eq!(std::fs::read(path("report")).unwrap(), b"page");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_keeps_the_other_files_of_a_batch_from_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("model");
        let mut batch = Batch::default();
        batch.add(&model, b"new").unwrap();
        batch.add(Path::new("/dev/full"), b"page").unwrap();
        let err = batch.finish().unwrap_err();
        assert!(err.to_string().contains("/dev/full"), "{err}");
        assert_eq!(err.written, Vec::<PathBuf>::new());
        assert!(!model.exists());
    }

    #[test]
    fn a_name_that_is_taken_in_the_meantime_is_told_with_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let mut batch = Batch::default();
        for name in ["model", "report", "series"] {
            batch.add(&path(name), b"new").unwrap();
        }
        std::fs::create_dir(path("report")).unwrap();
        let err = batch.finish().unwrap_err();
        assert!(err.to_string().contains("report"), "{err}");
        assert_eq!(err.written, [path("model")]);
        assert!(!path("series").exists());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "no temporary file stays");
    }

    #[test]
    fn a_record_of_a_batch_is_that_of_write_record() {
        let folder = tempfile::tempdir().unwrap();
        let record = Record {
            name: "run".into(),
            time: TimeBase::uniform(10.0),
            channels: vec![Channel { name: "u".into(), unit: Unit::new("V"), samples: vec![1.0, 2.5] }],
            valid: None,
            source: None,
        };
        for name in ["a.csv", "a.npz", "a.mat"] {
            let (alone, together) = (folder.path().join(name), folder.path().join(format!("b_{name}")));
            crate::write_record(&alone, &record).unwrap();
            let mut batch = Batch::default();
            batch.add_record(&together, &record).unwrap();
            assert!(!together.exists());
            batch.finish().unwrap();
            assert_eq!(std::fs::read(alone).unwrap(), std::fs::read(together).unwrap(), "{name}");
        }
    }
}
