# goal.proof: enclosure.

= two runs and an enclosure print the same, and the enclosure takes one run of fewer digits
$ for proof in two-runs enclosure; do cns run -q --yaml "$CASES"/case4.yaml --set time.end=60 --set goal.proof=$proof -o $proof.csv > $proof.yaml; done
$ grep -v '^#' two-runs.csv > a; grep -v '^#' enclosure.csv > b; wc -l < a; cmp a b
$ test $(sed -n 's/^digits: //p' enclosure.yaml) -lt $(sed -n 's/^digits: //p' two-runs.yaml)
> 122

= the table says what is proven, and by what
$ cns run -q "$CASES"/lorenz.yaml --set goal.proof=enclosure --set time.end=5 | sed -n '/^# proof/,/right$/p'
> # proof: an enclosure: the exact solution from the exact initial values, rounded to the places shown, is what
> #   is printed; a theorem, as far as this program's enclosures (src/integrate/tube.h says which files), MPFR, GMP
> #   and FLINT are right

= so does a plan
$ cns plan "$CASES"/lorenz.yaml --set goal.proof=enclosure --until 5 | sed -n 's/^digits *[0-9]*, //p'
> with an enclosure

= where there is no enclosure, two runs go on, and it is said
$ cns run "$CASES"/rest.yaml --set goal.proof=enclosure --set time.end=2 2> notes | grep '^# \(again\|proof\)' | cut -c1-14
$ grep -c 'no bound of the error beyond t = 0: .*; from here on by two runs' notes
> # proof: an en
> # again, with:
> # proof: a sec
> 1

= derived quantities, and significant digits
$ for proof in two-runs enclosure; do cns run -q "$CASES"/case4.yaml --set time.end=30 --set time.every=5 --set goal.proof=$proof --set 'output.columns=[t, Gamma, Fx, tau, speed, vx_lab]' --set goal.decimals=30 | grep -v '^#' > $proof; done; cmp two-runs enclosure
$ for proof in two-runs enclosure; do cns run -q "$CASES"/lorenz.yaml --set time.end=10 --set time.every=1 --set goal.proof=$proof --set 'goal={significant: 25}' --set goal.proof=$proof | grep -v '^#' > $proof; done; cmp two-runs enclosure

= a start that is no double, many digits, and another kernel
$ for proof in two-runs enclosure; do CNS_KERNEL=portable cns run -q "$CASES"/case4.yaml --set initial.theta=1/3 --set time.end=4 --set goal.decimals=200 --set goal.proof=$proof | grep -v '^#' > $proof; done; cmp two-runs enclosure

= events: the same as by two runs, each proven by itself
$ for proof in two-runs enclosure; do cns run -q "$CASES"/case4.yaml --set time.end=40 --set goal.decimals=20 --set goal.proof=$proof --events $proof.ev --section Vy=1/3 > /dev/null; grep -v '^#' $proof.ev > $proof; done
$ cmp two-runs enclosure; cut -d, -f1 enclosure | cut -c1-5 | sort -u; grep -c '^# proof: an enclosure: the exact solution has each' enclosure.ev
> Vy=1/
> event
> omega
> theta
> 1

= two events close together, a section just below a maximum
$ cat > a.yaml; for proof in two-runs enclosure; do cns run -q a.yaml --set goal.proof=$proof --events $proof.ev --section z=39.8234661207612717 > /dev/null; grep -v '^#' $proof.ev > $proof; done; cmp two-runs enclosure; grep -c '^z' enclosure
| model: lorenz
| initial: {x: -13.76361068213420052501, y: -19.57875194245179553883, z: 27}
| time: {end: 0.3}
| goal: {decimals: 15}
> 2

= an event that may be none is not told as one
$ cat > a.yaml; cns run -q a.yaml --set goal.proof=enclosure --events a.ev --section x=1 > /dev/null || echo $?; grep -vc '^#' a.ev
| model: lorenz
| initial: {x: 1, y: 1, z: 27}
| time: {end: 0.001}
| goal: {decimals: 12, max_digits: 60}
> 1
