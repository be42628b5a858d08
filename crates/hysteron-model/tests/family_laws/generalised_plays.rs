//! Generalised plays.

use super::*;

/// Thresholds wide enough for any envelopes of these shapes: |γ_r − γ_l| < 0.6.
fn model() -> impl Strategy<Value = (GeneralisedPlays, Vec<f64>)> {
    let shape = (0.15..0.2_f64, -0.5..0.5_f64, 0.15..0.2_f64, -0.5..0.5_f64);
    (vec(0.02..0.2_f64, 1..5), shape).prop_map(|(gaps, (a, b, c, d))| {
        let mut r = 0.3;
        let mut next = |gap: f64| {
            r += gap;
            r
        };
        let thresholds = gaps.into_iter().map(&mut next).collect();
        (GeneralisedPlays { thresholds }, vec![a, b, c, d])
    })
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn laws(
        (kernel, shape) in model(), u in drive(), moves in moves(), rest in -3.0..3.0_f64,
        inner in vec(0.0..1.0_f64, 0..8),
    ) {
        only_turning_points_count(&kernel, &shape, &u, 7, 0.0)?;
        the_periodic_start_closes(&kernel, &shape, &u, 0.0)?;
        continuous(&kernel, &shape, &moves, 0.2)?;
        return_point_memory(&kernel, &shape, &u, &inner, 0.0)?;
        congruent(&kernel, &shape, [&u, &[]], (-3.0, 2.0), 1e-14)?;
            a_memory_is_a_move(&kernel, &shape, &u, (rest, 0.5))?;
        derivatives_are_differences(&kernel, &shape, &u, Start::Rest { voltage_v: rest }, 1e-8)?;
        derivatives_are_differences(&kernel, &shape, &u, Start::PERIODIC, 1e-8)?;
        // Envelopes that mirror each other.
        odd(&kernel, &[shape[0], shape[1], shape[0], -shape[1]], &u, 1e-15)?;
    }
}

#[test]
fn envelopes_that_cross_too_far_are_refused_where_they_do() {
    let kernel = GeneralisedPlays { thresholds: vec![0.1] };
    let shape = [1.0, -1.0, 1.0, 1.0];
    let run = kernel.simulate_every(&shape, 1, &[20.0, 0.0], REST, &mut [0.0; 2]);
    assert!(matches!(run, Err(HysteresisError::Envelopes { u: 0.0, .. })), "{run:?}");
}
