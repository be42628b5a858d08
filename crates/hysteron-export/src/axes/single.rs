//! The sources in single precision, run along their own vectors before they are written.
//!
//! The arithmetic of the templates, operation by operation, on numbers rounded as in the source: what it
//! departs from double precision by is what the controller's does.

use std::collections::VecDeque;

use hysteron_model::axes::ScheduledModes;
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::DecouplingLaw;
use hysteron_rt::Real;

use super::tables::Limited;
use crate::number::Precision;

/// The model.
pub(super) struct Single {
    inputs: usize,
    modes: usize,
    steps: usize,
    settles: usize,
    transition: Vec<f32>,
    input: Vec<f32>,
    strain_input: Vec<f32>,
    output: Vec<f32>,
    feedthrough: Vec<f32>,
    strain_feedthrough: Vec<f32>,
    laws: Vec<Law>,
    x: Vec<f32>,
    held: Vec<f32>,
    strain: Vec<f32>,
    y: Vec<f32>,
}

/// The law of a free stroke or stress, and its plays.
struct Law {
    row: Vec<f32>,
    powers: [f32; 2],
    variance: f32,
    reach: f32,
    /// Weight, radius, mean slope, position.
    plays: Vec<[f32; 4]>,
}

fn rounded(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|x| f32::of(*x)).collect()
}

fn dot<'a>(a: &[f32], b: impl IntoIterator<Item = &'a f32>) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

/// `row · vector` of every row.
fn times<'a>(matrix: &'a [f32], vector: &'a [f32]) -> impl Iterator<Item = f32> + 'a {
    matrix.chunks(vector.len().max(1)).map(move |row| dot(row, vector))
}

impl Law {
    fn new(law: &hysteron_model::axes::StrainLaw, row: &[f64]) -> Self {
        let weights = law.coefficients.iter().skip(2);
        let plays = weights.zip(&law.radii).zip(&law.slopes);
        let power = |k: usize| law.coefficients.get(k).map_or(0.0, |c| f32::of(*c));
        Self {
            row: rounded(row),
            powers: [power(0), power(1)],
            variance: f32::of(law.variance),
            reach: f32::of(law.reach.min(f64::from(f32::MAX))),
            plays: plays.map(|((w, r), s)| [f32::of(*w), f32::of(*r), f32::of(*s), 0.0]).collect(),
        }
    }

    fn step(&mut self, x: &[f32], u: &[f32]) -> f32 {
        let (of_x, of_u) = self.row.split_at(x.len());
        let z = (dot(of_x, x) + dot(of_u, u)).clamp(-self.reach, self.reach);
        let square = z * z - self.variance;
        let cube = z * z * z - 3.0 * self.variance * z;
        let mut value = self.powers[0] * square + self.powers[1] * cube;
        for [weight, radius, slope, play] in &mut self.plays {
            *play = play.max(z - *radius).min(z + *radius);
            value += *weight * (*play - *slope * z);
        }
        value
    }
}

impl Single {
    /// At rest under voltages of 0.
    pub fn new(model: &ScheduledModes, s: f64, settles: usize) -> Self {
        let at = model.at(s);
        let row = model.states() + model.inputs;
        let laws = model.feedback.as_ref().map_or_else(Vec::new, |feedback| {
            let drive = feedback.drive_rows.chunks(row).map(|row| Law::new(&feedback.drive, row));
            let stress = feedback.stress_rows.chunks(row).zip(&feedback.stress);
            drive.chain(stress.map(|(row, law)| Law::new(law, row))).collect()
        });
        let mut single = Self {
            inputs: model.inputs,
            modes: model.modes,
            steps: model.steps,
            settles,
            transition: rounded(&at.transition),
            input: rounded(&model.input),
            strain_input: rounded(&model.strain_input),
            output: rounded(&at.output),
            feedthrough: rounded(&at.feedthrough),
            strain_feedthrough: rounded(&model.strain_feedthrough),
            laws,
            x: vec![0.0; model.states()],
            held: vec![0.0; model.inputs],
            strain: vec![0.0; model.inputs],
            y: vec![0.0; model.outputs],
        };
        single.settle(&vec![0.0; model.inputs]);
        single
    }

    /// One sample: outputs at it, and these voltages held from it on.
    pub fn step(&mut self, u: &[f32]) -> &[f32] {
        self.next_sample();
        self.apply(u);
        &self.y
    }

    fn settle(&mut self, u: &[f32]) {
        self.held.copy_from_slice(u);
        for _ in 0..self.settles {
            self.strains();
            self.advance();
        }
        self.apply(u);
    }

    fn strains(&mut self) {
        self.strain.fill(0.0);
        for (i, law) in self.laws.iter_mut().enumerate() {
            self.strain[i % self.inputs] += law.step(&self.x, &self.held);
        }
    }

