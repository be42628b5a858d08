//! A campaign made with a known structure.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Duration;

use super::*;
use crate::FamilyChoice;
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme, TransferFunction};
use hysteron_model::hysteresis::{ArticleOperator, Hysteresis, HysteresisForm};
use hysteron_model::record::{InputOutput, InterSample, TimeBase};
use hysteron_optimize::{Problem, Range};

const RATE_HZ: f64 = 1000.0;
const NOISE: f64 = 0.004;

/// Two poles at 60 Hz behind a hysteresis with a cubic.
fn truth() -> Model {
    let omega = TAU * 60.0;
    let term = |coefficient, order| hysteron_model::dynamics::Term { coefficient, order };
    let g = TransferFunction {
        numerator: vec![term(omega * omega, 0.0)],
        denominator: vec![term(omega * omega, 0.0), term(0.3 * omega, 1.0), term(1.0, 2.0)],
    };
    Model {
        hysteresis: Hysteresis::from(ArticleOperator::new(vec![3.0, -0.08], 0.9, 0.9, 0.3, 1.0).unwrap()),
        dynamics: Dynamics::Integer(g),
        offset: 0.0,
        delay_s: 3e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    }
}

fn measured(name: &str, seconds: f64, drive: impl Fn(f64) -> f64) -> CampaignRecord {
    measured_of(&truth(), name, seconds, drive)
}

fn measured_of(device: &Model, name: &str, seconds: f64, drive: impl Fn(f64) -> f64) -> CampaignRecord {
    let u: Vec<f64> = (0..(seconds * RATE_HZ) as usize).map(|k| drive(k as f64 / RATE_HZ)).collect();
    let mut y = device.simulate(&u, Some(RATE_HZ), &Start::Rest { voltage_v: 0.0 }).unwrap();
    // Reproducible noise, uniform: a linear congruential generator (Knuth's MMIX constants).
    let mut state = 1 + name.len() as u64;
    for y in &mut y {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *y += NOISE * 12f64.sqrt() * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
    }
    CampaignRecord { data: InputOutput::new(name, TimeBase::uniform(RATE_HZ), u, y).unwrap(), role: None }
}

fn sine(name: &str, amplitude: f64, f: f64, seconds: f64) -> CampaignRecord {
    measured(name, seconds, move |t| amplitude * (1.0 - (TAU * f * t).cos()))
}

fn campaign() -> Vec<CampaignRecord> {
    vec![
        sine("slow", 2.5, 1.0, 3.0),
        sine("half", 1.2, 2.0, 2.0),
        sine("quick", 2.0, 20.0, 1.0),
        sine("quicker", 1.5, 45.0, 1.0),
    ]
}

fn candidates(names: &[&str]) -> Vec<Candidate> {
    names.iter().map(|n| n.parse().unwrap()).collect()
}

