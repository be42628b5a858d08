//! Online correction of an identified model.
//!
//! [`Correction`] selects the adapted coefficients and computes the regressors; [`Adapter`] updates them
//! sample by sample and detects when the model no longer fits. The estimators and the monitor are those of
//! `hysteron-rt`, which a controller runs unchanged.
//!
//! ```
//! use hysteron_model::dynamics::{Dynamics, Scheme};
//! use hysteron_model::hammerstein::Model;
//! use hysteron_model::Start;
//! use hysteron_model::hysteresis::{ArticleOperator, Hysteresis};
//! use hysteron_identify::online::{Adapter, Correction, Estimator, Term};
//! use hysteron_model::record::InterSample;
//! use hysteron_rt::{FitMonitor, MonitorSettings, Rls, RlsSettings, Unexcited};
//!
//! let model = Model {
//!     hysteresis: Hysteresis::from(ArticleOperator::new(vec![3.2, -0.02], 1.1, 0.35, 0.08, 1.0)?),
//!     dynamics: Dynamics::None,
//!     offset: 0.0,
//!     delay_s: 0.0,
//!     scheme: Scheme::Tustin,
//!     inter_sample: InterSample::Linear,
//!     sample_rate_hz: None,
//! };
//! let correction = Correction::new(model, [Term::Offset, Term::Gain])?;
//! let u: Vec<f64> = (0..400).map(|k| 5.0 - 5.0 * (k as f64 * 0.1).cos()).collect();
//! let regressors = correction.regressors(&u, None, &Start::Rest { voltage_v: 0.0 })?;
//!
//! let least_squares = Rls::new(RlsSettings {
//!     start: correction.nominal(),
//!     deviations: [0.5, 0.1], // µm, 1
//!     noise: 0.005,           // µm
//!     forgetting: 0.99,
//!     unexcited: Unexcited::Hold,
//!     bounds: None,
//! })?;
//! let monitor =
//!     FitMonitor::new(MonitorSettings { shift: Some(0.5), spread: Some(1.5), run_length: 1e6, fewest: 3 })?;
//! let mut adapter = Adapter::new(Estimator::LeastSquares(least_squares), monitor, false);
//! for row in regressors.rows() {
//!     let displacement = 1.07 * row.regressors[1] - 0.2; // the device of today
//!     adapter.step(&row, displacement)?;
//! }
//! assert!((adapter.parameters()[1] - 1.07).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adapter;
mod correction;
mod file;
mod follow;
mod spacing;
mod summary;
mod term;

pub use adapter::{Adapted, Adapter, Alarm, Estimator, Trace};
pub use correction::{Correction, Regressors, Row};
pub use follow::{FollowMethod, FollowOptions, Followed, MOST_TERMS, Path, known_noise};
pub use summary::FollowedSummary;
pub use term::{Term, UnknownTerm};
