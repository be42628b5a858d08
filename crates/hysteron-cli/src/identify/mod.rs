//! `hysteron identify`: records in, model file and report out.

mod arguments;
mod failure;
mod modes_flags;
mod options;
mod other_kinds;
mod outcome;
mod search;
mod several_axes;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::structure::prospects;
use hysteron_identify::{
    CampaignRecord, DynamicsChoice, FamilyChoice, FindingKind, Fit, FitRecords, IdentifyError, Initial,
    Method, RecordRole, Task, fit, fit_on, usual_kind,
};
use hysteron_model::dynamics::{Creep, Scheme};
use hysteron_model::model::Capability;
use hysteron_model::model_file::Kind;
use hysteron_model::record::{InputOutput, InterSample};
use hysteron_report::fit::report;
use hysteron_report::page::Page;

use self::arguments::{
    ChoiceArg, OptimizerArg, StructureArg, degree, delay, exponent, inter_sample, name_range, name_value,
};
use self::failure::{explain, interrupted};
use self::modes_flags::ModesFlags;
use self::outcome::Outcome;
use crate::advice;
use crate::axes::AxesFlags;
use crate::choices::one_of;
use crate::columns::ColumnFlags;
use crate::console;
use crate::design::{self, DesignFrom};
use crate::failure::Failure;
use crate::interrupt::{Interrupt, partial};
use crate::kept::{self, Kept};
use crate::maker::maker;
use crate::model::Loaded;
use crate::numbers::{count, number, whole};
use crate::output::{self, OutFile};
use crate::outputs::Outputs;
use crate::progress;
use crate::remarks;
use crate::result_flags::ResultFlags;