#[test]
fn the_structure_that_made_the_records_is_preferred() {
    let list = candidates(&["none", "integer1", "integer2", "integer2+degree2", "fractional"]);
    let mut told = Vec::new();
    let watch = Watch::new(|event: &Event<'_>| {
        told.push(event.fraction);
        ControlFlow::Continue(())
    });
    let found = compare(&campaign(), Selection::Given(&list), &Options::default(), &watch).unwrap();
    drop(watch);
    let labels: Vec<&str> = found.folds.iter().map(|f| f.label.as_str()).collect();
    assert_eq!(labels, ["slow", "half", "quick", "quicker"]);
    let ranking = found.ranking.unwrap();
    // Same dynamics with a needless cubic, and with needless orders, are as good but richer.
    assert_eq!(found.entries[ranking.preferred].candidate.to_string(), "integer2+degree2", "{ranking:?}");
    let standing = |i: usize| ranking.standings[i].unwrap();
    assert!(standing(0).mean > 10.0 * standing(3).mean && !standing(0).as_good_as_best);
    assert!(standing(1).mean > 5.0 * standing(3).mean && !standing(1).as_good_as_best);
    // Held-out records are predicted to their noise, as errors and noise floor show.
    assert!((standing(3).mean / NOISE - 1.0).abs() < 0.15, "{}", standing(3).mean);
    assert!((found.noise_floor / NOISE - 1.0).abs() < 0.15, "{}", found.noise_floor);
    assert!((found.entries[3].training_rmse.unwrap() / NOISE - 1.0).abs() < 0.05);
    // u, u², α, β, γ, delay, natural frequency, damping.
    assert_eq!(found.entries[3].parameters, 8);
    assert_eq!(found.entries.iter().map(|e| e.parameters).collect::<Vec<_>>(), [7, 8, 9, 8, 11]);
    // White residuals: nearly every sample is independent, and BIC rejects the needless parameters.
    assert!(found.independent_samples > 0.5 * found.samples as f64, "{}", found.independent_samples);
    let bic = |i: usize| found.entries[i].bic.unwrap();
    assert!((0..5).all(|i| i == 3 || bic(i) > bic(3)), "{:?}", (0..5).map(bic).collect::<Vec<_>>());
    told.retain(|fraction| *fraction > 0.0);
    // Of each candidate five fits, and that it is finished.
    assert_eq!((told.len(), told.last()), (30, Some(&1.0)));
    assert!(!found.interrupted);
}

#[test]
fn what_is_finished_is_kept_when_stopped() {
    let list = candidates(&["none", "integer1", "integer2"]);
    let mut told = 0;
    let seven = Watch::new(|event: &Event<'_>| {
        told += usize::from(event.fraction > 0.0);
        if told >= 7 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let found = compare(&campaign(), Selection::Given(&list), &Options::default(), &seven).unwrap();
    assert!(found.interrupted);
    // The second candidate was running: another thread may finish its last fit before it sees the stop.
    let kept = found.entries.len();
    assert!((1..list.len()).contains(&kept), "{kept} candidates");
    assert_eq!(found.ranking.unwrap().order.len(), kept);
}

/// A clock that has run out once the first candidate was told of six times: its fit, four folds, its end.
#[test]
fn what_is_finished_in_time_is_compared() {
    let list = candidates(&["none", "integer1", "integer2"]);
    let told = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&told);
    let watch = Watch::new(move |event: &Event<'_>| {
        count.fetch_add(usize::from(event.fraction > 0.0), Ordering::Relaxed);
        ControlFlow::Continue(())
    });
    let clock = move || Duration::from_secs(if told.load(Ordering::Relaxed) >= 6 { 2 } else { 0 });
    let limited = watch.within(Duration::from_secs(1), clock);
    let found = compare(&campaign(), Selection::Given(&list), &Options::default(), &limited).unwrap();
    assert!(found.out_of_time && !found.interrupted && !watch.is_stopped());
    let kept = found.entries.len();
    assert!((1..list.len()).contains(&kept), "{kept} candidates");
    assert_eq!(found.ranking.unwrap().order.len(), kept);
}

#[test]
fn a_quick_search_is_one_of_the_commonest_structures() {
    let common = |part| {
        let all = Candidate::of(Block::NONE).common_alternatives(part).into_iter();
        all.map(|candidate| candidate.to_string()).collect::<Vec<_>>()
    };
    assert_eq!(common(StructurePart::Block), ["none", "integer2", "fractional"]);
    assert_eq!(common(StructurePart::Creep), ["none", "none+creep"]);
    assert_eq!(common(StructurePart::Shape), ["none+degree1", "none+degree2", "none"]);
    let found = compare(&campaign(), Selection::QuickSearch, &Options::default(), &Watch::silent()).unwrap();
    let preferred = found.entries[found.ranking.unwrap().preferred].candidate;
    assert_eq!(preferred.block, Block::integer(2), "{preferred}");
    assert!(found.entries.len() <= 12 && !found.out_of_time, "{} candidates", found.entries.len());
    let names = |is_hopeless: bool| {
        let entries = found.entries.iter().filter(move |entry| entry.is_hopeless == is_hopeless);
        entries.map(|entry| entry.candidate.to_string()).collect::<Vec<_>>()
    };
    assert!(names(true).contains(&"none+creep".to_owned()), "{:?}", names(true));
    assert!(found.entries.iter().all(|entry| entry.complete().is_none() == entry.is_hopeless));
}

