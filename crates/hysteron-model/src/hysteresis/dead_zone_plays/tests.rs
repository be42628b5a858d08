use proptest::prelude::*;

use super::super::HysteresisForm;
use super::*;
use crate::hysteresis::ColumnSensitivities;

/// Longer than a stretch of the pass and than one of its plays.
const SAMPLES: usize = 600;

fn drive() -> impl Strategy<Value = Vec<f64>> {
    // Moves that grow at random, so that the memory is forgotten early, late or never.
    let step = (0.0..10.0_f64, 0.0..1.0_f64);
    proptest::collection::vec(step, 2..SAMPLES).prop_map(|steps| {
        let count = steps.len() as f64;
        let of = |(k, (to, hold)): (usize, (f64, f64))| 5.0 + (to - 5.0) * hold * k as f64 / count;
        steps.into_iter().enumerate().map(of).collect()
    })
}

fn start() -> impl Strategy<Value = Start<f64>> {
    let memory = (0.0..10.0_f64, -2.0..12.0_f64);
    prop_oneof![
        memory.prop_map(|(voltage_v, memory)| Start::Remembering { voltage_v, memory }),
        (0.0..10.0_f64).prop_map(|voltage_v| Start::Rest { voltage_v }),
        Just(Start::PERIODIC),
    ]
}

fn shape() -> impl Strategy<Value = [f64; 2]> {
    (0.0..0.95_f64, 0.2..10.0_f64).prop_map(|(share, reach)| [share, reach])
}

fn form(plays: usize) -> HysteresisForm {
    let form = HysteresisForm::usual().into_iter().find(|form| form.name() == Entry.name()).unwrap();
    form.with_elements(plays).unwrap()
}

fn whole([share, reach]: [f64; 2]) -> [f64; 4] {
    [1.0, 9.0, share, reach]
}

proptest! {
    /// The pass in plain numbers against the operators one move at a time, in numbers with derivatives.
    #[test]
    fn columns_are_those_of_the_operators(
        u in drive(), start in start(), own in shape(), plays in 1..14_usize, factor in 1..3_usize,
    ) {
        let kernel = DeadZonePlays::regular([1.0, 9.0], plays);
        let mut exact = ColumnSensitivities::default();
        kernel.simulate_with_sensitivities(&own, factor, &u, start, &mut exact).unwrap();
        let mut out = Columns::default();
        form(plays).run(&whole(own), factor, &u, start, Some(&[false, false, true, true]), &mut out).unwrap();
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (1.0 + b.abs());
        let at = |of: &[f64], k: usize| of.get(k).copied().unwrap_or(0.0);
        let samples = u.len().div_ceil(factor);
        for j in 0..plays + BANDS {
            let [standing, by] = [out.standing[j], out.standing_by_memory[j]];
            prop_assert!(close(out.rest[j] + standing, exact.rest[j]));
            for k in 0..samples {
                let [a, b] = [out.values[j][k] + standing, exact.columns[j][k]];
                prop_assert!(close(a, b), "column {j} of {plays} at {k}: {a} {b}");
            }
            if let Start::Remembering { .. } = start {
                prop_assert!(close(out.rest_by_memory[j] + by, exact.d_start_rest[j]));
                for k in 0..samples {
                    let [a, b] = [at(&out.by_memory[j], k) + by, at(&exact.d_start[j], k)];
                    prop_assert!(close(a, b), "memory of column {j} of {plays} at {k}: {a} {b}");
                }
            }
        }
        for partial in &out.partials {
            let (index, column) = (partial.shape - GRID_ENDS, partial.column);
            prop_assert!(close(partial.rest, exact.d_shape_rest[index][column]));
            for k in 0..samples {
                let [a, b] = [partial.values[k], exact.d_shape[index][column][k]];
                prop_assert!(close(a, b), "shape {index} of column {column} of {plays} at {k}: {a} {b}");
            }
        }
    }

    /// A second run over a drive gives the same bits as a first one.
    #[test]
    fn a_run_again_is_a_run(
        u in drive(), shapes in [shape(), shape()], memories in [0.0..10.0_f64, 0.0..10.0_f64],
        are_the_same in any::<bool>(), derivatives in [any::<bool>(), any::<bool>()],
    ) {
        let start = |memory| Start::Remembering { voltage_v: u[0], memory };
        let second = start(memories[usize::from(!are_the_same)]);
        let wanted = |derivatives| if derivatives { Some(&[false, false, true, true][..]) } else { None };
        let [mut out, mut anew] = [0, 1].map(|_| Columns::default());
        form(12).run(&whole(shapes[0]), 1, &u, start(memories[0]), wanted(derivatives[0]), &mut out).unwrap();
        form(12).run_again(&whole(shapes[1]), 1, &u, second, wanted(derivatives[1]), &mut out).unwrap();
        form(12).run(&whole(shapes[1]), 1, &u, second, wanted(derivatives[1]), &mut anew).unwrap();
        prop_assert_eq!((&out.values, &out.rest, &out.standing), (&anew.values, &anew.rest, &anew.standing));
        if derivatives[1] {
            prop_assert_eq!(&out.by_memory, &anew.by_memory);
            prop_assert_eq!(&out.rest_by_memory, &anew.rest_by_memory);
            for (out, anew) in out.partials.iter().zip(&anew.partials) {
                prop_assert_eq!((&out.values, out.rest), (&anew.values, anew.rest));
            }
        }
    }
}
