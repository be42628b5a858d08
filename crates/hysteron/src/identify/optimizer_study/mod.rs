//! The optimisers compared on the article's two identification problems.
//!
//! Does the article's DE-ABC beat differential evolution and the plain bee colony, does its chaotic scout matter, and
//! what does a derivative-based fit need? Every [`Competitor`] runs on every [`StudyProblem`] from many seeds with
//! the same budget of evaluations; counted is how many it takes to come within 1 % of the best RMSE that can be
//! reached (that of a least-squares fit polished from the truth). All compete inside the same box, on the same noise
//! realisation; only the optimiser's seed changes.
//!
//! ```no_run
//! use hysteron::identify::optimizer_study::{StudyOptions, run_study};
//! use std::ops::ControlFlow;
//!
//! let study = run_study(&StudyOptions::default(), &mut |progress| {
//!     eprintln!("{} of {} runs", progress.done, progress.runs);
//!     ControlFlow::Continue(())
//! })?;
//! for problem in &study.problems {
//!     for row in &problem.rows {
//!         println!("{}: {:.4}, {} %", row.name, row.median_best_rmse, row.success_percent);
//!     }
//! }
//! # Ok::<(), hysteron::identify::optimizer_study::StudyError>(())
//! ```

mod competitor;
mod fractional_block;
mod noise;
mod options;
mod run;
mod static_block;
mod study;
mod summary;

pub use competitor::Competitor;
pub use fractional_block::FractionalBlock;
pub use options::{StudyError, StudyOptions, StudyProblem, StudyProgress};
pub use run::run_study;
pub use static_block::StaticBlock;
pub use study::{Curve, Parameter, ProblemResult, Row, Run, Study};
pub use summary::{Quartiles, quartiles};

#[cfg(test)]
mod tests;
