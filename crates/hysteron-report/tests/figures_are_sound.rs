//! Figures are well-formed, deterministic and small, whatever the data.
#![allow(clippy::unwrap_used)]

use hysteron_report::figure::{
    Axis, ConvergenceCurve, Figure, FrequencyResponseCurve, Marker, Panel, Series, Style, convergence,
    errors_by_category, errors_by_frequency, frequency_response, histogram, measured_and_model,
};
use hysteron_report::page::{Page, Section};
use proptest::prelude::*;

fn volts() -> Axis {
    Axis::linear("voltage", "V")
}

fn microns() -> Axis {
    Axis::linear("displacement", "µm")
}

fn one(x: Vec<f64>, y: Vec<f64>, x_axis: Axis, y_axis: Axis) -> Figure {
    Figure::new("f").panel(Panel::new(x_axis, y_axis).series(Series::line(
        "s",
        x,
        y,
        Style::nth(0).marked(0),
    )))
}

/// All texts of an SVG, after checking that it is well-formed and has no coordinate that is not a number.
fn texts(svg: &str) -> Vec<String> {
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "a coordinate is not a number");
    let document = roxmltree::Document::parse(svg).unwrap();
    let nodes = document.descendants().filter(|n| n.has_tag_name("text"));
    nodes.filter_map(|n| n.text()).map(str::to_owned).collect()
}

#[test]
fn series_without_a_drawable_point_say_no_data() {
    let nan = f64::NAN;
    for (x, y) in [
        (vec![], vec![]),
        (vec![nan; 5], vec![1.0; 5]),
        (vec![1.0, 2.0], vec![nan, f64::INFINITY]),
        (vec![1.0], vec![]),
        (vec![1.0, 2.0], vec![f64::MAX, f64::MIN]),
    ] {
        assert!(texts(&one(x, y, volts(), microns()).to_svg()).contains(&"no data".to_owned()));
    }
    let negative_on_log = one(vec![1.0, 2.0], vec![-1.0, 0.0], volts(), Axis::log("RMSE", "µm"));
    assert!(texts(&negative_on_log.to_svg()).contains(&"no data".to_owned()));
    assert!(!texts(&one(vec![1.0], vec![2.0], volts(), microns()).to_svg()).contains(&"no data".to_owned()));
    assert!(roxmltree::Document::parse(&Figure::new("").to_svg()).is_ok());
}

#[test]
fn a_constant_series_is_drawn_around_its_value() {
    for value in [0.0, 5.0, -3e-9, 1e12] {
        let found = texts(&one(vec![0.0, 1.0, 2.0], vec![value; 3], volts(), microns()).to_svg());
        assert!(!found.contains(&"no data".to_owned()), "{value}: {found:?}");
        assert!(found.len() >= 6, "{value}: {found:?}");
    }
}

#[test]
fn axis_titles_carry_their_units_and_powers_of_ten() {
    let found = texts(&one(vec![0.0, 1.0], vec![0.0, 4e-5], volts(), microns()).to_svg());
    assert!(found.contains(&"voltage (V)".to_owned()), "{found:?}");
    assert!(found.contains(&"displacement (10⁻⁶ µm)".to_owned()), "{found:?}");
}

#[test]
fn a_hundred_thousand_samples_give_a_small_drawing_with_every_extreme() {
    let n = 200_000;
    let time: Vec<f64> = (0..n).map(|k| f64::from(k) * 1e-4).collect();
    let u: Vec<f64> = time.iter().map(|t| (10.0 * t).sin()).collect();
    let mut y: Vec<f64> =
        time.iter().enumerate().map(|(k, t)| (10.0 * t - 0.3).sin() + 1e-3 * (k % 7) as f64).collect();
    y[123_457] = 4.0;
    let time_curve = Figure::new("t").panel(measured_and_model(volts(), microns(), &time, &y, &u)).to_svg();
    let loops = Figure::new("l").panel(measured_and_model(volts(), microns(), &u, &y, &u)).to_svg();
    for svg in [&time_curve, &loops] {
        assert!(svg.len() < 130_000, "{} bytes", svg.len());
    }
    // The spike is the largest value: its point lies 6/112 of the frame below the upper edge.
    let document = roxmltree::Document::parse(&time_curve).unwrap();
    let attribute = |class: &str, name: &str| {
        let node = document.descendants().find(|n| n.attribute("class") == Some(class)).unwrap();
        node.attribute(name).unwrap().to_owned()
    };
    let (top, height): (f64, f64) =
        (attribute("frame", "y").parse().unwrap(), attribute("frame", "height").parse().unwrap());
    let expected = top + height * 0.06 / 1.12;
    let highest = path_points(&attribute("line", "d")).into_iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    assert!((highest - expected).abs() < 0.02, "{highest} instead of {expected}");
}