#[test]
fn folds_of_given_candidates_are_never_omitted() {
    let list = candidates(&["integer2", "none"]);
    let found = compare(&campaign(), Selection::Given(&list), &Options::default(), &Watch::silent()).unwrap();
    let errors: Vec<f64> = found.entries.iter().map(|entry| entry.training_rmse.unwrap()).collect();
    assert!(errors[1] > 3.0 * errors[0] && found.entries.iter().all(|entry| entry.complete().is_some()));
}

#[test]
fn what_a_record_does_not_determine_is_moved_before_its_fit() {
    let campaign = campaign();
    let options = Options::default();
    let facts = usable(&campaign).unwrap();
    let watch = Watch::silent();
    let mut engine = Engine::new(None, Settings::default(), &watch, Plan(&[]), None);
    let members: Vec<JointMember<'_>> =
        facts.iter().map(|f| JointMember::new(f, &options, &mut engine).unwrap()).collect();
    let stop = watch.stop();
    let whole = Campaign { facts: &facts, members: &members, options: &options, stop };
    let candidate: Candidate = "integer2".parse().unwrap();
    let named = whole.fit(candidate, &[]).unwrap().named;
    let moved = |records: usize| {
        let own =
            Campaign { facts: &facts[..records], members: &members[..records], options: &options, stop };
        let problem = own.problem(candidate).unwrap();
        let ranges = &problem.bounds().ranges;
        let at = |range: &Range| named.iter().find(|(name, _)| *name == range.name).unwrap().1;
        let x: Vec<f64> = ranges.iter().map(at).collect();
        let apart = loose::without_what_is_loose(&problem, &x);
        let by = |(range, (x, apart)): (&Range, (&f64, &f64))| {
            (range.name.clone(), (range.to_unit(*apart) - range.to_unit(*x)).abs())
        };
        ranges.iter().zip(x.iter().zip(&apart)).map(by).collect::<BTreeMap<_, _>>()
    };
    // The loop of 1 Hz determines the hysteresis, not a resonance at 60 Hz.
    let by_loop = moved(1);
    assert!(by_loop["natural_frequency"] + by_loop["damping"] > 0.02, "{by_loop:?}");
    assert!(by_loop["beta"] < 1e-3, "{by_loop:?}");
    let by_all = moved(4);
    assert!(by_all.values().all(|by| *by < 1e-9), "{by_all:?}");
}

#[test]
fn the_result_does_not_depend_on_the_threads() {
    let list = candidates(&["none", "integer2"]);
    let errors = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool
            .install(|| compare(&campaign(), Selection::Given(&list), &Options::default(), &Watch::silent()));
        found.unwrap().entries.into_iter().flat_map(|e| e.fold_rmse).collect::<Vec<_>>()
    };
    assert_eq!(errors(1), errors(3));
}

#[test]
fn an_arx_candidate_is_compared_beside_the_others() {
    let list = candidates(&["none", "arx"]);
    let found = compare(&campaign(), Selection::Given(&list), &Options::default(), &Watch::silent()).unwrap();
    let arx = &found.entries[1];
    assert_eq!(arx.failures, Vec::<String>::new());
    assert!(arx.parameters > 7 && arx.training_rmse.unwrap() < found.entries[0].training_rmse.unwrap());
}

