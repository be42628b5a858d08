//! Explanation of a fitted structure in plain words.

use super::{Core, FrequencyResponse, ResponseFit};

/// One or two sentences about the fit.
pub(super) fn explain(fit: &ResponseFit, response: &FrequencyResponse) -> String {
    let structure = fit.structure;
    let mut parts: Vec<String> = Vec::new();
    match structure.core {
        Core::Constant => {}
        Core::FractionalLag => parts.push(format!(
            "a lag of order {:.3} with its corner at {}: flat below, falling as f^−{:.3} above",
            fit.value("order"),
            hertz(fit.value("corner_frequency")),
            fit.value("order")
        )),
        Core::FractionalOscillator => parts.push(format!(
            "one resonance at {} of orders {:.3} and {:.3}",
            hertz(fit.value("natural_frequency")),
            fit.value("order2"),
            fit.value("order1")
        )),
        Core::Rational { poles: 1, direct: true } => parts.push(lead_lag(fit)),
        Core::Rational { poles, .. } => parts.extend(modes(fit, poles / 2, response)),
        Core::Modes { count } => parts.extend(modes(fit, count, response)),
    }
    if structure.power_law {
        let exponent = fit.value("exponent");
        parts.push(format!(
            "a magnitude proportional to f^{} with a constant phase of {}",
            signed(-exponent, 4),
            degrees(-90.0 * exponent)
        ));
    }
    if structure.loss_angle {
        let angle = fit.value("loss_angle").to_degrees();
        parts.push(format!(
            "a further constant phase of {}, a loss angle without a fall of the magnitude, as of \
             rate-independent hysteresis (it would change with the amplitude of the drive; creep would not)",
            degrees(-angle)
        ));
    }
    if structure.delay {
        parts.push(format!("a delay of {}", seconds(fit.value("delay"))));
    }
    if structure.core == Core::Constant {
        parts.push(measured_phase(response));
    }
    let edges: Vec<&str> = fit.parameters.iter().filter(|p| p.on_edge).map(|p| p.name.as_str()).collect();
    let edge = if edges.is_empty() {
        String::new()
    } else {
        format!(" On the edge of the search: {}.", edges.join(", "))
    };
    format!(
        "{}. Error {:.2} % rms, at most {:.2} % (at {}).{edge}",
        sentence(&parts.join("; ")),
        100.0 * fit.relative_rms,
        100.0 * fit.largest.0,
        hertz(fit.largest.1)
    )
}

/// d + g/(1 + s/ω) has its zero at s/ω = −(d + g)/d, and its largest lag at the geometric mean.
fn lead_lag(fit: &ResponseFit) -> String {
    let (pole, direct, gain) = (fit.value("pole_frequency"), fit.value("direct"), fit.value("pole_gain"));
    let zero = pole * (direct + gain) / direct;
    if !(zero > 0.0 && zero.is_finite()) {
        return format!("a pole at {}", hertz(pole));
    }
    let middle = (pole * zero).sqrt();
    let phase = ((middle / zero).atan() - (middle / pole).atan()).to_degrees();
    format!(
        "a pole at {} and a zero at {}: a phase that varies, most ({}) at {}; a constant phase would need \
         ever more of them",
        hertz(pole),
        hertz(zero),
        degrees(phase),
        hertz(middle)
    )
}

/// Resonances inside the band, and the number of other poles.
fn modes(fit: &ResponseFit, pairs: usize, response: &FrequencyResponse) -> Vec<String> {
    let (low, high) = response.range_hz();
    let pair = |i: usize| (fit.value(&format!("mode{i}_frequency")), fit.value(&format!("mode{i}_damping")));
    let is_mode = |&(f, damping): &(f64, f64)| (low..=high).contains(&f) && damping < 0.7;
    let all: Vec<(f64, f64)> = (1..=pairs).map(pair).collect();
    let seen: Vec<String> = all
        .iter()
        .filter(|p| is_mode(p))
        .map(|(f, damping)| format!("{} (ζ {damping:.3})", hertz(*f)))
        .collect();
    let others = all.iter().filter(|p| !is_mode(p)).count();
    let mut parts = Vec::new();
    if !seen.is_empty() {
        parts.push(format!("resonances at {}", seen.join(", ")));
    }
    if others > 0 {
        parts.push(format!("{others} further pole pair(s), heavily damped or outside of the band"));
    }
    parts
}

fn measured_phase(response: &FrequencyResponse) -> String {
    let phases = response.phase_deg();
    let low = phases.iter().copied().fold(f64::INFINITY, f64::min);
    let high = phases.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("the measured phase lies between {} and {}", degrees(low), degrees(high))
}

fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn signed(x: f64, decimals: usize) -> String {
    format!("{x:.decimals$}").replace('-', "−")
}

fn degrees(x: f64) -> String {
    format!("{}°", signed(x, 2))
}

fn hertz(f: f64) -> String {
    match f {
        f if f >= 1e4 => format!("{:.1} kHz", f / 1e3),
        f if f >= 100.0 => format!("{f:.0} Hz"),
        f if f >= 1.0 => format!("{f:.2} Hz"),
        f => format!("{f:.2e} Hz"),
    }
}

fn seconds(t: f64) -> String {
    if t >= 1e-2 || t == 0.0 { format!("{t:.3} s") } else { format!("{:.1} µs", 1e6 * t) }
}