/// Absolute points of a path of `M` and `l` steps.
fn path_points(d: &str) -> Vec<(f64, f64)> {
    let (mut points, mut numbers, mut command) = (Vec::<(f64, f64)>::new(), Vec::new(), ' ');
    let mut tokens = Vec::new();
    for c in d.chars() {
        match c {
            'M' | 'l' | '-' => tokens.push(String::from(c)),
            ' ' => tokens.push(String::new()),
            c => tokens.last_mut().unwrap().push(c),
        }
        if matches!(c, 'M' | 'l') {
            tokens.push(String::new());
        }
    }
    for token in tokens.into_iter().filter(|t| !t.is_empty()) {
        match token.as_str() {
            "M" | "l" => command = token.chars().next().unwrap(),
            number => numbers.push(number.parse::<f64>().unwrap()),
        }
        if let [x, y] = numbers[..] {
            let from = if command == 'l' { *points.last().unwrap() } else { (0.0, 0.0) };
            points.push((from.0 + x, from.1 + y));
            numbers.clear();
        }
    }
    points
}

#[test]
fn every_kind_of_figure_is_well_formed_and_always_the_same() {
    let x: Vec<f64> = (1..=50).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|v| 1.0 / v).collect();
    let names = ["10 Hz".to_owned(), "20 Hz & <more>".to_owned()];
    let models = vec![("a".to_owned(), vec![1.0, f64::NAN]), ("b".to_owned(), vec![2.0, 3.0])];
    let runs = vec![y.clone(), x.clone(), y.iter().map(|v| 2.0 * v).collect()];
    let curve = FrequencyResponseCurve {
        label: "G".into(),
        frequency_hz: x.clone(),
        magnitude: y.clone(),
        phase_deg: x.iter().map(|v| -v).collect(),
        as_points: true,
    };
    let figures = [
        Figure::new("loop").panel(measured_and_model(volts(), microns(), &y, &x, &y)).in_columns(3),
        convergence(
            "c",
            "generation",
            Axis::log("RMSE", "µm"),
            &[ConvergenceCurve { label: "DE".into(), x: x.clone(), runs }],
        ),
        frequency_response("r", "", &[curve]),
        errors_by_category("e", "", &names, microns(), &models),
        errors_by_frequency("e", &[10.0, 20.0], Axis::log("RMSE", "µm"), &models),
        histogram("h", microns(), &y, 12),
        one(x.clone(), y, Axis::linear("x", ""), microns()).panel(
            Panel::new(volts(), microns())
                .span(3.0, 1.0, "backwards")
                .span(f64::NAN, 2.0, "")
                .series(Series::line("bars", x.clone(), x, Style::nth(2).with_marker(Marker::Bar))),
        ),
    ];
    for figure in figures {
        let svg = figure.to_svg();
        assert!(!texts(&svg).is_empty());
        assert_eq!(svg, figure.clone().to_svg(), "{}", figure.title);
    }
}

