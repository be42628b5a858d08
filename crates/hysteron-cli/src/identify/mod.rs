//! `hysteron identify`: records in, model file and report out.

mod family;
mod oscillator;
mod outcome;
mod parameters;
mod report;
mod starts;
pub mod written;

pub use written::command_line;

use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, ValueEnum};
use hysteron::dynamics::{Creep, Scheme};
use hysteron::identify::structure::neighbours;
use hysteron::identify::{
    CampaignRecord, Choice, Demands, DynamicsChoice, FindingKind, IdentifyError, Initial, Method, Options,
    RecordRole, Searches, Watcher, identify,
};
use hysteron::model_file::ModelFile;
use hysteron::optimize::{
    AbcOptions, Algorithm, CmaEsOptions, DeAbcOptions, DeOptions, LeastSquaresOptions, OptimizeError,
    Progress as SearchProgress, PsoOptions, ResumeError,
};
use hysteron::record::InterSample;
use hysteron_report::identification::{IdentificationReportData, identification_report};
use hysteron_report::write_figures;

use self::family::HysteresisArg;
use crate::axes::{AxesFlags, ModesFlags, identify_branches};
use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::interrupt;
use crate::numbers::{count, number, whole};
use crate::output;
use crate::progress::Progress;
use crate::result_flags::ResultFlags;

/// Largest file of interrupted searches read \[bytes\].
const MAX_RESUME_BYTES: u64 = 256 << 20;

/// Identify a model from measured records: hysteresis block, dynamic block, model file, report.
#[derive(Args)]
#[command(
    after_help = "With no flag the structure is what the records support: polynomial degree by evidence, fractional dynamics \
    where a record is much faster than the slowest one, delay and lag from a start from rest where none is. Which record is \
    slow is recognised; --static and --dynamic say it.\n\n\
    Records that carry dynamics are fitted jointly: both blocks, the delay, each record's offset and the hysteresis memory \
    it starts with, from several starts, on thinned records first and all samples last. --method two-step is the article's \
    way: hysteresis from the slow records, then dynamics from the others. Slow records alone, and --dynamics arx, oe, bj and srivc, go that way.\n\n\
    Parameters for --fix and --bound: linear, quadratic, cubic, …, alpha, beta, gamma, n (other families: the names in their model files), \
    offset, delay [s]; joint: \
    natural_frequency [Hz], damping, natural_frequency_2, damping_2, …, lag [s], order2, order1, order0, share, share_2, …, creep, creep_order, creep_per_decade, creep_start [s], creep_1, creep_time_1 [s], …, memory_1, memory_2, … (beta, gamma and \
    memory of alpha = 1); two-step: lag [s], gain.\n\n\
    --inputs u1_V,u2_V --outputs y1_nm,y2_nm fits several axes at once: structural modes with the hysteresis of each actuator in feedback, \
    from records of periodic multisines with different phases, one model for all amplitudes. They print the influence matrix.\n\n\
    --structure oscillator fits a mass on a hysteretic spring, m y'' + c y' + k y + z = u, to records of force and displacement \
    around a resonance; a force that repeats is taken to be in its steady state, another one to start from rest (--initial). Held \
    with --fix: mass, damping, n.\n\n\
    Ctrl-C keeps the best so far and writes MODEL.searches.json; go on from there with --resume.\n\n\
    Example: hysteron identify loop_1hz.csv -o model.json --report report.html\n\
    Example: hysteron identify loop_1hz.csv sweep.csv -o model.json --optimizer de-abc --seed 7\n\
    Example: hysteron identify multisine.csv --structure oscillator -o oscillator.json\n\
    Example: hysteron identify small*.csv large*.csv --inputs u1_V,u2_V --outputs y1_nm,y2_nm -o stage.json"
)]
pub struct Identify {
    /// The records
    #[arg(value_name = "RECORD", required_unless_present_any = ["static_records", "dynamic_records"])]
    records: Vec<PathBuf>,

    /// A quasi-static record, for the hysteresis block (repeatable)
    #[arg(long = "static", value_name = "FILE")]
    static_records: Vec<PathBuf>,

    /// A record that carries dynamics, for the dynamic block (repeatable)
    #[arg(long = "dynamic", value_name = "FILE")]
    dynamic_records: Vec<PathBuf>,

    /// Model file to write
    #[arg(short, long = "output-model", value_name = "MODEL.json")]
    out: PathBuf,

