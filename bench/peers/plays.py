"""Plays with fractional dynamics, fitted in numpy and scipy: by a plain user, and by the algorithm of ours.

y = offset + H * (sum c_i (u^i - u_0^i) + sum w_k (P_k - P_k(0))) for each record, P_k the play of half-width
r_k from the memory given, w_k >= 0, and

H(s) = (1 + k_c (s/w_c)^-mu) e^(-sT) / (b_2 (s/w_0)^q_2 + b_1 (s/w_0)^q_1 + 1)

on s = sigma + i omega (damped Fourier inversion, a linear convolution without wrap-around). Seven numbers of
the dynamics are searched: ln b_2, q_2, ln b_1, q_1, T, ln k_c, mu.

`plain`: scipy's least_squares over the seven, with its own finite differences, on all samples; c_i and w_k by
scipy's nnls at every candidate, on the triangular factor of the columns.

`gauss_newton`: records low-passed and decimated once to the band in which they carry information; joint
Gauss-Newton steps on c_i, w_k and the seven, with exact derivatives and the bounds on w_k, from the Gram
matrix of columns and derivatives; at the end c_i, w_k and offsets once more from all samples.
"""

import os
from dataclasses import dataclass

import numpy as np
import scipy.fft
import scipy.linalg
from scipy.optimize import least_squares, nnls

WORKERS = os.cpu_count()
# w_0 and w_c lie within the data: coefficients of the same size, little correlated with their orders.
REFERENCE, CREEP_REFERENCE = 2.0 * np.pi * 300.0, 2.0 * np.pi * 3.0
# The delay is searched in ms, so that all seven have steps of about the same size.
DELAY_UNIT_S = 1e-3
LOW = np.array([-20.0, 1.2, -20.0, 0.02, -1.0, -20.0, 0.01])
HIGH = np.array([20.0, 2.6, 20.0, 1.6, 10.0, 5.0, 0.95])
LARGEST_STEP = np.array([1.0, 0.3, 1.0, 0.3, 0.3, 1.0, 0.1])
SMALLEST_STEP, SMALLEST_FALL = 1e-5, 1e-8
FADE_S = 0.15
LEAD, UNSCORED = 48, 24
ATTENUATION = 1e-10
# Added to the unit diagonal of a Gram matrix: plays of neighbouring half-widths are nearly dependent.
RIDGE = 1e-13


@dataclass
class Structure:
    """What is given: half-widths of the plays [V] and the degree of the polynomial."""

    thresholds: np.ndarray
    degree: int


@dataclass
class Record:
    """Drive, output, and the voltage at which the device was virgin before its first sample."""

    u: np.ndarray
    y: np.ndarray
    memory_v: float


@dataclass
class Solution:
    """What a fit ends with; the offset of each record is eliminated."""

    theta: np.ndarray
    polynomial: np.ndarray
    weights: np.ndarray
    rms: float
    evaluations: int
    jacobians: int


def uneven_thresholds(count, reach_v):
    """Half-widths below the reach, closer at the small end."""
    x = np.arange(1, count + 1) / (count + 1)
    return reach_v * (0.35 * x + 0.65 * x * x)


def rough_start(resonance_hz, damping):
    """A resonance of whole orders, a short delay, a little creep."""
    ratio = REFERENCE / (2.0 * np.pi * resonance_hz)
    return np.array([2.0 * np.log(ratio), 2.0, np.log(2.0 * damping * ratio), 1.0, 0.1, np.log(0.05), 0.2])


def play_columns(u, memory_v, thresholds):
    """Outputs of the plays, a monotone piece of the drive at a time."""
    r = thresholds[:, None]
    out = np.empty((len(thresholds), len(u)))
    state = np.clip(memory_v, u[0] - r, u[0] + r)
    rises = np.diff(u) >= 0.0
    turns = np.flatnonzero(rises[1:] != rises[:-1]) + 2
    for first, end in zip([0, *turns], [*turns, len(u)], strict=True):
        piece = u[first:end]
        rising = rises[max(first - 1, 0)]
        out[:, first:end] = np.maximum(state, piece - r) if rising else np.minimum(state, piece + r)
        state = out[:, end - 1 : end]
    return out


