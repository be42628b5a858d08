"""The joint fit of both blocks in numpy, scipy and numba: the same model, cost, Jacobian and starts as ours.

y = offset + G(s) e^(-s delay) * (sum c_i u^i - alpha zeta) for each record, zeta the Bouc-Wen operator of
alpha = 1, n = 1, stepped in closed form; G = c0 / (s^order2 + c1 s^order1 + c0) on s = sigma + i omega
(damped Fourier inversion). Offsets, c_i and alpha are eliminated by linear least squares at every candidate
(variable projection), the Jacobian is Kaufman's with exact derivatives: those of zeta come out of its pass,
those of G in the frequency domain.
"""

import os
import time

import numba
import numpy as np
import scipy.fft
import scipy.linalg
import scipy.signal
from scipy.optimize import differential_evolution, least_squares

WORKERS = os.cpu_count()


@numba.njit(fastmath=True, inline="always")
def _relax(kappa, d):
    """e^(-kappa d), (1 - e^(-kappa d))/kappa and its derivative in kappa."""
    x = kappa * d
    if abs(x) < 0.05:
        g = 1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6 * (1 - x / 7 * (1 - x / 8))))))
        slope = -1 / 2 + x * (1 / 3 - x * (1 / 8 - x * (1 / 30 - x * (1 / 144 - x * (1 / 840 - x / 5760)))))
        return 1 - x * g, d * g, d * d * slope
    e = np.exp(-x)
    reach = (1 - e) / kappa
    return e, reach, (d * e - reach) / kappa


@numba.njit(fastmath=True)
def hysteresis(u, every, beta, gamma, start, derivatives, zeta, d_beta, d_gamma, d_start):
    """zeta at every so many samples and, if asked for, its derivatives in beta, gamma and its start."""
    z, zb, zg, zs = start, 0.0, 0.0, 1.0
    last = u[0]
    for k in range(len(u)):
        du = u[k] - last
        last = u[k]
        d = abs(du)
        if d > 0.0:
            s = 1.0 if du > 0.0 else -1.0
            w = s * z
            if w < 0.0:
                kappa = beta - gamma
                left = 1.0 - kappa * w
                if abs(kappa) > 1e-12:
                    to_zero = np.log(left) / kappa if left > 0.0 else np.inf
                else:
                    to_zero = -w
                if d > to_zero:
                    # Through zero: what follows starts there, with what is left of the move.
                    by_w = -1.0 / left
                    by_kappa = (-w / left - to_zero) / kappa if abs(kappa) > 1e-6 else 0.5 * w * w
                    e, reach, slope = _relax(beta + gamma, d - to_zero)
                    z = s * reach
                    if derivatives:
                        zb = s * (slope - e * (by_kappa + by_w * s * zb))
                        zg = s * (slope - e * (-by_kappa + by_w * s * zg))
                        zs = -e * by_w * zs
                else:
                    e, reach, slope = _relax(kappa, d)
                    own = slope - d * e * w
                    z = s * (w * e + reach)
                    if derivatives:
                        zb, zg, zs = e * zb + s * own, e * zg - s * own, e * zs
            else:
                e, reach, slope = _relax(beta + gamma, d)
                own = slope - d * e * w
                z = s * (w * e + reach)
                if derivatives:
                    zb, zg, zs = e * zb + s * own, e * zg + s * own, e * zs
        if k % every == 0:
            j = k // every
            zeta[j] = z
            if derivatives:
                d_beta[j], d_gamma[j], d_start[j] = zb, zg, zs


@numba.njit(fastmath=True)
def _means(fine, out):
    """Polygon with the means of the curve whose samples, twice as fine, are given."""
    before = 0.0
    n = len(out)
    for k in range(n):
        bulge = 0.0
        if k < n - 1:
            bulge = (fine[2 * k + 1] - 0.5 * (fine[2 * k] + fine[2 * k + 2])) / 1.5
        out[k] = fine[2 * k] + 0.5 * (before + bulge)
        before = bulge


