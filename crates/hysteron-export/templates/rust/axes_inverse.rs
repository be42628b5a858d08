$DESCRIPTION
#![allow(clippy::needless_range_loop, clippy::excessive_precision, clippy::unreadable_literal)]

use crate::saved::{self, NotSaved};
use crate::{INPUTS, Model, NUMBERS, OUTPUTS, STATES, dot};

/// Samples that the references handed to a step are ahead of those that its voltages are for.
pub const PREVIEW: usize = $N_PREVIEW;
/// Share by which the change of the strains moves to the newest one.
const SMOOTHING: $float = $SMOOTHING;

$TABLES
/// Marks the saved states of this export.
const MARK: u64 = $MARK;
/// Bytes of a saved state.
pub const SAVED_BYTES: usize = saved::bytes_of(NUMBERS + 3 * INPUTS + (PREVIEW + 1) * OUTPUTS + 1);

/// The inverse, sample by sample: references in, voltages out. A step allocates nothing.
#[derive(Clone, Debug)]
pub struct Inverse {
    model: Model,
    before: [$float; INPUTS],
    predicted: [$float; INPUTS],
    rate: [$float; INPUTS],
    window: [[$float; OUTPUTS]; PREVIEW + 1],
    present: usize,
}

impl Default for Inverse {
    fn default() -> Self {
        Self::new()
    }
}

impl Inverse {
    /// At rest under the voltages within the limits that are nearest to 0.
    pub fn new() -> Self {
        let mut inverse = Self {
            model: Model::new(),
            before: [0.0; INPUTS],
            predicted: [0.0; INPUTS],
            rate: [0.0; INPUTS],
            window: [[0.0; OUTPUTS]; PREVIEW + 1],
            present: 0,
        };
        inverse.rest_at([0.0; INPUTS]);
        inverse
    }

    /// At rest under these voltages \[$INPUT_UNIT\], moved into the limits; the references known are the
    /// outputs \[$OUTPUT_UNIT\] there, which it returns. Not for real time.
    pub fn rest_at(&mut self, voltages: [$float; INPUTS]) -> [$float; OUTPUTS] {
        let mut u = voltages;
        for i in 0..INPUTS {
            let wanted = if u[i].is_finite() { u[i] } else { 0.0 };
            u[i] = wanted.clamp(LOW[i], HIGH[i]);
        }
        let outputs = self.model.rest_at(u);
        self.before = u;
        self.predicted = self.model.strain;
        self.rate = [0.0; INPUTS];
        self.window = [outputs; PREVIEW + 1];
        self.present = 0;
        outputs
    }

    /// Takes the newest references without moving: called [`PREVIEW`] times before the first step, oldest
    /// first. One that is not finite is replaced by the last.
    pub fn know(&mut self, references: [$float; OUTPUTS]) {
        let last = self.window[(self.present + PREVIEW) % (PREVIEW + 1)];
        for m in 0..OUTPUTS {
            self.window[self.present][m] = if references[m].is_finite() { references[m] } else { last[m] };
        }
        self.present = (self.present + 1) % (PREVIEW + 1);
    }

    /// One sample: the voltages \[$INPUT_UNIT\] to be held from now on, within their limits. `references`
    /// \[$OUTPUT_UNIT\] are the newest known, [`PREVIEW`] samples ahead.
    pub fn step(&mut self, references: [$float; OUTPUTS]) -> [$float; INPUTS] {
        self.know(references);
        let last_strain = self.model.strain;
        self.model.next_sample();
        let x: &[$float; STATES] = &self.model.x;
        let last = self.model.held;
        let mut u = last;
        for i in 0..INPUTS {
            let mut wanted = dot(&LAW_STATES[i], x)
                + dot(&LAW_LAST[i], &last)
                + dot(&LAW_BEFORE[i], &self.before)
                + dot(&LAW_STRAINS[i], &self.predicted)
                + dot(&LAW_RATES[i], &self.rate);
            for (j, gains) in LAW_REFERENCES.iter().enumerate() {
                wanted += dot(&gains[i], &self.window[(self.present + j) % (PREVIEW + 1)]);
            }
            let target = if wanted.is_finite() { wanted } else { last[i] };
            let ranged = target.clamp(LOW[i], HIGH[i]);
            u[i] = ranged.clamp(last[i] - STEP[i], last[i] + STEP[i]);
        }
        self.before = last;
        let went_on = self.model.apply(u);
        for i in 0..INPUTS {
            if !went_on {
                self.rate[i] = 0.0;
                self.predicted[i] = self.model.strain[i];
                continue;
            }
            self.rate[i] += SMOOTHING * (self.model.strain[i] - last_strain[i] - self.rate[i]);
            self.predicted[i] = self.model.strain[i] + self.rate[i];
        }
        u
    }

    /// The state, as bytes that outlast a reset.
    pub fn save(&self) -> [u8; SAVED_BYTES] {
        let mut bytes = [0; SAVED_BYTES];
        let own = self.before.iter().chain(&self.predicted).chain(&self.rate);
        let numbers = self.model.numbers().chain(own).chain(self.window.as_flattened());
        saved::save(MARK, numbers.map(|x| $WORD).chain([self.present as u64]), &mut bytes);
        bytes
    }

    /// Takes the state that was saved, and goes on with the same bits.
    ///
    /// # Errors
    /// [`NotSaved`]; the state is then as it was.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), NotSaved> {
        if bytes.len() != SAVED_BYTES {
            return Err(NotSaved);
        }
        let mut words = saved::restore(MARK, bytes)?;
        let Self { model, before, predicted, rate, window, present } = self;
        let own = before.iter_mut().chain(predicted).chain(rate).chain(window.as_flattened_mut());
        model.numbers_mut().chain(own).zip(&mut words).for_each(|(x, word)| *x = $float::from_bits($BACK));
        *present = words.next().map_or(0, |word| (word % (PREVIEW as u64 + 1)) as usize);
        Ok(())
    }

    /// Outputs of the model at the last step \[$OUTPUT_UNIT\].
    pub fn output(&self) -> [$float; OUTPUTS] {
        self.model.output
    }
}
