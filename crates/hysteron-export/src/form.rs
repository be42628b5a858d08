//! The forms of an export: the one list of them, and the files of each.

use std::str::FromStr;

use hysteron_io::NamedFile;
use hysteron_numeric::Listener;
use serde::{Deserialize, Serialize};

use crate::c::c_files;
use crate::closed_loop::{ClosedLoop, controller_files};
use crate::error::ExportError;
use crate::fmu;
use crate::inverse::{Inverse, inverse_files};
use crate::matlab::{matlab_files, matlab_inverse_files};
use crate::rust_crate::crate_files;
use crate::simulink::{simulink_files, simulink_inverse_files};
use crate::subject::Subject;

/// Form of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// C99.
    C,
    /// A `no_std` Rust crate.
    Rust,
    /// Functional mock-up units, FMI 2.0 and 3.0.
    Fmu,
    /// Functions of MATLAB and GNU Octave.
    Matlab,
    /// C99 with a Simulink S-function around it.
    Simulink,
}

/// What an export uses of the machine that it is made on.
#[derive(Clone, Copy, Debug)]
pub struct Means<'a> {
    /// C compiler that makes the binaries of [`Form::Fmu`].
    pub compiler: &'a str,
    /// Hears of a compilation, and may stop it.
    pub listener: Listener<'a>,
}

/// What is exported around a model.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Around<'a> {
    /// Nothing.
    Nothing,
    /// Its inverse.
    Inverse(&'a Inverse),
    /// Its inverse, and a controller that runs it.
    Controller(&'a ClosedLoop),
}

impl<'a> Around<'a> {
    /// The inverse.
    pub fn inverse(self) -> Option<&'a Inverse> {
        match self {
            Self::Nothing => None,
            Self::Inverse(inverse) => Some(inverse),
            Self::Controller(closed) => Some(&closed.inverse),
        }
    }

    /// The controller.
    pub fn controller(self) -> Option<&'a ClosedLoop> {
        if let Self::Controller(closed) = self { Some(closed) } else { None }
    }
}

impl Form {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::C, Self::Rust, Self::Fmu, Self::Matlab, Self::Simulink];

    /// Name, as it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::Rust => "rust",
            Self::Fmu => "fmu",
            Self::Matlab => "matlab",
            Self::Simulink => "simulink",
        }
    }

    /// What it is, in a line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::C => "C99 source",
            Self::Rust => "A no_std crate",
            Self::Fmu => "FMI 2.0 and 3.0 for co-simulation",
            Self::Matlab => "Functions of MATLAB and GNU Octave",
            Self::Simulink => "C99 source with an S-function",
        }
    }

    /// The files that it writes.
    pub fn contents(self) -> &'static str {
        match self {
            Self::C => {
                "NAME.h, NAME.c (no malloc; <math.h> and memcpy alone), NAME_selftest.c with golden vectors"
            }
            Self::Rust => {
                "a no_std crate with the source of hysteron-rt beside it, and the same golden vectors as a test"
            }
            Self::Fmu => {
                "NAME_fmi2.fmu and NAME_fmi3.fmu for co-simulation: source, and binaries for Linux and \
                 Windows x86-64 and Linux aarch64, made by $CC or cc and Debian's cross compilers where \
                 they are installed"
            }
            Self::Matlab => {
                "NAME.m (no toolbox; GNU Octave too), NAME_parameters.m, NAME_selftest.m; double precision"
            }
            Self::Simulink => "the files of c, and NAME_sfun.c, an S-function for mex",
        }
    }

    /// Whether it is there in single precision.
    pub fn has_single_precision(self) -> bool {
        self != Self::Matlab
    }

    /// Whether it is there for controllers with feedback.
    pub fn has_controllers(self) -> bool {
        matches!(self, Self::C | Self::Rust | Self::Fmu)
    }

    /// The files of a model, and of what is around it.
    ///
    /// # Errors
    /// Those of the form: [`c_files`], [`crate::rust_files`], [`matlab_files`]; of a compiler for an FMU;
    /// [`ExportError::Stopped`] by the listener.
    pub(crate) fn files(
        self,
        subject: &Subject,
        around: Around<'_>,
        means: Means<'_>,
    ) -> Result<Vec<NamedFile>, ExportError> {
        let Means { compiler, listener } = means;
        let (inverse, controller) = (around.inverse(), around.controller());
        let units = 1.0 + [inverse.is_some(), controller.is_some()].map(f64::from).iter().sum::<f64>();
        let part = |k: f64| (compiler, listener.part(k / units, (k + 1.0) / units));
        listener.tell("sources", 0.0).map_err(|_| ExportError::Stopped)?;
        let mut files = match self {
            Self::C => c_files(subject)?,
            Self::Rust => crate_files(subject, inverse, controller)?,
            Self::Fmu => fmu::files(subject, None, part(0.0))?,
            Self::Matlab => matlab_files(subject)?,
            Self::Simulink => simulink_files(subject)?,
        };
        if let Some(inverse) = inverse {
            files.extend(match self {
                // The files of a controller contain those of its inverse.
                Self::C if controller.is_some() => Vec::new(),
                Self::C => inverse_files(inverse)?,
                Self::Rust => Vec::new(),
                Self::Fmu => fmu::files(&inverse.subject, Some(inverse), part(1.0))?,
                Self::Matlab => matlab_inverse_files(inverse)?,
                Self::Simulink => simulink_inverse_files(inverse)?,
            });
        }
        if let Some(controller) = controller {
            files.extend(match self {
                Self::C => controller_files(controller)?,
                Self::Fmu => fmu::controller_files(controller, part(2.0))?,
                Self::Rust | Self::Matlab | Self::Simulink => Vec::new(),
            });
        }
        Ok(files)
    }
}

impl FromStr for Form {
    type Err = ExportError;

    fn from_str(name: &str) -> Result<Self, ExportError> {
        let found = Self::ALL.into_iter().find(|form| form.name() == name);
        found.ok_or_else(|| ExportError::Form { name: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_found_by_its_name() {
        for form in Form::ALL {
            assert_eq!(form.name().parse::<Form>().unwrap(), form);
        }
        assert!("cobol".parse::<Form>().unwrap_err().to_string().contains("matlab"));
    }
}
