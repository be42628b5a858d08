//! Static hysteresis block: rate-independent operators, one file a model behind one enum.

pub mod bouc_wen;

pub use bouc_wen::BoucWen;

/// A rate-independent hysteresis operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Hysteresis {
    /// Bouc–Wen, article Eq. 1.
    BoucWen(BoucWen),
}
