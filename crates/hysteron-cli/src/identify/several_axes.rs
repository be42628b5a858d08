//! Records of several actuators that were given as records of one.

use std::path::Path;

use hysteron_identify::IdentifyError;
use hysteron_model::Advice;

use super::Identify;
use crate::advice;
use crate::failure::Failure;

impl Identify {
    /// Names the flags that identify all actuators together, where one of the records has further drives that
    /// move on their own.
    pub(super) fn naming_axes(&self, failure: Failure) -> Failure {
        let mut paths = self.records.iter().chain(&self.static_records).chain(&self.dynamic_records);
        match paths.find_map(|path| Some((path, self.axes_of(path)?))) {
            Some((path, axes)) => failure.hint_first(format!(
                "{}: several drives move on their own; all actuators together are {}",
                path.display(),
                advice::in_flags(&axes)
            )),
            None => failure,
        }
    }

    /// [`Self::naming_axes`] where a model of one input does not describe the records.
    pub(super) fn naming_axes_of(&self, error: &IdentifyError, failure: Failure) -> Failure {
        match error {
            IdentifyError::ModelClass { .. }
            | IdentifyError::OtherKind { .. }
            | IdentifyError::DeadBand { .. } => self.naming_axes(failure),
            _ => failure,
        }
    }

    fn axes_of(&self, path: &Path) -> Option<Advice> {
        let drive = self.columns.of_drive();
        drive.read_record(path).ok()?.several_axes(drive.input())
    }
}
