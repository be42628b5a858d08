//! The palette of figures and pages, in one place: light for paper and files, dark for screens that ask for
//! it.
//!
//! Curves: M. Okabe, K. Ito, "Color Universal Design" (2008), distinguishable with every common kind of
//! colour blindness; its sky blue, orange, purple and grey are darkened to a contrast of 3:1 on paper (WCAG
//! 2.2, 1.4.11), its yellow is left out.

/// A colour on light and on dark ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tone {
    /// Name of its variable in the style sheet, without the dashes.
    pub name: &'static str,
    /// On paper.
    pub light: &'static str,
    /// On a dark screen.
    pub dark: &'static str,
}

const fn tone(name: &'static str, light: &'static str, dark: &'static str) -> Tone {
    Tone { name, light, dark }
}

pub(crate) const PAPER: Tone = tone("paper", "#fdfdfb", "#14181b");
/// Text, and the model's curve.
pub(crate) const INK: Tone = tone("ink", "#1b1f23", "#e4e8eb");
/// Frames, marks and small print.
pub(crate) const SOFT: Tone = tone("soft", "#5b646c", "#a3adb5");
pub(crate) const GRID: Tone = tone("grid", "#dde1e5", "#2b3238");
pub(crate) const MINOR: Tone = tone("minor", "#eff1f3", "#21272b");
/// Shaded stretches of an axis.
pub(crate) const SPAN: Tone = tone("span", "#eceff2", "#20272c");
const RULE: Tone = tone("rule", "#d9dee2", "#333b41");
/// Borders of controls.
const BORDER: Tone = tone("border", "#858e96", "#76818a");
const TINT: Tone = tone("tint", "#f3f5f6", "#1c2226");
/// Rows to be found at a glance.
const TINT_2: Tone = tone("tint2", "#e3e8ec", "#2b343a");
const ACCENT: Tone = tone("accent", "#005a8d", "#7cc4ee");
const GOOD: Tone = tone("good", "#00734f", "#54c79f");
const WARN: Tone = tone("warn", "#a84300", "#f0a060");
const WARN_TINT: Tone = tone("warntint", "#fdf3ea", "#2a2119");

/// Colours of curves, in the order of [`super::Colour`].
pub(crate) const CURVES: [Tone; 8] = [
    tone("k0", "#1b1f23", "#f1f4f6"),
    tone("k1", "#0072b2", "#5b8def"),
    tone("k2", "#d55e00", "#f0803c"),
    tone("k3", "#009e73", "#2fbf94"),
    tone("k4", "#b87f00", "#f0b93a"),
    tone("k5", "#3a97d0", "#4aa8e0"),
    tone("k6", "#b9608f", "#dd98bd"),
    tone("k7", "#858e96", "#8b969e"),
];

const OF_PAGES: [Tone; 14] =
    [PAPER, INK, SOFT, GRID, MINOR, SPAN, RULE, BORDER, TINT, TINT_2, ACCENT, GOOD, WARN, WARN_TINT];

/// The palette as variables of a style sheet; paper is always light.
pub(crate) fn style() -> String {
    let mut out = String::from(":root{color-scheme:light dark");
    let tones = || OF_PAGES.iter().chain(&CURVES);
    tones().for_each(|t| put!(out, ";--{}:{}", t.name, t.light));
    out.push_str("}\n@media screen and (prefers-color-scheme:dark){:root{color-scheme:dark");
    tones().for_each(|t| put!(out, ";--{}:{}", t.name, t.dark));
    out.push_str("}}\n");
    CURVES.iter().for_each(|t| put!(out, ".{0}{{color:var(--{0})}}", t.name));
    out.push('\n');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear red, green and blue.
    fn linear(hex: &str) -> [f64; 3] {
        [1, 3, 5].map(|i| {
            let c = f64::from(u8::from_str_radix(&hex[i..i + 2], 16).unwrap()) / 255.0;
            if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    }

    fn times(matrix: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(v).map(|(m, x)| m * x).sum())
    }

    /// Contrast of two colours (WCAG 2.2, 1.4.3).
    fn contrast(a: &str, b: &str) -> f64 {
        let luminance = |hex| {
            let [r, g, b] = linear(hex);
            0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05
        };
        let (a, b) = (luminance(a), luminance(b));
        a.max(b) / a.min(b)
    }

    /// CIELAB (D65) of linear sRGB.
    fn lab(rgb: [f64; 3]) -> [f64; 3] {
        let to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        let white = [0.9505, 1.0, 1.089];
        let xyz = times(to_xyz, rgb.map(|c| c.clamp(0.0, 1.0)));
        let f = |i: usize| {
            let t = xyz[i] / white[i];
            if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 }
        };
        [116.0 * f(1) - 16.0, 500.0 * (f(0) - f(1)), 200.0 * (f(1) - f(2))]
    }

    /// Full protanopia, deuteranopia and tritanopia: G. M. Machado et al. (2009), doi:10.1109/TVCG.2009.113.
    const BLIND: [[[f64; 3]; 3]; 3] = [
        [
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ],
        [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ],
        [
            [1.255_528, -0.076_749, -0.178_779],
            [-0.078_411, 0.930_809, 0.147_602],
            [0.004_733, 0.691_367, 0.303_900],
        ],
    ];

    /// Least CIELAB distance of two colours under the three kinds of colour blindness.
    fn apart(a: &str, b: &str) -> f64 {
        let distances = BLIND.map(|blind| {
            let (a, b) = (lab(times(blind, linear(a))), lab(times(blind, linear(b))));
            a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        });
        distances.into_iter().fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn curves_stand_out_from_the_paper_and_text_can_be_read() {
        for tone in CURVES {
            for (colour, paper) in
                [(tone.light, PAPER.light), (tone.light, "#ffffff"), (tone.dark, PAPER.dark)]
            {
                let contrast = contrast(colour, paper);
                assert!(contrast >= 3.0, "{} {colour} on {paper}: {contrast:.2}", tone.name);
            }
        }
        for tone in [INK, SOFT, ACCENT, GOOD, WARN] {
            assert!(contrast(tone.light, PAPER.light) >= 4.5 && contrast(tone.dark, PAPER.dark) >= 4.5);
            assert!(contrast(tone.light, TINT.light) >= 4.5 && contrast(tone.dark, TINT.dark) >= 4.5);
        }
        for tone in [INK, SOFT] {
            assert!(contrast(tone.light, TINT_2.light) >= 4.5 && contrast(tone.dark, TINT_2.dark) >= 4.5);
        }
    }

    #[test]
    fn curves_of_one_figure_differ_for_the_colour_blind() {
        let [ink, blue, vermillion, green, _, measured, _, grey] = CURVES;
        // Measured, model, residual, reference and drive share figures without other marks.
        for (a, b) in [
            (measured, ink),
            (measured, vermillion),
            (ink, vermillion),
            (green, vermillion),
            (blue, vermillion),
            (grey, ink),
            (blue, ink),
        ] {
            for (a, b) in [(a.light, b.light), (a.dark, b.dark)] {
                assert!(apart(a, b) >= 26.0, "{a} {b}: {:.1}", apart(a, b));
            }
        }
    }
}
