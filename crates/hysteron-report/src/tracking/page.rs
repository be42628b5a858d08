//! Result as a page.

use hysteron_model::model_file::Maker;
use hysteron_model::tracking::{Controller, ControllerFamily, ControllerRun, Tracking};

use super::tables::{adaptations, bandwidths, errors, margins, reaches};
use super::words::{OF_ADAPTATIONS, introduction, of_bandwidths, of_runaways};
use crate::figure::{Axis, Colour, Dash, Figure, Marker, Panel, Series, Style};
use crate::number::significant;
use crate::page::{Block, Page, Section};

/// Curves of a figure at most.
const CURVES: usize = 6;

/// Page of a tracking result; `maker`: who made it, and by which command.
pub fn page(found: &Tracking, maker: &Maker) -> Page {
    let mut result =
        Section::new("Tracking error of each controller").block(Block::paragraph(introduction(found)));
    if let Some(sheet) = errors(found) {
        result = result.block(sheet.for_page());
    }
    if let Some(words) = of_runaways(found) {
        result = result.block(Block::paragraph(words));
    }
    let bare = uncompensated(found).map_or(f64::INFINITY, |run| run.score.rms);
    let title = match best(found).filter(|run| run.score.rms < bare) {
        Some(run) => format!(
            "Following {}: {} leaves the least error of {} controllers (simulated)",
            found.name,
            run.controller.words(),
            found.runs.len()
        ),
        None => format!("Following {} (simulated)", found.name),
    };
    let mut page = Page::new(title).section(result.block(motion(found)).block(left_over(found)));
    if let Some(sheet) = bandwidths(found) {
        let words = Block::paragraph(of_bandwidths(found));
        page = page.section(
            Section::new("Bandwidth").block(words).block(sheet.for_page()).block(over_frequency(found)),
        );
    }
    if let Some(sheet) = margins(found) {
        let words = Block::paragraph("Margins of the feedback on the identified model:");
        page = page.section(Section::new("Feedback").block(words).block(sheet.for_page()));
    }
    if let Some(sheet) = adaptations(found) {
        let words = Block::paragraph(OF_ADAPTATIONS);
        page = page.section(Section::new("Adaptive weights").block(words).block(sheet.for_page()));
    }
    if let Some(sheet) = reaches(found) {
        let section = Section::new("Bandwidth limit of the amplifier");
        page = page.section(section.block(sheet.for_page()).block(reach(found)));
    }
    if let Some(command) = &maker.command {
        page = page.section(Section::new("Provenance").block(Block::code(command)));
    }
    page.footer_line(&maker.program)
}

/// Error of the sines over frequency: a panel for each family of controllers, the uncompensated stage in
/// each.
fn over_frequency(found: &Tracking) -> Figure {
    let curve = |run: &ControllerRun| -> (Vec<f64>, Vec<f64>) {
        let answers = run.followed.iter().flat_map(|followed| &followed.answers);
        answers.map(|a| (a.frequency_hz, a.error_percent)).unzip()
    };
    let bare = uncompensated(found);
    let ends = found.sines.map_or([f64::NAN; 2], |sines| sines.range_hz);
    let (lowest, highest) = ends_of_all(found);
    let mut figure = Figure::new("Tracking error against frequency").panel_height(150.0).link_x();
    for family in ControllerFamily::ALL {
        let own = found.runs.iter().filter(|run| run.controller.family() == family);
        let own: Vec<&ControllerRun> =
            own.filter(|run| run.controller != Controller::Uncompensated).collect();
        if own.is_empty() && !(family == ControllerFamily::Line && bare.is_some()) {
            continue;
        }
        let axis = Axis::log("error, rms", "% of stroke").with_range(lowest, highest);
        let mut panel = Panel::new(Axis::log("frequency", "Hz"), axis).titled(family.words());
        let limit = Style::line(Colour::Grey).with_dash(Dash::Dotted);
        panel = panel.series(Series::line("", ends.to_vec(), vec![1.0, 1.0], limit));
        if let Some(run) = bare {
            let (x, y) = curve(run);
            let style = Style::line(Colour::Grey).with_width(2.8);
            panel = panel.series(Series::line("uncompensated", x, y, style));
        }
        for (i, run) in own.iter().enumerate() {
            let (x, y) = curve(run);
            panel = panel.series(Series::line(run.controller.words(), x, y, Style::nth(i)));
        }
        let marks = bare.into_iter().chain(own.iter().copied());
        let (mut lost, mut above) = ((Vec::new(), Vec::new()), (Vec::new(), Vec::new()));
        for run in marks {
            let Some([(_, minus_3_db), (_, one_percent)]) = run.bandwidths() else { continue };
            if let Some(f) = minus_3_db.found() {
                lost.0.push(f);
                lost.1.push(between(&curve(run), f));
            }
            if let Some(f) = one_percent.found() {
                above.0.push(f);
                above.1.push(1.0);
            }
        }
        let mark = |marker| Style::line(Colour::Ink).with_dash(Dash::None).with_marker(marker);
        for (label, (x, y), marker) in [("1 % error", above, Marker::Circle), ("−3 dB", lost, Marker::Square)]
        {
            if !x.is_empty() {
                panel = panel.series(Series::line(label, x, y, mark(marker)));
            }
        }
        figure = figure.panel(panel);
    }
    figure.captioned(
        "Simulated sines of the reference's amplitude: rms error in per cent of the stroke, noise and \
         harmonics included. ● where it exceeds 1 %, ■ where the sine falls below 1/√2 of its amplitude.",
    )
}

