"""The two steps of the article's identification with scipy's differential evolution over numba and scipy.fft.

Same records, same search boxes, same number of evaluations: 50 members, 150 generations (and the first
population).
"""

import numpy as np
from scipy.optimize import differential_evolution

from . import bouc_wen, fractional


def from_unit(box, unit):
    """The box's units; logarithmic where a range says so."""
    out = np.empty(len(box))
    for i, (_, low, high, logarithmic) in enumerate(box):
        out[i] = low * (high / low) ** unit[i] if logarithmic else low + (high - low) * unit[i]
    return out


class Static:
    """y = offset + creep + sum c_i u^i - z, offset and creep eliminated; n = 1 in closed form."""

    def __init__(self, u, y, box):
        self.u, self.box = u, box
        t = np.arange(len(u)) / fractional.RATE_HZ
        nuisance = np.stack([np.ones_like(t), np.log1p(t)], axis=1)
        self.q, _ = np.linalg.qr(nuisance)
        self.y, self.linear, self.quadratic = (self.free(x) for x in (y, u, u * u))
        self.z = np.empty_like(u)
        self.names = [name for name, *_ in box]

    def free(self, x):
        return x - self.q @ (self.q.T @ x)

    def cost(self, unit):
        p = dict(zip(self.names, from_unit(self.box, unit)))
        if p["alpha"] == 0.0:
            return np.inf
        # alpha < 0 mirrors z: -z obeys the same law with -alpha and -gamma.
        sign = 1.0 if p["alpha"] > 0.0 else -1.0
        if p["beta"] + sign * p["gamma"] <= 0.0:
            return np.inf
        bouc_wen.exact_linear(self.u, abs(p["alpha"]), p["beta"], sign * p["gamma"], self.z)
        r = self.y - p["linear"] * self.linear - p["quadratic"] * self.quadratic + sign * self.free(self.z)
        cost = np.sqrt(r @ r / len(r))
        return cost if np.isfinite(cost) else np.inf


class Dynamic(fractional.Quadrature):
    """y = offset + gain · c0 / (s^order2 + c1 s^order1 + c0) v, offset eliminated; v the output of step 1."""

    def __init__(self, v, y, box):
        super().__init__(v - v[0])
        self.y = y - y.mean()
        self.box = box
        self.names = [name for name, *_ in box]

    def cost(self, unit):
        p = dict(zip(self.names, from_unit(self.box, unit)))
        o2, o1 = p["order2"], p["order1"]
        w = 2.0 * np.pi * p["natural_frequency"]
        c0, c1 = w**o2, 2.0 * p["damping"] * w ** (o2 - o1)
        if o2 - o1 < 0.02:
            return np.inf
        fractional._quotient(self.log_s, self.spectrum, c0 * p["gain"], 1.0, o2, c1, o1, c0, self.sum)
        x = fractional.scipy.fft.irfft(self.sum, self.length, workers=1, overwrite_x=True)[: self.samples]
        x *= self.growth
        x -= x.mean()
        r = self.y - x
        cost = np.sqrt(r @ r / len(r))
        return cost if np.isfinite(cost) else np.inf


def search(problem, generations, seed):
    """50 members, so many generations, one worker, no polish."""
    dimension = len(problem.box)
    return differential_evolution(
        problem.cost, [(0.0, 1.0)] * dimension, popsize=50 // dimension, maxiter=generations, tol=0.0,
        atol=0.0, polish=False, rng=seed, init="latinhypercube",
    )
