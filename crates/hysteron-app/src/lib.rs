//! The page of Hysteron, served from the person's own machine: a server over the library with the page
//! inside, and a workspace that is a plain folder.
//!
//! [`App::bind`] opens the folder and listens, [`App::serve`] answers until the program is told to end. The
//! interface is `/api/v1` ([`api`]), described by [`document`], made from the same types. No numerics and no
//! logic of its own: what a page shows is what the library returns.
#![forbid(unsafe_code)]

pub mod api;
mod bench;
mod clock;
mod command;
mod draw;
mod error;
mod jobs;
mod models;
mod notice;
mod options;
mod prepare;
mod problem;
mod refused;
mod response;
mod server;
mod workspace;

pub use error::AppError;
pub use server::{App, MAX_UPLOAD_BYTES, Settings, document};
