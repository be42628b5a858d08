//! Hysteresis of many sorts, input 0 to 1, each a small simulator of its own.

use super::draw::Draw;

/// A sort of device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sort {
    // Those on which the factor of the band was set.
    GeneralisedPlays,
    TwoBoucWen,
    Preisach,
    RateDependentPlays,
    // Those that are scored.
    AsymmetricPlays,
    CreepingPlays,
    Duhem,
    JilesAtherton,
    DeadZonePlays,
    BentPlays,
    MovingPreisach,
    NonSymmetricBoucWen,
    // In the class of Bouc–Wen models.
    BoucWen,
}

impl Sort {
    pub const SET_ON: [Self; 4] =
        [Self::GeneralisedPlays, Self::TwoBoucWen, Self::Preisach, Self::RateDependentPlays];
    pub const SCORED: [Self; 8] = [
        Self::AsymmetricPlays,
        Self::CreepingPlays,
        Self::Duhem,
        Self::JilesAtherton,
        Self::DeadZonePlays,
        Self::BentPlays,
        Self::MovingPreisach,
        Self::NonSymmetricBoucWen,
    ];

    pub fn in_words(self) -> &'static str {
        match self {
            Self::GeneralisedPlays => "generalised plays",
            Self::TwoBoucWen => "two Bouc–Wen states",
            Self::Preisach => "Preisach",
            Self::RateDependentPlays => "rate-dependent plays",
            Self::AsymmetricPlays => "asymmetric bias-dependent plays",
            Self::CreepingPlays => "plays with creep inside",
            Self::Duhem => "Duhem",
            Self::JilesAtherton => "Jiles–Atherton",
            Self::DeadZonePlays => "plays and dead zones",
            Self::BentPlays => "plays, output bent",
            Self::MovingPreisach => "moving Preisach",
            Self::NonSymmetricBoucWen => "non-symmetric Bouc–Wen",
            Self::BoucWen => "Bouc–Wen, in the class",
        }
    }
}

/// Plays in a device.
const PLAYS: usize = 30;
/// Thresholds of relays a side.
const RELAYS: usize = 24;

/// A play: half-widths up and down, weight and its slopes with the play's position, state.
#[derive(Clone, Copy, Default)]
struct Play {
    rising: f64,
    falling: f64,
    weight: f64,
    bend: [f64; 2],
    state: f64,
}

impl Play {
    fn follow(&mut self, u: f64, widths: f64) {
        self.state = self
            .state
            .clamp(u - self.rising * widths, (u + self.falling * widths).max(u - self.rising * widths));
    }

    /// ∫ weight (1 + bend₀ p + bend₁ p²) dp.
    fn value(&self) -> f64 {
        let p = self.state;
        self.weight * (p + self.bend[0] * p * p / 2.0 + self.bend[1] * p * p * p / 3.0)
    }
}

/// A sort with its numbers and its state.
pub struct Hysteresis {
    sort: Sort,
    plays: Vec<Play>,
    relays: Vec<[f64; 4]>,
    /// Numbers by sort.
    p: [f64; 8],
    polynomial: [f64; 3],
    z: [f64; 2],
    u: f64,
    fresh: bool,
}

