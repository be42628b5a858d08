//! The platforms that a unit has binaries for.

use std::process::{Command, Stdio};

use super::FmiVersion;

/// Platform of a binary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Platform {
    /// Linux on x86-64.
    Linux,
    /// Windows on x86-64.
    Windows,
    /// Linux on 64-bit ARM.
    LinuxArm,
}

impl Platform {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Linux, Self::Windows, Self::LinuxArm];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Linux => "Linux x86-64",
            Self::Windows => "Windows x86-64",
            Self::LinuxArm => "Linux aarch64",
        }
    }

    /// Whether this program runs on it.
    fn is_own(self) -> bool {
        match self {
            Self::Linux => cfg!(all(target_os = "linux", target_arch = "x86_64")),
            Self::Windows => cfg!(all(windows, target_arch = "x86_64")),
            Self::LinuxArm => cfg!(all(target_os = "linux", target_arch = "aarch64")),
        }
    }

    /// Name of the compiler for it on other platforms, as Debian has it.
    pub fn cross_compiler(self) -> &'static str {
        match self {
            Self::Linux => "x86_64-linux-gnu-gcc",
            Self::Windows => "x86_64-w64-mingw32-gcc",
            Self::LinuxArm => "aarch64-linux-gnu-gcc",
        }
    }

    /// The compiler of its binary: `own` on this platform, for others the cross compiler where it is there.
    pub(super) fn compiler(self, own: &str) -> Option<&str> {
        if self.is_own() {
            return Some(own);
        }
        let command = self.cross_compiler();
        // It is of use with the headers of its C library alone.
        let looked = Command::new(command)
            .args(["-include", "math.h", "-include", "stdlib.h", "-E", "-x", "c", "-"])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        looked.is_ok_and(|status| status.success()).then_some(command)
    }

    /// The platforms that no compiler is there for: their binaries are left out.
    pub fn left_out() -> Vec<Self> {
        Self::ALL.into_iter().filter(|platform| platform.compiler("").is_none()).collect()
    }

    /// Flags of the compiler: a library that needs none but those of the system, the same bytes every day.
    pub(super) fn flags(self) -> &'static [&'static str] {
        match self {
            Self::Linux | Self::LinuxArm => &["-fPIC"],
            Self::Windows => &["-static-libgcc", "-Wl,--no-insert-timestamp"],
        }
    }

    /// Folder of the binary. FMI 2.0 has no name for 64-bit ARM: it is that of FMI 3.0.
    pub(super) fn folder(self, version: FmiVersion) -> &'static str {
        match (self, version) {
            (Self::Linux, FmiVersion::Two) => "binaries/linux64",
            (Self::Windows, FmiVersion::Two) => "binaries/win64",
            (Self::Linux, FmiVersion::Three) => "binaries/x86_64-linux",
            (Self::Windows, FmiVersion::Three) => "binaries/x86_64-windows",
            (Self::LinuxArm, _) => "binaries/aarch64-linux",
        }
    }

    /// Ending of the binary's name.
    pub(super) fn ending(self) -> &'static str {
        match self {
            Self::Linux | Self::LinuxArm => "so",
            Self::Windows => "dll",
        }
    }
}
