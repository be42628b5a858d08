//! Why the server could not be started.

use std::net::SocketAddr;
use std::path::PathBuf;

/// Error of opening the workspace or of listening.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AppError {
    /// The folder cannot be made or read.
    #[error("the folder {} cannot be used: {source}", .folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The history file is no such file, or cannot be written.
    #[error("the history of the workspace (hysteron.sqlite) cannot be used: {0}")]
    History(#[from] rusqlite::Error),
    /// The history file is of a newer program.
    #[error(
        "the history of the workspace (hysteron.sqlite) is of version {version}, this program knows {known}"
    )]
    NewerHistory {
        /// Version of the file.
        version: i64,
        /// Version that this program writes.
        known: i64,
    },
    /// The examples cannot be copied.
    #[error("{0}")]
    Examples(String),
    /// The address is taken or not of this machine.
    #[error("{address} cannot be listened on: {source}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The system's error.
        source: std::io::Error,
    },
    /// The system refuses something else that a server needs.
    #[error("the server cannot run: {0}")]
    System(#[from] std::io::Error),
}