@numba.njit(fastmath=True)
def _response(log_s, s, join, c0, c1, order2, order1, delay, out):
    for i in range(len(log_s)):
        a, t = log_s[i].real, log_s[i].imag
        m2, m1 = np.exp(order2 * a), c1 * np.exp(order1 * a)
        re = c0 + m2 * np.cos(order2 * t) + m1 * np.cos(order1 * t)
        im = m2 * np.sin(order2 * t) + m1 * np.sin(order1 * t)
        size, turn = np.exp(-delay * s[i].real) * c0 / (re * re + im * im), -delay * s[i].imag
        out[i] = complex(re, -im) * complex(size * np.cos(turn), size * np.sin(turn)) * join[i]


@numba.njit(fastmath=True)
def _tangents(log_s, s, join, f, damping, c0, c1, order2, order1, delay, total, out):
    """Derivatives of the response in natural frequency, damping, order2, order1 and delay, times a
    spectrum."""
    ln_omega = np.log(2.0 * np.pi * f)
    for i in range(len(log_s)):
        a, t = log_s[i].real, log_s[i].imag
        m2, m1 = np.exp(order2 * a), c1 * np.exp(order1 * a)
        s2 = complex(m2 * np.cos(order2 * t), m2 * np.sin(order2 * t))
        s1 = complex(m1 * np.cos(order1 * t), m1 * np.sin(order1 * t))
        d = s2 + s1 + c0
        g = c0 / d
        size, turn = np.exp(-delay * s[i].real), -delay * s[i].imag
        weight = complex(size * np.cos(turn), size * np.sin(turn)) * join[i] * total[i]
        per = weight / d
        out[0, i] = (order2 * c0 - g * ((order2 - order1) * s1 + order2 * c0)) / f * per
        out[1, i] = -g * s1 / damping * per
        out[2, i] = (c0 * ln_omega - g * (log_s[i] * s2 + ln_omega * (s1 + c0))) * per
        out[3, i] = -g * (log_s[i] - ln_omega) * s1 * per
        out[4, i] = -s[i] * g * weight


def _even_fast_length(n):
    while n % 2 or scipy.fft.next_fast_len(n, real=True) != n:
        n += 1
    return n


def thinned(y, factor):
    """Every so many samples behind the low-pass that this needs."""
    if factor == 1:
        return y
    reach = 8.0 * factor / 0.6
    j = np.arange(-int(reach), int(reach) + 1)
    kernel = np.sinc(0.6 * j / factor) * np.i0(9.0 * np.sqrt(1.0 - (j / reach) ** 2))
    edge = len(kernel) // 2
    padded = np.concatenate([2 * y[0] - y[edge:0:-1], y, 2 * y[-1] - y[-2 : -edge - 2 : -1]])
    return scipy.signal.oaconvolve(padded, kernel / kernel.sum(), mode="valid")[::factor]