    /// Where the hysteresis is: ahead of linear dynamics, or in feedback [default: hammerstein; modes with --inputs]
    #[arg(long, value_enum)]
    structure: Option<StructureArg>,

    /// Hysteresis block
    #[arg(long, value_enum, default_value_t = HysteresisArg::BoucWen)]
    hysteresis: HysteresisArg,

    /// Elements of the hysteresis block: plays, slip elements, states, lines or intervals of a plane, degree
    /// [default: the family's own]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    elements: Option<usize>,

    /// Dynamic block; if not given, what the records support
    #[arg(long, value_enum)]
    dynamics: Option<DynamicsArg>,

    /// Identification method
    #[arg(long, value_enum, default_value_t = MethodArg::Joint)]
    method: MethodArg,

    /// Poles of --dynamics integer, 1 to 12, or modes, 2 to 12 (joint)
    #[arg(long, value_name = "N", default_value_t = 2)]
    order: usize,

    /// Creep factor of the dynamics (joint) [default: fractional where the records ask for it, none beside --dynamics]
    #[arg(long, value_enum, value_name = "KIND")]
    creep: Option<CreepArg>,

    /// Elements of --creep kelvin-voigt, 1 to 4 [default: 2]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    creep_elements: Option<usize>,

    /// What happened before each record (joint)
    #[arg(long, value_enum, default_value_t = InitialArg::Auto)]
    initial: InitialArg,

    /// Allow for a linear drift of each record's output (joint)
    #[arg(long)]
    drift: bool,

    /// Optimiser; auto: least squares from data-driven starts with the linear parameters eliminated
    #[arg(long, value_enum, default_value_t = OptimizerArg::Auto)]
    optimizer: OptimizerArg,

    /// Generations of a population method [default: 150]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    generations: Option<usize>,

    /// Population: food sources of de-abc and abc [default: 25], members of de and particles of pso [default: 50],
    /// starts of least-squares [default: 20]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    population: Option<usize>,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64>, allow_hyphen_values = true)]
    seed: u64,

    /// Threads; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    threads: Option<usize>,

    /// Go on from the searches of an interrupted identification
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,

