//! The operators in C99, each beside its Rust, for programs that write C.
//!
//! Templates, in which `R(x)` is the constant x as a literal of the number type, `F(f)` the function f of `<math.h>` in that type, `K(x)`
//! the place of the coefficients x, `$key` a name or a size, and lines between `//{ flag` and `//}` hold where the flag is set. The law of one
//! branch ([`crate::Branch::c_fragment`]) comes between the two.

/// Functions that laws and operators call; each behind those that it calls itself.
pub const SHARED: &str = concat!(
    include_str!("increment.c"),
    include_str!("series.c"),
    include_str!("bouc_wen/linear.c"),
    include_str!("bouc_wen/quadratic.c"),
    include_str!("bouc_wen/power.c"),
    include_str!("branch/moments.c"),
    include_str!("branch/root.c"),
);

/// Plays, planes of relays, and the part of a law that need not be written.
pub const OPERATORS: &str = concat!(
    include_str!("branch/law.c"),
    include_str!("play/play.c"),
    include_str!("play/sided.c"),
    include_str!("play/activated.c"),
    include_str!("plane/plane.c"),
);