class Record:
    """Everything that does not depend on the candidate: drive, spectra of its powers, s, buffers."""

    def __init__(self, u, y, rate_hz, weight, degree, factor):
        self.factor, self.weight = factor, weight
        y = thinned(y, factor)
        n = self.samples = len(y)
        # At full rate the operator's output is joined by straight lines that keep its means: it runs twice as
        # fine.
        self.drive = np.interp(np.arange(2 * n - 1) / 2, np.arange(n), u) if factor == 1 else u
        self.every = max(factor, 1)
        target = weight * y
        self.target = target - target.mean()
        length = self.length = _even_fast_length(max(2 * n, 256))
        damping = np.log(1e10) / length
        x = damping + 2j * np.pi * np.arange(length // 2 + 1) / length
        self.s = x * rate_hz / factor
        self.log_s = np.log(self.s)
        self.join = (np.sinh(0.5 * x) / (0.5 * x)) ** 2 if factor == 1 else np.ones_like(x)
        self.decay = np.exp(-damping * np.arange(n))
        self.growth = np.exp(damping * np.arange(n)) * weight
        count = min(length - n, n)
        j = np.arange(1, count)
        self.fade = (0.5 + 0.5 * np.cos(np.pi * j / count)) * np.exp(-damping * (n - 1 + j))
        powers = [self.coarse(self.drive**p - self.drive[0] ** p) for p in range(1, degree + 1)]
        self.powers = self.transform(np.stack(powers))
        fine = len(self.drive) if factor == 1 else n
        self.passes = np.zeros((4, fine))
        self.signals = np.empty((4, n))
        self.response = np.empty_like(self.s)
        self.tangents = np.empty((5, len(self.s)), dtype=complex)

    def coarse(self, fine):
        if self.factor > 1:
            return fine[:: self.factor]
        out = np.empty(self.samples)
        _means(fine, out)
        return out

    def transform(self, signals):
        """Damped, continued past the end by reflection and fading, transformed."""
        n = self.samples
        time = np.zeros((len(signals), self.length))
        np.multiply(signals, self.decay, out=time[:, :n])
        fade = len(self.fade)
        time[:, n : n + fade] = (2 * signals[:, -1:] - signals[:, n - 2 :: -1][:, :fade]) * self.fade
        return scipy.fft.rfft(time, workers=WORKERS, overwrite_x=True)

    def invert(self, spectra):
        """Weighted signals without their means: the offset of the record is eliminated."""
        out = scipy.fft.irfft(spectra, self.length, workers=WORKERS, overwrite_x=True)
        out = out[:, : self.samples] * self.growth
        out -= out.mean(axis=1, keepdims=True)
        return out

    def zeta(self, p, memory, derivatives):
        """The operator's output, as its input to the dynamics, and its derivatives."""
        every = 1 if self.factor == 1 else self.factor
        hysteresis(self.drive, every, p["beta"], p["gamma"], memory, derivatives, *self.passes)
        count = 4 if derivatives else 1
        for i in range(count):
            if self.factor == 1:
                _means(self.passes[i], self.signals[i])
            else:
                self.signals[i] = self.passes[i]
        signals = -self.signals[:count]
        signals[0] += memory
        if derivatives:
            signals[3] += 1.0
        return signals

    def respond(self, p):
        c0, c1 = coefficients(p)
        _response(self.log_s, self.s, self.join, c0, c1, p["order2"], p["order1"], p["delay"], self.response)


def coefficients(p):
    omega = 2.0 * np.pi * p["natural_frequency"]
    return omega ** p["order2"], 2.0 * p["damping"] * omega ** (p["order2"] - p["order1"])


FORM = ("natural_frequency", "damping", "order2", "order1", "delay")


class Joint:
    """The least-squares problem on the unit box."""

    def __init__(self, records, ranges, rate_hz, degree):
        self.records = [Record(r["u"], r["y"], rate_hz, r["weight"], degree, r["factor"]) for r in records]
        self.names = [r["name"] for r in ranges]
        self.low, self.high = (np.array([r[end] for r in ranges]) for end in ("low", "high"))
        self.logarithmic = np.array([r["logarithmic"] for r in ranges])
        self.edges = np.cumsum([0] + [r.samples for r in self.records])
        self.target = np.concatenate([r.target for r in self.records])
        self.evaluations = self.jacobians = 0
        self.kept = None

    def to_unit(self, x):
        low, high, x = (
            np.where(self.logarithmic, np.log(np.abs(a) + (a == 0)), a)
            for a in (self.low, self.high, np.array(x))
        )
        return np.clip((x - low) / (high - low), 0.0, 1.0)

    def from_unit(self, t):
        lin = self.low + (self.high - self.low) * t
        with np.errstate(all="ignore"):
            log = self.low * (self.high / self.low) ** t
        return np.where(self.logarithmic, log, lin)

    def parameters(self, t):
        return dict(zip(self.names, self.from_unit(t)))

    def columns(self, t, derivatives):
        p = self.parameters(t)
        columns, inputs = [], []
        for i, record in enumerate(self.records):
            record.respond(p)
            zeta = record.transform(record.zeta(p, p[f"memory_{i + 1}"], derivatives))
            inputs.append(zeta)
            columns.append(record.invert(np.concatenate([record.powers, zeta[:1]]) * record.response))
        q, r = scipy.linalg.qr(np.concatenate(columns, axis=1).T, mode="economic", check_finite=False)
        share = q.T @ self.target
        return p, inputs, q, scipy.linalg.solve_triangular(r, share), self.target - q @ share

    def residuals(self, t):
        self.evaluations += 1
        return self.columns(t, False)[4]

    def cost(self, t):
        r = self.residuals(t)
        return np.sqrt(r @ r / len(r))

    def jacobian(self, t):
        self.jacobians += 1
        p, inputs, q, c, _ = self.columns(t, True)
        out = np.zeros((len(self.names), len(self.target)))
        at = {name: i for i, name in enumerate(self.names)}
        c0, c1 = coefficients(p)
        for i, (record, zeta) in enumerate(zip(self.records, inputs)):
            rows = slice(self.edges[i], self.edges[i + 1])
            total = c[:-1] @ record.powers + c[-1] * zeta[0]
            _tangents(
                record.log_s, record.s, record.join, p["natural_frequency"], p["damping"], c0, c1,
                p["order2"], p["order1"], p["delay"], total, record.tangents,
            )
            shape = zeta[1:] * (c[-1] * record.response)
            found = record.invert(np.concatenate([shape, record.tangents]))
            for name, column in zip(("beta", "gamma", f"memory_{i + 1}", *FORM), found):
                out[at[name], rows] = column
        out -= (out @ q) @ q.T
        ratio = np.where(self.logarithmic, self.high / np.where(self.low == 0, 1, self.low), 1)
        slope = np.where(self.logarithmic, self.from_unit(t) * np.log(ratio), self.high - self.low)
        return -(out * slope[:, None]).T

    def fit(self, starts):
        """Best of bounded trust-region fits from these starts."""
        best = None
        for start in starts:
            found = least_squares(
                self.residuals, start, jac=self.jacobian, bounds=(0.0, 1.0), method="trf", x_scale="jac",
                ftol=1e-10, xtol=1e-10, gtol=1e-12, max_nfev=100,
            )
            if best is None or found.cost < best.cost:
                best = found
        return best


class Plain:
    """All parameters in the search, one simulation an evaluation: what a plain user hands to differential
    evolution."""

    def __init__(self, joint, slope, largest_v, range_um):
        self.joint = joint
        degree = joint.records[0].powers.shape[0]
        low, high = joint.low, joint.high
        most = [4.0 * slope / largest_v**p for p in range(degree)]
        most += [2.0 * slope] + [range_um] * len(joint.records)
        self.bounds = list(zip(joint.to_unit(low), joint.to_unit(high))) + [(-m, m) for m in most]
        self.edge = len(joint.names)
        self.degree = degree

    def cost(self, x):
        joint = self.joint
        p = joint.parameters(x[: self.edge])
        c, offsets = x[self.edge : self.edge + self.degree + 1], x[self.edge + self.degree + 1 :]
        square = 0.0
        for i, record in enumerate(joint.records):
            record.respond(p)
            zeta = record.transform(record.zeta(p, p[f"memory_{i + 1}"], False))
            spectrum = (c[:-1] @ record.powers + c[-1] * zeta[0]) * record.response
            y = record.invert(spectrum[None])[0]
            # Means were taken off; the offset about them is as free as any.
            r = record.target - y - record.weight * offsets[i]
            square += r @ r
        cost = np.sqrt(square / len(joint.target))
        return cost if np.isfinite(cost) else np.inf


class OutOfTime(Exception):
    pass


def evolve(cost, bounds, seconds, popsize=15, seed=1):
    """scipy's differential evolution for so long: evaluations done, time they took, best cost. Its own
    population size is popsize x dimension; a whole run of 150 generations has 151 times that many
    evaluations."""
    done = {"evaluations": 0, "cost": np.inf}
    start, start_cpu = time.perf_counter(), time.process_time()

    def counted(x):
        if time.perf_counter() - start > seconds:
            raise OutOfTime
        value = cost(x)
        done["evaluations"] += 1
        done["cost"] = min(done["cost"], value)
        return value

    try:
        differential_evolution(counted, bounds, popsize=popsize, maxiter=150, tol=0.0, polish=False, rng=seed)
    except OutOfTime:
        pass
    done["seconds"], done["cpu_s"] = time.perf_counter() - start, time.process_time() - start_cpu
    done["dimension"] = len(bounds)
    done["whole_run"] = 151 * popsize * len(bounds)
    return done