/// Identify a model from measured records: hysteresis block, dynamic block, model file, report.
#[derive(Args)]
#[command(after_help = "Without flags the structure is chosen from the records: polynomial degree by BIC; \
    a resonance with a lag and, where the records show it, creep where a record is much faster than the \
    slowest one (fractional orders where these leave a far smaller error), else, where a record starts from rest \
    with a jump, a delay and a first-order lag. Slow and fast records are recognised; --static and \
    --dynamic override it. Where another kind of model leaves less than a quarter of the error, it is named \
    and no model is written.\n\n\
    Records are fitted jointly: both blocks, the delay, offset and initial hysteresis memory of each record, \
    from several starts, first on decimated records, then on all samples. --method two-step is the article's \
    procedure: hysteresis from the slow records, then dynamics from the others; --dynamics arx, oe, bj and \
    srivc imply it.\n\n\
    Parameters for --fix and --bound: linear, quadratic, cubic, …, alpha, beta, gamma, n (other families: \
    the names in their model files), offset, delay [s]; joint: natural_frequency [Hz], damping, \
    natural_frequency_2, damping_2, …, lag [s], order2, order1, order0, share, share_2, …, creep, \
    creep_order, creep_per_decade, creep_start [s], creep_1, creep_time_1 [s], …, memory_1, memory_2, … \
    (beta, gamma and memory of alpha = 1); two-step: lag [s], gain.\n\n\
    --inputs u1_V,u2_V --outputs y1_nm,y2_nm fits several axes at once: structural modes with the hysteresis \
    of each actuator in feedback, from records of periodic multisines with different phases, one model for \
    all amplitudes. The influence matrix is printed.\n\n\
    --structure oscillator fits a mass on a hysteretic spring, m y'' + c y' + k y + z = u, to records of \
    force and displacement around a resonance; a periodic force is assumed to be in steady state, any other \
    to start from rest (--initial). --fix can hold mass, damping and n.\n\n\
    --structure force fits the force of a damper against its displacement, and is the default where the input \
    is a displacement and the output a force (x_mm, F_N): \
    hysteresis of the displacement (--hysteresis, --elements), stiffness (--degree), a viscous force, and \
    one that saturates with the rate behind a compliance. The rate is that of the displacement, or measured \
    (--rate v_mm_per_s). --fix can hold the numbers of the hysteresis family's shape, viscous, \
    saturating_force, saturating_rate and saturating_reach.\n\n\
    Ctrl-C writes the best model so far to MODEL.partial.json, which every command reads, and leaves \
    MODEL.json unchanged (exit code 130, 143 after SIGTERM); --resume MODEL.partial.json continues the \
    fit. A fit that is killed leaves its state of at most two seconds before in MODEL.searches.json: \
    --resume MODEL.searches.json.\n\n\
    Example: hysteron identify loop_1hz.csv -o model.json --report report.html\n\
    Example: hysteron identify loop_1hz.csv sweep.csv -o model.json --optimizer de-abc --seed 7\n\
    Example: hysteron identify multisine.csv --structure oscillator -o oscillator.json\n\
    Example: hysteron identify slow.csv fast.csv -o damper.json --rate v_mm_per_s\n\
    Example: hysteron identify small*.csv large*.csv --inputs u1_V,u2_V --outputs y1_nm,y2_nm -o stage.json")]
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
    out: OutFile,

    /// Structure: hysteresis ahead of linear dynamics, in feedback, or beside terms of the rate [default:
    /// hammerstein; modes with --inputs]
    #[arg(long, value_enum)]
    structure: Option<StructureArg>,

    /// Hysteresis block [default: bouc-wen; dahl with exponent 1 for a force; activated-plays for a record
    /// with non-uniform time stamps that has small oscillations beside wide moves]
    #[arg(
        long, value_name = "HYSTERESIS",
        value_parser = one_of(FamilyChoice::offered(), FamilyChoice::name, FamilyChoice::summary),
    )]
    hysteresis: Option<FamilyChoice>,

    /// Size of the hysteresis block: number of plays or of the corners of their density, slip elements,
    /// states, grid lines or intervals of a plane, or the polynomial degree [default: usual for the family]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    elements: Option<usize>,

    /// Dynamic block [default: the one that the records support]
    #[arg(long, value_parser = one_of(DynamicsChoice::ALL, DynamicsChoice::name, DynamicsChoice::summary))]
    dynamics: Option<DynamicsChoice>,

    /// Identification method
    #[arg(long, value_parser = one_of(Method::ALL, Method::name, Method::summary), default_value = "joint")]
    method: Method,

    /// Poles of --dynamics integer, 1 to 12, or modes, 2 to 12 (joint)
    #[arg(long, value_name = "N", default_value_t = 2)]
    order: usize,

    /// Creep factor of the dynamics (joint) [default: fractional where the records show creep; none with
    /// --dynamics]
    #[arg(long, value_name = "KIND", value_parser = one_of(Creep::USUAL, Creep::name, Creep::summary))]
    creep: Option<Creep>,

    /// Elements of --creep kelvin-voigt, 1 to 4 [default: 2]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    creep_elements: Option<usize>,

    /// Initial state of each record (joint)
    #[arg(long, value_parser = one_of(Initial::ALL, Initial::name, Initial::summary), default_value = "auto")]
    initial: Initial,

    /// The records are consecutive parts of one run on one clock: hysteresis memory, creep and offset carry
    /// over; the drive is interpolated linearly through the pauses. A record that overlaps the one before it
    /// starts another run
    #[arg(long)]
    continued: bool,

    /// Estimate a linear drift of each record's output (joint)
    #[arg(long)]
    drift: bool,

    /// Optimiser; auto: least squares from data-driven starts with the linear parameters eliminated
    #[arg(long, value_enum, default_value_t = OptimizerArg::Auto)]
    optimizer: OptimizerArg,

    /// Generations of a population method [default: 150]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    generations: Option<usize>,

    /// Population: food sources of de-abc and abc [default: 25], members of de and particles of pso [default:
    /// 50], starts of least-squares [default: 20]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    population: Option<usize>,

    /// Seed of the random numbers
    #[arg(
        long, value_name = "N", default_value_t = 1, value_parser = whole::<u64>, allow_hyphen_values = true,
    )]
    seed: u64,

    /// Threads; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true)]
    threads: Option<usize>,

    /// Resume the searches of an interrupted identification
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,

    /// Degree of the polynomial l(u)
    #[arg(
        long, value_name = "N|auto", default_value = "auto", value_parser = degree,
        allow_hyphen_values = true,
    )]
    degree: ChoiceArg<usize>,

    /// Exponent n of a hysteresis family that has one [default: 1; free for an oscillator]
    #[arg(long, value_name = "VALUE|free", value_parser = exponent, allow_hyphen_values = true)]
    n: Option<ChoiceArg<f64>>,

    /// Delay between input and output in seconds; a given delay is taken as the total time shift of a
    /// quasi-static record
    #[arg(
        long, value_name = "SECONDS|auto", default_value = "auto", value_parser = delay,
        allow_hyphen_values = true,
    )]
    delay: ChoiceArg<f64>,

    /// Hold a parameter at a value (repeatable)
    #[arg(long, value_name = "NAME=VALUE", value_parser = name_value, allow_hyphen_values = true)]
    fix: Vec<(String, f64)>,

    /// Keep a parameter within a range (repeatable)
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = name_range, allow_hyphen_values = true)]
    bound: Vec<(String, f64, f64)>,

    /// Model whose parameters are the first starting point of every search
    #[arg(long, value_name = "MODEL.json")]
    start: Option<PathBuf>,

    /// Simulation scheme of the dynamic block [default: band-limited for a joint fit of records that start
    /// smoothly, else tustin]
    #[arg(long, value_parser = one_of(Scheme::ALL, Scheme::name, Scheme::summary))]
    scheme: Option<Scheme>,

    /// Inter-sample rule of the drive: auto; hold, for a zero-order hold that shares the recorder's clock;
    /// linear; band-limited [default: auto, recognised from the records, else linear; band-limited for an
    /// oscillator]
    #[arg(long, value_name = "RULE", value_parser = inter_sample())]
    inter_sample: Option<ChoiceArg<InterSample>>,

    /// Minimum fit of each record, in %; no model is returned below it
    #[arg(
        long, value_name = "PERCENT", default_value_t = 75.0, value_parser = number,
        allow_hyphen_values = true,
    )]
    least_fit: f64,

    /// Column of the rate of the input, for a model of the kind force: its name, with or without unit, e.g.
    /// v_mm_per_s [default: the rate is that of the displacement]
    #[arg(long, value_name = "COL")]
    rate: Option<String>,

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

