# Series of a low order gain nothing from the fast arithmetic.

= below order 8 the plain arithmetic is used, and the table says so
$ sed 's/ORDER/7/' > low.yaml; cns run -q low.yaml | grep '^# kernel'; sed 's/: 7/: 8/' low.yaml > next.yaml; CNS_KERNEL=portable cns run -q next.yaml | grep '^# kernel'
$ cns run -q low.yaml --set numerics.arithmetic=mpfr | tail -n 2 > plain; cns run -q low.yaml | tail -n 2 | cmp - plain
| model: apw
| initial: {theta: 1.7, Vx: -0.45, Vy: -0.3, omega: 0.6}
| time: {end: 0.2}
| numerics: {digits: 16, order: ORDER}
> # kernel: mpfr
> # kernel: portable