/// Least and largest error of all sines, for axes that compare.
fn ends_of_all(found: &Tracking) -> (f64, f64) {
    let all = found.runs.iter().filter_map(|run| run.followed.as_ref());
    let all: Vec<f64> = all.flat_map(|followed| &followed.answers).map(|a| a.error_percent).collect();
    let (low, high) = all.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
    (0.7 * low.min(0.5), 1.4 * high.max(2.0))
}

/// The curve at a frequency, on logarithmic scales.
fn between((x, y): &(Vec<f64>, Vec<f64>), f: f64) -> f64 {
    let after = x.partition_point(|x| *x < f).clamp(1, x.len().saturating_sub(1).max(1));
    let (Some([a, b]), Some([p, q])) = (x.get(after - 1..=after), y.get(after - 1..=after)) else {
        return f64::NAN;
    };
    p * (q / p).powf((f / a).ln() / (b / a).ln())
}

fn time(found: &Tracking) -> Vec<f64> {
    (0..found.reference.len()).map(|k| k as f64 / found.sample_rate_hz).collect()
}

fn motion(found: &Tracking) -> Figure {
    let unit = found.output.to_string();
    let wide = Style::line(Colour::Green).with_width(4.0);
    let mut panel = Panel::new(Axis::linear("time", "s"), Axis::linear("displacement", unit))
        .series(Series::line("reference", time(found), found.reference.clone(), wide));
    let styles = [Style::line(Colour::Vermillion).with_dash(Dash::Dashed), Style::model()];
    let shown = [uncompensated(found), best(found)];
    for (run, style) in shown.into_iter().zip(styles).filter_map(|(run, style)| Some((run?, style))) {
        let y = run.played.displacement.clone();
        panel = panel.series(Series::line(run.controller.words(), time(found), y, style));
    }
    let rms = |run: &ControllerRun| format!("{} {}", significant(run.score.rms, 3), found.output);
    let caption = match shown {
        [Some(bare), Some(best)] => format!(
            "The reference, the stage without compensation ({}: rms error {}), and with the controller of the \
             smallest error ({}: {}), simulated.",
            bare.controller.words(),
            rms(bare),
            best.controller.words(),
            rms(best)
        ),
        [None, Some(best)] => format!(
            "The reference, and the stage with the controller of the smallest error ({}: {}), simulated.",
            best.controller.words(),
            rms(best)
        ),
        _ => "The reference, and the stage without compensation, simulated.".to_owned(),
    };
    Figure::new("Reference and displacement").panel(panel).captioned(caption)
}

fn uncompensated(found: &Tracking) -> Option<&ControllerRun> {
    found.runs.iter().find(|run| run.controller == Controller::Uncompensated)
}

/// The controller of the smallest rms error, beside none.
fn best(found: &Tracking) -> Option<&ControllerRun> {
    let others = found.runs.iter().filter(|run| run.controller != Controller::Uncompensated);
    others.filter(|run| run.score.rms.is_finite()).min_by(|a, b| a.score.rms.total_cmp(&b.score.rms))
}

/// Error over time of the controllers with the smallest errors, and of the first.
fn left_over(found: &Tracking) -> Figure {
    let unit = found.output.to_string();
    let mut order: Vec<usize> = (0..found.runs.len()).collect();
    order.sort_by(|a, b| found.runs[*b].score.rms.total_cmp(&found.runs[*a].score.rms));
    let skipped = order.len().saturating_sub(CURVES - 1);
    let mut shown: Vec<usize> = vec![0];
    shown.extend(order.into_iter().skip(skipped).filter(|i| *i != 0));
    let mut figure = Figure::new("Error over time").panel_height(130.0).in_columns(2).link_x();
    for (place, i) in shown.into_iter().enumerate() {
        let run = &found.runs[i];
        let scored = || found.scored.clone();
        let error = found.reference[scored()].iter().zip(&run.played.displacement[scored()]);
        let error: Vec<f64> = error.map(|(r, y)| r - y - run.score.mean).collect();
        let time = time(found)[scored()].to_vec();
        let panel = Panel::new(Axis::linear("time", "s"), Axis::linear("error", unit.clone()))
            .series(Series::line(run.controller.words(), time, error, Style::nth(place)));
        figure = figure.panel(panel);
    }
    figure.captioned(
        "Reference minus displacement, mean removed: the first controller and those with the smallest \
         errors. Each panel has its own scale.",
    )
}

fn reach(found: &Tracking) -> Figure {
    let (x, y) = found.reach.iter().map(|r| (r.amplitude, r.highest_hz)).unzip();
    let axis = Axis::log("amplitude", found.output.to_string());
    let panel = Panel::new(axis, Axis::log("highest frequency", "Hz")).series(Series::line(
        "largest rate of the drive",
        x,
        y,
        Style::nth(0),
    ));
    Figure::new("Bandwidth against amplitude").panel(panel).captioned(
        "Highest frequency of a sine within the slew limit of the drive, by formula from the model.",
    )
}
