//! A recalibration and model files.

use super::{Prior, Recalibration};
use crate::hysteresis::Hysteresis;
use crate::model_file::{ModelFile, Quantity, polynomial_name};

impl Prior {
    /// What the standard errors in a model file say: that of `linear`, relative, for the gain, and that of the delay.
    pub fn of(file: &ModelFile) -> Self {
        let linear = file.hysteresis.parameters.get("linear");
        let gain = linear.and_then(|q| Some((q.std_error? / q.value).abs()));
        let known = |s: &f64| s.is_finite() && *s > 0.0;
        Self { gain: gain.filter(known), delay_s: file.delay.std_error.filter(known) }
    }
}

impl Recalibration {
    /// The old model's file with the new numbers. Standard errors: the old one, scaled, and that of the gain, as if independent of
    /// each other: the file holds no covariance, and the true ones are at most about as large.
    pub fn file(&self, old: &ModelFile) -> ModelFile {
        let mut file = old.clone();
        let Hysteresis::BoucWen(new) = &self.model.hysteresis;
        let of_gain = self.gain.std_error.unwrap_or(0.0) / self.gain.value;
        let set = |quantity: Option<&mut Quantity>, value: f64, power: f64| {
            let Some(quantity) = quantity else { return };
            let scale = self.gain.value.powf(power);
            quantity.value = value;
            quantity.std_error = quantity.std_error.map(|s| (scale * s).hypot(power * value * of_gain));
        };
        let parameters = &mut file.hysteresis.parameters;
        for (index, &value) in new.polynomial.iter().enumerate() {
            set(parameters.get_mut(&polynomial_name(index + 1)), value, 1.0);
        }
        set(parameters.get_mut("alpha"), new.alpha, 1.0);
        set(parameters.get_mut("beta"), new.beta, 1.0 - new.n);
        set(parameters.get_mut("gamma"), new.gamma, 1.0 - new.n);
        (file.delay.value, file.delay.std_error) = (self.model.delay_s, self.delay.std_error);
        (file.offset.value, file.offset.std_error) = (self.model.offset, None);
        file
    }
}
