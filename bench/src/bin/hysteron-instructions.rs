//! The hot paths whose instructions `bench/instructions.sh` counts: `hysteron-instructions PATH REPETITIONS`
//! does one of them so many times, and without arguments lists them. A new path is a line in `PATHS` and a
//! function.

#[path = "../synthetic.rs"]
mod synthetic;

use std::error::Error;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::io::{Write, stderr, stdout};
use std::process::ExitCode;

use hysteron_model::Start;
use hysteron_model::dynamics::{Sampling, Scheme, SimulationPlan, TransferFunction};
use hysteron_model::hysteresis::{Sensitivities, UnitShape};
use hysteron_optimize::{
    Algorithm, Bounds, Derivative, LeastSquaresOptions, LeastSquaresProblem, Problem, Range, Settings,
    Unobserved, minimize, root_mean_square,
};

type Outcome = Result<(), Box<dyn Error + Send + Sync>>;

/// Samples of the records simulated.
const SAMPLES: usize = 100_000;

/// Name, and the work so many times.
type HotPath = (&'static str, fn(usize) -> Outcome);

const PATHS: [HotPath; 4] = [
    ("hysteresis-pass", hysteresis_pass),
    ("dynamics-column", dynamics_column),
    ("joint-objective", joint_objective),
    ("least-squares", least_squares),
];

/// Sine of 1000 samples a period.
fn drive() -> Vec<f64> {
    (0..SAMPLES).map(|k| 5.0 - 5.0 * (TAU * k as f64 / 1000.0).cos()).collect()
}

/// ζ and its derivatives with respect to β', γ' and ζ(0), n = 1.
fn hysteresis_pass(repetitions: usize) -> Outcome {
    let u = drive();
    let shape = UnitShape { beta: 0.1111, gamma: -0.0024, n: 1.0 };
    let mut out = Sensitivities::default();
    for _ in 0..repetitions {
        black_box(shape).simulate_with_sensitivities(
            1,
            &u,
            Start::Rest { voltage_v: 0.0 },
            false,
            &mut out,
        )?;
    }
    Ok(())
}

/// Frequency response of article Eq. 13 and its application to a transformed input.
fn dynamics_column(repetitions: usize) -> Outcome {
    let plan = SimulationPlan::new(SAMPLES, 1e4, Scheme::Tustin, Start::ZERO)?;
    let spectrum = plan.transform(&drive())?;
    let (mut workspace, mut response) = (plan.workspace(), plan.empty_response(0));
    let mut output = vec![0.0; SAMPLES];
    let tf = TransferFunction::article_eq13();
    let sampling = Sampling::of(plan.scheme());
    for _ in 0..repetitions {
        plan.response(black_box(&tf), 1e-4, sampling, &mut response)?;
        plan.apply(&response, &spectrum, &mut workspace, &mut output)?;
    }
    Ok(())
}

/// Residuals and Jacobian of a joint fit of two records, one thread.
fn joint_objective(repetitions: usize) -> Outcome {
    let (objective, mut x) = synthetic::objective(SAMPLES / 10, 2)?;
    let count = objective.residual_count();
    let mut workspace = objective.workspace();
    let (mut residuals, mut jacobian) = (vec![0.0; count], vec![0.0; count * x.len()]);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        for _ in 0..repetitions {
            synthetic::move_on(&mut x);
            let feasible = objective.residuals(black_box(&x), &mut workspace, &mut residuals);
            let written = objective.jacobian(black_box(&x), &mut workspace, &mut jacobian);
            if !feasible || written != Derivative::Written {
                return Err("the joint objective cannot be evaluated".into());
            }
        }
        Ok(())
    })
}

/// A sum of two decays fitted to 20 000 samples of another, with exact derivatives: what is left is the
/// optimiser.
struct Decays {
    bounds: Bounds,
    wanted: Vec<f64>,
}

impl Decays {
    fn time(k: usize) -> f64 {
        k as f64 / 20_000.0
    }

    fn new() -> Self {
        let wanted =
            |k| (-2.0 * Self::time(k)).exp() + 0.5 * (-9.0 * Self::time(k)).exp() + 0.01 * (k as f64).sin();
        let range = Range::linear;
        let ranges =
            [range("a", 0.0, 4.0), range("p", 0.5, 4.0), range("b", 0.0, 4.0), range("q", 5.0, 20.0)];
        Self { bounds: Bounds { ranges: ranges.to_vec() }, wanted: (0..20_000).map(wanted).collect() }
    }
}

impl Problem for Decays {
    type Workspace = Vec<f64>;
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn workspace(&self) -> Vec<f64> {
        vec![0.0; self.wanted.len()]
    }
    fn cost(&self, x: &[f64], workspace: &mut Vec<f64>) -> f64 {
        let mut residuals = std::mem::take(workspace);
        self.residuals(x, workspace, &mut residuals);
        *workspace = residuals;
        root_mean_square(workspace)
    }
}

impl LeastSquaresProblem for Decays {
    fn residual_count(&self) -> usize {
        self.wanted.len()
    }
    fn residuals(&self, x: &[f64], _: &mut Vec<f64>, out: &mut [f64]) -> bool {
        let &[a, p, b, q] = x else { return false };
        for (k, (r, wanted)) in out.iter_mut().zip(&self.wanted).enumerate() {
            let t = Self::time(k);
            *r = a * (-p * t).exp() + b * (-q * t).exp() - wanted;
        }
        true
    }
    fn jacobian(&self, x: &[f64], _: &mut Vec<f64>, out: &mut [f64]) -> Derivative {
        let &[a, p, b, q] = x else { return Derivative::Infeasible };
        let count = self.wanted.len();
        for (j, column) in out.chunks_exact_mut(count).enumerate() {
            let (size, rate) = if j < 2 { (a, p) } else { (b, q) };
            for (k, d) in column.iter_mut().enumerate() {
                let t = Self::time(k);
                *d = (-rate * t).exp() * if j % 2 == 0 { 1.0 } else { -size * t };
            }
        }
        Derivative::Written
    }
}

/// Levenberg–Marquardt from one start to the optimum, one thread.
fn least_squares(repetitions: usize) -> Outcome {
    let problem = Decays::new();
    let options = LeastSquaresOptions { starts: 1, agreement: None, ..LeastSquaresOptions::default() };
    let settings =
        Settings { starts: vec![vec![2.0, 1.0, 2.0, 15.0]], threads: Some(1), ..Settings::default() };
    let algorithm = Algorithm::LeastSquares(options);
    for _ in 0..repetitions {
        minimize(black_box(&problem), &algorithm, &settings, &mut Unobserved, None)?;
    }
    Ok(())
}

fn run() -> Outcome {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, repetitions] = arguments.as_slice() else {
        for (name, _) in PATHS {
            writeln!(stdout(), "{name}")?;
        }
        return Ok(());
    };
    let path = PATHS.iter().find(|(known, _)| known == name);
    let (_, work) = path.ok_or_else(|| format!("no hot path '{name}': without arguments they are listed"))?;
    work(repetitions.parse().map_err(|error| format!("REPETITIONS '{repetitions}': {error}"))?)
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(stderr(), "error: hysteron-instructions: {error}");
            ExitCode::FAILURE
        }
    }
}
