#!/usr/bin/env python3
"""Independent reference trajectories, to test cns against.

    tools/reference.py CASE.yaml [options] -o OUT.csv

Shares no code, no formulation and no arithmetic with the C program: Taylor series in binary fixed point on Python's
(or gmpy2's) integers, the falling-disk equations in the form in which they are printed, elementary constants from Arb
(python-flint).  Every case is integrated twice, with different precision, order and steps; a table is written only if
both runs give the same text, also after their difference has been enlarged a thousandfold.

Needs python-flint and PyYAML (pip install python-flint pyyaml); gmpy2, if there, makes it several times faster and
changes no digit.

The equations are those of Andersen, Pesavento and Wang, J. Fluid Mech. 541 (2005), as printed by Xu, Li, Li and Liao,
"Accurate predictions of chaotic motion of a free fall disk".

|omega| is exact: its sign is held over an arc; the end of the arc, omega = 0, is isolated on the step's own polynomial
by bounds on its derivatives, so that two close crossings cannot be missed; the trajectory lands there, omega is
set to 0, and the first non-zero coefficient of omega gives the next sign.  `abs: {smooth: eps}` in the case file
replaces |omega| by sqrt(omega^2 + eps^2).
"""

import argparse
import math
import os
import re
import sys
import tempfile
import time
from fractions import Fraction
from operator import mul

import flint
import yaml

try:
    from gmpy2 import mpz as Z
except ImportError:
    Z = int

SOURCE = ("Xu, Li, Li, Liao, 'Accurate predictions of chaotic motion of a free fall disk'; "
          "Andersen, Pesavento, Wang, J. Fluid Mech. 541 (2005)")


class Trouble(Exception):
    """Something the user has to know: a bad case, or a run that cannot be trusted."""


# --- Numbers ----------------------------------------------------------------------------------------------------------