#[test]
fn a_stopped_joint_fit_is_resumed_to_the_same_bits_wherever_it_was_stopped() {
    let options = Options { dynamics: DynamicsChoice::Integer, ..Options::default() };
    let campaign = campaign();
    let mut events = 0;
    let count = Watch::new(|event: &Event<'_>| {
        events += 1;
        assert!(event.stage != "joint fit" || event.model().is_some(), "the model is shown as it grows");
        ControlFlow::Continue(())
    });
    let straight = crate::identify(&campaign, &options, &count, None).unwrap();
    drop(count);
    for share in [0.2, 0.5, 0.8] {
        let mut left = (share * events as f64) as usize;
        let watch = Watch::new(|_: &Event<'_>| {
            left = left.saturating_sub(1);
            if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let stopped = crate::identify(&campaign, &options, &watch, None).unwrap();
        drop(watch);
        assert!(stopped.cancelled);
        let resumed = crate::identify(&campaign, &options, &Watch::silent(), Some(stopped.resume)).unwrap();
        assert!(!resumed.cancelled);
        assert_eq!(resumed.model, straight.model, "stopped after {share} of the events");
        assert_eq!(resumed.parameters, straight.parameters);
    }
}

#[test]
fn the_neighbours_of_what_was_identified_are_told_apart() {
    let options =
        Options { dynamics: DynamicsChoice::Integer, degree: crate::Choice::Given(2), ..Options::default() };
    let campaign = campaign();
    let found = crate::identify(&campaign, &options, &Watch::silent(), None).unwrap();
    let list = neighbours(&campaign, &options, &found, &Watch::silent()).unwrap();
    let names: Vec<String> = list.entries.iter().map(|e| e.candidate.to_string()).collect();
    assert_eq!(names[0], "integer2+degree2");
    let entry = |name: &str| &list.entries[names.iter().position(|n| n == name).unwrap()];
    let own = entry("integer2+degree2");
    assert!((own.rmse / NOISE - 1.0).abs() < 0.05 && own.parameters == 8, "{own:?}");
    // A missing term increases the error, a needless one only BIC.
    assert!(entry("none+degree2").rmse > 10.0 * own.rmse && entry("integer2+degree1").rmse > 2.0 * own.rmse);
    for name in ["integer2", "integer2+creep+degree2", "fractional+degree2", "integer2+degree2+n-free"] {
        let richer = entry(name);
        assert!(richer.rmse < 1.001 * own.rmse && richer.bic > own.bic, "{richer:?} {own:?}");
    }
    let once = [campaign[0].clone()];
    assert!(matches!(
        neighbours(&once, &options, &found, &Watch::silent()),
        Err(IdentifyError::CannotRank { .. })
    ));
}

#[test]
fn the_neighbour_of_a_density_of_plays_is_that_density() {
    let hysteresis = HysteresisForm::plays(12);
    let options = Options {
        hysteresis: FamilyChoice::Given(hysteresis),
        dynamics: DynamicsChoice::None,
        degree: crate::Choice::Given(1),
        ..Options::default()
    };
    let campaign = &campaign()[..2];
    let found = crate::identify(campaign, &options, &Watch::silent(), None).unwrap();
    assert!(found.model.hysteresis.weights().len() > 12);
    let own = neighbours(campaign, &options, &found, &Watch::silent()).unwrap().entries.swap_remove(0);
    assert_eq!((own.candidate.hysteresis, own.parameters), (hysteresis, 1 + 12 + 1));
}

#[test]
fn parts_of_a_sweep_are_predicted_from_the_others() {
    let records = [measured("sweep", 4.0, |t| 2.0 * (1.0 - (TAU * (t + 6.0 * t * t)).cos()))];
    let list = candidates(&["none+degree2", "integer2+degree2"]);
    let found = compare(&records, Selection::Given(&list), &Options::default(), &Watch::silent()).unwrap();
    assert_eq!(found.folds.len(), 4);
    let ranking = found.ranking.unwrap();
    assert_eq!(ranking.preferred, 1);
    assert!(ranking.standings[1].unwrap().mean < 1.3 * NOISE, "{ranking:?}");
    assert!(found.notes.iter().any(|n| n.contains("Parts of records")), "{:?}", found.notes);
}

