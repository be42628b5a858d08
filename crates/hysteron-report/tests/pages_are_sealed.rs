//! A page runs nothing but its own script, loads nothing, and shows hostile text as text.
#![allow(clippy::unwrap_used)]

use hysteron_identify::Correlation;
use hysteron_model::validate::Correlogram;
use hysteron_report::figure::{Axis, ConvergenceCurve, Figure, FrequencyResponseCurve, Panel, Series, Style};
use hysteron_report::identification::{
    DegreeRow, IdentificationReportData, ParameterRow, ScoreRow, StructureRow, identification_report,
};
use hysteron_report::page::{Block, Column, Highlight, Page, Section, Table};
use hysteron_report::record_curves::{BandWidths, RecordCurves};
use hysteron_report::starts::{SearchStarts, StartRow};
use proptest::prelude::*;

const HOSTILE: &str =
    "</script></style></title></svg><script>alert(1)</script><img src=x onerror=alert(1)>\"'&<!--";

/// A report in which every text is `text`.
fn report(text: &str) -> Page {
    let t = || text.to_owned();
    let ramp: Vec<f64> = (0..50).map(f64::from).collect();
    let correlogram = Correlogram { first_lag: 1, coefficients: vec![0.5, f64::NAN], bound: 0.1 };
    let page = identification_report(&IdentificationReportData {
        title: t(),
        model_name: t(),
        summary: t(),
        simulated: true,
        highlights: vec![Highlight::new(t(), t(), t())],
        warnings: vec![t()],
        limits: vec![t()],
        equations: vec![t()],
        parameters: vec![ParameterRow {
            block: t(),
            symbol: t(),
            meaning: t(),
            value: 1.0,
            unit: t(),
            interval: Some((0.5, 1.5)),
            is_profiled: true,
            std_error: Some(0.1),
            note: t(),
        }],
        verdicts: vec![(t(), t())],
        scores: vec![ScoreRow { record: t(), role: t(), unit: t(), ..ScoreRow::default() }],
        score_definitions: vec![t()],
        preparation: vec![t()],
        records: vec![RecordCurves {
            segments: Vec::new(),
            sines: Vec::new(),
            gain_unit: String::new(),
            name: t(),
            role: t(),
            time_s: ramp.clone(),
            input: (t(), t()),
            u: ramp.clone(),
            output: (t(), t()),
            measured: ramp.clone(),
            model: ramp.clone(),
            valid: Vec::new(),
            band: Some(BandWidths { model: ramp.clone(), measurement: ramp.clone() }),
            skipped_until_s: 3.0,
            autocorrelation: Some(correlogram.clone()),
            input_correlation: Some(correlogram.clone()),
        }],
        convergence: vec![ConvergenceCurve { label: t(), x: ramp.clone(), runs: vec![ramp.clone()] }],
        starts: vec![SearchStarts {
            step: t(),
            unit: t(),
            rows: vec![StartRow { how: t(), best: true, ..StartRow::default() }],
        }],
        objective: t(),
        objective_unit: t(),
        convergence_x_label: t(),
        frequency_response: vec![FrequencyResponseCurve {
            label: t(),
            frequency_hz: ramp.clone(),
            magnitude: ramp.clone(),
            phase_deg: ramp,
            as_points: false,
        }],
        excited_hz: Some((1.0, 20.0)),
        magnitude_unit: t(),
        correlations: vec![Correlation {
            step: t(),
            names: vec![t(), t()],
            matrix: vec![vec![1.0; 2]; 2],
            condition_number: f64::INFINITY,
        }],
        degrees: vec![DegreeRow { degree: 2, rmse: 0.1, bic: -3.0, chosen: true }],
        degrees_note: t(),
        structures: vec![StructureRow { name: t(), chosen: true, ..StructureRow::default() }],
        structures_note: t(),
        convergence_note: t(),
        provenance: vec![(t(), t())],
        commands: vec![t()],
        footer: vec![t()],
    });
    let table = Table::new([Column::number(t(), t())]).captioned(t()).group(t(), 1).row([t()]).note(t());
    page.section(
        Section::new(t())
            .block(Block::Heading(t()))
            .block(Block::paragraph(t()))
            .block(Block::good(t()))
            .block(Block::details(t(), vec![Block::info(t()), table.into()])),
    )
}

/// Names of all elements in the HTML, by a scan that knows only `<name`.
fn elements(html: &str) -> Vec<String> {
    html.split('<')
        .skip(1)
        .map(|rest| {
            rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '/' || *c == '!').collect()
        })
        .collect()
}

/// The page without its own style sheet and script.
fn content(html: &str) -> String {
    let (head, rest) = html.split_once("<style>").unwrap();
    let (_, rest) = rest.split_once("</style>").unwrap();
    let (body, rest) = rest.rsplit_once("<script>").unwrap();
    let (_, tail) = rest.split_once("</script>").unwrap();
    format!("{head}{body}{tail}")
}

