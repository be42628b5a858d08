//! Hysteron identifies validated models of piezo actuators from measured records, and runs their inverse in a
//! controller.
//!
//! The model is a Hammerstein model, hysteresis followed by fractional-order dynamics with delay, after L.
//! Yang, Z. Zhao, Y. Zhang and D. Li, *Micromachines* 13 (2022) 42, doi:10.3390/mi13010042; or an oscillator,
//! modes or branches ([`Kind`]). Units of all interfaces: V, µm, s, Hz. [`prelude`] has the types that most
//! programs need.
//!
//! ```
//! use hysteron::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # std::env::set_current_dir(folder.path())?;
//! # let line = |k: u32| {
//! #     let t = f64::from(k) / 200.0;
//! #     let u = (2.0 - f64::from(k / 200) * 0.5) * (1.0 - (std::f64::consts::TAU * t).cos());
//! #     format!("{t},{u},{}\n", 15.0 * u - 0.25 * u * u)
//! # };
//! # let text: String = std::iter::once("t_s,u_V,y_um\n".to_owned()).chain((0..600).map(line)).collect();
//! # std::fs::write("loop.csv", &text)?;
//! # std::fs::write("unseen.csv", &text)?;
//! let records = hysteron::read(["loop.csv"])?;
//! let fit = Identify::new(&records)
//!     .hysteresis(HysteresisForm::plays(12))
//!     .watch(|event| {
//!         eprintln!("{}: {:.0} %", event.stage, 100.0 * event.fraction);
//!         ControlFlow::Continue(())
//!     })
//!     .run()?;
//! fit.save("model.json")?;
//! fit.report()?.save("report.html")?;
//!
//! let model = Model::load("model.json")?;
//! let drive = Signal::uniform(vec![0.0, 1.0, 2.0, 1.0], 200.0, "V");
//! let y = model.simulate(&drive, Start::AsIdentified)?;
//! assert_eq!(y.samples.len(), 4);
//!
//! let unseen = hysteron::read(["unseen.csv"])?.remove(0);
//! let score = model.score(&unseen, Scoring::default())?;
//! assert!(score.rmse < 0.05, "RMSE {} {}", score.rmse, score.unit);
//!
//! let reference = Signal::uniform(vec![10.0, 10.5, 11.0, 11.5], 200.0, "um");
//! let drive = model.invert(&reference, Limits::range(0.0, 4.0))?;
//! assert!(drive.samples.iter().all(|u| (0.0..=4.0).contains(u)));
//!
//! let mut controller = model.controller(10_000.0, Limits::range(0.0, 4.0).slew(5e3))?;
//! let voltage = controller.step(10.0).voltage;
//! assert!((0.0..=4.0).contains(&voltage));
//!
//! model.export(10_000.0, Target::C { float: Precision::F32 })?.write("firmware")?;
//! # assert!(std::path::Path::new("firmware/model.c").exists());
//! # assert!(std::path::Path::new("report.html").exists());
//! # Ok(())
//! # }
//! ```
//!
//! # Guided tour, in the order of the data
//!
//! **Files to records.** [`read`] takes files of any known format; [`read_with`] takes [`ReadOptions`]:
//! columns chosen, renamed ([`Rename`]), left out, and a [`Cut`] by time, by [`Turns`] of the drive, or by
//! [`Condition`]s on the value of a column ([`Admitted`]). [`contents`] lists what a file holds, one
//! [`Content`] an array. A [`Record`] is [`Channel`]s, each with its [`Unit`], on a [`TimeBase`]. [`Prepare`]
//! joins, scales, detrends and resamples records; the result, [`Prepared`], has a [`PreparedSummary`].
//! [`write`](write()) writes a record. A [`Signal`] is one channel with its time base: a drive or a
//! reference; [`InterSample`] is its interpolation between samples.
//!
//! **Records to a model.** [`Identify`] takes records and options; options that are not set are chosen from
//! the records. The hysteresis block is a [`HysteresisForm`], or chosen by held-out error
//! ([`FamilyChoice`]); the dynamic block a [`DynamicsChoice`],
//! discretised by a [`Scheme`], with [`Creep`] as a factor. Every option of a kind is in its [`Task`]: the
//! [`Method`], the [`RecordRole`] of each record. While it runs, a [`Watch`] receives [`Event`]s, a [`Stop`]
//! ends it from another thread, and [`Searches`] are the state from which an interrupted fit is resumed.
//!
//! **The result.** A [`Fit`] holds the [`Model`], its numbers as [`FitParameter`]s with standard errors,
//! training scores, and [`Finding`]s, each of a [`FindingKind`]: verdict, advice, warning. [`Fit::report`]
//! makes a [`Report`], one HTML page.
//!
//! **Which structure.** [`Compare`] fits [`Candidate`]s to all records but the held-out ones and simulates
//! them on those; a [`Comparison`] ranks them and identifies the preferred one.
//!
//! **Simulation and scores.** [`Model::load`] reads a model file of any [`Kind`]. [`Model::simulate`] runs a
//! drive from a [`Start`]. [`Model::score`] compares with a record as [`Scoring`] says ([`OffsetTreatment`]
//! of the sensor's offset): a [`Score`] holds the [`Scores`] of every output, a [`RunScore`] those of a run
//! in parts; a [`Remark`] says where the model extrapolates.
//!
//! **The next experiment.** [`Model::design`] and [`Fit::design`] make the drive of a given length, within
//! range and slew rate, after which the model is known best for a [`Purpose`]: [`DesignOptions`] in, a
//! [`Design`] out, with the standard errors to expect ([`Expected`], [`DesignSummary`]).
//!
//! **Its inverse.** [`Model::invert`] makes the drive for a reference within [`Limits`];
//! [`Model::controller`] is a [`Controller`] that steps sample by sample; [`Model::decouple`] and
//! [`DecouplingController`] drive several axes. [`Model::track`] simulates several
//! controllers following a reference ([`TrackOptions`]), on the model itself or on a [`Stage`]: a
//! [`Tracking`] holds the errors and bandwidths of each. [`Model::export`] writes an [`Export`] for a
//! [`Target`], C99, `no_std` Rust, FMU, MATLAB or Simulink, in a [`Precision`].
//!
//! **Errors.** [`Error`] contains the error of the layer where it arose. Not every [`Kind`] has every
//! [`Capability`]; one that is missing is the error [`Unsupported`].
//!
//! # Behind the facade
//!
//! `hysteron-model` (records, hysteresis, dynamics, simulation, inversion), `hysteron-identify`,
//! `hysteron-io`, `hysteron-report`, `hysteron-export`, and `hysteron-rt`, the arithmetic of one sample
//! without `std`. Layers, rules and three walks through the code: `docs/architecture.md`.
#![forbid(unsafe_code)]

