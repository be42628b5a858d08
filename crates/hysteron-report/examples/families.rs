//! The pictures of the theory pages of hysteresis families: the loop of each, and what each parameter does to
//! it. `cargo run -p hysteron-report --example families -- docs/figures`

use std::path::Path;

use hysteron_model::Start;
use hysteron_model::hysteresis::{
    ColumnKernel, Dahl, DeadZonePlays, DensityLaw, Duhem, GeneralisedPlays, HysteresisError, JilesAtherton,
    KrasnoselskiiPokrovskii, MaxwellSlip, NonSymmetricBoucWen, Preisach, PreisachDensity, RateDependentPlays,
    SongDerKiureghian,
};
use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};

type Curve = Result<Vec<f64>, HysteresisError>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os().nth(1).ok_or("usage: families OUT_DIR")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let figures = [
        ("duhem", duhem()?),
        ("dahl", dahl()?),
        ("maxwell-slip", maxwell_slip()?),
        ("generalised-play", generalised_play()?),
        ("dead-zone-plays", dead_zone_plays()?),
        ("rate-dependent-plays", rate_dependent_plays()?),
        ("krasnoselskii-pokrovskii", krasnoselskii_pokrovskii()?),
        ("preisach", preisach()?),
        ("jiles-atherton", jiles_atherton()?),
        ("asymmetric-bouc-wen", asymmetric_bouc_wen()?),
    ];
    for (name, figure) in figures {
        std::fs::write(folder.join(format!("family-{name}.svg")), figure.to_svg())?;
    }
    Ok(())
}

/// From rest to 5 V, −5 V, 5 V and down again, with a minor loop between −1 and 3 V on the way.
fn drive() -> Vec<f64> {
    let turns = [0.0, 5.0, -5.0, 5.0, -1.0, 3.0, -1.0, -5.0];
    let legs = turns.windows(2).flat_map(|leg| {
        let [from, to] = [leg[0], leg[1]];
        (0..100).map(move |k| from + (to - from) * f64::from(k) / 100.0)
    });
    legs.chain([-5.0]).collect()
}

fn columns<K: ColumnKernel>(polynomial: &[f64], kernel: K, shape: &[f64], weights: &[f64]) -> Curve {
    let u = drive();
    let mut columns = vec![0.0; kernel.columns() * u.len()];
    kernel.simulate_every(shape, 1, &u, Start::Rest { voltage_v: 0.0 }, &mut columns)?;
    let line = |u: f64| polynomial.iter().rev().fold(0.0, |sum, c| (sum + c) * u);
    let memory =
        |k: usize| weights.iter().enumerate().map(|(j, w)| w * columns[j * u.len() + k]).sum::<f64>();
    Ok(u.iter().enumerate().map(|(k, &u)| line(u) + memory(k)).collect())
}

/// A panel of loops, one a value of a parameter.
fn panel(
    title: &str,
    values: &[(&str, f64)],
    mut loop_at: impl FnMut(f64) -> Curve,
) -> Result<Panel, HysteresisError> {
    let mut panel =
        Panel::new(Axis::linear("voltage", "V"), Axis::linear("displacement", "µm")).titled(title);
    for (index, (label, value)) in values.iter().enumerate() {
        panel = panel.series(Series::line(*label, drive(), loop_at(*value)?, Style::nth(index)));
    }
    Ok(panel)
}

fn family(title: &str, panels: Vec<Panel>) -> Figure {
    let caption =
        "From rest to 5 V, −5 V and 5 V, then down with a minor loop between −1 and 3 V. Simulated.";
    let figure = Figure::new(title)
        .subtitled("from rest through ±5 V, with a minor loop between −1 and 3 V; simulated")
        .captioned(caption)
        .in_columns(2)
        .panel_height(200.0);
    panels.into_iter().fold(figure, Figure::panel)
}

