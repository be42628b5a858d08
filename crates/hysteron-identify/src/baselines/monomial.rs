//! Products of powers of regressors.

/// A product of regressors, each as often as its power: `[]` is 1, `[0, 0, 3]` is x₀² x₃.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Monomial(pub Vec<usize>);

impl Monomial {
    /// All products of up to `degree` of `count` regressors; `once`, whose square is 1, to the first power
    /// only.
    pub fn all(count: usize, degree: usize, once: usize) -> Vec<Self> {
        let mut list = vec![Self(Vec::new())];
        let mut from = 0;
        for _ in 0..degree {
            let to = list.len();
            for index in from..to {
                let least = list[index].0.last().copied().unwrap_or(0);
                for next in least..count {
                    if next == once && list[index].0.last() == Some(&once) {
                        continue;
                    }
                    let longer = [list[index].0.as_slice(), &[next]].concat();
                    list.push(Self(longer));
                }
            }
            from = to;
        }
        list
    }

    /// Value at `x`.
    pub fn value(&self, x: &[f64]) -> f64 {
        self.0.iter().map(|&i| x[i]).product()
    }

    /// Adds `times` its derivatives to `by_x`.
    pub(super) fn add_derivatives(&self, x: &[f64], times: f64, by_x: &mut [f64]) {
        for (place, &i) in self.0.iter().enumerate() {
            let others = self.0.iter().enumerate().filter(|(other, _)| *other != place);
            by_x[i] += times * others.map(|(_, &j)| x[j]).product::<f64>();
        }
    }

    /// Name, e.g. `y₁ Δ s`.
    pub fn name(&self, regressors: &[String]) -> String {
        if self.0.is_empty() {
            return "1".to_owned();
        }
        let mut parts = Vec::new();
        for same in self.0.chunk_by(|a, b| a == b) {
            let name = regressors.get(same[0]).map_or("?", String::as_str);
            parts.push(if same.len() == 1 { name.to_owned() } else { format!("({name})^{}", same.len()) });
        }
        parts.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_of_two_regressors_by_hand() {
        let names = ["a".to_owned(), "s".to_owned()];
        let list: Vec<String> = Monomial::all(2, 3, 1).iter().map(|m| m.name(&names)).collect();
        assert_eq!(list, ["1", "a", "s", "(a)^2", "a s", "(a)^3", "(a)^2 s"]);
        // Without the restriction there are C(n + d, d).
        assert_eq!(Monomial::all(5, 3, usize::MAX).len(), 56);
    }

    #[test]
    fn derivatives_are_those_of_the_product() {
        let x = [0.7, -1.3, 0.4];
        for monomial in Monomial::all(3, 3, usize::MAX) {
            let mut by_x = [0.0; 3];
            monomial.add_derivatives(&x, 2.0, &mut by_x);
            for i in 0..3 {
                let step = |h: f64| {
                    let mut moved = x;
                    moved[i] += h;
                    monomial.value(&moved)
                };
                // The error of a cubic's central difference of step h is h² at most here.
                let difference = 2.0 * (step(1e-5) - step(-1e-5)) / 2e-5;
                assert!((by_x[i] - difference).abs() < 1e-9, "{monomial:?} {i}");
            }
        }
    }
}