impl Identify {
    pub fn run(&self) -> Result<(), Failure> {
        self.check_outputs()?;
        let (task, records) = self.task_and_records()?;
        let resume = self.resume.as_deref().map(kept::read).transpose()?;
        let stop = Interrupt::listen("the best so far is kept")?;
        let kept = Kept::beside(Some(&self.out));
        let watch = kept.watch_searches(&stop);
        let found = fit_on(self.threads, || fit(&records, &task, &watch, resume, &maker()));
        drop(watch);
        let found = found.map_err(|e| match (&e, kept.file()) {
            (IdentifyError::Stopped, Some(file)) => stop.told(interrupted(file)),
            _ => {
                kept.forget();
                stop.told(self.naming_axes_of(&e, explain(&e, task.kind())))
            }
        })?;
        let written = if found.interrupted { partial(&self.out) } else { self.out.to_path_buf() };
        let page = || self.page(&records, &task, &found, &stop);
        self.write(&written, &found, page).map_err(|e| kept.told(e))?;
        for score in &found.scores {
            remarks::tell(Path::new(&score.record), &found.model, &score.simulation.remarks);
        }
        // Warnings are repeated on standard error if the result is redirected; those about units were printed
        // when the records were read.
        if self.result.json || !std::io::stdout().is_terminal() {
            let warnings = found.findings.iter().filter(|f| f.kind == FindingKind::Warning);
            warnings.filter(|f| f.topic != "units").for_each(|f| console::warning(&advice::text(f)));
        }
        if self.result.json {
            console::json(&Outcome { model: written.display().to_string(), fit: &found })?;
        } else {
            console::result(&(outcome::text(&found) + &self.measure_next(&records, &found)))?;
            console::message(&format!("model written to {}", written.display()));
        }
        if found.interrupted {
            let resume = format!("go on with the same command and --resume {}", written.display());
            return Err(stop.failure(&written, &resume));
        }
        kept.forget();
        Ok(())
    }

    /// Kind of model that the flags or else the records select, with its options and its starting model; and
    /// the records.
    fn task_and_records(&self) -> Result<(Task, FitRecords), Failure> {
        let task = self.kind_of_task()?;
        let records = self.fit_records(&task)?;
        let task = match &records {
            FitRecords::Single(records)
                if self.structure.is_none() && usual_kind(records.iter().map(|r| &r.data)) == Kind::Force =>
            {
                console::note(
                    "force over displacement: a model of the kind force is identified (--structure \
                     hammerstein for hysteresis followed by linear dynamics)",
                );
                self.force()?
            }
            _ if self.rate.is_some() && task.kind() != Kind::Force => {
                return Err(Failure::usage("--rate goes with --structure force"));
            }
            _ => task,
        };
        let Some(path) = &self.start else { return Ok((task, records)) };
        let started = task.starting_from(Loaded::read(path)?.model());
        let failed = || Failure::new(format!("cannot start from the model {}", path.display()));
        started.map(|task| (task, records)).map_err(|e| failed().because(e))
    }