fn duhem() -> Result<Figure, HysteresisError> {
    let run = |rate: f64, w: [f64; 2]| columns(&[1.2], Duhem { degree: 1 }, &[rate], &w);
    Ok(family(
        "Duhem (Coleman–Hodgdon)",
        vec![
            panel("loop", &[("", 0.0)], |_| run(0.5, [-0.6, 0.0]))?,
            panel("rate b", &[("0.2", 0.2), ("0.5", 0.5), ("1.5 /V", 1.5)], |b| run(b, [-0.6, 0.0]))?,
            panel("weight w₀", &[("−0.2", -0.2), ("−0.4", -0.4), ("−0.6 µm/V", -0.6)], |w| {
                run(0.5, [w, 0.0])
            })?,
            panel("weight w₁", &[("−0.08", -0.08), ("0", 0.0), ("0.08 µm/V²", 0.08)], |w| {
                run(0.5, [-0.4, w])
            })?,
        ],
    ))
}

fn dahl() -> Result<Figure, HysteresisError> {
    let run = |reach: f64, exponent: f64, sigma: f64| columns(&[1.2], Dahl, &[reach, exponent], &[-sigma]);
    Ok(family(
        "Dahl",
        vec![
            panel("loop", &[("", 0.0)], |_| run(2.0, 1.0, 0.6))?,
            panel("reach u_c", &[("0.7", 0.7), ("2", 2.0), ("6 V", 6.0)], |r| run(r, 1.0, 0.6))?,
            panel("exponent i", &[("0", 0.0), ("0.5", 0.5), ("1", 1.0)], |i| run(2.0, i, 0.6))?,
            panel("stiffness σ", &[("0.2", 0.2), ("0.4", 0.4), ("0.6 µm/V", 0.6)], |s| run(2.0, 1.0, s))?,
        ],
    ))
}

fn maxwell_slip() -> Result<Figure, HysteresisError> {
    let run = |count: u8, scale: f64, stiffness: f64| {
        let thresholds: Vec<f64> = (1..=count).map(|j| 4.0 * f64::from(j) / f64::from(count)).collect();
        let weights = vec![-stiffness / f64::from(count); usize::from(count)];
        columns(&[2.0], MaxwellSlip { thresholds }, &[scale], &weights)
    };
    Ok(family(
        "Maxwell slip",
        vec![
            panel("loop of six elements", &[("", 0.0)], |_| run(6, 1.0, 1.5))?,
            panel("scale of the thresholds", &[("0.4", 0.4), ("1", 1.0), ("2", 2.0)], |s| run(6, s, 1.5))?,
            panel("number of elements", &[("1", 1.0), ("3", 3.0), ("20", 20.0)], |n| run(n as u8, 1.0, 1.5))?,
            panel("stiffness Σ kⱼ", &[("−0.5", -0.5), ("−1.5", -1.5), ("−2.2", -2.2)], |k| {
                run(6, 1.0, -k)
            })?,
        ],
    ))
}

fn generalised_play() -> Result<Figure, HysteresisError> {
    let run = |[rise_right, rise_left]: [f64; 2], apart: f64, widest: f64| {
        let thresholds: Vec<f64> = (0..6_u8).map(|j| widest * (0.15 + 0.17 * f64::from(j))).collect();
        let shape = [rise_right, 0.5 * apart, rise_left, -0.5 * apart];
        columns(&[0.5], GeneralisedPlays { thresholds }, &shape, &[2.5; 6])
    };
    Ok(family(
        "Generalised Prandtl–Ishlinskii",
        vec![
            panel("loop", &[("", 0.0)], |_| run([0.35; 2], 0.5, 0.5))?,
            panel("rise of both", &[("0.2", 0.2), ("0.35", 0.35), ("0.8 /V", 0.8)], |a| {
                run([a; 2], 0.5, 0.5)
            })?,
            panel("rise of the falling branch", &[("0.3", 0.3), ("0.35", 0.35), ("0.4 /V", 0.4)], |a| {
                run([0.35, a], 0.5, 0.5)
            })?,
            panel("distance of the centres", &[("0", 0.0), ("0.5", 0.5), ("2 V", 2.0)], |d| {
                run([0.35; 2], d, 0.5)
            })?,
            panel("thresholds", &[("× 0.5", 0.25), ("× 1", 0.5), ("× 1.8", 0.9)], |r| {
                run([0.35; 2], 0.5, r)
            })?,
        ],
    ))
}

