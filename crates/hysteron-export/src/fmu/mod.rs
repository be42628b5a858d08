//! Functional mock-up units: FMI 2.0 and 3.0, co-simulation, source and binary.

mod axes_unit;
mod compiler;
mod platform;
mod variables;
mod zip;

use hysteron_model::realise::RuntimeParts;
use hysteron_numeric::Listener;
use hysteron_rt::Real;

use crate::c::{Numbers, core_files, filling};
use crate::closed_loop::{ClosedLoop, controller_core};
use crate::error::ExportError;
use crate::inverse::{Inverse, inverse_core, inverse_filling};
use crate::number::Precision;
use crate::subject::Subject;
use crate::template::Filling;
pub(crate) use axes_unit::{AxesUnit, InverseOfAxes};
use compiler::Compiler;
use hysteron_io::NamedFile;
pub use platform::Platform;
use variables::{Described, Parameter, build_description, cases, description, parameters};

/// Version of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FmiVersion {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

impl FmiVersion {
    fn number(self) -> u8 {
        match self {
            Self::Two => 2,
            Self::Three => 3,
        }
    }
}

/// The model as FMUs of both versions, `NAME_fmi2.fmu` and `NAME_fmi3.fmu`: source and a binary for each
/// [`Platform`] that a compiler is there for, `compiler` on its own.
///
/// # Errors
/// [`ExportError::Compiler`] where the compiler is not there or fails; as [`crate::c_files`].
pub fn fmu_files(subject: &Subject, compiler: &str) -> Result<Vec<NamedFile>, ExportError> {
    files(subject, None, (compiler, Listener::silent()))
}

/// The inverse as FMUs of both versions, `NAME_inverse_fmi2.fmu` and `NAME_inverse_fmi3.fmu`; as
/// [`fmu_files`].
///
/// # Errors
/// Those of [`fmu_files`].
pub fn inverse_fmu_files(inverse: &Inverse, compiler: &str) -> Result<Vec<NamedFile>, ExportError> {
    files(&inverse.subject, Some(inverse), (compiler, Listener::silent()))
}