def columns(record, structure):
    """Everything that is linear in the parameters, ahead of the dynamics; 0 at the first sample."""
    u = record.u
    powers = np.cumprod(np.broadcast_to(u, (structure.degree, len(u))), axis=0)
    plays = play_columns(u, record.memory_v, structure.thresholds)
    signals = np.concatenate([powers, plays])
    signals -= signals[:, :1].copy()
    return signals


def continued(signals, count):
    """Point reflection at the last sample, faded to 0: neither a jump nor a corner at the end."""
    count = min(count, signals.shape[1] - 1)
    fade = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, count + 1) / (count + 1))
    beyond = 2.0 * signals[:, -1:] - signals[:, -2 : -count - 2 : -1]
    return np.concatenate([signals, beyond * fade], axis=1)


def response(theta, log_s, s):
    """H and the parts of it that its derivatives need."""
    ln_b2, q2, ln_b1, q1, delay, ln_creep, mu = theta
    log_0, log_c = log_s - np.log(REFERENCE), log_s - np.log(CREEP_REFERENCE)
    second, first = np.exp(ln_b2 + q2 * log_0), np.exp(ln_b1 + q1 * log_0)
    creep = np.exp(ln_creep - mu * log_c)
    denominator = second + first + 1.0
    h = (1.0 + creep) * np.exp(-delay * DELAY_UNIT_S * s) / denominator
    return h, (log_0, log_c, second / denominator, first / denominator, creep / (1.0 + creep))


def tangents(h, parts, s):
    """Derivatives of H in the seven numbers."""
    log_0, log_c, second, first, creep = parts
    return h * np.stack([
        -second, -second * log_0, -first, -first * log_0, -DELAY_UNIT_S * s, creep, -creep * log_c
    ])


