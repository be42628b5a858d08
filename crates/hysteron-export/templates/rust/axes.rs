$DESCRIPTION
#![no_std]
#![forbid(unsafe_code)]
#![allow(clippy::needless_range_loop, clippy::excessive_precision, clippy::unreadable_literal)]
#![allow(clippy::let_and_return)]

//{ has_inverse
pub mod inverse;
//}
mod saved;

pub use saved::NotSaved;

/// Samples a second \[Hz\]. The coefficients belong to this rate.
pub const SAMPLE_RATE_HZ: $float = $RATE;
/// Actuators.
pub const INPUTS: usize = $N_INPUTS;
/// Axes.
pub const OUTPUTS: usize = $N_OUTPUTS;
//{ range
/// Lowest and highest voltage of the records that the model was identified from \[$INPUT_UNIT\]; beyond, it
/// extrapolates.
pub const VOLTAGE_RANGE: ($float, $float) = ($RANGE_LOW, $RANGE_HIGH);
//}
const MODES: usize = $N_MODES;
const STATES: usize = 2 * MODES + INPUTS;
/// Steps of the model in one sample, and those after which every state has settled.
const STEPS: usize = $N_STEPS;
const SETTLES: usize = $N_SETTLES;
//{ strains
const PLAYS: usize = $N_PLAYS;
//}

$TABLES
/// Marks the saved states of this export: those of another model, rate or version have another.
const MARK: u64 = $MARK;
/// Numbers that the model remembers.
const NUMBERS: usize = STATES + 2 * INPUTS + OUTPUTS
//{ strains
    + 2 * INPUTS * PLAYS
//}
    ;
/// Bytes of a saved state.
pub const SAVED_BYTES: usize = saved::bytes_of(NUMBERS);

/// The model. A step allocates nothing.
#[derive(Clone, Debug)]
pub struct Model {
    x: [$float; STATES],
    held: [$float; INPUTS],
    strain: [$float; INPUTS],
//{ strains
    plays: [[$float; PLAYS]; 2 * INPUTS],
//}
    output: [$float; OUTPUTS],
}

fn dot(a: &[$float], b: &[$float]) -> $float {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}

impl Default for Model {
    fn default() -> Self {
        Self::new()
    }
}

impl Model {
    /// At rest under voltages of 0.
    pub fn new() -> Self {
        let mut model = Self {
            x: [0.0; STATES],
            held: [0.0; INPUTS],
            strain: [0.0; INPUTS],
//{ strains
            plays: [[0.0; PLAYS]; 2 * INPUTS],
//}
            output: [0.0; OUTPUTS],
        };
        model.settle([0.0; INPUTS]);
        model
    }

    /// At rest under these voltages \[$INPUT_UNIT\]: simulates until every state has settled. Not for real
    /// time. Those that are not finite count as 0.
    pub fn rest_at(&mut self, voltages: [$float; INPUTS]) -> [$float; OUTPUTS] {
        self.settle(voltages.map(|u| if u.is_finite() { u } else { 0.0 }));
        self.output
    }

    /// One sample: these voltages \[$INPUT_UNIT\] are held from now on; returns the outputs \[$OUTPUT_UNIT\]
    /// now. One that is not finite is replaced by the last. Where a drive far from those of the identification
    /// throws the motion out of the range of numbers, it goes on from 0, without memory.
    pub fn step(&mut self, voltages: [$float; INPUTS]) -> [$float; OUTPUTS] {
        let mut u = voltages;
        for (u, held) in u.iter_mut().zip(&self.held) {
            if !u.is_finite() {
                *u = *held;
            }
        }
        self.next_sample();
        self.apply(u);
        self.output
    }

    /// The state, as bytes that outlast a reset.
    pub fn save(&self) -> [u8; SAVED_BYTES] {
        let mut bytes = [0; SAVED_BYTES];
        saved::save(MARK, self.numbers().map(|x| $WORD), &mut bytes);
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
        let words = saved::restore(MARK, bytes)?;
        self.numbers_mut().zip(words).for_each(|(x, word)| *x = $float::from_bits($BACK));
        Ok(())
    }