/// Loops of three amplitudes, without dynamics.
fn slow_loops(hysteresis: Hysteresis) -> Vec<CampaignRecord> {
    let device = Model { hysteresis, dynamics: Dynamics::None, delay_s: 0.0, ..truth() };
    let of = |name, amplitude: f64, f: f64| {
        measured_of(&device, name, 2.0 / f, move |t| amplitude * (1.0 - (TAU * f * t).cos()))
    };
    vec![of("wide", 2.5, 1.0), of("middle", 1.7, 1.5), of("narrow", 0.9, 2.0)]
}

#[test]
fn the_family_that_made_the_records_is_chosen() {
    let plays = HysteresisForm::plays(4);
    let weights = vec![0.5, 0.3, 0.2, 0.2];
    let plays = Hysteresis::new(vec![3.0], plays, vec![0.4, 0.9, 1.4, 2.1], weights).unwrap();
    for device in [truth().hysteresis, plays] {
        let family = device.form().name();
        let asked =
            Options { hysteresis: FamilyChoice::Auto, dynamics: DynamicsChoice::None, ..Options::default() };
        let records = slow_loops(device);
        let found = crate::identify(&records, &asked, &Watch::silent(), None).unwrap();
        let selection = found.structure.family.clone().unwrap();
        assert_eq!(selection.chosen.name(), family, "{}", selection.verdict);
        assert_eq!(found.model.hysteresis.form().name(), family);
        assert_eq!(found.findings[0].text, selection.verdict);
        assert!(selection.verdict.contains(family) && selection.verdict.contains("3 folds"));
        let error =
            |name: &str| selection.errors.iter().find(|(form, _)| form.name() == name).unwrap().1.unwrap();
        let others = selection.errors.iter().filter(|(form, _)| form.name() != family);
        assert!(others.clone().count() == 2 && others.clone().all(|(_, e)| e.unwrap() > error(family)));
        let list = neighbours(&records, &asked, &found, &Watch::silent()).unwrap();
        assert_eq!(list.entries[0].candidate.hysteresis.name(), family);
    }
}

#[test]
fn where_families_cannot_be_compared_the_usual_one_is_kept_with_the_reason() {
    let records = slow_loops(truth().hysteresis);
    let auto = Options { hysteresis: FamilyChoice::Auto, ..Options::default() };
    let mut held = auto.clone();
    held.demands.fixed.push(("alpha".to_owned(), 0.9));
    let free = Options { n: crate::Choice::Auto, ..auto.clone() };
    let two_steps = Options { method: crate::Method::TwoStep, ..auto.clone() };
    for (records, options, why) in [
        (&records[..1], &auto, "one amplitude and one frequency"),
        (&records, &held, "its own numbers"),
        (&records, &free, "its exponent"),
        (&records, &two_steps, "two steps"),
    ] {
        let selection = choose_family(records, options, &Watch::silent(), None).unwrap();
        assert_eq!((selection.chosen, selection.errors.len()), (HysteresisForm::default(), 0));
        assert!(selection.verdict.contains(why), "{}", selection.verdict);
    }
}

#[test]
fn a_choice_of_family_that_is_stopped_says_so() {
    let watch = Watch::silent();
    watch.stop().request();
    let auto = Options { hysteresis: FamilyChoice::Auto, ..Options::default() };
    let stopped = choose_family(&slow_loops(truth().hysteresis), &auto, &watch, None);
    assert!(matches!(stopped, Err(IdentifyError::Stopped)), "{stopped:?}");
}

