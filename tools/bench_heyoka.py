#!/usr/bin/env python3
"""The problems of bench_fast in heyoka's multiprecision reals: processor time per unit of integrated time.

heyoka (https://bluescarni.github.io/heyoka.py) compiles a Taylor integrator for the equations; the time that
takes is not counted. The order, the tolerance and the step are heyoka's own for so many bits; tolerance
2^-prec, the same bits as cns works with for so many digits.

usage: bench_heyoka.py [DIGITS...]      default 60 300
"""
import math
import sys
import time

import heyoka as hy

GUARD_BITS = 16  # as cns_digits_to_bits
STATES = {"lorenz": ("-15.8", "-17.48", "35.64"), "apw, eps 1e-3": ("0", "0", "1.7", "-0.45", "-0.3", "0.6")}
UNTIL = {"lorenz": {60: 2.0, 300: 1.0}, "apw, eps 1e-3": {60: 3.0, 300: 0.8}}


def lorenz(real):
    x, y, z = hy.make_vars("x", "y", "z")
    sigma, r, b = real("10"), real("28"), real("8") / real("3")
    return [(x, sigma * (y - x)), (y, r * x - y - x * z), (z, x * y - b * z)]


def disk(real):
    """The equations as src/model/apw.c writes them: one root and two quotients, |omega| smoothed."""
    x, y, theta, vx, vy, omega = hy.make_vars("x", "y", "theta", "vx", "vy", "omega")
    pi = hy.real("3." + PI[2:], real("1").prec)
    inertia, ct, a, b, mu1, mu2 = (real(t) for t in ("2.2", "1.2", "1.4", "1", "0.2", "0.2"))
    one, half, two, quarter, eps = (real(t) for t in ("1", "0.5", "2", "0.25", "0.001"))
    lift, turn = two, two * ct / pi  # (2/pi) CR, CR = pi
    s = hy.sqrt(vx * vx + vy * vy)
    vxvy = vx * vy
    r = vxvy / s
    e = (vx * vx - vy * vy) / s
    gx = (inertia + one - lift) * omega + turn * r
    gy = (lift - inertia) * omega - turn * r
    f = a / pi * s - b / pi * e
    sin, cos = hy.sin(theta), hy.cos(theta)
    torque = mu1 * omega + mu2 * hy.sqrt(omega * omega + eps * eps) * omega
    over = one / (quarter * (inertia + half))
    return [
        (x, vx * cos - vy * sin),
        (y, vx * sin + vy * cos),
        (theta, omega),
        (vx, one / inertia * (gx * vy - sin - f * vx)),
        (vy, one / (inertia + one) * (gy * vx - cos - f * vy)),
        (omega, real("-1") * over * (vxvy + torque)),
    ]


def pi_text(digits):
    """Machin: pi = 16 arctan(1/5) - 4 arctan(1/239), in integers."""
    one = 10 ** (digits + 10)

    def arctan(n):
        total = term = one // n
        k, sign = 1, -1
        while term:
            term //= n * n
            k += 2
            total += sign * (term // k)
            sign = -sign
        return total

    text = str((16 * arctan(5) - 4 * arctan(239)) // 10**10)
    return text[0] + "." + text[1:]


PI = pi_text(1200)


def run(name, equations, digits):
    prec = math.ceil(digits * math.log2(10)) + GUARD_BITS

    def real(text):
        return hy.real(text, prec)

    built = time.process_time()
    integrator = hy.taylor_adaptive(
        equations(real), [real(t) for t in STATES[name]], fp_type=hy.real, prec=prec, tol=hy.real(f"1e-{digits}", prec)
    )
    built = time.process_time() - built
    until = UNTIL[name].get(digits, 1.0)
    integrator.step()
    since = float(integrator.time)
    start = time.process_time()
    integrator.propagate_until(real(str(since + until)))
    seconds = time.process_time() - start
    print(f"{name:14s} {digits:6d} {integrator.order:6d} {seconds / until:12.4g}   (compiled in {built:.1f} s)", flush=True)


def main():
    print(f"heyoka {hy.__version__}, real: seconds of processor time per unit of integrated time, one thread")
    print(f"{'model':14s} {'digits':>6s} {'order':>6s} {'real':>12s}")
    for name, equations in (("lorenz", lorenz), ("apw, eps 1e-3", disk)):
        for digits in [int(a) for a in sys.argv[1:]] or [60, 300]:
            run(name, equations, digits)


if __name__ == "__main__":
    main()