    fn advance(&mut self) {
        let driven = times(&self.input, &self.held).zip(times(&self.strain_input, &self.strain));
        let mut next: Vec<f32> = driven.map(|(u, w)| u + w).collect();
        let (modes, lags) = next.split_at_mut(2 * self.modes);
        let pairs = modes.chunks_exact_mut(2).zip(self.transition.chunks_exact(2));
        for ((next, p), x) in pairs.zip(self.x.chunks_exact(2)) {
            next[0] += p[0] * x[0] - p[1] * x[1];
            next[1] += p[0] * x[1] + p[1] * x[0];
        }
        let before = self.transition[2 * self.modes..].iter().zip(&self.x[2 * self.modes..]);
        lags.iter_mut().zip(before).for_each(|(next, (a, x))| *next += a * x);
        self.x = next;
    }

    fn next_sample(&mut self) {
        for step in 0..self.steps {
            if step > 0 {
                self.strains();
            }
            self.advance();
        }
    }

    fn apply(&mut self, u: &[f32]) {
        self.held.copy_from_slice(u);
        self.strains();
        let parts = times(&self.output, &self.x).zip(times(&self.feedthrough, &self.held));
        let y = parts.zip(times(&self.strain_feedthrough, &self.strain)).map(|((x, u), w)| x + u + w);
        self.y = y.collect();
    }
}

/// The inverse.
pub(super) struct SingleInverse {
    model: Single,
    limits: Vec<Limited>,
    states: Vec<f32>,
    recent: [Vec<f32>; 2],
    strains: Vec<f32>,
    rates: Vec<f32>,
    /// Gains on the references, from the present one on.
    references: Vec<Vec<f32>>,
    smoothing: f32,
    before: Vec<f32>,
    predicted: Vec<f32>,
    rate: Vec<f32>,
    /// References, the oldest first.
    window: VecDeque<Vec<f32>>,
}

impl SingleInverse {
    /// At rest under the voltages within the limits that are nearest to 0.
    pub fn new(law: &DecouplingLaw, limits: &[Limits], settles: usize) -> Self {
        let model = &law.held.model;
        let limits: Vec<Limited> =
            limits.iter().map(|limit| Limited::new(limit, model.sample_rate_hz, Precision::F32)).collect();
        let mut model = Single::new(model, law.state, settles);
        let rest: Vec<f32> =
            limits.iter().map(|l| f32::of(0.0).max(f32::of(l.low)).min(f32::of(l.high))).collect();
        model.laws.iter_mut().flat_map(|law| &mut law.plays).for_each(|play| play[3] = 0.0);
        model.x.fill(0.0);
        model.strain.fill(0.0);
        model.settle(&rest);
        Self {
            limits,
            states: rounded(&law.states),
            recent: [rounded(&law.recent[0]), rounded(&law.recent[1])],
            strains: rounded(&law.strains),
            rates: rounded(&law.strain_rates),
            references: law.reference.iter().map(|gains| rounded(gains)).collect(),
            smoothing: f32::of(law.smoothing),
            predicted: model.strain.clone(),
            rate: vec![0.0; rest.len()],
            window: std::iter::repeat_n(model.y.clone(), law.preview + 1).collect(),
            before: rest,
            model,
        }
    }

    /// One sample: the voltages held from it on.
    pub fn step(&mut self, references: &[f32]) -> &[f32] {
        self.window.pop_front();
        self.window.push_back(references.to_vec());
        let last_strain = self.model.strain.clone();
        self.model.next_sample();
        let last = self.model.held.clone();
        let mut wanted: Vec<f32> = times(&self.states, &self.model.x).collect();
        for (gains, of) in [
            (&self.recent[0], &last),
            (&self.recent[1], &self.before),
            (&self.strains, &self.predicted),
            (&self.rates, &self.rate),
        ] {
            wanted.iter_mut().zip(times(gains, of)).for_each(|(wanted, more)| *wanted += more);
        }
        for (gains, of) in self.references.iter().zip(&self.window) {
            wanted.iter_mut().zip(times(gains, of)).for_each(|(wanted, more)| *wanted += more);
        }
        let limited = wanted.iter().zip(&last).zip(&self.limits).map(|((wanted, last), limit)| {
            let ranged = wanted.max(f32::of(limit.low)).min(f32::of(limit.high));
            ranged.max(last - f32::of(limit.step)).min(last + f32::of(limit.step))
        });
        let u: Vec<f32> = limited.collect();
        self.before = last;
        self.model.apply(&u);
        let strains = self.model.strain.iter().zip(&last_strain);
        for ((rate, predicted), (strain, last)) in self.rate.iter_mut().zip(&mut self.predicted).zip(strains)
        {
            *rate += self.smoothing * (strain - last - *rate);
            *predicted = strain + *rate;
        }
        &self.model.held
    }
}