    /// Degree of the polynomial l(u)
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = degree, allow_hyphen_values = true)]
    degree: ChoiceArg<usize>,

    /// Exponent n of the Bouc–Wen model [default: 1; free for an oscillator]
    #[arg(long, value_name = "VALUE|free", value_parser = exponent, allow_hyphen_values = true)]
    n: Option<ChoiceArg<f64>>,

    /// Delay between input and output in seconds; a given delay stands for the whole time shift of a quasi-static record
    #[arg(long, value_name = "SECONDS|auto", default_value = "auto", value_parser = delay, allow_hyphen_values = true)]
    delay: ChoiceArg<f64>,

    /// Hold a parameter at a value (repeatable)
    #[arg(long, value_name = "NAME=VALUE", value_parser = name_value, allow_hyphen_values = true)]
    fix: Vec<(String, f64)>,

    /// Keep a parameter within a range (repeatable)
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = name_range, allow_hyphen_values = true)]
    bound: Vec<(String, f64, f64)>,

    /// Model whose parameters every search tries first
    #[arg(long, value_name = "MODEL.json")]
    start: Option<PathBuf>,

    /// Simulation scheme of the dynamic block [default: band-limited for a joint fit of records that start smoothly, else
    /// tustin]
    #[arg(long, value_enum)]
    scheme: Option<SchemeArg>,

    /// What the drive does between its samples: hold for a converter without filter that shares the recorder's clock
    /// [default: linear; band-limited for an oscillator]
    #[arg(long, value_enum)]
    inter_sample: Option<InterSampleArg>,

    /// Hand out the model even if it explains less than this share of a record's variation, in %
    #[arg(long, value_name = "PERCENT", default_value_t = 75.0, value_parser = number, allow_hyphen_values = true)]
    least_fit: f64,

    #[command(flatten)]
    result: ResultFlags,

    /// Folder to write every figure of the report to, as SVG
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,

    #[command(flatten)]
    columns: ColumnFlags,

    #[command(flatten)]
    axes: AxesFlags,

    #[command(flatten)]
    modes: ModesFlags,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum StructureArg {
    /// Hysteresis, then linear dynamics
    Hammerstein,
    /// A mass on a hysteretic spring: resonances move with the amplitude
    Oscillator,
    /// Several axes: structural modes with hysteresis in feedback, that move with the level of the drive
    Modes,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodArg {
    /// All records, both blocks, delay and initial states in one fit
    Joint,
    /// The article's way: hysteresis from slow records, then dynamics from the others
    TwoStep,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum InitialArg {
    /// Rest, judged by the record
    Auto,
    /// Rest at the first sample, with an unknown hysteresis memory
    Rest,
    /// The record is a steady state that repeats
    Periodic,
    /// Rest at 0 V without memory
    Zero,
    /// Rest, with motion left over from before
    Free,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DynamicsArg {
    None,
    /// Whole orders: pairs of poles and, for an odd --order, a lag in series
    Integer,
    /// Resonances in parallel and, for an odd --order, a lag behind them
    Modes,
    /// Equation error, sampled (two steps)
    Arx,
    /// Output error B/F, sampled (two steps)
    Oe,
    /// Box–Jenkins: output error B/F with a noise model C/D, sampled (two steps)
    Bj,
    /// B(s)/A(s) in continuous time by refined instrumental variables (two steps)
    Srivc,
    /// b / (s^a2 + c1 s^a1 + c0)
    Fractional,
    /// b / (s^a2 + c1 s^a1 + c0 s^a0)
    FractionalFreeLowest,
    /// Two fractional modes in parallel
    TwoFractional,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CreepArg {
    /// 1 + k s^-mu: a power law without an end
    Fractional,
    /// 1 + gamma log10(1 + t/t0) after a unit step: the same amount every decade of time
    Logarithmic,
    /// 1 + sum of k/(1 + tau s): springs and dampers, creep that comes to an end
    KelvinVoigt,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OptimizerArg {
    Auto,
    DeAbc,
    Abc,
    De,
    Pso,
    CmaEs,
    LeastSquares,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SchemeArg {
    Tustin,
    GrunwaldLetnikov,
    Bdf2,
    BandLimited,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum InterSampleArg {
    Hold,
    Linear,
    BandLimited,
}

impl From<InterSampleArg> for InterSample {
    fn from(arg: InterSampleArg) -> Self {
        match arg {
            InterSampleArg::Hold => InterSample::Hold,
            InterSampleArg::Linear => InterSample::Linear,
            InterSampleArg::BandLimited => InterSample::BandLimited,
        }
    }
}

impl From<SchemeArg> for Scheme {
    fn from(arg: SchemeArg) -> Self {
        match arg {
            SchemeArg::Tustin => Scheme::Tustin,
            SchemeArg::GrunwaldLetnikov => Scheme::GrunwaldLetnikov,
            SchemeArg::Bdf2 => Scheme::Bdf2,
            SchemeArg::BandLimited => Scheme::BandLimited,
        }
    }
}

/// [`Choice`] as clap wants it.
#[derive(Clone, Copy)]
struct ChoiceArg<T>(Choice<T>);

fn degree(text: &str) -> Result<ChoiceArg<usize>, String> {
    if text == "auto" {
        return Ok(ChoiceArg(Choice::Auto));
    }
    let degree = text.parse().map_err(|_| "expected a whole number or auto".to_owned())?;
    Ok(ChoiceArg(Choice::Given(degree)))
}

fn exponent(text: &str) -> Result<ChoiceArg<f64>, String> {
    number_or(text, "free")
}

fn delay(text: &str) -> Result<ChoiceArg<f64>, String> {
    number_or(text, "auto")
}

fn number_or(text: &str, word: &str) -> Result<ChoiceArg<f64>, String> {
    if text == word {
        return Ok(ChoiceArg(Choice::Auto));
    }
    number(text).map(|x| ChoiceArg(Choice::Given(x))).map_err(|e| format!("{e} or {word}"))
}

fn name_value(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE, e.g. gamma=0")?;
    Ok((name.trim().to_owned(), number(value.trim())?))
}

fn name_range(text: &str) -> Result<(String, f64, f64), String> {
    const WANTED: &str = "expected NAME=LOW:HIGH, e.g. beta=0:2";
    let (name, range) = text.split_once('=').ok_or(WANTED)?;
    let (low, high) = range.split_once(':').ok_or(WANTED)?;
    Ok((name.trim().to_owned(), number(low.trim())?, number(high.trim())?))
}

impl Identify {
    pub fn run(&self) -> Result<(), Failure> {
        match (self.structure, self.axes.are_given()) {
            (Some(StructureArg::Modes), _) | (None, true) => return self.run_modes(),
            (Some(StructureArg::Hammerstein), true) => return self.run_branches(),
            (Some(StructureArg::Oscillator), true) => {
                return Err(Failure::usage(
                    "--inputs and --outputs go with --structure modes or hammerstein",
                )
                .hint("one axis: choose its columns with --input and --output"));
            }
            _ => {}
        }
        if let Some(flag) = self.modes.given() {
            return Err(Failure::usage(format!("{flag} goes with --structure modes")));
        }
        if self.structure == Some(StructureArg::Oscillator) {
            return self.run_oscillator();
        }
        self.check_outputs()?;
        let options = self.options()?;
        let campaign = self.campaign()?;
        let resume = self.resume.as_deref().map(read_searches).transpose()?;
        let stop = interrupt::stop_flag("the best so far is kept")?;
        let mut watcher = Console { stop: &stop, shown: None };
        let found = identify(&campaign, &options, &mut watcher, resume);
        drop(watcher);
        let found = found.map_err(|e| explain(&e))?;
        let file = written::model_file(&found, &campaign, &options);
        file.write(&self.out).map_err(|e| {
            Failure::new(format!("cannot write the model to {}", self.out.display())).because(e)
        })?;
        if found.cancelled {
            self.write_searches(&found.resume)?;
        }
        if self.result.has_report() || self.figures.is_some() {
            let stop = || stop.load(Ordering::Relaxed);
            let others = neighbours(&campaign, &options, &found, &stop);
            self.write_report(&report::data(&self.out, &found, &file, &others))?;
        }
        // Where the result goes elsewhere, its warnings still reach the user; those about units came with the records.
        if self.result.json || !std::io::stdout().is_terminal() {
            let warnings = found.findings.iter().filter(|f| f.kind == FindingKind::Warning);
            warnings.filter(|f| f.topic != "units").for_each(|f| console::warning(&f.text));
        }
        if self.result.json {
            return console::json(&outcome::Outcome::new(&self.out, &found, &file));
        }
        console::result(&outcome::text(&found, &file))?;
        console::message(&format!("model written to {}", self.out.display()));
        Ok(())
    }

    fn run_branches(&self) -> Result<(), Failure> {
        if let Some(flag) = self.modes.given() {
            return Err(Failure::usage(format!("{flag} goes with --structure modes")));
        }
        self.refuse_flags_but(
            "hammerstein and several axes",
            "these branches are Bouc–Wen loops with n = 1, a pair of poles and a delay each",
            &[
                ("--inter-sample", self.inter_sample.is_some()),
                ("--start", self.start.is_some()),
                ("--fix", !self.fix.is_empty()),
                ("--n", self.n.is_some()),
                ("--initial", self.initial != InitialArg::Auto),
            ],
        )?;
        output::check_file("the model", &self.out)?;
        let columns = (self.records.as_slice(), &self.axes, self.columns.of_drive());
        self.in_threads(|| identify_branches(columns, (&self.out, self.result.json), self.least_fit))?
    }

    fn run_modes(&self) -> Result<(), Failure> {
        self.refuse_flags_but(
            "modes",
            "modes have --modes, --plays, --linear, --steps, --iterations, --exponent, --initial periodic",
            &[
                ("--inter-sample", self.inter_sample.is_some()),
                ("--start", self.start.is_some()),
                ("--fix", !self.fix.is_empty()),
                ("--n", self.n.is_some()),
            ],
        )?;
        let whole_records = match self.initial {
            InitialArg::Auto => false,
            InitialArg::Periodic => true,
            _ => {
                return Err(Failure::usage("modes are identified from a steady state")
                    .hint("leave --initial out, or say --initial periodic"));
            }
        };
        output::check_file("the model", &self.out)?;
        let columns = (self.records.as_slice(), &self.axes, self.columns.of_drive());
        self.in_threads(|| {
            self.modes.run(columns, (&self.out, self.result.json), (whole_records, self.least_fit))
        })?
    }

    fn check_outputs(&self) -> Result<(), Failure> {
        output::check_file("the model", &self.out)?;
        self.result.check()?;
        if let Some(folder) = &self.figures {
            output::check_folder("the figures", folder)?;
        }
        Ok(())
    }

    fn options(&self) -> Result<Options, Failure> {
        let start = match &self.start {
            Some(path) => {
                let failure = || Failure::new(format!("cannot start from the model {}", path.display()));
                let file = ModelFile::read(path).map_err(|e| failure().because(e))?;
                Some(file.to_model().map_err(|e| failure().because(e))?)
            }
            None => None,
        };
        Ok(Options {
            method: match self.method {
                MethodArg::Joint => Method::Joint,
                MethodArg::TwoStep => Method::TwoStep,
            },
            hysteresis: self.hysteresis.form(self.elements)?,
            order: self.order,
            creep: self.creep()?,
            initial: match self.initial {
                InitialArg::Auto => Initial::Auto,
                InitialArg::Rest => Initial::Rest,
                InitialArg::Periodic => Initial::Periodic,
                InitialArg::Zero => Initial::Zero,
                InitialArg::Free => Initial::Free,
            },
            drift: self.drift,
            dynamics: match self.dynamics {
                None => DynamicsChoice::Auto,
                Some(DynamicsArg::None) => DynamicsChoice::None,
                Some(DynamicsArg::Integer) => DynamicsChoice::Integer,
                Some(DynamicsArg::Modes) => DynamicsChoice::Modes,
                Some(DynamicsArg::Arx) => DynamicsChoice::Arx,
                Some(DynamicsArg::Oe) => DynamicsChoice::OutputError,
                Some(DynamicsArg::Bj) => DynamicsChoice::BoxJenkins,
                Some(DynamicsArg::Srivc) => DynamicsChoice::Srivc,
                Some(DynamicsArg::Fractional) => DynamicsChoice::Fractional,
                Some(DynamicsArg::FractionalFreeLowest) => DynamicsChoice::FractionalFreeLowest,
                Some(DynamicsArg::TwoFractional) => DynamicsChoice::TwoFractional,
            },
            algorithm: self.algorithm(),
            generations: self.generations.unwrap_or(Options::default().generations),
            seed: self.seed,
            threads: self.threads,
            degree: self.degree.0,
            n: self.n.map_or(Choice::Given(1.0), |n| n.0),
            delay_s: self.delay.0,
            demands: Demands { fixed: self.fix.clone(), bounded: self.bound.clone() },
            start,
            scheme: self.scheme.map_or(Choice::Auto, |scheme| Choice::Given(scheme.into())),
            inter_sample: self.inter_sample.map_or(InterSample::Linear, InterSampleArg::into),
            least_fit_percent: self.least_fit,
        })
    }

    fn creep(&self) -> Result<Creep, Failure> {
        if self.creep_elements.is_some() && self.creep != Some(CreepArg::KelvinVoigt) {
            return Err(Failure::usage("--creep-elements belongs to --creep kelvin-voigt"));
        }
        Ok(match self.creep {
            None => Creep::None,
            Some(CreepArg::Fractional) => Creep::Fractional,
            Some(CreepArg::Logarithmic) => Creep::Logarithmic,
            Some(CreepArg::KelvinVoigt) => Creep::KelvinVoigt { elements: self.creep_elements.unwrap_or(2) },
        })
    }

    fn algorithm(&self) -> Option<Algorithm> {
        let population = |default: usize| self.population.unwrap_or(default);
        match self.optimizer {
            OptimizerArg::Auto => None,
            OptimizerArg::DeAbc => {
                let options = DeAbcOptions::default();
                Some(Algorithm::DeAbc(DeAbcOptions { population: population(options.population), ..options }))
            }
            OptimizerArg::Abc => {
                let options = AbcOptions::default();
                Some(Algorithm::Abc(AbcOptions { population: population(options.population), ..options }))
            }
            OptimizerArg::De => {
                let options = DeOptions::default();
                Some(Algorithm::De(DeOptions { population: population(options.population), ..options }))
            }
            OptimizerArg::Pso => {
                let options = PsoOptions::default();
                Some(Algorithm::Pso(PsoOptions { population: population(options.population), ..options }))
            }
            OptimizerArg::CmaEs => {
                let options = CmaEsOptions::default();
                Some(Algorithm::CmaEs(CmaEsOptions { population: self.population, ..options }))
            }
            OptimizerArg::LeastSquares => {
                let options = LeastSquaresOptions::default();
                Some(Algorithm::LeastSquares(LeastSquaresOptions {
                    starts: population(options.starts),
                    ..options
                }))
            }
        }
    }

    fn campaign(&self) -> Result<Vec<CampaignRecord>, Failure> {
        let given = |paths: &[PathBuf], role: Option<RecordRole>| {
            paths.iter().map(|path| (path.clone(), role)).collect::<Vec<_>>()
        };
        let (paths, roles): (Vec<PathBuf>, Vec<_>) = given(&self.records, None)
            .into_iter()
            .chain(given(&self.static_records, Some(RecordRole::QuasiStatic)))
            .chain(given(&self.dynamic_records, Some(RecordRole::Dynamic)))
            .unzip();
        let records = self.columns.read_all(&paths)?.into_iter().zip(roles);
        Ok(records.map(|(data, role)| CampaignRecord { data, role }).collect())
    }

    fn write_searches(&self, searches: &Searches) -> Result<(), Failure> {
        let path = self.out.with_extension("searches.json");
        let failure = || Failure::new(format!("cannot write the interrupted searches to {}", path.display()));
        let text = serde_json::to_string(searches).map_err(|e| failure().because(e))?;
        hysteron::atomic_file::write_atomically(&path, text.as_bytes()).map_err(|e| failure().because(e))?;
        console::note(&format!("interrupted; go on with the same command and --resume {}", path.display()));
        Ok(())
    }

    fn write_report(&self, data: &IdentificationReportData) -> Result<(), Failure> {
        let page = identification_report(data);
        self.result.write(|| &page)?;
        if let Some(folder) = &self.figures {
            let failure = || Failure::new(format!("cannot write the figures to {}", folder.display()));
            std::fs::create_dir_all(folder).map_err(|e| failure().because(e))?;
            let written = write_figures(folder, "figure", &page)
                .map_err(|e| output::cannot_write("the figures", folder, e))?;
            console::message(&format!("{} figures written to {}", written.len(), folder.display()));
        }
        Ok(())
    }
}

fn read_searches(path: &Path) -> Result<Searches, Failure> {
    let failure = || {
        Failure::new(format!("cannot resume from {}", path.display()))
            .hint("it must be the MODEL.searches.json that an interrupted identification wrote")
    };
    let size = std::fs::metadata(path).map_err(|e| failure().because(e))?.len();
    if size > MAX_RESUME_BYTES {
        return Err(failure().because(format!("it has {size} bytes; at most {MAX_RESUME_BYTES} are read")));
    }
    let bytes = std::fs::read(path).map_err(|e| failure().because(e))?;
    serde_json::from_slice(&bytes).map_err(|e| failure().because(e))
}

/// The library's error with what to do about it.
fn explain(error: &IdentifyError) -> Failure {
    const TITLE: &str = "no model was identified";
    let failure = Failure::new(TITLE).because(error);
    match error {
        IdentifyError::UnknownParameter { .. }
        | IdentifyError::Demand { .. }
        | IdentifyError::CreepTakesJointFit
        | IdentifyError::Option { .. } => Failure::usage(TITLE).because(error),
        IdentifyError::Optimize(OptimizeError::Resume(error)) => {
            let failure = Failure::new(TITLE).hint(
                "resume with the records and options of the interrupted run; or leave --resume out and begin anew",
            );
            match error {
                ResumeError::Problem { .. } => {
                    failure.because("the interrupted searches are of other records or options")
                }
                error => failure.because(error),
            }
        }
        IdentifyError::ModelClass { .. } => failure.hint(
            "look at the record with hysteron inspect; check the columns (--input, --output); --least-fit 0 hands the model \
             out all the same",
        ),
        IdentifyError::NotUniform { .. } => failure.hint("give --sample-rate HZ, or --dynamics none"),
        IdentifyError::Constant { .. } => failure.hint("choose other columns with --input and --output"),
        IdentifyError::Units { .. } => failure.hint("correct the headers, or choose columns with --input and --output"),
        _ => failure,
    }
}

/// Progress bar and Ctrl-C.
struct Console<'a> {
    stop: &'a AtomicBool,
    shown: Option<(String, Progress)>,
}

impl Watcher for Console<'_> {
    fn progress(
        &mut self,
        step: &str,
        progress: &SearchProgress<'_>,
        _: &dyn Fn() -> Searches,
    ) -> ControlFlow<()> {
        if self.shown.as_ref().is_none_or(|(name, _)| name != step) {
            self.shown = Some((step.to_owned(), Progress::new(step, progress.generations as u64)));
        }
        if let Some((_, bar)) = &self.shown {
            bar.set(progress.generation as u64, format!("best RMSE {:.5}", progress.best_cost));
        }
        if self.stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