fn dead_zone_plays() -> Result<Figure, HysteresisError> {
    let run = |share: f64, reach: f64, plays: f64, slopes: [f64; 6]| {
        let kernel = DeadZonePlays::regular([-5.0, 5.0], 8);
        let weights: Vec<f64> = std::iter::repeat_n(plays, 8).chain(slopes).collect();
        columns(&[0.3], kernel, &[share, reach], &weights)
    };
    let bent = |by: f64| [0, 1, 2, 3, 4, 5].map(|k| 0.6 * (1.0 + by * (f64::from(k) - 2.5) / 2.5));
    Ok(family(
        "Plays and bands of their outputs",
        vec![
            panel("loop", &[("", 0.0)], |_| run(0.6, 3.0, 0.02, bent(0.7)))?,
            panel("bend of the six slopes", &[("−0.7", -0.7), ("0", 0.0), ("0.7", 0.7)], |b| {
                run(0.6, 3.0, 0.02, bent(b))
            })?,
            panel("loop share s", &[("0", 0.0), ("0.3", 0.3), ("0.9", 0.9)], |s| {
                run(s, 3.0, 0.0, bent(0.7))
            })?,
            panel("reach ρ", &[("0.5", 0.5), ("2", 2.0), ("20 V", 20.0)], |r| run(0.6, r, 0.0, bent(0.7)))?,
        ],
    ))
}

fn rate_dependent_plays() -> Result<Figure, HysteresisError> {
    // A hundred samples a leg of up to 10 V: a leg of 1 s is the rate of up to 10 V/s.
    let run = |gain: f64, leg_s: f64| {
        let thresholds: Vec<f64> = (1..=8).map(|j| 0.4 * f64::from(j)).collect();
        let kernel = RateDependentPlays { thresholds, interval_s: 0.01 * leg_s };
        columns(&[0.6], kernel, &[1.0, gain], &[0.1; 8])
    };
    Ok(family(
        "Rate-dependent plays",
        vec![
            panel("loop, 1 s a leg", &[("", 0.0)], |_| run(0.05, 1.0))?,
            panel("time a leg takes", &[("10", 10.0), ("1", 1.0), ("0.5 s", 0.5)], |t| run(0.05, t))?,
            panel("rate gain λ, 1 s a leg", &[("0", 0.0), ("0.05", 0.05), ("0.15 s", 0.15)], |g| {
                run(g, 1.0)
            })?,
        ],
    ))
}

fn krasnoselskii_pokrovskii() -> Result<Figure, HysteresisError> {
    // Density falls off with the width of a kernel over `width` lines.
    let run = |lines: usize, rise: f64, width: f64| {
        let kernel = KrasnoselskiiPokrovskii { range: [-4.5, 4.5], lines };
        let pairs = (0..lines).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let weights: Vec<f64> =
            pairs.map(|(i, j)| (-(kernel.line(i) - kernel.line(j)) / width).exp()).collect();
        let total: f64 = weights.iter().sum();
        let weights: Vec<f64> = weights.iter().map(|w| 8.0 * w / total).collect();
        columns(&[0.3], kernel, &[rise], &weights)
    };
    Ok(family(
        "Krasnosel'skii–Pokrovskii",
        vec![
            panel("loop", &[("", 0.0)], |_| run(9, 2.0, 3.0))?,
            panel("rise of the ramps", &[("0.1", 0.1), ("1", 1.0), ("5 V", 5.0)], |a| run(9, a, 3.0))?,
            panel("lines of the grid", &[("3", 3.0), ("5", 5.0), ("17", 17.0)], |n| {
                run(n as usize, 1.0, 3.0)
            })?,
            panel("width over which weights fall", &[("1", 1.0), ("3", 3.0), ("20 V", 20.0)], |w| {
                run(9, 2.0, w)
            })?,
        ],
    ))
}