class Number:
    """An exact rational times a power of pi, from its text."""

    def __init__(self, text):
        text = str(text).strip()
        match = re.fullmatch(r"([+-]?)\s*(.+)", text)
        if not match:
            raise Trouble(f"not a number: '{text}'")
        self.q, self.pi, over = Fraction(-1 if match[1] == "-" else 1), 0, False
        for token in re.split(r"\s*([*/])\s*", match[2]):
            if token in "*/" and token:
                over = token == "/"
            elif token == "pi":
                self.pi += -1 if over else 1
            elif re.fullmatch(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", token):
                value = Fraction(token)
                if over and not value:
                    raise Trouble(f"division by zero: '{text}'")
                self.q = self.q / value if over else self.q * value
            else:
                raise Trouble(f"not a number: '{text}'")

    def fixed(self, bits):
        if not self.pi:
            return Z(round(self.q * 2**bits))
        return arb_to_fixed(arb_of(self.q.numerator, bits) * flint.arb.pi()**self.pi / self.q.denominator, bits)

    def rational(self):
        if self.pi:
            raise Trouble("times must be rational numbers here")
        return self.q


def arb_of(n, bits):
    flint.ctx.prec = 2 * bits + 200
    return flint.arb(flint.fmpz(int(n)))


def arb_to_fixed(a, bits):
    """Nearest multiple of 2^-bits, or one of the two nearest."""
    return Z(int((a * flint.arb(2)**bits).mid().floor().unique_fmpz()))


def sin_cos(angle, bits):
    a = arb_of(angle, bits) / flint.arb(2)**bits
    s, c = a.sin_cos()
    return arb_to_fixed(s, bits), arb_to_fixed(c, bits)


def isqrt(n):
    return Z(math.isqrt(int(n)))


# --- Power series in fixed point --------------------------------------------------------------------------------------

def product(a, b):
    """Coefficient k of a series product, unshifted; both operands hold exactly k + 1 coefficients."""
    return sum(map(mul, a, reversed(b)))


def square(a):
    k = len(a) - 1
    half = (k + 1) // 2
    total = 2 * sum(map(mul, a[:half], a[:k - half:-1])) if half else 0
    return total + a[half] * a[half] if k % 2 == 0 else total


def quotient(a, b, q, bits):
    """Coefficient k of q = a / b, given q_0 .. q_k-1."""
    k = len(b) - 1
    rest = sum(map(mul, q, b[:0:-1])) if k else 0
    return ((a << bits) - rest) // b[0]


def root(a, s, bits):
    """Coefficient k of s = sqrt(a), given s_0 .. s_k-1."""
    k = len(s)
    if k == 0:
        return isqrt(a << bits)
    rest = square([Z(0)] + s[1:] + [Z(0)]) if k > 1 else 0      # sum of s_i s_k-i, 0 < i < k
    return ((a << bits) - rest) // (2 * s[0])


def horner(a, x, bits):
    total = Z(0)
    for c in reversed(a):
        total = (total * x >> bits) + c
    return total


def derivative(a):
    return [k * c for k, c in enumerate(a)][1:]


class Roots:
    """Simple real roots of a polynomial in (0, end], 0 < end <= 1, isolated by bounds on its first two derivatives.

    On an interval with centre m and radius r there is no root if |g(m)| > r sup|g'|, and at most one if
    |g'(m)| > r sup|g''|; otherwise the interval is halved.  Bounds, not samples: nothing between can be missed.
    """

    def __init__(self, g, end, bits):
        while g and g[0] == 0:                  # an exact root at 0, left behind by a landing, is divided out
            g = g[1:]
        self.g, self.bits, self.end = g, bits, end
        self.d = derivative(g)
        self.noise = Z(1) << 12
        self.sup1 = horner([abs(c) for c in self.d], end, bits) + self.noise
        self.sup2 = horner([abs(c) for c in derivative(self.d)], end, bits) + self.noise
        self.narrowest = Z(1) << (bits // 2 - 24)

    def brackets(self):
        stack = [(Z(0), self.end)] if self.g else []
        bits = self.bits
        while stack:
            a, b = stack.pop()
            m, r = (a + b) >> 1, ((b - a) >> 1) + 1
            if abs(horner(self.g, m, bits)) > (r * self.sup1 >> bits) + self.noise:
                continue
            if abs(horner(self.d, m, bits)) > (r * self.sup2 >> bits) + self.noise:
                at_a, at_b = horner(self.g, a, bits), horner(self.g, b, bits)
                if (at_a > 0) != (at_b > 0) and at_a != 0:
                    yield a, b
                continue
            if r < self.narrowest:
                raise Trouble("a crossing that cannot be told from a tangency")
            stack += [(m, b), (a, m)]

    def __iter__(self):
        for a, b in self.brackets():
            yield self.refine(a, b)

    def refine(self, a, b):
        """Newton's method, kept inside the bracket; g is monotone there."""
        rising = horner(self.g, b, self.bits) > 0
        x = (a + b) >> 1
        for _ in range(20 * self.bits):
            value = horner(self.g, x, self.bits)
            if value == 0:
                break
            if (value > 0) == rising:
                b = x
            else:
                a = x
            slope = horner(self.d, x, self.bits)
            after = x - (value << self.bits) // slope if slope else a
            if not a < after < b:
                after = (a + b) >> 1
            if abs(after - x) <= 1 or b - a <= 2:
                return after
            x = after
        return x


# --- Models -----------------------------------------------------------------------------------------------------------

class Lorenz:
    states = ["x", "y", "z"]
    defaults = {"sigma": "10", "R": "28", "b": "8/3"}
    steering = [0, 1, 2]
    digits_per_time = 0.42
    smoothable = False

    def __init__(self, parameters, smooth, bits):
        self.bits = bits
        self.sigma, self.r, self.b = (parameters[k].fixed(bits) for k in ("sigma", "R", "b"))

    def series(self, state, rho, order):
        P, (num, shift) = self.bits, rho
        x, y, z = ([v] for v in state)
        for k in range(order):
            def advance(series, slope):
                series.append(slope * num // (k + 1) >> shift)
            xz, xy = product(x, z) >> P, product(x, y) >> P
            dx = self.sigma * (y[k] - x[k]) >> P
            dy = (self.r * x[k] >> P) - y[k] - xz
            dz = xy - (self.b * z[k] >> P)
            advance(x, dx), advance(y, dy), advance(z, dz)
        return [x, y, z]

    def watched(self, jet):
        return {}

    def slopes(self, state):
        P = self.bits
        x, y, z = state
        return [self.sigma * (y - x) >> P, (self.r * x >> P) - y - (x * z >> P), (x * y >> P) - (self.b * z >> P)]


class Disk:
    """Andersen-Pesavento-Wang, term by term as printed."""
    states = ["x", "y", "theta", "Vx", "Vy", "omega"]
    defaults = {"I": None, "CT": "6/5", "CR": "pi", "A": "7/5", "B": "1", "mu1": "1/5", "mu2": "1/5"}
    steering = [2, 3, 4, 5]                     # nothing feeds back from x and y
    digits_per_time = 0.10
    smoothable = True

    def __init__(self, parameters, smooth, bits):
        self.bits, self.one = bits, Z(1) << bits
        for name in self.defaults:
            setattr(self, name, parameters[name].fixed(bits))
        inverse_pi = Number("1/pi").fixed(bits)
        self.ipi, self.ipi2 = inverse_pi, 2 * inverse_pi
        self.i1 = self.I + self.one                             # I + 1
        self.i3 = (self.I + (self.one >> 1)) >> 2               # (I + 1/2) / 4
        self.eps2 = None
        if smooth:
            eps = smooth.fixed(2 * bits)
            self.eps2 = eps * eps >> 3 * bits
            if not self.eps2:
                raise Trouble("eps^2 is below the working precision")

    def series(self, state, rho, order):
        P, (num, shift) = self.bits, rho
        x, y, th, u, v, w = ([value] for value in state)
        sn, cs = ([value] for value in sin_cos(state[2], P))
        # At rest, or where the only velocity component passes zero, both velocities are t times a series (U, V), and
        # so is s.  Working with the quotients keeps 0/0 out of Vx Vy / s and (Vx^2 - Vy^2) / (Vx^2 + Vy^2).
        m = 1 if state[3] == 0 and state[4] == 0 else 0
        U, V, S2, S, UV, R, D, Q, E = ([] for _ in range(9))    # reduced by m (s, R) or 2m (products), Q by 0
        G, K, absw = [], [], []                                 # Gamma and its like, in full
        sign, w2, W2 = 0, [], []
        for k in range(order):
            def advance(series, slope):
                series.append(slope * num // (k + 1) >> shift)
            j = k - m
            if j >= 0:
                U.append(u[k]), V.append(v[k])
                uu, vv = square(U), square(V)
                UV.append(product(U, V) >> P)
                S2.append((uu + vv) >> P)
                D.append((uu - vv) >> P)
                S.append(root(S2[j], S, P))
                if not S[0]:
                    raise Trouble("the velocity vanishes: the model is singular there")
                R.append(quotient(UV[j], S, R, P))                              # Vx Vy / s
                Q.append(quotient(D[j], S2, Q, P))                              # (Vx^2 - Vy^2) / (Vx^2 + Vy^2)
                E.append((self.A if j == 0 else 0) - (self.B * Q[j] >> P))
                K.append((product(E, S) >> P) * self.ipi >> P)                  # (A - B ...) s / pi
                r = R[j]
            else:
                K.append(Z(0))
                r = Z(0)
            G.append(self.ipi2 * ((self.CR * w[k] >> P) - (self.CT * r >> P)) >> P)
            # |omega| omega
            if self.eps2 is None:
                if sign == 0 and w[k] != 0:
                    sign = 1 if w[k] > 0 else -1
                    if k and abs(w[k]) < Z(1) << (P // 2):
                        raise Trouble("the sign of omega after a landing cannot be told from rounding")
                friction = sign * (square(w) >> P)
            else:
                w2.append((square(w) >> P) + (self.eps2 if k == 0 else 0))
                absw.append(root(w2[k], absw, P))
                friction = product(absw, w) >> P
            tau = (self.mu1 * w[k] >> P) + (self.mu2 * friction >> P)
            uv = UV[k - 2 * m] if k >= 2 * m else 0
            wv, wu, gv, gu = product(w, v), product(w, u), product(G, v), product(G, u)
            fx, fy = product(K, u), product(K, v)
            du = (((self.i1 * (wv >> P)) - gv - fx >> P) - sn[k] << P) // self.I
            dv = ((-(self.I * (wu >> P)) + gu - fy >> P) - cs[k] << P) // self.i1
            dw = (-uv - tau << P) // self.i3
            dx = product(u, cs) - product(v, sn) >> P
            dy = product(u, sn) + product(v, cs) >> P
            dsn, dcs = product(w, cs) >> P, -(product(w, sn) >> P)
            advance(x, dx), advance(y, dy), advance(th, w[k])
            advance(u, du), advance(v, dv), advance(w, dw)
            advance(sn, dsn), advance(cs, dcs)
        return [x, y, th, u, v, w]

    def watched(self, jet):
        """State index -> polynomial whose zero ends an arc."""
        events = {}
        if self.eps2 is None:
            events[5] = jet[5]
        # On an invariant line with one velocity identically zero, s is the absolute value of the other.
        if not any(jet[3]):
            events[4] = jet[4]
        elif not any(jet[4]):
            events[3] = jet[3]
        return events

    def slopes(self, state):
        """The right-hand side at a point, with a true root and a true absolute value; None where it is 0/0."""
        P = self.bits
        x, y, th, u, v, w = state
        sn, cs = sin_cos(th, P)
        s2 = u * u + v * v
        s = isqrt(s2)
        if s == 0:
            return None
        gamma = self.ipi2 * ((self.CR * w >> P) - (self.CT * (u * v // s) >> P)) >> P
        drag = ((self.A - (self.B * (((u * u - v * v) << P) // s2) >> P)) * s >> P) * self.ipi >> P
        mod = abs(w) if self.eps2 is None else isqrt(w * w + (self.eps2 << P))
        tau = (self.mu1 + (self.mu2 * mod >> P)) * w >> P
        du = ((self.i1 * (w * v >> P) - gamma * v - drag * u >> P) - sn << P) // self.I
        dv = ((-self.I * (w * u >> P) + gamma * u - drag * v >> P) - cs << P) // self.i1
        return [u * cs - v * sn >> P, u * sn + v * cs >> P, w, du, dv, (-(u * v >> P) - tau << P) // self.i3]


MODELS = {"apw": Disk, "lorenz": Lorenz}


# --- Integration ------------------------------------------------------------------------------------------------------

def log2(n):
    n = int(abs(n))
    if n == 0:
        return -math.inf
    shift = max(n.bit_length() - 60, 0)
    return math.log2(n >> shift) + shift


class Run:
    """One integration: rows at the given times, as fixed-point integers."""

    def __init__(self, case, digits, order, reach, quiet, label):
        guard = 64
        if case.smooth:                         # sqrt(omega^2 + eps^2) divides by eps
            guard += 3 * max(0, math.ceil(log2(case.smooth.q.denominator) - log2(case.smooth.q.numerator)))
        self.bits = math.ceil(digits * math.log2(10)) + guard
        self.tolerance = guard - 8              # truncation, in bits above the last
        self.case, self.digits, self.order, self.reach = case, digits, order, reach
        self.quiet, self.label = quiet, label
        self.steps = self.retries = 0
        self.crossings, self.stats = [], {"min slope": None, "shortest arc": None, "near miss": None, "min s": None}
        self.worst_mismatch = -math.inf

    def note(self, key, value, t):
        if self.stats[key] is None or value < self.stats[key][0]:
            self.stats[key] = (value, t)

    def integrate(self):
        case, P, N = self.case, self.bits, self.order
        model = case.model(case.parameters, case.smooth, P)
        state = [n.fixed(P) for n in case.initial]
        rows, targets = [], [Z(round(t * 2**P)) for t in case.times]
        t, rho, begun, told = Z(0), (Z(1), 4), time.time(), time.time()
        if targets and targets[0] == 0:
            rows.append(list(state))
        landed = False
        while len(rows) < len(targets):
            num, shift = rho
            jet = model.series(state, rho, N)
            # step: the last four coefficients of what feeds back, against the tolerance
            logs = [max(log2(jet[i][k]) for i in model.steering) for k in range(N - 3, N + 1)]
            log_step = min((self.tolerance - size) / k for k, size in zip(range(N - 3, N + 1), logs)) + self.reach
            if log_step < -2:                   # the unit of time was far too long: again, in a shorter one
                self.retries += 1
                rho = self.unit(rho, log_step + 0.1)
                if rho[1] > P:
                    raise Trouble(f"no step at t = {float(Fraction(int(t), 2**P))}")
                continue
            end = Z(1) << P if log_step >= 0 else Z(int(2.0**(log_step + 53))) << (P - 53)
            # does an arc end inside?
            land = None
            for index, poly in model.watched(jet).items():
                for found in Roots(poly, end, P):
                    if 0 < found <= end and (land is None or found < land[0]):
                        land = (found, index)
                    break
            if land:
                end = land[0]
            self.inspect(model, jet, end, rho, t, landed, land)
            t_end = t + (end * num >> shift)
            while len(rows) < len(targets) and targets[len(rows)] <= t_end:
                at = ((targets[len(rows)] - t) << shift) // num
                rows.append([horner(c, at, P) for c in jet])
            state = [horner(c, end, P) for c in jet]
            landed = land is not None
            if land:
                state[land[1]] = Z(0)
                if land[1] == 5:
                    self.crossings.append(float(Fraction(int(t_end), 2**P)))
            self.check(model, jet, state, end, rho, t_end)
            t = t_end
            self.steps += 1
            if not land:
                rho = self.unit(rho, min(log_step, 1.0) + 0.1)
            if not self.quiet and time.time() - told > 20:
                told = time.time()
                print(f"{self.label}: t = {float(Fraction(int(t), 2**P)):.3f}, {self.steps} steps, "
                      f"{told - begun:.0f} s", file=sys.stderr, flush=True)
        self.seconds = time.time() - begun
        return rows

    @staticmethod
    def unit(rho, log_factor):
        """A new unit of time, num / 2^shift, near 2^log_factor times the old one."""
        size = log2(rho[0]) - rho[1] + log_factor
        whole = math.floor(size)
        num, shift = round(2**(size - whole) * 64), 6 - whole
        if shift < 0:
            num, shift = num << -shift, 0
        return Z(num), shift

    def inspect(self, model, jet, end, rho, t, landed, land):
        """Statistics: how close the trajectory comes to what would be hard."""
        if model is None or not isinstance(model, Disk):
            return
        P, unit = self.bits, float(rho[0]) / 2.0**rho[1]
        scale = 2.0**-60
        def small(n):
            return float(int(n) >> (P - 60)) * scale if n >= 0 else -float(int(-n) >> (P - 60)) * scale
        when = small(t)
        self.note("min s", math.hypot(small(jet[3][0]), small(jet[4][0])), when)
        if model.eps2 is not None:
            return
        slope = derivative(jet[5])
        if land and land[1] == 5:
            where = when + small(end) * unit
            self.note("min slope", abs(small(horner(slope, end, P))) / unit, where)
            if self.crossings:
                self.note("shortest arc", where - self.crossings[-1], where)
        try:
            for found in Roots(slope, end, P):              # minima of |omega| that are not crossings
                value, bend = horner(jet[5], found, P), horner(derivative(slope), found, P)
                if found <= end and (value > 0) == (bend > 0):
                    self.note("near miss", abs(small(value)), when + small(found) * unit)
        except Trouble:
            pass                                            # omega' with a double root: of no consequence

    def check(self, model, jet, state, end, rho, t):
        """The jet's slope at the step's end against the equations evaluated there: catches a wrong branch."""
        slopes = model.slopes(state)
        if slopes is None:
            return
        P, (num, shift) = self.bits, rho
        for i, slope in enumerate(slopes):
            mismatch = log2(abs((horner(derivative(jet[i]), end, P) << shift) // num - slope)) - P
            if mismatch > (self.tolerance - P) // 2:
                raise Trouble(f"at t = {float(Fraction(int(t), 2**P))} the series of {model.states[i]} leaves the "
                              f"equations by 2^{mismatch:.0f}")
            self.worst_mismatch = max(self.worst_mismatch, mismatch)


# --- Cases and tables -------------------------------------------------------------------------------------------------

class Case:
    def __init__(self, path, options):
        with open(path, encoding="utf-8") as stream:
            tree = yaml.load(stream, Loader=yaml.BaseLoader)        # scalars stay text
        if not isinstance(tree, dict) or tree.get("model") not in MODELS:
            raise Trouble(f"{path}: 'model' must be one of {', '.join(MODELS)}")
        self.name, self.model = tree["model"], MODELS[tree["model"]]
        given = tree.get("parameters") or {}
        self.texts = dict(self.model.defaults, **given)
        for name, text in self.texts.items():
            if name not in self.model.defaults:
                raise Trouble(f"{path}: unknown parameter '{name}'")
            if text is None:
                raise Trouble(f"{path}: parameter '{name}' is missing")
        self.parameters = {name: Number(text) for name, text in self.texts.items()}
        start = tree.get("initial") or {}
        for name in start:
            if name not in self.model.states:
                raise Trouble(f"{path}: unknown state '{name}'")
        self.start = [start.get(name, "0") for name in self.model.states]
        self.initial = [Number(text) for text in self.start]
        mode = tree.get("abs", "exact")
        self.smooth = None
        if mode != "exact":
            if not isinstance(mode, dict) or list(mode) != ["smooth"]:
                raise Trouble(f"{path}: abs must be 'exact' or {{smooth: eps}}")
            self.smooth = Number(mode["smooth"])
            if self.smooth.pi or self.smooth.q <= 0:
                raise Trouble(f"{path}: eps must be a positive rational number")
        self.abs = f"sqrt(omega^2 + eps^2), eps = {mode['smooth']}" if self.smooth else "exact"
        when = tree.get("time") or {}
        end = Number(options.end or when.get("end", "0")).rational()
        every = Number(options.every or when.get("every", str(end))).rational()
        first = Number(options.first).rational()
        if end <= 0 or every <= 0:
            raise Trouble(f"{path}: time needs a positive 'end' and 'every'")
        times = [i * every for i in range(math.floor(end / every) + 1)]
        self.times = [t for t in times + ([end] if times[-1] != end else []) if t >= first]
        self.end = end
        goal = tree.get("goal") or {}
        self.decimals = int(options.decimals or goal.get("decimals", 40))


def exact_decimal(q, decimals):
    for places in range(decimals + 1):
        if (q * 10**places).denominator == 1:
            return decimal_text(q.numerator * 10**places // q.denominator, places)
    return decimal_text(round(q * 10**decimals), decimals)


def decimal_text(n, places):
    n, text = int(n), str(abs(int(n))).rjust(places + 1, "0")
    return ("-" if n < 0 else "") + (text[:-places] + "." + text[-places:] if places else text)


def rounded(value, bits, places):
    return (2 * value * 10**places + (Z(1) << bits)) >> (bits + 1)


def settle(case, coarse, a, fine, b):
    """The text of every value both runs agree on; how far they differ, row by row."""
    lift = fine.bits - coarse.bits
    lines, apart = [], []
    for t, ra, rb in zip(case.times, a, b):
        cells, worst = [exact_decimal(t, case.decimals)], -math.inf
        for name, va, vb in zip(case.model.states, ra, rb):
            gap = abs((va << lift) - vb)
            worst = max(worst, (log2(gap) - fine.bits) * math.log10(2))
            e = 1000 * gap + (Z(1) << (lift + 16))
            low, high = (rounded(v, fine.bits, case.decimals) for v in (vb - e, vb + e))
            if low != high:
                raise Trouble(f"{name} at t = {cells[0]}: the runs agree to 10^{worst:.1f} only, or the value lies too "
                              f"near a rounding boundary; ask for more --digits")
            cells.append(decimal_text(low, case.decimals))
        lines.append(",".join(cells))
        apart.append(worst)
    return lines, apart


def main():
    parser = argparse.ArgumentParser(description="Independent reference trajectories, to test cns against.")
    parser.add_argument("case", help="case file")
    parser.add_argument("-o", dest="out", required=True, metavar="FILE", help="table to write")
    parser.add_argument("--decimals", type=int, help="decimals to print (default: the case's goal, or 40)")
    parser.add_argument("--digits", type=int, help="working digits of the coarser run (default: from decimals and end)")
    parser.add_argument("--every", help="interval between rows")
    parser.add_argument("--end", help="last time")
    parser.add_argument("--from", dest="first", default="0", help="first time to print")
    parser.add_argument("-q", dest="quiet", action="store_true", help="no progress on stderr")
    options = parser.parse_args()
    case = Case(options.case, options)
    end = float(case.end)
    digits = options.digits or case.decimals + math.ceil(case.model.digits_per_time * end + 0.8 * math.sqrt(end)) + 12
    finer = digits + 15
    runs = [Run(case, digits, max(24, round(1.15 * digits)), 0.0, options.quiet, "first run"),
            Run(case, finer, max(30, round(1.27 * finer)), -0.12, options.quiet, "second run")]
    results = [run.integrate() for run in runs]
    lines, apart = settle(case, runs[0], results[0], runs[1], results[1])
    head = [f"script: tools/reference.py, independent of cns; case file {os.path.basename(options.case)}",
            f"equations: {SOURCE}" if case.model is Disk else "equations: Lorenz, J. Atmos. Sci. 20 (1963)",
            f"model: {case.name}; " + ", ".join(f"{k} = {v}" for k, v in case.texts.items()),
            "initial: " + ", ".join(f"{k} = {v}" for k, v in zip(case.model.states, case.start)),
            f"abs: {case.abs}" if case.model.smoothable else "abs: none in this model",
            "method: Taylor series in binary fixed point, adaptive steps, dense output at the rows"]
    head += [f"{run.label}: {run.digits} working digits ({run.bits} fraction bits), order {run.order}, "
             f"{run.steps} steps, {len(run.crossings)} crossings of omega = 0" for run in runs]
    head += [f"the runs differ by at most 10^{max(apart):.1f}; all {case.decimals} decimals printed are right, rounded "
             "to nearest"]
    table = [f"# {line}" for line in head] + [",".join(["t"] + case.model.states)] + lines + ["# complete"]
    folder = os.path.dirname(os.path.abspath(options.out))
    with tempfile.NamedTemporaryFile("w", dir=folder, delete=False, encoding="ascii") as stream:
        stream.write("\n".join(table) + "\n")
    os.chmod(stream.name, 0o644)
    os.replace(stream.name, options.out)
    if not options.quiet:
        for run in runs:
            print(f"{run.label}: {run.digits} digits, order {run.order}, {run.steps} steps, {run.retries} retries, "
                  f"{len(run.crossings)} crossings, {run.seconds:.0f} s, slope mismatch 2^{run.worst_mismatch:.0f} at "
                  f"{run.bits} bits", file=sys.stderr)
        for key, value in runs[1].stats.items():
            if value:
                print(f"{key}: {value[0]:.6g} at t = {value[1]:.6g}", file=sys.stderr)
        for i in range(0, len(apart), max(1, len(apart) // 12)):
            print(f"t = {float(case.times[i]):g}: runs apart 10^{apart[i]:.1f}", file=sys.stderr)


if __name__ == "__main__":
    try:
        main()
    except Trouble as trouble:
        print(f"reference.py: {trouble}", file=sys.stderr)
        sys.exit(1)