impl Hysteresis {
    pub fn at_random(sort: Sort, draw: &mut Draw) -> Self {
        let mut own = Self {
            sort,
            plays: Vec::new(),
            relays: Vec::new(),
            p: [0.0; 8],
            polynomial: [draw.between(0.8, 1.2), draw.between(-0.2, 0.3), draw.between(-0.15, 0.15)],
            z: [0.0; 2],
            u: 0.0,
            fresh: true,
        };
        let share = draw.between(0.15, 0.5);
        match sort {
            Sort::GeneralisedPlays | Sort::RateDependentPlays | Sort::CreepingPlays => {
                own.plays = plays(draw, share, 0.1, 0.4);
            }
            Sort::AsymmetricPlays => own.plays = plays(draw, share, 0.35, 1.2),
            Sort::DeadZonePlays | Sort::BentPlays => own.plays = plays(draw, share, 0.1, 0.0),
            Sort::Preisach | Sort::MovingPreisach => own.relays = relays(draw, share),
            _ => {}
        }
        own.p = match sort {
            Sort::GeneralisedPlays => [
                draw.between(1.0, 3.0),
                draw.between(-0.3, 0.3),
                draw.between(1.0, 3.0),
                draw.between(-0.3, 0.3),
                0.0,
                0.0,
                0.0,
                0.0,
            ],
            Sort::TwoBoucWen => [
                share * draw.between(0.1, 0.25),
                draw.between(8.0, 20.0),
                draw.between(-4.0, 4.0),
                share * draw.between(0.1, 0.25),
                draw.between(1.5, 5.0),
                draw.between(-1.0, 1.0),
                0.0,
                0.0,
            ],
            Sort::RateDependentPlays => [draw.between(0.02, 0.12), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            Sort::CreepingPlays => {
                [draw.between(0.02, 0.4), draw.between(0.01, 0.04), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
            }
            Sort::Duhem => [
                draw.between(2.0, 7.0),
                draw.between(0.1, 0.3),
                draw.between(1.0, 3.0),
                draw.between(0.3, 0.7),
                0.0,
                0.0,
                0.0,
                0.0,
            ],
            Sort::JilesAtherton => [
                draw.between(0.15, 0.35),
                draw.between(0.0, 0.15),
                draw.between(0.04, 0.15),
                draw.between(0.1, 0.4),
                draw.between(0.3, 0.8),
                0.0,
                0.0,
                0.0,
            ],
            Sort::BentPlays => {
                [draw.between(0.3, 1.1), draw.between(-0.3, 0.3), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
            }
            Sort::MovingPreisach => [draw.between(-0.25, 0.25), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            Sort::NonSymmetricBoucWen => [
                0.3 * share,
                draw.between(2.0, 8.0),
                draw.between(-1.5, 1.5),
                draw.between(1.2, 2.2),
                draw.between(-0.6, 0.6),
                0.0,
                0.0,
                0.0,
            ],
            Sort::BoucWen => {
                [0.3 * share, draw.between(2.0, 8.0), draw.between(-1.5, 1.5), 1.0, 0.0, 0.0, 0.0, 0.0]
            }
            _ => [0.0; 8],
        };
        own
    }

    /// Output at the drive `u`, `dt` seconds after the last.
    pub fn step(&mut self, u: f64, dt: f64) -> f64 {
        if self.fresh {
            self.rest(u);
        }
        let du = u - self.u;
        self.u = u;
        let memory = self.memory(u, du, dt);
        let [a, b, c] = self.polynomial;
        match self.sort {
            Sort::Duhem | Sort::JilesAtherton => 0.6 * a * u + memory,
            Sort::BentPlays => {
                let v = u + memory;
                v + self.p[1] * v * v + self.p[0] * (1.5 * (v - 0.6)).tanh()
            }
            _ => a * u + b * u * u + c * u * u * u + memory,
        }
    }

    /// A virgin device at `u`.
    fn rest(&mut self, u: f64) {
        self.fresh = false;
        self.u = u;
        for play in &mut self.plays {
            play.state = u;
        }
        for relay in &mut self.relays {
            relay[3] = ((u - relay[0]) * RELAYS as f64).clamp(0.0, 1.0);
        }
    }

    fn memory(&mut self, u: f64, du: f64, dt: f64) -> f64 {
        let p = self.p;
        match self.sort {
            Sort::GeneralisedPlays => {
                let rising = envelope(u, p[0], p[1]);
                let falling = envelope(u, p[2], p[3]);
                self.plays.iter_mut().fold(0.0, |sum, play| {
                    let (low, high) = (rising - play.rising, falling + play.falling);
                    play.state = play.state.max(low).min(high.max(low));
                    sum + play.value()
                })
            }
            Sort::RateDependentPlays => {
                // Rate over a second's swing; the filter makes it smooth.
                let rate = (du / dt).abs();
                self.z[0] += (rate - self.z[0]) * (dt / 0.002).min(1.0);
                let widths = 1.0 + p[0] * (1.0 + self.z[0]).ln();
                self.sum(u, widths)
            }
            Sort::CreepingPlays => {
                let (time_s, width) = (p[0], p[1]);
                self.plays.iter_mut().fold(0.0, |sum, play| {
                    let (low, high) = (u - play.rising, u + play.falling);
                    // The edge gives way within `width`, the rest follows in `time_s`.
                    let beyond = (low - play.state).max(0.0) - (play.state - high).max(0.0);
                    let kept = beyond.clamp(-width, width);
                    play.state += (beyond - kept) + kept * (1.0 - (-dt / time_s).exp());
                    sum + play.value()
                })
            }
            Sort::DeadZonePlays => {
                let memory = self.sum(u, 1.0);
                let zone = |edge: f64| (u + memory - edge).max(0.0);
                memory + 0.3 * zone(0.35) - 0.4 * zone(0.8)
            }
            Sort::Preisach => self.relayed(u),
            Sort::MovingPreisach => {
                let moved = u + p[0] * self.z[0];
                self.z[0] = self.relayed(moved);
                self.z[0]
            }
            Sort::TwoBoucWen => {
                for (k, z) in self.z.iter_mut().enumerate() {
                    *z = bouc_wen(*z, du, (p[3 * k + 1], p[3 * k + 2], 1.0, 0.0));
                }
                p[0] * p[1] * self.z[0] + p[3] * p[4] * self.z[1]
            }
            Sort::NonSymmetricBoucWen | Sort::BoucWen => {
                self.z[0] = bouc_wen(self.z[0], du, (p[1], p[2], p[3], p[4]));
                p[0] * p[1] * self.z[0]
            }
            Sort::Duhem => {
                let aim = p[1] * (p[2] * (u - p[3])).tanh();
                self.z[0] += p[0] * du.abs() * (aim - self.z[0]) + 0.1 * du;
                self.z[0]
            }
            Sort::JilesAtherton => self.jiles_atherton(2.0 * u - 1.0, 2.0 * du),
            Sort::AsymmetricPlays | Sort::BentPlays => self.sum(u, 1.0),
        }
    }

    fn sum(&mut self, u: f64, widths: f64) -> f64 {
        self.plays.iter_mut().fold(0.0, |sum, play| {
            play.follow(u, widths);
            sum + play.value()
        })
    }

    /// Relays that turn over a distance, so that their sum is smooth.
    fn relayed(&mut self, u: f64) -> f64 {
        let turned = |x: f64| (x * RELAYS as f64).clamp(0.0, 1.0);
        self.relays.iter_mut().fold(0.0, |sum, [up, down, weight, state]| {
            let low = turned(u - *up);
            *state = state.max(low).min(turned(u - *down + 1.0 / RELAYS as f64).max(low));
            sum + *weight * *state
        })
    }

    /// dM/dH of Jiles and Atherton (1986, doi:10.1016/0304-8853(86)90066-1), reversible share p₃.
    fn jiles_atherton(&mut self, h: f64, dh: f64) -> f64 {
        let [a, alpha, k, c, gain, ..] = self.p;
        let steps = ((dh.abs() / 2e-4).ceil()).max(1.0);
        let dh = dh / steps;
        let mut field = h - dh * steps;
        for _ in 0..steps as usize {
            field += dh;
            let x = (field + alpha * self.z[0]) / a;
            let anhysteretic = if x.abs() < 1e-3 { x / 3.0 } else { 1.0 / x.tanh() - 1.0 / x };
            let slope = if x.abs() < 1e-3 { 1.0 / 3.0 } else { 1.0 / (x * x) - 1.0 / x.sinh().powi(2) } / a;
            let gap = anhysteretic - self.z[0];
            let sign = dh.signum();
            let irreversible = if gap * sign > 0.0 { gap / (k * sign - alpha * gap) } else { 0.0 };
            let rate = ((1.0 - c) * irreversible.clamp(0.0, 50.0) + c * slope) / (1.0 - alpha * c * slope);
            self.z[0] += rate * dh;
        }
        gain * self.z[0]
    }
}

fn envelope(u: f64, steepness: f64, bend: f64) -> f64 {
    u + 0.15 * ((steepness * (u - 0.5)).tanh() + bend * (u - 0.5))
}

/// Explicit midpoint step of ż = u̇ (1 − |z|ⁿ (β sign(u̇ z) + γ + δ sign u̇)) in z over its saturation 1/β.
fn bouc_wen(z: f64, du: f64, (beta, gamma, n, skew): (f64, f64, f64, f64)) -> f64 {
    let rate = |z: f64| {
        let power = (beta * z).abs().powf(n);
        du * (1.0 - power * ((du * z).signum() + gamma / beta + skew * du.signum() * 0.5))
    };
    let steps = ((du.abs() / 2e-3).ceil()).max(1.0);
    let mut z = z;
    for _ in 0..steps as usize {
        let middle = z + 0.5 * rate(z) / steps;
        z += rate(middle) / steps;
    }
    z
}

/// Plays of a random smooth density: asymmetric by `skew`, weights that bend by up to `bend` with the bias.
fn plays(draw: &mut Draw, share: f64, skew: f64, bend: f64) -> Vec<Play> {
    let reach = draw.between(0.3, 0.9);
    let (tone, phase, slope) = (draw.between(0.5, 2.0), draw.between(0.0, 6.0), draw.between(0.0, 1.2));
    let uneven = draw.between(-skew, skew);
    let mut plays: Vec<Play> = (0..PLAYS)
        .map(|k| {
            let x = (k as f64 + 0.5) / PLAYS as f64;
            let half = 0.5 * reach * x;
            let density = (1.3 - slope * x).max(0.1) * (1.0 + 0.6 * (6.0 * tone * x + phase).sin());
            Play {
                rising: half * (1.0 + uneven),
                falling: half * (1.0 - uneven),
                weight: density * draw.between(0.6, 1.4),
                bend: [draw.between(-bend, bend), draw.between(-bend, bend)],
                state: 0.0,
            }
        })
        .collect();
    let total: f64 = plays.iter().map(|play| play.weight).sum();
    plays.iter_mut().for_each(|play| play.weight *= 2.0 * share / total);
    plays
}

/// Relays (up, down, weight, state) on the triangle: two Gaussian hills along its edge and a flat ground.
fn relays(draw: &mut Draw, share: f64) -> Vec<[f64; 4]> {
    let hill = |draw: &mut Draw| {
        [
            draw.between(0.2, 0.8),
            draw.between(0.02, 0.3),
            draw.between(0.1, 0.35),
            draw.between(0.05, 0.2),
            draw.between(0.4, 1.0),
        ]
    };
    let hills = [hill(draw), hill(draw)];
    let ground = draw.between(0.02, 0.2);
    let at = |k: usize| -0.05 + 1.1 * (k as f64 + 0.5) / RELAYS as f64;
    let mut relays = Vec::new();
    for up in 0..RELAYS {
        for down in 0..=up {
            let (bias, width) = (0.5 * (at(up) + at(down)), at(up) - at(down));
            let of = |[b, w, sb, sw, height]: [f64; 5]| {
                height * (-0.5 * ((bias - b) / sb).powi(2) - 0.5 * ((width - w) / sw).powi(2)).exp()
            };
            relays.push([at(up), at(down), ground + of(hills[0]) + of(hills[1]), 0.0]);
        }
    }
    let total: f64 = relays.iter().map(|relay| relay[2]).sum();
    relays.iter_mut().for_each(|relay| relay[2] *= 2.0 * share / total);
    relays
}