/// The state of a comparison, through its file, when `candidates` have finished, which stops it.
fn interrupted_after(candidates: usize, compare: impl FnOnce(&Watch<'_>)) -> Searches {
    let mut kept = None;
    let mut finished = 0;
    let watch = Watch::new(|event: &Event<'_>| {
        if event.candidates().is_some() && finished < candidates {
            finished += 1;
            kept = event.searches();
        }
        if finished < candidates { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    compare(&watch);
    drop(watch);
    serde_json::from_str(&serde_json::to_string(&kept.unwrap()).unwrap()).unwrap()
}

#[test]
fn a_resumed_comparison_fits_the_others_and_ends_with_the_same_bits() {
    let list = candidates(&["none", "integer1", "integer2", "integer1+degree1", "integer2+degree1"]);
    let (records, options) = (campaign(), Options::default());
    let selection = Selection::Given(&list);
    let whole = compare(&records, selection, &options, &Watch::silent()).unwrap();
    let state = interrupted_after(2, |watch| {
        let found = compare(&records, selection, &options, watch).unwrap();
        // Those fitted at the same time as the second are finished too.
        assert!(found.interrupted && found.entries.len() == 4);
    });
    assert_eq!(state.comparison.as_ref().unwrap().finished(), 2);
    let mut fits = Vec::new();
    let watch = Watch::new(|event: &Event<'_>| {
        fits.push(event.stage.split(',').next().unwrap_or_default().to_owned());
        ControlFlow::Continue(())
    });
    let resumed = compare_from(&records, selection, &options, &watch, Some(state.clone())).unwrap();
    drop(watch);
    assert_eq!(format!("{resumed:?}"), format!("{whole:?}"));
    // One report that it is taken and one that it is finished; five fits and the end of the others.
    let of = |name: &str| fits.iter().filter(|fit| *fit == name).count();
    assert_eq!(list.iter().map(|c| of(&c.to_string())).collect::<Vec<_>>(), [2, 2, 6, 6, 6]);
    let others = Selection::Given(&list[..3]);
    let refused = compare_from(&records, others, &options, &Watch::silent(), Some(state));
    assert!(matches!(refused, Err(IdentifyError::Resume)));
}

#[test]
fn a_resumed_search_takes_the_same_way() {
    let (records, options) = (campaign(), Options::default());
    let run = |watch: &Watch<'_>, resume| {
        compare_from(&records, Selection::QuickSearch, &options, watch, resume).unwrap()
    };
    let whole = run(&Watch::silent(), None);
    // All but the last: the ways of the search are decided by what was finished at each turn.
    let state = interrupted_after(whole.entries.len() - 1, |watch| drop(run(watch, None)));
    assert_eq!(format!("{:?}", run(&Watch::silent(), Some(state))), format!("{whole:?}"));
}

#[test]
fn a_resumed_choice_of_the_family_goes_on_from_the_families_that_are_fitted() {
    let records = slow_loops(truth().hysteresis);
    let auto = Options { hysteresis: FamilyChoice::Auto, ..Options::default() };
    let whole = crate::identify(&records, &auto, &Watch::silent(), None).unwrap();
    let state = interrupted_after(3, |watch| {
        let stopped = crate::identify(&records, &auto, watch, None);
        assert!(matches!(stopped, Err(IdentifyError::Stopped)));
    });
    let mut news = 0;
    let mut kept = Vec::new();
    let watch = Watch::new(|event: &Event<'_>| {
        news += usize::from(event.candidates().is_some());
        kept.extend(event.searches().and_then(|searches| searches.comparison).map(|c| c.finished()));
        ControlFlow::Continue(())
    });
    let resumed = crate::identify(&records, &auto, &watch, Some(state)).unwrap();
    drop(watch);
    assert_eq!(format!("{:?}", resumed.model), format!("{:?}", whole.model));
    assert_eq!(resumed.structure, whole.structure);
    // The state of the fit that follows holds the families too, and so does the result.
    assert_eq!(kept.last(), Some(&news));
    assert_eq!(resumed.resume.comparison.map(|c| c.finished()), Some(news));
}
