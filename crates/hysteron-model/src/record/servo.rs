//! Detection of records taken in closed loop (servo): the output then follows the reference, and the
//! hysteresis is in the drive.

use super::InputOutput;
use super::turning_points::{span, turning_points};

/// Moves of at least this share of the stroke are evaluated, without such a share at either end of each.
const WIDE: f64 = 0.5;
const ENDS: f64 = 0.1;
/// Fewest samples of a move.
const FEWEST: usize = 50;
/// Departure from a straight line, as a share of a move, below which the output and above which the drive
/// indicate a servo.
const STRAIGHT: f64 = 0.002;
const BENT: f64 = 0.005;
/// Least ratio of the drive's departure to the output's.
const TIMES: f64 = 5.0;

/// Straightness of the moves of a record: rms departure from a straight line in time over the size of the
/// move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// Straightness of the output.
    pub output: f64,
    /// Straightness of the drive.
    pub input: f64,
}

/// The straightness of the moves of a record whose output moves linearly under a curved drive; `None` for
/// others, and for records without time or wide moves.
pub fn servo(data: &InputOutput) -> Option<Servo> {
    let valid = |k: usize| data.is_valid(k);
    let kept: Vec<usize> = (0..data.len()).filter(|&k| valid(k)).collect();
    let pick = |x: &[f64]| kept.iter().filter_map(|&k| x.get(k).copied()).collect::<Vec<f64>>();
    let (u, y) = (pick(&data.u), pick(&data.y));
    let times: Vec<f64> = kept.iter().map(|&k| data.time.time_s(k)).collect::<Option<_>>()?;
    let stroke = span(&y);
    let turns = turning_points(&y, WIDE * stroke);
    let mut ends = vec![0];
    ends.extend(turns.iter().map(|turn| turn.index));
    ends.push(y.len().checked_sub(1)?);
    let mut moves: Vec<Servo> = Vec::new();
    for two in ends.windows(2) {
        // From where the move has begun to where it has not ended yet: a rest before or after it is none of
        // it.
        let (from, to) = (y[two[0]], y[two[1]]);
        let within = |k: &usize| {
            let share = (y[*k] - from) / (to - from);
            (ENDS..=1.0 - ENDS).contains(&share)
        };
        let inside: Vec<usize> = (two[0]..two[1]).filter(within).collect();
        if (to - from).abs() < WIDE * stroke || inside.len() < FEWEST {
            continue;
        }
        let of = |x: &[f64]| {
            let points: Vec<(f64, f64)> = inside.iter().map(|&k| (times[k], x[k])).collect();
            off_a_line(&points)
        };
        moves.push(Servo { output: of(&y)?, input: of(&u)? });
    }
    let mean = |of: fn(&Servo) -> f64| moves.iter().map(of).sum::<f64>() / moves.len() as f64;
    let found = Servo { output: mean(|m| m.output), input: mean(|m| m.input) };
    let is_servo = found.output < STRAIGHT && found.input > BENT && found.input > TIMES * found.output;
    is_servo.then_some(found)
}

/// Rms departure from the least-squares line over the range of the values.
fn off_a_line(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let (t_mean, x_mean) = points.iter().fold((0.0, 0.0), |(t, x), p| (t + p.0 / n, x + p.1 / n));
    let (tt, tx) = points
        .iter()
        .fold((0.0, 0.0), |(tt, tx), p| (tt + (p.0 - t_mean).powi(2), tx + (p.0 - t_mean) * (p.1 - x_mean)));
    let slope = if tt > 0.0 { tx / tt } else { return None };
    let square = points.iter().map(|p| (p.1 - x_mean - slope * (p.0 - t_mean)).powi(2)).sum::<f64>() / n;
    let range = span(&points.iter().map(|p| p.1).collect::<Vec<f64>>());
    (range > 0.0).then(|| square.sqrt() / range)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::record::TimeBase;

    /// A triangle and the same bent by 10 % on its way up and down.
    fn triangle() -> (Vec<f64>, Vec<f64>) {
        let straight = |k: usize| 1.0 - ((k % 400) as f64 / 200.0 - 1.0).abs();
        let bent = |k: usize| {
            straight(k) + 0.4 * straight(k) * (1.0 - straight(k)) * if k % 400 < 200 { 1.0 } else { -1.0 }
        };
        ((0..1600).map(straight).collect(), (0..1600).map(bent).collect())
    }

    #[test]
    fn a_straight_output_of_a_bent_drive_is_a_servo_s_and_the_other_way_round_is_none() {
        let (straight, bent) = triangle();
        let record = |u: &[f64], y: &[f64]| {
            InputOutput::new("r", TimeBase::uniform(1000.0), u.to_vec(), y.to_vec()).unwrap()
        };
        let found = servo(&record(&bent, &straight)).unwrap();
        assert!(found.output < 1e-9 && found.input > 0.01, "{found:?}");
        assert_eq!(servo(&record(&straight, &bent)), None);
        assert_eq!(servo(&record(&straight, &straight)), None);
    }
}
