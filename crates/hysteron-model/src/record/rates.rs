//! Rate of a drive between its samples.

/// Property of a drive that a hysteresis memory depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dependence {
    /// The order of its samples.
    Order,
    /// The time between them, too.
    Time,
    /// Its rate: where that jumps, so does the memory.
    Rate,
}

/// Rate and duration of the move to a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// |du/dt| on the way \[V/s\]; 0 for a jump in no time.
    pub rate: f64,
    /// Time on the way \[s\].
    pub interval_s: f64,
}

/// Rate and duration of the move of the drive `u` \[V\] at `times_s` \[s\] to each of its samples, on a
/// straight line from the one before; both are 0 at the first, where a device rests.
pub fn paces_on(times_s: &[f64], u: &[f64]) -> Vec<Pace> {
    let moves = times_s.windows(2).zip(u.windows(2));
    let paces = moves.map(|(times, u)| {
        let (interval_s, move_v) = (times[1] - times[0], u[1] - u[0]);
        Pace { rate: if interval_s > 0.0 { (move_v / interval_s).abs() } else { 0.0 }, interval_s }
    });
    u.first().map(|_| Pace::default()).into_iter().chain(paces).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paces_by_hand() {
        let (times_s, u) = ([0.0, 0.5, 0.5, 2.5], [1.0, 2.0, 5.0, 4.0]);
        let pace = |rate, interval_s| Pace { rate, interval_s };
        assert_eq!(paces_on(&times_s, &u), [pace(0.0, 0.0), pace(2.0, 0.5), pace(0.0, 0.0), pace(0.5, 2.0)]);
        assert!(paces_on(&[], &[]).is_empty());
    }
}