    fn kind_of_task(&self) -> Result<Task, Failure> {
        match (self.structure, self.axes.are_given()) {
            (Some(StructureArg::Modes), _) | (None, true) => return self.modes(),
            (Some(StructureArg::Hammerstein), true) => return self.branches(),
            (Some(StructureArg::Oscillator | StructureArg::Force), true) => {
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
            return self.oscillator();
        }
        if self.structure == Some(StructureArg::Force) {
            return self.force();
        }
        Ok(Task::Hammerstein(Box::new(self.options()?)))
    }

    fn fit_records(&self, task: &Task) -> Result<FitRecords, Failure> {
        if !task.takes_several_axes() {
            return self.campaign().map(FitRecords::Single).map_err(|failure| {
                if self.columns.of_drive().input().is_none() { self.naming_axes(failure) } else { failure }
            });
        }
        if self.axes.outputs.is_empty() {
            return Err(Failure::usage("several axes need their outputs")
                .hint("name them in order, e.g. --outputs y1_nm,y2_nm,y3_nm"));
        }
        self.axes.read_all(&self.records, self.columns.of_drive()).map(FitRecords::Several)
    }

    /// The report; for a Hammerstein model with its neighbouring structures, unless the fit was interrupted.
    fn page(
        &self,
        records: &FitRecords,
        task: &Task,
        found: &Fit,
        stop: &Interrupt,
    ) -> Result<Page, Failure> {
        let name = self.out.file_stem().map(|s| s.to_string_lossy()).unwrap_or_default();
        let others =
            if found.interrupted { None } else { found.neighbours(records, task, &progress::watch(stop)) };
        report(&name, found, others.as_ref()).map_err(|e| Failure::new("cannot make the report").because(e))
    }

    /// What to measure next and the command that makes the drive: from the model, or from the records where
    /// these leave a parameter undetermined, which a model file does not say. Empty for a kind without it.
    fn measure_next(&self, records: &FitRecords, found: &Fit) -> String {
        let FitRecords::Single(campaign) = records else { return String::new() };
        let Ok(model) = found.model.hammerstein(Capability::Design) else { return String::new() };
        if found.interrupted {
            return String::new();
        }
        let records: Vec<InputOutput> = campaign.iter().map(|record| record.data.clone()).collect();
        let prospects = prospects(&records);
        let open = model.data().correlation.is_none()
            || found.parameters.iter().any(|p| !p.held && p.std_error.is_none());
        let all = self.records.iter().chain(&self.static_records).chain(&self.dynamic_records);
        let all: Vec<PathBuf> = all.cloned().collect();
        let from = if open { DesignFrom::Records(&all, &self.columns) } else { DesignFrom::Model(&self.out) };
        design::measure_next(&prospects, &design::command(from, &records, prospects.next_for))
    }

    fn check_outputs(&self) -> Result<(), Failure> {
        output::check_file("the model", &self.out)?;
        self.result.check()?;
        if let Some(folder) = &self.figures {
            output::check_folder("the figures", folder)?;
        }
        Ok(())
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
        let records = self.columns.read_all(&paths)?.into_iter().zip(&paths).zip(roles);
        let record = |((data, path), role): ((_, &PathBuf), _)| {
            let data = match &self.rate {
                Some(column) => self.columns.of_drive().with_rate(path, data, column)?,
                None => data,
            };
            Ok(CampaignRecord { data, role })
        };
        records.map(record).collect()
    }

    /// Writes model, report and figures, or the interrupted searches: all of them or none.
    fn write(
        &self,
        model: &Path,
        found: &Fit,
        page: impl FnOnce() -> Result<Page, Failure>,
    ) -> Result<(), Failure> {
        let mut outputs = Outputs::default();
        outputs.add_model(model, &found.model)?;
        if found.interrupted {
            self.add_searches(&mut outputs, &found.resume)?;
        }
        if self.result.has_report() || self.figures.is_some() {
            let page = page()?;
            self.result.add(&mut outputs, || &page)?;
            if let Some(folder) = &self.figures {
                outputs.add_figures(folder, "figure", &page)?;
            }
        }
        outputs.finish()
    }
}
