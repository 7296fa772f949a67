# What looks like a singularity and is none, and what is one.

= a large angle costs digits, which the plan counts: as 1e12 mod 2 pi
$ cat > a.yaml; cns run a.yaml > a.csv 2> log; grep -c again log || true
$ cns run -q a.yaml --set initial.theta=5.62556054804280000944603503765828 > b.csv
$ for f in a b; do grep ^5, $f.csv | cut -d, -f2,3,5-7; done
| model: apw
| initial: {theta: 1e12, Vy: 0.01, omega: 1}
| time: {end: 5}
| goal: {decimals: 10}
> 0
> -0.3720706077,-3.0421981709,-0.3522433118,-0.8751572273,-0.8549345522
> -0.3720706077,-3.0421981709,-0.3522433118,-0.8751572273,-0.8549345522

= a state that begins large is no pole
$ cat > a.yaml; cns run -q a.yaml | tail -n 1
| model: apw
| initial: {theta: 1e9, Vy: 0.01, omega: 1}
| time: {end: 5}
| numerics: {method: rk4, arithmetic: double, step: 1e-3}
> # complete

= smoothing far below the precision: |omega| next to its zero
$ cat > a.yaml; cns run -q a.yaml > a.csv; cns run -q a.yaml --set abs=exact > b.csv
$ for f in a b; do grep ^0.001, $f.csv | cut -d, -f2-7; done
| model: apw
| initial: {theta: 1.202, Vx: 1e-10, Vy: -1e-10}
| time: {end: 1e-3}
| abs: {smooth: 1e-40}
| goal: {significant: 2}
> -2.4e-08,-2.2e-07,1.2e+00,-4.2e-04,-1.1e-04,-2.4e-11
> -2.4e-08,-2.2e-07,1.2e+00,-4.2e-04,-1.1e-04,-2.4e-11

= the same by hand in double
$ cat > a.yaml; cns run -q a.yaml | tail -n 1
| model: apw
| parameters: {I: 10}
| initial: {theta: 2.942, Vx: -1e-5, Vy: 1e-30}
| time: {end: 1e-3}
| abs: {smooth: 1e-20}
| numerics: {method: taylor, arithmetic: double}
> # complete

= a step that is too large for the method is not taken for a pole
$ cat > a.yaml; cns run -q a.yaml > a.csv
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 10}
| numerics: {method: rk4, arithmetic: double, step: 1}
2> re:^cns: t = 1: x grows without bound: the step of 1 is too large; the solution itself goes on there$
? 3

= a pole is, with any step: omega' is proportional to omega^2
$ cat > a.yaml; cns run -q a.yaml > a.csv
| model: apw
| parameters: {mu1: -30, mu2: -0.2}
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 10}
| numerics: {method: rk4, arithmetic: double, step: 0.01}
2> re:^cns: t = 0\.1[0-9]*: (theta|omega) grows without bound: a pole$
? 3

= a speed of zero is passed: Vy = 0 at W (I + 1) atan(0.01 / W), W = sqrt(pi / (A + B)), then Vy = -W tanh((t - t0) / (W (I + 1)))
$ cat > a.yaml; cns run -q a.yaml --events e.csv --section Vy=0 | grep ^10, | cut -d, -f6; grep ^Vy e.csv | cut -d, -f1-3
| model: apw
| initial: {Vy: 0.01}
| time: {end: 10}
| goal: {decimals: 30}
> -1.134278880380653598799404637968
> Vy=0,-1,0.031999185164040372605346552543

= by a speed of zero, at a distance at which double has none
$ cat > a.yaml; for v in 0 1e-40 -1e-100; do cns run -q a.yaml --set initial.Vx=$v | grep ^1, | cut -d, -f2-7; done | uniq | wc -l
| model: apw
| initial: {theta: 1}
| time: {end: 1}
| goal: {decimals: 20}
> 1
