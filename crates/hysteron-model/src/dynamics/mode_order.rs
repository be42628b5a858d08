//! Order of the modes of a form, on which G does not depend.

use super::{DynamicForm, ParameterKind};

impl DynamicForm {
    /// Parameters of the same G with the natural frequencies of its modes in increasing order, so that they
    /// do not depend on which mode a search finds first.
    pub fn in_order(&self, values: &[f64]) -> Vec<f64> {
        let parameters = self.parameters();
        let value =
            |kind| parameters.iter().zip(values).find(|(p, _)| p.kind == kind).map(|(_, &value)| value);
        let of_every_mode = |kind: fn(usize) -> ParameterKind| -> Vec<f64> {
            (1..).map_while(|mode| value(kind(mode))).collect()
        };
        let frequencies = of_every_mode(ParameterKind::NaturalFrequency);
        let mut order: Vec<usize> = (0..frequencies.len()).collect();
        order.sort_by(|&a, &b| frequencies[a].total_cmp(&frequencies[b]));
        if order.is_sorted() {
            return values.to_vec();
        }
        let mut shares = of_every_mode(ParameterKind::Share);
        shares.push(1.0 - shares.iter().sum::<f64>());
        let place = |mode: usize| order.get(mode - 1).copied();
        let moved = |kind: fn(usize) -> ParameterKind, mode: usize| value(kind(place(mode)? + 1));
        let in_order = |(parameter, &own): (&super::FormParameter, &f64)| {
            let found = match parameter.kind {
                ParameterKind::NaturalFrequency(mode) => moved(ParameterKind::NaturalFrequency, mode),
                ParameterKind::Damping(mode) => moved(ParameterKind::Damping, mode),
                ParameterKind::HighestOrder(mode) => moved(ParameterKind::HighestOrder, mode),
                ParameterKind::MiddleOrder(mode) => moved(ParameterKind::MiddleOrder, mode),
                ParameterKind::Share(mode) => place(mode).and_then(|place| shares.get(place).copied()),
                _ => None,
            };
            found.unwrap_or(own)
        };
        parameters.iter().zip(values).map(in_order).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Creep, Modes};
    use super::*;

    /// Descending natural frequencies, all numbers different.
    fn example(form: &DynamicForm) -> Vec<f64> {
        let of = |(index, parameter): (usize, super::super::FormParameter)| match parameter.kind {
            ParameterKind::NaturalFrequency(mode) => 300.0 / mode as f64,
            ParameterKind::HighestOrder(mode) => 1.7 + 0.1 * mode as f64,
            ParameterKind::MiddleOrder(mode) => 0.8 + 0.1 * mode as f64,
            ParameterKind::Lag | ParameterKind::CreepTime(_) => 1e-3,
            _ => 0.1 + 0.02 * index as f64,
        };
        form.parameters().into_iter().enumerate().map(of).collect()
    }

    #[test]
    fn the_transfer_function_stays_and_frequencies_rise() {
        let frequencies_hz = [0.1, 20.0, 100.0, 140.0, 310.0, 900.0];
        for modes in [
            Modes::Integer { order: 5 },
            Modes::Integer { order: 6 },
            Modes::Resonances { count: 3, lag: true },
            Modes::Resonances { count: 4, lag: false },
            Modes::TwoFractional,
        ] {
            let form = DynamicForm { modes, creep: Creep::Fractional };
            let values = example(&form);
            let ordered = form.in_order(&values);
            let response =
                |p: &[f64]| form.transfer_function(p).unwrap().frequency_response(&frequencies_hz, 0.0);
            for (before, after) in response(&values).iter().zip(response(&ordered)) {
                assert!((before - after).norm() < 1e-12 * before.norm(), "{modes:?}: {before} {after}");
            }
            let is_frequency =
                |p: &super::super::FormParameter| matches!(p.kind, ParameterKind::NaturalFrequency(_));
            let found: Vec<f64> = form
                .parameters()
                .iter()
                .zip(&ordered)
                .filter(|(p, _)| is_frequency(p))
                .map(|(_, f)| *f)
                .collect();
            assert!(found.len() > 1 && found.is_sorted(), "{modes:?}: {found:?}");
            let again = form.in_order(&ordered);
            assert_eq!(again, ordered, "{modes:?}");
        }
    }

    #[test]
    fn one_mode_is_in_order() {
        let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
        assert_eq!(form.in_order(&[70.0, 0.1, 1.9, 0.9]), [70.0, 0.1, 1.9, 0.9]);
    }
}
