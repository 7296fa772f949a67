#!/usr/bin/env python3
"""One problem of cns_bench in heyoka's multiprecision reals: processor time per unit of integrated time.

heyoka (https://bluescarni.github.io/heyoka.py) compiles a Taylor integrator for the equations; the time that
takes is not counted. The order and the step are heyoka's own for a tolerance of 10^-DIGITS in as many bits as
cns works with for so many digits. Steps are made as there: one before the clock starts, then until UNTIL is
reached. The disk with |omega| exact is run with omega in its place: up to t = 8 omega is positive.

usage: bench_heyoka.py MODEL DIGITS UNTIL [RUNS]
    prints  order N,  run SECONDS  (for each run, fewer when they are long),  state X  (for each state at UNTIL)
"""
import math
import sys
import time

import heyoka as hy

GUARD_BITS = 17  # as cns_digits_to_bits
LONG = 60  # seconds of runs after which no other is begun
DISK = ("0", "0", "1.7", "-0.45", "-0.3", "0.6")
LORENZ = ("-15.8", "-17.48", "35.64")


def lorenz(real):
    x, y, z = hy.make_vars("x", "y", "z")
    sigma, r, b = real("10"), real("28"), real("8") / real("3")
    return [(x, sigma * (y - x)), (y, r * x - y - x * z), (z, x * y - b * z)]


def disk(real, smooth):
    """The equations as src/model/apw.c writes them: one root and two quotients."""
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
    size = hy.sqrt(omega * omega + eps * eps) if smooth else omega
    torque = mu1 * omega + mu2 * size * omega
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


MODELS = {
    "lorenz": (lorenz, LORENZ),
    "apw": (lambda real: disk(real, False), DISK),
    "apw, eps 1e-3": (lambda real: disk(real, True), DISK),
}


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    model, digits, until = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
    runs = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    equations, start = MODELS[model]
    prec = math.floor(digits * math.log2(10)) + GUARD_BITS

    def real(text):
        return hy.real(text, prec)

    integrator = hy.taylor_adaptive(
        equations(real),
        [real(t) for t in start],
        fp_type=hy.real,
        prec=prec,
        tol=hy.real(f"1e-{digits}", prec),
        compact_mode=True,
    )
    print("order", integrator.order)
    end = hy.real(until, prec)
    total = 0.0
    for _ in range(runs):
        integrator.time = hy.real(0, prec)
        integrator.state[:] = [real(t) for t in start]
        integrator.step()
        since = integrator.time
        begun = time.process_time()
        stepped = False
        while integrator.time < end or not stepped:
            integrator.step()
            stepped = True
        seconds = time.process_time() - begun
        print("run", seconds / float(integrator.time - since), flush=True)
        total += seconds
        if total > LONG:
            break
    integrator.propagate_until(end)
    for x in integrator.state:
        print("state", x)


if __name__ == "__main__":
    main()