    fn numbers(&self) -> impl Iterator<Item = &$float> {
        let numbers = self.x.iter().chain(&self.held).chain(&self.strain).chain(&self.output);
//{ strains
        let numbers = numbers.chain(self.plays.as_flattened());
//}
        numbers
    }

    fn numbers_mut(&mut self) -> impl Iterator<Item = &mut $float> {
        let Self { x, held, strain, output, .. } = self;
        let numbers = x.iter_mut().chain(held).chain(strain).chain(output);
//{ strains
        let numbers = numbers.chain(self.plays.as_flattened_mut());
//}
        numbers
    }

    fn settle(&mut self, u: [$float; INPUTS]) {
        self.x = [0.0; STATES];
        self.strain = [0.0; INPUTS];
//{ strains
        self.plays = [[0.0; PLAYS]; 2 * INPUTS];
//}
        self.held = u;
        for _ in 0..SETTLES {
//{ strains
            self.strains();
//}
            self.advance();
        }
        self.apply(u);
    }

//{ strains
    /// The strains of the actuators under the voltages held; moves the plays.
    fn strains(&mut self) {
        self.strain = [0.0; INPUTS];
        for i in 0..2 * INPUTS {
            let (of_states, of_voltages) = ROWS[i].split_at(STATES);
            let z = dot(of_states, &self.x) + dot(of_voltages, &self.held);
            let z = z.clamp(-REACH[i], REACH[i]);
            let square = z * z - VARIANCE[i];
            let cube = z * z * z - 3.0 * VARIANCE[i] * z;
            let mut value = POWERS[i][0] * square + POWERS[i][1] * cube;
//{ plays
            for j in 0..PLAYS {
                let play = &mut self.plays[i][j];
                if z - RADII[i][j] > *play {
                    *play = z - RADII[i][j];
                } else if z + RADII[i][j] < *play {
                    *play = z + RADII[i][j];
                }
                value += WEIGHTS[i][j] * (*play - SLOPES[i][j] * z);
            }
//}
            self.strain[i % INPUTS] += value;
        }
    }

//}
    /// One step of the modes and lags under the voltages held.
    fn advance(&mut self) {
        let mut next = [0.0; STATES];
        for k in 0..STATES {
            next[k] = dot(&INPUT[k], &self.held) + dot(&STRAIN_INPUT[k], &self.strain);
        }
        for k in 0..MODES {
            let (a, b) = (TRANSITION[2 * k], TRANSITION[2 * k + 1]);
            let (re, im) = (self.x[2 * k], self.x[2 * k + 1]);
            next[2 * k] += a * re - b * im;
            next[2 * k + 1] += a * im + b * re;
        }
        for k in 2 * MODES..STATES {
            next[k] += TRANSITION[k] * self.x[k];
        }
        self.x = next;
    }

    fn next_sample(&mut self) {
//{ strains
        for step in 0..STEPS {
            if step > 0 {
                self.strains();
            }
            self.advance();
        }
//}
//{ !strains
        for _ in 0..STEPS {
            self.advance();
        }
//}
    }

    /// Holds voltages from the present sample on. False where the motion has left the range of numbers: it goes
    /// on from 0 then, without memory.
    fn apply(&mut self, u: [$float; INPUTS]) -> bool {
        self.held = u;
        self.find_output();
        if self.output.iter().all(|y| y.is_finite()) {
            return true;
        }
        self.x = [0.0; STATES];
//{ strains
        self.plays = [[0.0; PLAYS]; 2 * INPUTS];
//}
        self.find_output();
        false
    }

    /// The outputs under the voltages held.
    fn find_output(&mut self) {
//{ strains
        self.strains();
//}
        for m in 0..OUTPUTS {
            self.output[m] = dot(&OUTPUT[m], &self.x)
                + dot(&FEEDTHROUGH[m], &self.held)
                + dot(&STRAIN_FEEDTHROUGH[m], &self.strain);
        }
    }
}
