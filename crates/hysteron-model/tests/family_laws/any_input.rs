//! Any finite drive gives finite columns or an error, with derivatives and without.

use super::*;

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        prop::num::f64::NORMAL | prop::num::f64::ZERO,
        -10.0..10.0_f64,
        Just(0.0),
        Just(1.0),
        Just(-1.0)
    ]
}

/// Shapes may be anything too: then most are refused.
fn finite_or_refused<K: ColumnKernel>(
    kernel: &K,
    shapes: [&[f64]; 2],
    u: &[f64],
    start: Start<f64>,
) -> TestCaseResult {
    for shape in shapes {
        let shape = &shape[..kernel.shape_names().len()];
        let mut out = vec![0.0; kernel.columns() * u.len()];
        if kernel.simulate_every(shape, 1, u, start, &mut out).is_ok() {
            prop_assert!(out.iter().all(|x| x.is_finite()), "{out:?}");
        }
        let mut all = ColumnSensitivities::default();
        if kernel.simulate_with_sensitivities(shape, 1, u, start, &mut all).is_ok() {
            let finite = all.columns.iter().chain(&all.d_start).chain(all.d_shape.iter().flatten()).flatten();
            prop_assert!(finite.copied().all(f64::is_finite), "{all:?}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(40))]

    #[test]
    fn gives_finite_columns_or_an_error(
        shape in prop::array::uniform6(number()), usual in prop::array::uniform6(0.1..0.9_f64),
        u in vec(number(), 0..8), at in number(), periodic in any::<bool>(),
    ) {
        let start = if periodic { Start::PERIODIC } else { Start::Rest { voltage_v: at } };
        let shapes = [&shape[..], &usual[..]];
        finite_or_refused(&Duhem { degree: 2 }, shapes, &u, start)?;
        finite_or_refused(&Dahl, shapes, &u, start)?;
        let thresholds = vec![0.5, 2.0, 1e200];
        finite_or_refused(&OneSidedPlays { thresholds: thresholds.clone() }, shapes, &u, start)?;
        finite_or_refused(&MaxwellSlip { thresholds }, shapes, &u, start)?;
        finite_or_refused(&GeneralisedPlays { thresholds: vec![0.0, 0.5] }, shapes, &u, start)?;
        let kernel = RateDependentPlays { thresholds: vec![0.5, 2.0, 1e200], interval_s: 1e-3 };
        finite_or_refused(&kernel, shapes, &u, start)?;
        finite_or_refused(&DeadZonePlays::regular([-2.0, 3.0], 3), shapes, &u, start)?;
        let kernel = KrasnoselskiiPokrovskii { range: [-2.0, 3.0], lines: 4 };
        finite_or_refused(&kernel, shapes, &u, start)?;
        let plane = Preisach { levels: vec![-2.0, 0.0, 1.0, 3.0] };
        finite_or_refused(
            &PreisachDensity { plane: plane.clone(), law: DensityLaw::Gaussian },
            shapes,
            &u,
            start,
        )?;
        finite_or_refused(&plane, shapes, &u, start)?;
        finite_or_refused(&JilesAtherton, shapes, &u, start)?;
        finite_or_refused(&SongDerKiureghian, shapes, &u, start)?;
        finite_or_refused(&NonSymmetricBoucWen, shapes, &u, start)?;
    }
}
