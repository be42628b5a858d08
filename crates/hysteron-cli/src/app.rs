//! `hysteron app`: the page in a browser, served from this machine.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use clap::Args;
use hysteron_app::{App as Server, AppError, MAX_UPLOAD_BYTES, Settings};

use crate::console;
use crate::failure::Failure;
use crate::numbers::whole;

/// Serve the page: records, fit, validation, drive and code in a browser, without flags.
#[derive(Args)]
#[command(
    after_help = "The page is at the address printed, and only for this machine; it loads nothing from \
    elsewhere. Everything it shows lies as plain files in FOLDER, which the other commands read and write \
    too; hysteron.sqlite beside them holds what the page was told of the records, and the history. A \
    subfolder is a device. Deleted files are in the folder trash.\n\n\
    Ctrl-C ends it within two seconds; a fit that runs is kept, and goes on from there when asked to. \
    Uploads above --max-upload are refused: copy such a file into FOLDER.\n\n\
    --listen ADDRESS lets other machines in, with the token in the address printed; the connection is not \
    encrypted.\n\n\
    Example: hysteron app stage --open\n\
    Example: hysteron app --port 8080"
)]
pub struct App {
    /// Folder of records, models and reports; made if it does not exist
    #[arg(value_name = "FOLDER", default_value = ".")]
    folder: PathBuf,

    /// Port; 0: any that is free
    #[arg(long, value_name = "N", default_value_t = 4567)]
    port: u16,

    /// Open the page in the browser
    #[arg(long)]
    open: bool,

    /// Copy the measured examples, an AFM scanner and a P-885 stack, into FOLDER first
    #[arg(long)]
    examples: bool,

    /// Address to listen on; any but a loopback address needs the token that is printed
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,

    /// Largest upload, in bytes
    #[arg(
        long, value_name = "BYTES", default_value_t = MAX_UPLOAD_BYTES, value_parser = whole::<u64>,
        allow_hyphen_values = true,
    )]
    max_upload: u64,
}

impl App {
    pub fn run(&self) -> Result<(), Failure> {
        let settings = Settings {
            folder: self.folder.clone(),
            address: SocketAddr::new(self.listen, self.port),
            max_upload_bytes: self.max_upload,
            examples: self.examples,
        };
        let server = Server::bind(&settings).map_err(|e| cannot(&e))?;
        let url = server.url();
        console::result(&format!("{url}\n"))?;
        console::message(&format!("serving {}; Ctrl-C ends it", server.folder().display()));
        if self.open {
            open(&url);
        }
        server.serve().map_err(|e| cannot(&e))
    }
}

fn cannot(error: &AppError) -> Failure {
    let failure = Failure::new("the page cannot be served").because(error);
    match error {
        AppError::Listen { .. } => failure.hint("--port 0 takes any port that is free"),
        AppError::Folder { .. } => failure.hint("name a folder that you may write to"),
        AppError::History(_) => {
            failure.hint("another hysteron app may use the folder; else move the file away")
        }
        AppError::NewerHistory { .. } => failure.hint("use the newer program, or another folder"),
        _ => failure,
    }
}

/// Opens the address in the person's browser; a note says so where there is none.
fn open(url: &str) {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "windows") {
        ("cmd", &["/C", "start", ""])
    } else if cfg!(target_os = "macos") {
        ("open", &[])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(url).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if command.spawn().is_err() {
        console::note("no browser could be opened: open the address above");
    }
}
