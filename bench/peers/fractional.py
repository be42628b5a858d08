"""Eq. 13 over a record with numpy, scipy and numba: the best versions we can write.

G(s) = 5.2589e6 / (s^2.0384 + 3081 s^1.0523 + 5.4955e6), Tustin convolution quadrature:
s = 2 fs (1 - z)/(1 + z), z = r exp(-i theta), r^L = 1e-10, L >= 2 N. The recursion is Grünwald-Letnikov's.
"""

import numba
import numpy as np
import scipy.fft

RATE_HZ = 10_000.0
B = 5.2589e6
C0 = 5.4955e6
TERMS = ((1.0, 2.0384), (3081.0, 1.0523))


@numba.njit(fastmath=True)
def _quotient(log_s, spectrum, b, c2, o2, c1, o1, c0, out):
    for i in range(len(out)):
        a, t = log_s[i].real, log_s[i].imag
        m2, m1 = c2 * np.exp(o2 * a), c1 * np.exp(o1 * a)
        re = c0 + m2 * np.cos(o2 * t) + m1 * np.cos(o1 * t)
        im = m2 * np.sin(o2 * t) + m1 * np.sin(o1 * t)
        out[i] = spectrum[i] * complex(b * re, -b * im) / (re * re + im * im)


class Quadrature:
    """Everything that does not depend on the candidate is kept: log s, damping, input spectrum, buffers."""

    def __init__(self, u):
        n = len(u)
        self.samples = n
        self.length = scipy.fft.next_fast_len(2 * n, real=True)
        damping = -np.log(1e-10) / self.length
        k = np.arange(n)
        self.decay = np.exp(-damping * k)
        self.growth = np.exp(damping * k)
        theta = 2.0 * np.pi * np.arange(self.length // 2 + 1) / self.length
        z = np.exp(-damping - 1j * theta)
        self.log_s = np.log(2.0 * RATE_HZ * (1.0 - z) / (1.0 + z))
        self.padded = np.zeros(self.length)
        self.u = u
        self.spectrum = self.transform().copy()
        self.term = np.empty_like(self.log_s)
        self.sum = np.empty_like(self.log_s)

    def transform(self):
        np.multiply(self.u, self.decay, out=self.padded[: self.samples])
        return scipy.fft.rfft(self.padded, workers=1)

    def respond(self, spectrum, b, terms, c0):
        term, total = self.term, self.sum
        total.fill(c0)
        for coefficient, order in terms:
            np.multiply(self.log_s, order, out=term)
            np.exp(term, out=term)
            term *= coefficient
            total += term
        np.divide(spectrum, total, out=total)
        y = scipy.fft.irfft(total, self.length, workers=1, overwrite_x=True)[: self.samples]
        y *= self.growth
        y *= b
        return y

    def respond_by_numba(self, spectrum):
        (c2, o2), (c1, o1) = TERMS
        _quotient(self.log_s, spectrum, B, c2, o2, c1, o1, C0, self.sum)
        y = scipy.fft.irfft(self.sum, self.length, workers=1, overwrite_x=True)[: self.samples]
        y *= self.growth
        return y

    def simulate_by_numba(self):
        """One pair of transforms, G in one pass compiled by numba."""
        return self.respond_by_numba(self.transform())

    def candidate_by_numba(self):
        """The input's transform kept, G in one pass compiled by numba."""
        return self.respond_by_numba(self.spectrum)

    def simulate(self):
        """One pair of transforms."""
        return self.respond(self.transform(), B, TERMS, C0)

    def candidate(self):
        """The input's transform kept."""
        return self.respond(self.spectrum, B, TERMS, C0)


@numba.njit
def weights(order, count):
    """Grünwald-Letnikov weights."""
    w = np.empty(count)
    w[0] = 1.0
    for j in range(1, count):
        w[j] = w[j - 1] * (1.0 - (order + 1.0) / j)
    return w


@numba.njit(fastmath=True)
def _recursion(u, kernel_reversed, first, b):
    # The kernel is reversed so that both arrays are walked forwards, which is what the vector units want.
    n = len(u)
    x = np.empty(n)
    for k in range(n):
        memory = 0.0
        at = n - 1 - k
        for j in range(k):
            memory += kernel_reversed[at + j] * x[j]
        x[k] = (b * u[k] - memory) / first
    return x


class Recursion:
    """The O(N²) recursion with one merged kernel for both terms and fast-math, as numba does it best."""

    def __init__(self, u):
        self.u = u
        kernel = sum(c * RATE_HZ**order * weights(order, len(u)) for c, order in TERMS)
        self.first = kernel[0] + C0
        self.reversed = np.ascontiguousarray(kernel[::-1])

    def simulate(self):
        return _recursion(self.u, self.reversed, self.first, B)