fn preisach() -> Result<Figure, HysteresisError> {
    let run = |shape: [f64; 4], law: DensityLaw| {
        let kernel = PreisachDensity { plane: Preisach::regular([-6.0, 6.0], 49), law };
        columns(&[0.3], kernel, &shape, &[8.0])
    };
    let usual = [1.0, 0.7, 0.0, 2.0];
    let with = |index: usize| {
        move |value: f64| {
            let mut shape = usual;
            shape[index] = value;
            run(shape, DensityLaw::Gaussian)
        }
    };
    let laws = [("Gaussian", 0.0), ("Lorentzian", 1.0)];
    Ok(family(
        "Preisach density",
        vec![
            panel("law", &laws, |law| {
                run(usual, if law == 0.0 { DensityLaw::Gaussian } else { DensityLaw::Lorentzian })
            })?,
            panel("mean half-width h₀", &[("0.3", 0.3), ("1", 1.0), ("2 V", 2.0)], with(0))?,
            panel("its spread σ_h", &[("0.2", 0.2), ("0.7", 0.7), ("2 V", 2.0)], with(1))?,
            panel("mean bias m₀", &[("−1.5", -1.5), ("0", 0.0), ("1.5 V", 1.5)], with(2))?,
            panel("its spread σ_m", &[("0.7", 0.7), ("2", 2.0), ("6 V", 6.0)], with(3))?,
        ],
    ))
}

fn jiles_atherton() -> Result<Figure, HysteresisError> {
    let run = |shape: [f64; 4]| columns(&[0.3], JilesAtherton, &shape, &[10.0]);
    let usual = [1.0, 1.0, 0.2, 1.5];
    let with = |index: usize| {
        move |value: f64| {
            let mut shape = usual;
            shape[index] = value;
            run(shape)
        }
    };
    Ok(family(
        "Jiles–Atherton",
        vec![
            panel("loop", &[("", 0.0)], |_| run(usual))?,
            panel("anhysteretic a", &[("0.6", 0.6), ("1", 1.0), ("2 V", 2.0)], with(0))?,
            panel("pinning k", &[("0.3", 0.3), ("1", 1.0), ("2 V", 2.0)], with(1))?,
            panel("reversibility c", &[("0", 0.0), ("0.2", 0.2), ("0.8", 0.8)], with(2))?,
            panel("coupling α", &[("0", 0.0), ("1.5", 1.5), ("2.7 V", 2.7)], with(3))?,
        ],
    ))
}

fn asymmetric_bouc_wen() -> Result<Figure, HysteresisError> {
    let six = |index: usize| {
        move |value: f64| {
            let mut shape = [0.5, 0.0, 0.0, 0.0, 0.0, 0.0];
            shape[index] = value;
            columns(&[1.2], SongDerKiureghian, &shape, &[-0.6])
        }
    };
    let delta = |value: f64| columns(&[1.2], NonSymmetricBoucWen, &[0.5, 0.0, value], &[-0.6]);
    let values = [("−0.2", -0.2), ("0", 0.0), ("0.2 /V", 0.2)];
    Ok(family(
        "Asymmetric Bouc–Wen",
        vec![
            panel("loop of Bouc–Wen", &[("", 0.5)], six(0))?,
            panel("β₁", &[("0.2", 0.2), ("0.5", 0.5), ("1.5 /V", 1.5)], six(0))?,
            panel("β₂", &values, six(1))?,
            panel("β₃", &values, six(2))?,
            panel("β₄", &values, six(3))?,
            panel("β₅", &values, six(4))?,
            panel("β₆", &values, six(5))?,
            panel("δ of Zhu and Wang", &[("−0.1", -0.1), ("0", 0.0), ("0.1 /V", 0.1)], delta)?,
        ],
    ))
}