#[test]
fn no_text_is_smaller_than_nine_points() {
    let svg = one(vec![0.0, 1.0], vec![0.0, 1.0], volts(), microns()).subtitled("simulated").to_svg();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let sizes: Vec<f64> =
        document.descendants().filter_map(|n| n.attribute("font-size")).map(|s| s.parse().unwrap()).collect();
    assert!(!sizes.is_empty() && sizes.iter().all(|px| px * 0.75 >= 9.0), "{sizes:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn any_numbers_give_a_well_formed_drawing(
        x in prop::collection::vec(any::<f64>(), 0..40), y in prop::collection::vec(any::<f64>(), 0..40),
        log_x: bool, log_y: bool, low in any::<f64>(), high in any::<f64>(), fixed: bool,
    ) {
        let axis = |log: bool| if log { Axis::log("a", "V") } else { Axis::linear("a", "V") };
        let x_axis = if fixed { axis(log_x).with_range(low, high) } else { axis(log_x) };
        let svg = one(x, y, x_axis, axis(log_y)).to_svg();
        prop_assert!(roxmltree::Document::parse(&svg).is_ok());
        prop_assert!(!svg.contains("NaN") && !svg.contains("inf\""));
    }

    #[test]
    fn any_text_gives_a_well_formed_drawing(text in any::<String>()) {
        let panel = Panel::new(Axis::linear(&text, &text), Axis::categories(&text, [&text])).titled(&text);
        let series = Series::line(&text, vec![0.0, 1.0], vec![0.0, 1.0], Style::default());
        let figure = Figure::new(&text).subtitled(&text).captioned(&text).panel(panel.series(series));
        prop_assert!(roxmltree::Document::parse(&figure.to_svg()).is_ok());
    }
}

/// Sizes of the drawings of a page: width and height of the wide one and of the narrow one.
fn drawings(figure: Figure) -> Vec<String> {
    let page = Page::new("p").section(Section::new("s").block(figure)).to_html();
    let body = page.split("<main>").nth(1).unwrap().split("</main>").next().unwrap();
    body.split("<svg ").skip(1).map(|rest| format!("<svg {}", rest.split("</svg>").next().unwrap())).collect()
}

#[test]
fn a_page_has_each_figure_also_for_a_narrow_screen_with_the_data_once() {
    let x: Vec<f64> = (0..100).map(f64::from).collect();
    let long = "a record whose name goes on and on: simulated_sweep_1_100hz_with_half_the_amplitude.csv";
    let figure = one(x.clone(), x.clone(), volts(), microns())
        .titled(long)
        .panel(Panel::new(volts(), microns()).series(Series::line("second", x.clone(), x, Style::nth(1))))
        .in_columns(2);
    let [wide, narrow] = &drawings(figure)[..] else { panic!("two drawings") };
    assert!(wide.contains("width=\"680\"") && wide.contains("class=\"figure\""));
    assert!(narrow.contains("width=\"358\"") && narrow.contains("class=\"figure narrow\""));
    assert!(wide.contains(" data-points=") && !narrow.contains(" data-points="));
    // Panels one below the other, and the whole title.
    let frames: Vec<&str> =
        narrow.split(" data-frame=\"").skip(1).map(|f| f.split(' ').next().unwrap()).collect();
    assert!(frames.len() == 2 && frames[0] == frames[1], "{frames:?}");
    for word in ["a record", "simulated_", "amplitude.csv"] {
        assert!(narrow.contains(word), "{word}");
    }
    assert!(!narrow.replace("<title>", "").contains('…'));
}

#[test]
fn names_on_an_axis_are_whole_on_a_narrow_screen() {
    let names = ["fractional+creep+prandtl-ishlinskii", "integer2"];
    let panel = Panel::new(Axis::log("error", "µm"), Axis::categories("", names));
    let figure = Figure::new("f").panel(panel.series(Series::line(
        "s",
        vec![1.0, 2.0],
        vec![0.0, 1.0],
        Style::nth(0),
    )));
    let [_, narrow] = &drawings(figure)[..] else { panic!("two drawings") };
    assert!(
        narrow.contains(">fractional+creep+</text>") && narrow.contains(">prandtl-ishlinskii</text>"),
        "{narrow}"
    );
}

#[test]
fn a_figure_with_named_points_keeps_its_width_and_scrolls() {
    let panel = Panel::new(volts(), microns()).series(Series::line(
        "s",
        vec![1.0, 2.0],
        vec![1.0, 2.0],
        Style::nth(0),
    ));
    let figure = Figure::new("f").panel(panel.name(1.0, 1.0, "here"));
    assert_eq!(drawings(figure.clone()).len(), 1);
    assert!(Page::new("p").section(Section::new("s").block(figure)).to_html().contains("class=\"scrolls\""));
}