class Convolution:
    """The columns of one record, transformed once, and their outputs for any H."""

    def __init__(self, inputs, target, rate_hz, scored, weight, least_length):
        self.scored, self.weight = scored, weight
        self.target = self.centred(target[None])[0]
        count = inputs.shape[1]
        length = self.length = scipy.fft.next_fast_len(max(least_length, count), real=True)
        damping = -np.log(ATTENUATION) / length
        self.s = (damping + 2j * np.pi * np.arange(length // 2 + 1) / length) * rate_hz
        self.log_s = np.log(self.s)
        self.growth = np.exp(damping * np.arange(length))[scored]
        self.spectra = scipy.fft.rfft(inputs / np.exp(damping * np.arange(count)), length, workers=WORKERS)

    def centred(self, signals):
        """Scored samples, weighted, without their mean: the offset of the record is eliminated."""
        kept = signals[:, self.scored]
        return self.weight * (kept - kept.mean(axis=1, keepdims=True))

    def invert(self, spectra):
        time = scipy.fft.irfft(spectra, self.length, workers=WORKERS, overwrite_x=True)[:, self.scored]
        time *= self.growth
        time -= time.mean(axis=1, keepdims=True)
        time *= self.weight
        return time

    def outputs(self, theta):
        self.last = response(theta, self.log_s, self.s)
        return self.invert(self.spectra * self.last[0])

    def derivatives(self, coefficients):
        """At the candidate of the last outputs."""
        return self.invert(tangents(*self.last, self.s) * (coefficients @ self.spectra))


def whole_record(record, inputs, rate_hz):
    """All samples."""
    inputs = continued(inputs, round(FADE_S * rate_hz))
    count = len(record.u)
    return Convolution(inputs, record.y, rate_hz, slice(0, count), 1.0, 2 * count)


def information_band(y, rate_hz):
    """Twice the frequency from which a record is little more than its noise [Hz]."""
    extended = continued((y - y[:20].mean())[None], round(FADE_S * rate_hz))
    length = scipy.fft.next_fast_len(2 * len(y), real=True)
    power = np.abs(scipy.fft.rfft(extended[0], length)) ** 2
    bins = max(3, round(length / rate_hz * 5.0))
    smooth = np.convolve(power, np.ones(bins) / bins, mode="same")
    floor = np.median(smooth[len(smooth) // 2 :])
    return 2.0 * np.argmax(smooth < 1.3 * floor) * rate_hz / length


def low_pass(signals, band_hz, rate_hz):
    """Signals low-passed to the band, two and a half samples per period of it; the lead in which the low-pass
    rises, in samples of the record, and the decimation factor."""
    count = signals.shape[1]
    lead = round(LEAD * rate_hz / (2.5 * band_hz))
    length = scipy.fft.next_fast_len(count + 2 * lead, real=True)
    short = even_fast_length(length * 2.5 * band_hz / rate_hz)
    placed = np.zeros((len(signals), length))
    placed[:, lead : lead + count] = signals
    spectra = scipy.fft.rfft(placed, workers=WORKERS, overwrite_x=True)[:, : short // 2 + 1]
    f = np.arange(short // 2 + 1) * rate_hz / length
    edge = np.clip((f / band_hz - 1.0) / 0.2, 0.0, 1.0)
    spectra *= (0.5 + 0.5 * np.cos(np.pi * edge)) * short / length
    return scipy.fft.irfft(spectra, short, workers=WORKERS, overwrite_x=True), lead, length / short


def even_fast_length(least):
    n = scipy.fft.next_fast_len(int(np.ceil(least)), real=True)
    while n % 2:
        n = scipy.fft.next_fast_len(n + 1, real=True)
    return n


def compressed_record(record, inputs, rate_hz):
    """The band that carries information, low-passed and decimated."""
    y = record.y
    band_hz = information_band(y, rate_hz)
    if 4.0 * band_hz > rate_hz:
        return whole_record(record, inputs, rate_hz)
    signals = np.concatenate([inputs, (y - y[:20].mean())[None]])
    extended = continued(signals, round(FADE_S * rate_hz))
    reduced, lead, factor = low_pass(extended, band_hz, rate_hz)
    scored = slice(0, int((lead + len(y)) / factor) - UNSCORED)
    least = 2 * reduced.shape[1] + 600
    return Convolution(reduced[:-1], reduced[-1], rate_hz / factor, scored, factor**0.5, least)


def bounded_solve(triangle, free):
    """Least squares from the triangular factor of [free columns, non-negative columns, target]: coefficients
    and the square of the residual. The free ones are eliminated by the triangle itself."""
    of_rest, of_target = triangle[:free, free:-1], triangle[:, -1]
    weights, norm = nnls(triangle[free:-1, free:-1], of_target[free:-1], maxiter=50 * triangle.shape[1])
    others = scipy.linalg.solve_triangular(triangle[:free, :free], of_target[:free] - of_rest @ weights)
    return np.concatenate([others, weights]), norm**2 + of_target[-1] ** 2


def triangle_of(gram):
    """Cholesky factor, of a diagonal scaled to 1 and the scale put back."""
    scale = np.sqrt(np.diag(gram))
    unit = gram / np.outer(scale, scale) + RIDGE * np.eye(len(gram))
    return scipy.linalg.cholesky(unit) * scale


class Whole:
    """The problem on all samples."""

    def __init__(self, records, inputs, rate_hz, degree):
        self.degree = degree
        pairs = zip(records, inputs, strict=True)
        self.records = [whole_record(record, own, rate_hz) for record, own in pairs]
        self.target = np.concatenate([record.target for record in self.records])
        self.evaluations = 0

    def solve(self, theta):
        """Coefficients at this candidate and the residuals."""
        self.evaluations += 1
        outputs = np.concatenate([record.outputs(theta) for record in self.records], axis=1)
        table = np.concatenate([outputs, self.target[None]]).T
        triangle = scipy.linalg.qr(table, mode="r", check_finite=False)[0][: table.shape[1]]
        coefficients, _ = bounded_solve(triangle, self.degree)
        return coefficients, self.target - coefficients @ outputs

    def solution(self, theta, evaluations, jacobians):
        coefficients, residuals = self.solve(theta)
        rms = np.sqrt(np.mean(residuals**2))
        return Solution(
            theta, coefficients[: self.degree], coefficients[self.degree :], float(rms), evaluations,
            jacobians,
        )


def plain(records, rate_hz, structure, start):
    """least_squares and nnls on all samples."""
    inputs = [columns(record, structure) for record in records]
    problem = Whole(records, inputs, rate_hz, structure.degree)
    found = least_squares(
        lambda theta: problem.solve(theta)[1], start, bounds=(LOW, HIGH), x_scale="jac",
        ftol=1e-8, xtol=1e-8, gtol=1e-12, max_nfev=100,
    )
    return problem.solution(found.x, problem.evaluations, int(found.njev))


@dataclass
class Point:
    """A candidate of the compressed problem, its coefficients eliminated."""

    theta: np.ndarray
    outputs: list
    gram: np.ndarray
    coefficients: np.ndarray
    cost: float


class Compressed:
    """The problem on compressed records, through Gram matrices alone."""

    def __init__(self, records, inputs, rate_hz, degree):
        self.degree = degree
        pairs = zip(records, inputs, strict=True)
        self.records = [compressed_record(record, own, rate_hz) for record, own in pairs]
        self.evaluations = self.jacobians = 0

    def point(self, theta):
        self.evaluations += 1
        tables = [np.concatenate([r.outputs(theta), r.target[None]]) for r in self.records]
        gram = sum(table @ table.T for table in tables)
        coefficients, cost = bounded_solve(triangle_of(gram), self.degree)
        return Point(theta, tables, gram, coefficients, cost)

    def with_tangents(self, point):
        """Gram matrix of [derivatives, columns, target] at the point evaluated last."""
        self.jacobians += 1
        across, own = 0.0, 0.0
        for record, table in zip(self.records, point.outputs, strict=True):
            slopes = record.derivatives(point.coefficients)
            across, own = across + slopes @ table.T, own + slopes @ slopes.T
        return np.block([[own, across], [across.T, point.gram]])


def better(problem, point, gram, damping):
    """The first step that lowers the cost, more and more damped; the point it leads to, the step, and the
    damping it took. No point where there is none."""
    count = len(point.theta)
    diagonal = np.zeros(len(gram))
    diagonal[:count] = np.diag(gram)[:count]
    while damping < 1e8:
        triangle = triangle_of(gram + np.diag(damping * diagonal))
        step = bounded_solve(triangle, count + problem.degree)[0][:count]
        theta = np.clip(point.theta + np.clip(step, -LARGEST_STEP, LARGEST_STEP), LOW, HIGH)
        trial = problem.point(theta)
        largest = np.abs(theta - point.theta).max()
        if trial.cost < point.cost:
            return trial, largest, damping
        if largest < SMALLEST_STEP:
            break
        damping *= 10.0
    return None, 0.0, damping


def fit_compressed(problem, theta, damping=1e-3):
    """Joint Gauss-Newton steps, damped on the seven numbers alone."""
    point = problem.point(theta)
    for _ in range(60):
        trial, largest, damping = better(problem, point, problem.with_tangents(point), damping)
        if trial is None:
            break
        fall = 1.0 - trial.cost / point.cost
        point, damping = trial, damping / 6.0
        if largest < SMALLEST_STEP or fall < SMALLEST_FALL:
            break
    return point.theta


def gauss_newton(records, rate_hz, structure, start):
    """The algorithm of ours for one given structure."""
    inputs = [columns(record, structure) for record in records]
    reduced = Compressed(records, inputs, rate_hz, structure.degree)
    theta = fit_compressed(reduced, start)
    whole = Whole(records, inputs, rate_hz, structure.degree)
    return whole.solution(theta, reduced.evaluations, reduced.jacobians)