mod compare;
mod error;
mod export;
mod identify;
mod model;
pub mod prelude;
mod report;

pub use compare::{Compare, Comparison};
pub use error::Error;
pub use export::{Export, Target};
pub use identify::{Fit, Identify};
pub use model::Model;
pub use report::Report;

#[doc(inline)]
pub use hysteron_export::Precision;
#[doc(inline)]
pub use hysteron_identify::design::{Design, DesignOptions, DesignSummary, Expected, Purpose};
#[doc(inline)]
pub use hysteron_identify::{
    DynamicsChoice, Event, FamilyChoice, Finding, FindingKind, FitParameter, Method, RecordRole, Searches,
    Stop, Task, Watch, structure::Candidate,
};
#[doc(inline)]
pub use hysteron_io::{Content, ReadOptions, Rename};
#[doc(inline)]
pub use hysteron_model::Start;
#[doc(inline)]
pub use hysteron_model::compensator::{Controller, Limits};
#[doc(inline)]
pub use hysteron_model::control::Stage;
pub use hysteron_model::decoupling::DecouplingController;
#[doc(inline)]
pub use hysteron_model::dynamics::{Creep, Scheme};
#[doc(inline)]
pub use hysteron_model::hysteresis::HysteresisForm;
#[doc(inline)]
pub use hysteron_model::model::{Capability, Remark, RunScore, Score, Unsupported};
#[doc(inline)]
pub use hysteron_model::model_file::Kind;
#[doc(inline)]
pub use hysteron_model::record::{
    Admitted, Channel, Condition, Cut, InterSample, Prepare, Prepared, PreparedSummary, Record, Signal,
    TimeBase, Turns, Unit,
};
#[doc(inline)]
pub use hysteron_model::tracking::{TrackOptions, Tracking};
#[doc(inline)]
pub use hysteron_model::validate::{OffsetTreatment, Scores, Scoring};

use std::path::Path;

/// Reads records, each from a file of any format that is known: CSV, MAT, HDF5, TDMS, NPY, NPZ, XLSX, LVM,
/// GCS, JPK.
///
/// # Errors
/// [`Error::File`] for the first file that is no readable record; it names file, line and column.
pub fn read<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Result<Vec<Record>, Error> {
    read_with(paths, &ReadOptions::default())
}

/// Reads records with options: columns chosen, renamed and left out, and the part of each record to keep.
/// Further preprocessing is done by [`Prepare`].
///
/// ```
/// use hysteron::prelude::*;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("scan.csv");
/// # let line = |k: u32| format!("{},{},{},{}\n", f64::from(k) / 1000.0, k % 50, k % 50, k / 500);
/// # let head = "t_s,u_V,y_V,segment\n".to_owned();
/// # let text: String = std::iter::once(head).chain((0..1500).map(line)).collect();
/// # std::fs::write(&path, &text)?;
/// let cut = Cut { from_s: Some(0.2), conditions: vec!["segment=0..1".parse()?], ..Cut::default() };
/// let records = hysteron::read_with([&path], &ReadOptions { cut, ..ReadOptions::default() })?;
/// let prepare = Prepare {
///     scales: vec!["y=2.5um/V".parse()?],
///     sample_rate_hz: Some(500.0),
///     ..Prepare::default()
/// };
/// let prepared = prepare.run(&records)?;
/// assert_eq!(prepared.record.len(), 400);
/// # let path = folder.path().join("scan_500.csv");
/// hysteron::write(&path, &prepared.record)?;
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Those of [`read`].
pub fn read_with<P: AsRef<Path>>(
    paths: impl IntoIterator<Item = P>,
    options: &ReadOptions,
) -> Result<Vec<Record>, Error> {
    paths.into_iter().map(|path| Ok(hysteron_io::read_record(path.as_ref(), options)?)).collect()
}

/// Contents of a file: the columns of a text, the arrays of a file of named arrays with their paths, shapes
/// and units.
///
/// # Errors
/// Those of [`read`].
pub fn contents(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Vec<Content>, Error> {
    Ok(hysteron_io::contents(path.as_ref(), options)?)
}

/// Writes a record, as MAT to a file `NAME.mat`, as NPZ to a file `NAME.npz`, as CSV to any other.
///
/// # Errors
/// [`Error::File`].
pub fn write(path: impl AsRef<Path>, record: &Record) -> Result<(), Error> {
    Ok(hysteron_io::write_record(path.as_ref(), record)?)
}
