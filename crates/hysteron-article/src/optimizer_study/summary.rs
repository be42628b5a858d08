//! Medians and quartiles.

use serde::{Deserialize, Serialize};

/// Median and quartiles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quartiles {
    /// First quartile.
    pub lower: f64,
    /// Median.
    pub median: f64,
    /// Third quartile.
    pub upper: f64,
}

/// Median and quartiles of `values`, interpolated between order statistics at (N − 1) p (Hyndman and Fan
/// 1996, doi:10.1080/00031305.1996.10473566, definition 7); `None` for no values. An infinite neighbour
/// counts only where it has a weight.
pub fn quartiles(values: &[f64]) -> Option<Quartiles> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |p: f64| {
        let position = p * (sorted.len() as f64 - 1.0);
        let (below, share) = (position.floor() as usize, position.fract());
        let low = sorted.get(below)?;
        match sorted.get(below + 1) {
            Some(high) if share > 0.0 => Some((1.0 - share) * low + share * high),
            _ => Some(*low),
        }
    };
    Some(Quartiles { lower: at(0.25)?, median: at(0.5)?, upper: at(0.75)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_interpolate_between_order_statistics() {
        let of = |values: &[f64]| quartiles(values).map(|q| [q.lower, q.median, q.upper]);
        assert_eq!(of(&[4.0, 1.0, 3.0, 2.0]), Some([1.75, 2.5, 3.25]));
        assert_eq!(of(&[5.0, 1.0, 3.0]), Some([2.0, 3.0, 4.0]));
        assert_eq!(of(&[7.0]), Some([7.0; 3]));
        assert_eq!(of(&[1.0, f64::INFINITY, 2.0, f64::INFINITY, 3.0]), Some([2.0, 3.0, f64::INFINITY]));
        assert_eq!(of(&[]), None);
    }
}
