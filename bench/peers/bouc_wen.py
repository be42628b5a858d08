"""Bouc-Wen z' = alpha u' - beta |u'| z |z|^(n-1) - gamma u' |z|^n with numba, and a reference by scipy.

Every drive moves linearly between samples and turns only at samples, so all methods approximate the same
function.
"""

import numba
import numpy as np
from scipy.integrate import solve_ivp


@numba.njit(inline="always")
def _slope(z, s, alpha, beta, gamma, n):
    # dz/du, s = sign of du; the two common exponents without pow.
    a = abs(z)
    if n == 1.0:
        p = a
    elif n == 2.0:
        p = a * a
    else:
        p = a**n
    return alpha - beta * s * (p if z > 0.0 else -p) - gamma * p


@numba.njit(fastmath=True)
def euler(u, alpha, beta, gamma, n, substeps, z):
    """Explicit Euler with so many sub-steps a sample: what everybody codes."""
    state, last = 0.0, 0.0
    for k in range(len(u)):
        h = (u[k] - last) / substeps
        s = 1.0 if h > 0.0 else -1.0
        for _ in range(substeps):
            state += h * _slope(state, s, alpha, beta, gamma, n)
        last = u[k]
        z[k] = state


@numba.njit(fastmath=True)
def runge_kutta(u, alpha, beta, gamma, n, substeps, z):
    """The classical fourth-order method with so many sub-steps a sample."""
    state, last = 0.0, 0.0
    for k in range(len(u)):
        h = (u[k] - last) / substeps
        s = 1.0 if h > 0.0 else -1.0
        for _ in range(substeps):
            k1 = _slope(state, s, alpha, beta, gamma, n)
            k2 = _slope(state + 0.5 * h * k1, s, alpha, beta, gamma, n)
            k3 = _slope(state + 0.5 * h * k2, s, alpha, beta, gamma, n)
            k4 = _slope(state + h * k3, s, alpha, beta, gamma, n)
            state += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        last = u[k]
        z[k] = state


@numba.njit(fastmath=True)
def exact_linear(u, alpha, beta, gamma, z):
    """n = 1 in closed form (alpha > 0, beta + gamma > 0), split where z passes 0."""
    state, last = 0.0, 0.0
    for k in range(len(u)):
        du = u[k] - last
        last = u[k]
        d = abs(du)
        if d == 0.0:
            z[k] = state
            continue
        s = 1.0 if du > 0.0 else -1.0
        w = s * state
        # w' = alpha - kappa w along |u|; kappa = beta + gamma where w > 0, beta - gamma where w < 0.
        if w < 0.0:
            kappa = beta - gamma
            to_zero = np.log1p(-kappa * w / alpha) / kappa if kappa != 0.0 else -w / alpha
            if d <= to_zero:
                w = (
                    alpha / kappa + (w - alpha / kappa) * np.exp(-kappa * d)
                    if kappa != 0.0
                    else w + alpha * d
                )
                state = s * w
                z[k] = state
                continue
            w, d = 0.0, d - to_zero
        kappa = beta + gamma
        state = s * (alpha / kappa + (w - alpha / kappa) * np.exp(-kappa * d))
        z[k] = state


def reference(u, alpha, beta, gamma, n):
    """z at every sample by scipy's DOP853 in u, leg by leg between turning points, to 1e-12."""
    z = np.empty_like(u)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(u))) != 0) + 1
    edges = [0, *turns, len(u) - 1]
    state = 0.0
    z[0] = state
    for a, b in zip(edges[:-1], edges[1:]):
        s = np.sign(u[b] - u[a])

        def slope(_, z):
            p = abs(z) ** n
            return alpha - beta * s * np.sign(z) * p - gamma * p

        def crossing(_, z):
            return z[0]

        crossing.terminal = True
        at, wanted = u[a], u[a + 1 : b + 1]
        found = np.empty(0)
        # The equation has a corner at z = 0: a leg is integrated up to it and from it.
        while len(found) < len(wanted):
            rest = wanted[len(found) :]
            run = solve_ivp(
                slope, (at, rest[-1]), [state], method="DOP853", t_eval=rest, rtol=1e-12, atol=1e-13,
                events=crossing if state != 0.0 else None,
            )
            found = np.concatenate([found, run.y[0]])
            if run.status == 1:
                at, state = run.t_events[0][0], 0.0
            else:
                state = run.y[0][-1]
        z[a + 1 : b + 1] = found
        state = found[-1]
    return z
