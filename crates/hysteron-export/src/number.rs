//! The number types of an export and how their numbers are written.

use hysteron_rt::Real;
use serde::{Deserialize, Serialize};

/// Number type of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

impl Precision {
    /// Name of the type in Rust and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// Name of the type in C.
    pub fn c_type(self) -> &'static str {
        match self {
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// Distance from 1 to the next number.
    pub fn epsilon(self) -> f64 {
        match self {
            Self::F32 => f64::from(f32::EPSILON),
            Self::F64 => f64::EPSILON,
        }
    }

    /// `x` rounded to this type.
    pub fn round(self, x: f64) -> f64 {
        match self {
            Self::F32 => f64::from(f32::of(x)),
            Self::F64 => x,
        }
    }

    /// The least number of this type not below `x`.
    pub fn at_least(self, x: f64) -> f64 {
        match self {
            Self::F32 => f64::from(f32::at_least(x)),
            Self::F64 => x,
        }
    }

    /// The largest number of this type not above `x`.
    pub fn at_most(self, x: f64) -> f64 {
        match self {
            Self::F32 => f64::from(f32::at_most(x)),
            Self::F64 => x,
        }
    }

    /// The shortest text that reads back as `x`, which must be finite, rounded to this type; in C with its
    /// suffix.
    pub fn c_literal(self, x: f64) -> String {
        match self {
            Self::F32 => format!("{:?}f", f32::of(x)),
            Self::F64 => format!("{x:?}"),
        }
    }

    /// Infinity in C.
    pub(crate) fn c_infinity(self) -> &'static str {
        match self {
            Self::F32 => "HUGE_VALF",
            Self::F64 => "HUGE_VAL",
        }
    }

    /// [`Self::c_literal`] for Rust, without suffix.
    pub fn rust_literal(self, x: f64) -> String {
        match self {
            Self::F32 => format!("{:?}", f32::of(x)),
            Self::F64 => format!("{x:?}"),
        }
    }

    /// The value of a constant of the runtime in this type.
    pub(crate) fn constant(self, name: &str) -> Option<f64> {
        fn of<T: Real + Into<f64>>(name: &str) -> Option<f64> {
            let value = match name {
                "SMALL" => T::SMALL,
                "FLOOR" => T::FLOOR,
                "LARGEST" => T::LARGEST,
                "EPSILON" => T::EPSILON,
                "HALF_PI" => T::of(core::f64::consts::FRAC_PI_2),
                _ => return None,
            };
            Some(value.into())
        }
        match (self, name) {
            (Self::F32, "MAX") => Some(f64::from(f32::MAX)),
            (Self::F64, "MAX") => Some(f64::MAX),
            (Self::F32, _) => of::<f32>(name),
            (Self::F64, _) => of::<f64>(name),
        }
    }
}
