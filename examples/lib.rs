//! Measured records of two piezo devices with their licences, as bytes of the program: so that the page shows a
//! real device without a network. A crate, since a package holds only files of its own folder.

#![forbid(unsafe_code)]

/// A file of a folder beside this one: name and content.
macro_rules! file {
    ($folder:literal, $name:literal) => {
        ($name, include_bytes!(concat!($folder, "/", $name)).as_slice())
    };
}

/// Records of one device, in the order in which they were measured.
pub struct MeasuredExample {
    /// Name of its folder.
    pub name: &'static str,
    /// Device and what was measured.
    pub title: &'static str,
    /// Columns of input and output, where the files hold more.
    pub columns: Option<(&'static str, &'static str)>,
    /// Files of samples. Where there are several, each continues the one before it.
    pub records: &'static [(&'static str, &'static [u8])],
    /// File that tells who measured it and under which licence.
    pub licence: (&'static str, &'static [u8]),
}

/// All of them.
pub static EXAMPLES: [MeasuredExample; 2] = [
    MeasuredExample {
        name: "piezo-p885-200hz",
        title: "P-885 stack, a loop of 1 Hz from rest",
        columns: None,
        records: &[file!("piezo-p885-200hz", "identification_1hz.csv")],
        licence: file!("piezo-p885-200hz", "README.md"),
    },
    MeasuredExample {
        name: "afm-z-scanner",
        title: "AFM z scanner, ramps, rests and sines of 1 to 300 Hz",
        columns: Some(("u_V", "y_um")),
        records: &[
            file!("afm-z-scanner", "cycle_1_300hz_01.csv"),
            file!("afm-z-scanner", "cycle_1_300hz_02.csv"),
            file!("afm-z-scanner", "cycle_1_300hz_03.csv"),
        ],
        licence: file!("afm-z-scanner", "README.md"),
    },
];