/// The units of both versions; the listener hears of the compilations and may stop them.
pub(crate) fn files(
    subject: &Subject,
    inverse: Option<&Inverse>,
    (compiler, listener): (&str, Listener<'_>),
) -> Result<Vec<NamedFile>, ExportError> {
    let parameters = match subject.precision {
        Precision::F32 => of_type::<f32>(subject)?,
        Precision::F64 => of_type::<f64>(subject)?,
    };
    both(&subject.name, (compiler, listener), |version, means| {
        unit(subject, inverse, &parameters, version, means)
    })
}

/// A model of several axes, or its inverse, as units of both versions.
pub(crate) fn axes_files(own: &AxesUnit, means: (&str, Listener<'_>)) -> Result<Vec<NamedFile>, ExportError> {
    let described = Described::several(own);
    both(&own.name, means, |version, means| {
        let mut filling = own.filling.clone();
        filling
            .part("memory of a unit", include_str!("../../templates/fmu/axes_memory.h"))
            .part("functions of a unit", include_str!("../../templates/fmu/axes_functions.h"));
        pack(&described, filling, own.files.clone(), version, means)
    })
}

/// The controller as FMUs of both versions, `NAME_controller_fmi2.fmu` and `NAME_controller_fmi3.fmu`; as
/// [`fmu_files`].
///
/// # Errors
/// Those of [`fmu_files`].
pub fn controller_fmu_files(closed: &ClosedLoop, compiler: &str) -> Result<Vec<NamedFile>, ExportError> {
    controller_files(closed, (compiler, Listener::silent()))
}

/// The units of a controller; the listener hears of the compilations and may stop them.
///
/// # Errors
/// Those of [`fmu_files`].
pub(crate) fn controller_files(
    closed: &ClosedLoop,
    means: (&str, Listener<'_>),
) -> Result<Vec<NamedFile>, ExportError> {
    let described = Described::controller(closed);
    let (sources, filling) = controller_core(closed)?;
    both(&closed.name, means, |version, means| {
        let mut filling = filling.clone();
        filling
            .part("memory of a unit", include_str!("../../templates/fmu/controller_memory.h"))
            .part("functions of a unit", include_str!("../../templates/fmu/controller_functions.h"));
        pack(&described, filling, sources.clone(), version, means)
    })
}

/// Units of both versions; the listener hears of the compilations and may stop them.
fn both(
    name: &str,
    (compiler, listener): (&str, Listener<'_>),
    unit: impl Fn(FmiVersion, (&str, Listener<'_>)) -> Result<Vec<(String, Vec<u8>)>, ExportError>,
) -> Result<Vec<NamedFile>, ExportError> {
    let halves = [(FmiVersion::Two, listener.part(0.0, 0.5)), (FmiVersion::Three, listener.part(0.5, 1.0))];
    halves
        .into_iter()
        .map(|(version, listener)| {
            let bytes = zip::archive(&unit(version, (compiler, listener))?)?;
            Ok(NamedFile::new(format!("{name}_fmi{}.fmu", version.number()), bytes))
        })
        .collect()
}

fn of_type<T: Real + Into<f64>>(subject: &Subject) -> Result<Vec<Parameter>, ExportError> {
    Ok(parameters(subject, &RuntimeParts::<T>::new(&subject.realisation)?.coefficients()))
}

/// Files of one unit.
fn unit(
    subject: &Subject,
    inverse: Option<&Inverse>,
    parameters: &[Parameter],
    version: FmiVersion,
    means: (&str, Listener<'_>),
) -> Result<Vec<(String, Vec<u8>)>, ExportError> {
    let (mut filling, sources) = match inverse {
        None => {
            let filling = filling(subject, Numbers::Tunable)?;
            let sources = core_files(subject, &filling)?;
            (filling, sources)
        }
        Some(inverse) => {
            let filling = inverse_filling(inverse, Numbers::Tunable)?;
            let sources = inverse_core(inverse, &filling)?;
            (filling, sources)
        }
    };
    filling.flag("inverse", inverse.is_some());
    filling
        .key("PARAMETER_CASES", cases(parameters))
        .part("memory of a unit", include_str!("../../templates/fmu/one_memory.h"))
        .part("functions of a unit", include_str!("../../templates/fmu/one_functions.h"));
    pack(&Described::one(subject, inverse, parameters), filling, sources, version, means)
}

/// Files of a unit around the C source of what it runs.
fn pack(
    described: &Described,
    mut filling: Filling,
    mut sources: Vec<NamedFile>,
    version: FmiVersion,
    (compiler, listener): (&str, Listener<'_>),
) -> Result<Vec<(String, Vec<u8>)>, ExportError> {
    let token = token(&sources, version);
    filling.key("TOKEN", &token);
    let (types, functions, name) = match version {
        FmiVersion::Two => (
            include_str!("../../templates/fmu/fmi2_types.h"),
            include_str!("../../templates/fmu/fmi2.c"),
            "fmi2",
        ),
        FmiVersion::Three => (
            include_str!("../../templates/fmu/fmi3_types.h"),
            include_str!("../../templates/fmu/fmi3.c"),
            "fmi3",
        ),
    };
    sources.push(NamedFile::new("instance.h", filling.fill(include_str!("../../templates/fmu/instance.h"))?));
    sources.push(NamedFile::new(format!("{name}_types.h"), types));
    sources.push(NamedFile::new(format!("{name}.c"), filling.fill(functions)?));
    let mut main: Vec<String> =
        sources.iter().filter(|f| f.name.ends_with(".c")).map(|f| f.name.clone()).collect();
    main.sort();
    let about = description(described, version, &token, &main);
    let mut files = vec![("modelDescription.xml".to_owned(), about.into_bytes())];
    for platform in Platform::ALL {
        if let Some(command) = platform.compiler(compiler) {
            let compiler = Compiler { command, flags: platform.flags(), listener };
            let library = compiler.library(&sources, &main)?;
            files.push((
                format!("{}/{}.{}", platform.folder(version), described.name, platform.ending()),
                library,
            ));
        }
    }
    if version == FmiVersion::Three {
        files.push((
            "sources/buildDescription.xml".into(),
            build_description(&described.name, &main).into_bytes(),
        ));
    }
    files.extend(sources.into_iter().map(|f| (format!("sources/{}", f.name), f.bytes)));
    Ok(files)
}

/// Token that ties description and binary to each other: two 64-bit FNV-1a sums of the sources.
fn token(sources: &[NamedFile], version: FmiVersion) -> String {
    let sum = |start: u64| {
        sources
            .iter()
            .flat_map(|f| &f.bytes)
            .fold(start, |sum, &b| (sum ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
    };
    format!("{{{:016x}{:016x}}}", sum(0xcbf2_9ce4_8422_2325), sum(u64::from(version.number())))
}
