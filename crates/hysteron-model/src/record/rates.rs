//! How fast a drive moves between its samples.

/// |du/dt| \[V/s\] of the straight line to each sample of the drive `u` \[V\] at `times_s` \[s\] from the one before; 0 for the first,
/// which a device at rest comes to without rate, and for a jump in no time.
pub fn rates_on(times_s: &[f64], u: &[f64]) -> Vec<f64> {
    let moves = times_s.windows(2).zip(u.windows(2));
    let rates = moves.map(|(times, u)| {
        let (time_s, move_v) = (times[1] - times[0], u[1] - u[0]);
        if time_s > 0.0 { (move_v / time_s).abs() } else { 0.0 }
    });
    u.first().map(|_| 0.0).into_iter().chain(rates).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_by_hand() {
        let (times_s, u) = ([0.0, 0.5, 0.5, 2.5], [1.0, 2.0, 5.0, 4.0]);
        assert_eq!(rates_on(&times_s, &u), [0.0, 2.0, 0.0, 0.5]);
        assert!(rates_on(&[], &[]).is_empty());
    }
}
