//! Types that most programs need.
//!
//! The example of README.md, from a measured record to C source:
//!
//! ```
//! use hysteron::prelude::*;
//!
//! fn main() -> Result<(), Error> {
//! #   let source = concat!(
//! #       env!("CARGO_MANIFEST_DIR"),
//! #       "/../../examples/piezo-p885-200hz/identification_1hz.csv"
//! #   );
//! #   let folder = tempfile::tempdir().unwrap();
//! #   std::env::set_current_dir(folder.path()).unwrap();
//! #   std::fs::create_dir_all("examples/piezo-p885-200hz").unwrap();
//! #   std::fs::copy(source, "examples/piezo-p885-200hz/identification_1hz.csv").unwrap();
//!     let records = hysteron::read(["examples/piezo-p885-200hz/identification_1hz.csv"])?;
//!     let fit = Identify::new(&records).run()?;
//!     fit.save("model.json")?;
//!     let reference = Signal::uniform(vec![-110.0, -105.0, -100.0], 200.0, "um");
//!     let drive = fit.model.invert(&reference, Limits::range(0.0, 3.6))?;
//!     let mut controller = fit.model.controller(200.0, Limits::range(0.0, 3.6))?;
//!     println!("{:.3?} V, then {:.3} V", drive.samples, controller.step(-100.0).voltage);
//!     fit.model.export(10_000.0, Target::C { float: Precision::F32 })?.write("firmware")
//! }
//! ```

pub use std::ops::ControlFlow;

pub use crate::{
    Channel, Controller, Creep, Cut, DynamicsChoice, Error, Event, Export, FamilyChoice, Finding, Fit,
    HysteresisForm, Identify, InterSample, Kind, Limits, Model, Precision, Prepare, ReadOptions, Record,
    Report, Score, Scoring, Signal, Start, Stop, Target, TimeBase, Unit, Unsupported,
};
