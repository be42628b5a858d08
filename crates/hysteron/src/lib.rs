//! Hysteron: measured records of a piezo actuator go in, a checked model comes out.
//!
//! The model is a Hammerstein model, Bouc–Wen hysteresis followed by fractional-order dynamics with delay, after L. Yang,
//! Z. Zhao, Y. Zhang and D. Li, *Micromachines* 13 (2022) 42, doi:10.3390/mi13010042. "Eq. 1" and the like are its
//! equations. Units at every surface: V, µm, s, Hz.
//!
//! # From a record to a model to a score
//!
//! ```
//! use hysteron_model::hammerstein::Start;
//! use hysteron_model::hysteresis::{BoucWen, Hysteresis};
//! use hysteron_identify::{CampaignRecord, Options, Unwatched, identify};
//! use hysteron_model::record::{InputOutput, TimeBase};
//! use hysteron_model::validate::{Scoring, score};
//!
//! // A device to measure: here one that we know. 1 Hz loops of shrinking amplitude, 200 Hz, 0–4 V.
//! let device = Hysteresis::BoucWen(BoucWen::new(vec![15.0, -0.25], 3.5, 0.6, 0.2, 1.0)?);
//! let measure = |amplitudes: &[f64]| {
//!     let phase = |k: usize| std::f64::consts::TAU * k as f64 / 200.0;
//!     let u: Vec<f64> =
//!         (0..200 * amplitudes.len()).map(|k| amplitudes[k / 200] * (1.0 - phase(k).cos())).collect();
//!     let mut y = vec![0.0; u.len()];
//!     device.simulate(&u, hysteron_model::hysteresis::Origin::Virgin { rest: 0.0 }, &mut y).map(|_| (u, y))
//! };
//! let (u, y) = measure(&[2.0, 1.5, 1.0, 0.5])?;
//! let record = InputOutput::new("loops", TimeBase::uniform(200.0), u, y)?;
//!
//! // Identify: degree, start, delay and dynamics are chosen from the record.
//! let campaign = [CampaignRecord { data: record, role: None }];
//! let found = identify(&campaign, &Options::default(), &mut Unwatched, None)?;
//! let number = |name| found.model.hysteresis.number(name).unwrap_or(f64::NAN);
//! assert!((number("alpha") - 3.5).abs() < 1e-3 && (number("beta") - 0.6).abs() < 1e-3);
//! for finding in &found.findings {
//!     println!("{}", finding.text);
//! }
//!
//! // Score on a record that the fit has not seen.
//! let (u, y) = measure(&[0.7, 1.8])?;
//! let unseen = InputOutput::new("unseen", TimeBase::uniform(200.0), u, y)?;
//! let simulated = found.model.simulate(&unseen.u, Some(200.0), &Start::Rest { voltage_v: 0.0 })?;
//! let scores = score(&unseen, &simulated, &Scoring::default())?;
//! assert!(scores.rmse < 1e-3, "RMSE {} µm", scores.rmse);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crates behind it, in the order of the data: [`io`] reads, [`identify`] finds a [`model`], [`report`] shows it,
//! [`export`] writes it as source.

pub use hysteron_export as export;
pub use hysteron_identify as identify;
pub use hysteron_io as io;
pub use hysteron_model as model;
pub use hysteron_report as report;