#[test]
fn hostile_text_adds_no_element_and_no_attribute() {
    let (plain, hostile) = (report("plain").to_html(), report(HOSTILE).to_html());
    // The same elements in the same order; figures may only drop or cut texts that do not fit.
    // and long names may break.
    let of_text = |name: &str| matches!(name.trim_start_matches('/'), "text" | "wbr" | "bdi");
    let without_text = |html: &str| -> Vec<String> {
        elements(&content(html)).into_iter().filter(|name| !of_text(name)).collect()
    };
    assert_eq!(without_text(&plain), without_text(&hostile));
    assert_eq!(hostile.matches("<script>").count(), 1);
    assert!(!content(&hostile).contains("<img") && !content(&hostile).contains("<!--"));
    assert!(content(&hostile).contains("&lt;img src=x onerror=alert(1)&gt;"));
    // What a button copies is the same text, in an attribute that it cannot leave.
    let csv: Vec<&str> =
        hostile.split(" data-csv=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(csv.len() >= 5 && csv.iter().all(|text| !text.contains(['<', '>', '\''])), "{csv:?}");
}

#[test]
fn a_page_names_no_address_and_its_policy_forbids_the_network() {
    let html = report("plain").to_html();
    let addresses = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!addresses.contains("http:") && !addresses.contains("https:") && !addresses.contains("url(//"));
    for loader in [" src=", "<link", "@import", "fetch(", "XMLHttpRequest", "WebSocket", "import("] {
        assert!(!addresses.contains(loader), "{loader}");
    }
    assert!(html.contains("default-src 'none'"));
    assert!(!html.contains("unsafe-inline") && !html.contains("unsafe-eval"));
    // Without 'unsafe-inline' a style attribute or an event handler would silently be dead.
    let body = content(&html);
    assert!(!body.contains(" style=") && !body.contains(" onclick="));
}

#[test]
fn ids_are_unique_and_every_reference_finds_its_target() {
    let html = content(&report("plain").to_html());
    let after = |mark: &str, end: char| -> Vec<String> {
        html.split(mark).skip(1).filter_map(|rest| rest.split(end).next()).map(str::to_owned).collect()
    };
    let ids = after(" id=\"", '"');
    let mut unique = ids.clone();
    unique.sort();
    unique.dedup();
    assert_eq!(ids.len(), unique.len(), "{ids:?}");
    let references: Vec<String> = after("url(#", ')').into_iter().chain(after("href=\"#", '"')).collect();
    assert!(!references.is_empty() && references.iter().all(|r| ids.contains(r)), "{references:?}");
}

#[test]
fn a_report_without_content_is_still_a_page() {
    let html = identification_report(&IdentificationReportData::default()).to_html();
    assert!(html.contains("</html>") && !html.contains("<script>") && !html.contains("<h2>"));
}

#[test]
fn long_records_keep_the_file_small() {
    let time: Vec<f64> = (0..300_000).map(|k| f64::from(k) * 1e-4).collect();
    let y: Vec<f64> = time.iter().map(|t| (30.0 * t * t).sin()).collect();
    let panel = |x: &[f64]| {
        Panel::new(Axis::linear("x", ""), Axis::linear("y", "µm")).series(Series::line(
            "y",
            x.to_vec(),
            y.clone(),
            Style::model(),
        ))
    };
    let page = Page::new("long")
        .section(Section::new("s").block(Figure::new("f").panel(panel(&time)).panel(panel(&y))));
    let size = page.to_html().len();
    assert!(size < 350_000, "{size} bytes");
    assert_eq!(page.to_html(), page.clone().to_html());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn no_text_opens_an_element(text in "[<>&\"'/a-z \u{0}-\u{1f}=;!-]{0,40}") {
        let html = content(&report(&text).to_html());
        let known = |name: &str| matches!(
            name.trim_start_matches('/'),
            "!doctype" | "html" | "head" | "meta" | "title" | "body" | "header" | "h1" | "h2" | "h3" | "p"
            | "nav" | "a" | "main" | "section" | "div" | "span" | "strong" | "small" | "b" | "table"
            | "caption" | "thead" | "tbody" | "tr" | "th" | "td" | "ul" | "li" | "dl" | "dt" | "dd" | "figure"
            | "figcaption" | "pre" | "code" | "details" | "summary" | "footer" | "svg" | "g" | "path" | "rect"
            | "text" | "clipPath" | "wbr" | "bdi"
        );
        for name in elements(&html) {
            prop_assert!(known(&name), "<{name}");
        }
    }
}

#[test]
fn a_page_of_three_sections_has_its_contents_at_the_side_and_above() {
    let page = |sections: usize| {
        let section = |i: usize| Section::new(format!("part {i}")).block(Block::paragraph("text"));
        (0..sections).map(section).fold(Page::new("p"), Page::section).to_html()
    };
    assert!(!page(2).contains("<nav"));
    let html = page(3);
    assert!(html.contains("<nav class=\"side\"") && html.contains("<details class=\"above\">"));
    assert_eq!(html.matches("<a href=\"#s1\">part 1</a>").count(), 2);
    // Without script there is no button, in print no contents and no button.
    assert!(!content(&html).contains("<button"));
    let print = html.split("@media print").nth(1).unwrap().split("</style>").next().unwrap();
    assert!(print.contains("nav,.above,.tools,svg.narrow"), "{print}");
}
