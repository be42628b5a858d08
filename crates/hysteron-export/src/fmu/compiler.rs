//! The C compiler that makes the binary of a unit.

use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use hysteron_io::NamedFile;
use hysteron_numeric::Listener;

use crate::error::ExportError;

/// Time between two looks at a running compiler.
const LOOK: Duration = Duration::from_millis(20);
/// Name of the library while it is made: with an ending, since some compilers add one.
const LIBRARY: &str = "unit.bin";
/// Stage that the listener hears.
const STAGE: &str = "compiling";

/// A compiler, and who hears of its work.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compiler<'a> {
    /// Its command.
    pub command: &'a str,
    /// Flags of its platform.
    pub flags: &'a [&'a str],
    /// Hears of it, and may stop it.
    pub listener: Listener<'a>,
}

impl Compiler<'_> {
    /// Compiles the sources into a shared library.
    pub(super) fn library(self, sources: &[NamedFile], main: &[String]) -> Result<Vec<u8>, ExportError> {
        let failed = |problem: String| ExportError::Compiler { compiler: self.command.to_owned(), problem };
        let no_folder = |e: std::io::Error| failed(format!("has no folder to work in: {e}"));
        let folder = hysteron_io::temporary_folder().map_err(no_folder)?;
        let at = |name: &str| folder.path().join(name);
        for file in sources {
            std::fs::write(at(&file.name), &file.bytes).map_err(no_folder)?;
        }
        let mut child = self.started(folder.path(), main).map_err(failed)?;
        self.wait(&mut child)?;
        std::fs::read(at(LIBRARY)).map_err(|e| failed(format!("left nothing behind: {e}")))
    }

    fn started(self, folder: &Path, main: &[String]) -> Result<Child, String> {
        let flags = ["-std=c99", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-s"];
        Command::new(self.command)
            .args(flags)
            .args(self.flags)
            .args(main)
            .args(["-o", LIBRARY, "-lm"])
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|e| format!("could not be started: {e}"))
    }

    /// Waits for the compiler, which a stop ends.
    fn wait(self, child: &mut Child) -> Result<(), ExportError> {
        let failed = |problem: String| ExportError::Compiler { compiler: self.command.to_owned(), problem };
        // Read beside the wait: a full pipe would hold the compiler up.
        let mut messages = child.stderr.take();
        let reader = std::thread::spawn(move || {
            let mut said = Vec::new();
            if let Some(messages) = &mut messages {
                let _ = messages.read_to_end(&mut said);
            }
            said
        });
        let status = loop {
            if let Some(status) = child.try_wait().map_err(|e| failed(format!("was lost: {e}")))? {
                break status;
            }
            if self.listener.tell(STAGE, 0.0).is_err() {
                let _ = child.kill();
                let _ = child.wait();
                return Err(ExportError::Stopped);
            }
            std::thread::sleep(LOOK);
        };
        if status.success() {
            return Ok(());
        }
        let said = reader.join().unwrap_or_default();
        let said = String::from_utf8_lossy(&said);
        Err(failed(format!("failed ({status}): {}", said.lines().next().unwrap_or_default())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;
    use std::time::Instant;

    /// A compiler that never ends is a command that waits.
    #[cfg(unix)]
    #[test]
    fn a_stop_ends_a_compiler_that_runs() {
        let stop = |_: &str, _: f64| ControlFlow::Break(());
        let compiler = Compiler { command: "cc", flags: &[], listener: Listener::new(&stop) };
        let mut child = Command::new("sleep").arg("60").stderr(Stdio::piped()).spawn().unwrap();
        let begun = Instant::now();
        assert!(matches!(compiler.wait(&mut child), Err(ExportError::Stopped)));
        assert!(begun.elapsed() < Duration::from_secs(10));
        assert!(child.try_wait().unwrap().is_some());
    }
}
