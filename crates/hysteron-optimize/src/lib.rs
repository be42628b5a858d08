//! Bounded global and local optimisation: seeded, identical for any number of threads, observable, resumable.
//!
//! A problem is a [`Problem`] (a cost over a box) or a [`LeastSquaresProblem`] (a residual vector whose root
//! mean square is the cost). An [`Algorithm`] is chosen with its options, [`Settings`] limit the run, and one
//! call runs it: [`minimize`] for a least-squares problem with any algorithm, [`minimize_cost`] for a plain
//! cost with the population methods.
//!
//! | [`Algorithm`] | what it is | source |
//! | --- | --- | --- |
//! | [`DeAbc`](Algorithm::DeAbc) | bee colony with the mutation of differential evolution and a chaotic scout
//! | article Eqs. 8–12 |
//! | [`Abc`](Algorithm::Abc) | artificial bee colony | Karaboga and Basturk 2007,
//! doi:10.1007/s10898-007-9149-x |
//! | [`De`](Algorithm::De) | differential evolution rand/1/bin | Storn and Price 1997,
//! doi:10.1023/A:1008202821328 |
//! | [`Pso`](Algorithm::Pso) | particle swarm with constriction coefficients | Clerc and Kennedy 2002,
//! doi:10.1109/4235.985692 |
//! | [`CmaEs`](Algorithm::CmaEs) | covariance matrix adaptation with restarts | Hansen and Ostermeier 2001,
//! doi:10.1162/106365601750190398 |
//! | [`LeastSquares`](Algorithm::LeastSquares) | bounded Levenberg–Marquardt from many starts | Kanzow,
//! Yamashita and Fukushima 2004, doi:10.1016/j.cam.2004.02.013 |
//!
//! Common to all of them:
//! - The search runs on the unit box: each parameter is scaled to [0, 1], logarithmically where its [`Range`]
//!   says so.
//! - **Bit-identical for a seed and any number of threads**: a generation is proposed as a whole, evaluated
//!   in parallel, accepted in index order; every candidate has a separate random stream, numbered by the
//!   candidate.
//! - A run ends on its generations, its budget of evaluations, a target cost, stagnation, or a stop by the
//!   [`Observer`]; the best so far is kept, and [`Outcome::stopped`] gives the reason.
//! - Every evaluation is counted, including those of finite differences and of the scout.
//! - A candidate whose cost is not finite has cost +∞ and is never accepted.
//! - A [`Checkpoint`] is the serialisable state of a run; a resumed run ends with the same bits as an
//!   uninterrupted one. A checkpoint of another problem or other options is rejected ([`OptimizeError`]).
//!
//! ```
//! use hysteron_optimize::{
//!     Algorithm, Bounds, DeAbcOptions, Problem, Range, Settings, Unobserved, minimize_cost,
//! };
//!
//! struct Bowl(Bounds);
//! impl Problem for Bowl {
//!     type Workspace = ();
//!     fn bounds(&self) -> &Bounds {
//!         &self.0
//!     }
//!     fn workspace(&self) {}
//!     fn cost(&self, x: &[f64], _: &mut ()) -> f64 {
//!         (x[0] - 1.0).powi(2) + (x[1] + 2.0).powi(2)
//!     }
//! }
//! let bowl = Bowl(Bounds { ranges: vec![Range::linear("a", -5.0, 5.0), Range::linear("b", -5.0, 5.0)] });
//! let algorithm = Algorithm::DeAbc(DeAbcOptions::default());
//! let outcome = minimize_cost(&bowl, &algorithm, &Settings::default(), &mut Unobserved, None)?;
//! assert!(outcome.cost < 1e-12);
//! # Ok::<(), hysteron_optimize::OptimizeError>(())
//! ```

mod abc;
mod algorithm;
mod bounded_linear;
mod bounds;
mod checkpoint;
mod cma_es;
mod colony;
mod de;
mod de_abc;
mod error;
mod evaluate;
pub mod infinite_as_null;
mod jacobian;
mod least_squares;
mod ledger;
mod levenberg_marquardt;
mod minimize;
mod observer;
mod outcome;
mod points;
mod problem;
mod pso;
mod settings;
mod starts;
mod stream;

pub use abc::AbcOptions;
pub use algorithm::{Algorithm, UnknownAlgorithm};
pub use bounds::{Bounds, Range};
pub use checkpoint::Checkpoint;
pub use cma_es::CmaEsOptions;
pub use de::DeOptions;
pub use de_abc::{Chaos, DeAbcOptions, MovedComponents, Scout, ScoutKeeps};
pub use error::OptimizeError;
pub use hysteron_numeric::{Stop, root_mean_square};
pub use jacobian::{Differences, residual_jacobian};
pub use least_squares::{LeastSquaresOptions, LocalStatus, StartResult};
pub use ledger::{GenerationRecord, Improvement};
pub use minimize::{minimize, minimize_cost};
pub use observer::{Observer, Progress, Unobserved};
pub use outcome::{Outcome, StopReason};
pub use problem::{Derivative, Eliminated, LeastSquaresProblem, Problem};
pub use pso::PsoOptions;
pub use settings::{Settings, Stagnation};
pub use starts::Starts;

#[cfg(test)]
mod test_problems;
