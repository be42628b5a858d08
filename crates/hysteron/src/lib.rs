//! Hysteron: measured records of a piezo actuator go in, a checked model comes out.
//!
//! The model is a Hammerstein model, Bouc–Wen hysteresis followed by fractional-order dynamics with delay, after L. Yang,
//! Z. Zhao, Y. Zhang and D. Li, *Micromachines* 13 (2022) 42, doi:10.3390/mi13010042. "Eq. 1" and the like are its
//! equations. Units at every surface: V, µm, s, Hz.
//!
//! # From a record to a model to a score
//!
//! ```
//! use hysteron::hammerstein::Start;
//! use hysteron::hysteresis::{BoucWen, Hysteresis};
//! use hysteron::identify::{CampaignRecord, Options, Unwatched, identify};
//! use hysteron::record::{InputOutput, TimeBase};
//! use hysteron::validate::{Scoring, score};
//!
//! // A device to measure: here one that we know. 1 Hz loops of shrinking amplitude, 200 Hz, 0–4 V.
//! let device = Hysteresis::BoucWen(BoucWen::new(vec![15.0, -0.25], 3.5, 0.6, 0.2, 1.0)?);
//! let measure = |amplitudes: &[f64]| {
//!     let phase = |k: usize| std::f64::consts::TAU * k as f64 / 200.0;
//!     let u: Vec<f64> =
//!         (0..200 * amplitudes.len()).map(|k| amplitudes[k / 200] * (1.0 - phase(k).cos())).collect();
//!     let mut y = vec![0.0; u.len()];
//!     device.simulate(&u, hysteron::hysteresis::Origin::Virgin { rest: 0.0 }, &mut y).map(|_| (u, y))
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
//! # Guided tour, in the order of the data
//!
//! 1. [`excitation`] makes the drive that a campaign plays; [`bench_rig`] is a simulated device that answers it, to
//!    rehearse on and to test with.
//! 2. [`record`] holds what was measured: channels with units on a time base, never changed in place; [`record::inspect`] says
//!    what is in it.
//! 3. The model has two blocks. [`hysteresis`] is rate independent (Eq. 1), stepped exactly by `hysteron-rt`. [`dynamics`] is
//!    a transfer function with real orders (Eqs. 2–6), on [`fractional`] calculus and the kernels of [`numeric`].
//!    [`hammerstein`] joins them: [`hammerstein::Model::simulate`]. [`oscillator`] has its hysteresis in feedback instead.
//!    [`axes`] couples several inputs and outputs.
//! 4. [`optimize`] searches: bounded least squares, the article's DE-ABC (Eqs. 8–12), ABC, DE, PSO, all seeded and identical
//!    for any number of threads.
//! 5. [`identify`] is the article's two-step procedure: [`identify::identify`] hands out model, standard errors, scores
//!    and what the records leave open.
//! 6. [`validate`] defines every score once ([`validate::definitions`]) and tests residuals.
//! 7. [`realise`] turns a model into real poles and pole pairs that run sample by sample.
//! 8. [`online`] corrects a model while it runs and says when it no longer fits.
//! 9. [`invert`] makes the drive that lets the output follow a reference.
//!    [`compensator`] does it sample by sample, in a controller; [`control`] closes the loop around it.
//! 10. [`baselines`] are black-box models to compare with.
//! 11. [`model_file`] stores a model with its provenance; [`atomic_file`] writes files whole or not at all.
//!
//! Records from CSV files are read by the crate `hysteron-io`, reports written by `hysteron-report`.

pub mod article;
pub mod atomic_file;
pub mod axes;
pub mod baselines;
pub mod bench_rig;
pub mod compensator;
pub mod control;
pub mod display;
pub mod dynamics;
pub mod excitation;
pub mod fractional;
pub mod frequency_response;
pub mod hammerstein;
pub mod hysteresis;
pub mod identify;
pub mod invert;
pub mod model_file;
pub mod numeric;
pub mod online;
pub mod optimize;
pub mod oscillator;
pub mod realise;
pub mod record;
pub mod validate;
