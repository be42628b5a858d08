//! Controllers of several axes on the simulated bench, as a page.

use hysteron_model::decoupling::{AxesController, AxesControllerRun, AxesTracking};
use hysteron_model::model::AxesTrackingSummary;
use hysteron_model::model_file::Maker;
use hysteron_model::record::Unit;

use crate::figure::{Axis, Colour, Dash, Figure, Panel, Series, Style};
use crate::number::significant;
use crate::page::{Block, Highlight, Page, Section};
use crate::results::axes_tracking::{ABOUT_ERRORS, errors, sentences};

/// A comparison of controllers with what it was made from.
pub struct AxesTracked<'a> {
    /// Name of the references.
    pub name: &'a str,
    /// The stage in words.
    pub stage: &'a str,
    /// The comparison.
    pub found: &'a AxesTracking,
    /// Its figures, with the names of the axes.
    pub summary: &'a AxesTrackingSummary,
    /// Names of the actuators.
    pub actuators: &'a [String],
    /// Unit of the drives.
    pub input_unit: &'a Unit,
    /// References, one list per axis.
    pub references: &'a [Vec<f64>],
}

/// The page; `maker`: who made it, and by which command.
pub fn axes_page(of: &AxesTracked<'_>, maker: &Maker) -> Page {
    let mut result = Section::new("Tracking error and cross-coupling of each controller");
    result = result
        .blocks(highlights(of))
        .block(Block::paragraph(format!("Simulated on the bench of several axes ({}).", of.stage)));
    let result = result.blocks(sentences(of.summary).into_iter().map(Block::paragraph));
    let result = result.block(errors(of.summary).for_page(1).note(ABOUT_ERRORS));
    let mut page = Page::new(format!("Following {} on several axes (simulated)", of.name))
        .section(result)
        .section(Section::new("Motion").block(motion(of)).block(left_over(of)))
        .section(Section::new("Drives").blocks(drives(of)));
    if let Some(command) = &maker.command {
        page = page.section(Section::new("Provenance").block(Block::code(command)));
    }
    page.footer_line(&maker.program)
}

/// The controller with the least cross-coupling beside the uncompensated stage.
fn highlights(of: &AxesTracked<'_>) -> Option<Block> {
    let all = || of.summary.controllers.iter();
    let best = all()
        .filter(|run| run.controller != AxesController::Uncompensated)
        .filter(|run| run.cross_rms_percent.is_some_and(f64::is_finite))
        .min_by(|a, b| a.cross_rms_percent.unwrap_or(0.0).total_cmp(&b.cross_rms_percent.unwrap_or(0.0)))?;
    let bare = all().find(|run| run.controller == AxesController::Uncompensated);
    let cross = |run: &hysteron_model::model::AxesControllerSummary| {
        run.cross_rms_percent.map_or_else(|| "–".to_owned(), |x| significant(x, 2))
    };
    let mut shown = vec![
        Highlight::new("least cross-coupling", cross(best), "% of stroke"),
        Highlight::new("by", best.controller.name(), ""),
    ];
    shown.extend(bare.map(|bare| Highlight::new("uncompensated", cross(bare), "% of stroke")));
    Some(Block::Highlights(shown))
}

fn time(of: &AxesTracked<'_>) -> Vec<f64> {
    let samples = of.references.first().map_or(0, Vec::len);
    (0..samples).map(|k| k as f64 / of.found.sample_rate_hz).collect()
}

fn unit(of: &AxesTracked<'_>) -> String {
    Unit::new(&of.summary.output_unit).to_string()
}

/// Sum of the squares of the errors relative to the strokes.
fn size(of: &AxesTracked<'_>, run: &AxesControllerRun) -> f64 {
    let relative = run.rms.iter().zip(&of.found.strokes).filter(|(_, stroke)| **stroke > 0.0);
    relative.map(|(rms, stroke)| (rms / stroke).powi(2)).sum()
}

/// Reference of every axis, with the uncompensated stage and the best controller.
fn motion(of: &AxesTracked<'_>) -> Figure {
    let runs = &of.found.runs;
    let bare = runs.iter().find(|run| run.controller == AxesController::Uncompensated);
    let best = runs.iter().min_by(|a, b| size(of, a).total_cmp(&size(of, b)));
    let mut figure = Figure::new("References and displacements").panel_height(110.0).link_x();
    for (m, axis) in of.summary.axes.iter().enumerate() {
        let wide = Style::line(Colour::Green).with_width(4.0);
        let mut panel = Panel::new(Axis::linear("time", "s"), Axis::linear("displacement", unit(of)))
            .titled(axis.as_str())
            .series(Series::line("reference", time(of), of.references[m].clone(), wide));
        let styles = [Style::line(Colour::Vermillion).with_dash(Dash::Dashed), Style::model()];
        for (run, style) in [bare, best].into_iter().zip(styles) {
            let Some(run) = run else { continue };
            let y = run.displacement[m].clone();
            panel = panel.series(Series::line(run.controller.name(), time(of), y, style));
        }
        figure = figure.panel(panel);
    }
    figure
        .captioned("References, the stage without compensation, and with the controller of the least error.")
}

/// Error of every axis over the scored samples, all controllers but the uncompensated stage.
fn left_over(of: &AxesTracked<'_>) -> Figure {
    let scored = || of.found.scored.clone();
    let time = time(of)[scored()].to_vec();
    let mut figure = Figure::new("Errors over time").panel_height(130.0).link_x();
    for (m, axis) in of.summary.axes.iter().enumerate() {
        let mut panel =
            Panel::new(Axis::linear("time", "s"), Axis::linear("error", unit(of))).titled(axis.as_str());
        let shown = of.found.runs.iter().filter(|run| run.controller != AxesController::Uncompensated);
        for (place, run) in shown.enumerate() {
            let error = of.references[m][scored()].iter().zip(&run.displacement[m][scored()]);
            let error: Vec<f64> = error.map(|(r, y)| r - y).collect();
            let mean = error.iter().sum::<f64>() / error.len().max(1) as f64;
            let error = error.into_iter().map(|e| e - mean).collect();
            panel = panel.series(Series::line(run.controller.name(), time.clone(), error, Style::nth(place)));
        }
        figure = figure.panel(panel);
    }
    figure.captioned(
        "Reference minus displacement, mean removed, of the controllers that know the couplings, over the \
         scored samples.",
    )
}

/// Drives of the feedforward.
fn drives(of: &AxesTracked<'_>) -> Option<Figure> {
    let run = of.found.runs.iter().find(|run| run.controller == AxesController::Feedforward)?;
    let volts = Axis::linear("drive", of.input_unit.to_string());
    let mut panel = Panel::new(Axis::linear("time", "s"), volts);
    for (n, (name, drive)) in of.actuators.iter().zip(&run.drive).enumerate() {
        panel = panel.series(Series::line(name.as_str(), time(of), drive.clone(), Style::nth(n)));
    }
    Some(Figure::new("Drives of the actuators").panel(panel).captioned("Drives of the feedforward."))
}
