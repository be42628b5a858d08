//! The operators in C99, each beside its Rust, for code generation.
//!
//! Templates, in which `R(x)` is the constant x as a literal of the number type, `F(f)` the function f of
//! `<math.h>` in that type, `K(x)` the place of the coefficients x, `$key` a name or a size, and lines
//! between `//{ flag` and `//}` hold where the flag is set. The law of one branch
//! ([`crate::Branch::c_fragment`]) comes between the two.

use crate::state_law;

/// Type of the parameters of a state; it comes before any table of them.
pub const STATE_LAW: &str = state_law::C_PARAMETERS;

/// Functions called by laws and operators, each after those it calls itself.
pub const SHARED: &[&str] = &[
    include_str!("increment.c"),
    include_str!("series.c"),
    state_law::C_INCREMENT,
    include_str!("branch/moments.c"),
    include_str!("branch/root.c"),
];

/// Functions of every operator: virgin output at a voltage (`hysteresis_at_rest`), output after a trial move
/// (`hysteresis_look`) and after a move (`hysteresis_move`), reset to virgin (`hysteresis_rest`); with the
/// provided methods of a branch law.
pub const OPERATORS: &[&str] = &[
    state_law::C_OPERATOR,
    include_str!("branch/law.c"),
    include_str!("play/play.c"),
    include_str!("play/sided.c"),
    include_str!("play/relaxing.c"),
    include_str!("plane/plane.c"),
];

/// Lines of a header under `//= sizes`, `//= members of the state` and `//= parameters`, operator by
/// operator.
const HEADERS: &[&str] = &[
    state_law::C_HEADER,
    include_str!("branch/law.h"),
    include_str!("play/plays.h"),
    include_str!("plane/plane.h"),
];

/// The lines of a header that belong under this heading: `sizes`, `members of the state` or `parameters`.
pub fn header_lines(heading: &str) -> impl Iterator<Item = &'static str> {
    let mut current = "";
    HEADERS.iter().flat_map(|header| header.lines()).filter(move |line| match line.strip_prefix("//= ") {
        Some(next) => {
            current = next;
            false
        }
        None => current == heading,
    })
}
