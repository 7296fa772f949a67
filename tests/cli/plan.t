# cns plan.

= the keys of the summary
$ cns plan --yaml "$CASES"/case4.yaml --until 10 > sum
$ grep -cE '^(digits|order|steps|memory_bytes): [1-9][0-9]*$' sum; grep -cE '^seconds: [0-9.]+$' sum; grep '^until' sum
> 4
> 1
> until: 10

= digits, order and steps are those of the run
$ cns plan --yaml "$CASES"/case4.yaml --until 10 --decimals 20 > sum
$ cns run -q --yaml "$CASES"/case4.yaml --set time.end=10 --set goal.decimals=20 > run
$ grep '^digits\|^order' sum > a; grep '^digits\|^order' run > b; cmp a b
$ p=$(sed -n 's/^steps: //p' sum); r=$(sed -n 's/^steps: //p' run); test $((10 * p)) -ge $((8 * r)); test $((10 * p)) -le $((12 * r))

= a run says the same first
$ cns plan "$CASES"/case4.yaml --until 5 --decimals 12 > plan; d=$(sed -n 's/^digits *\([0-9]*\),.*/\1/p' plan); o=$(sed -n 's/^order *\([0-9]*\).*/\1/p' plan); s=$(sed -n 's/^steps *about //p' plan)
$ cns run "$CASES"/case4.yaml --set time.end=5 --set goal.decimals=12 2> note > table; grep -c "$d digits, order $o, .* about $s steps" note
> 1

= the goal of the case by default
$ cns plan "$CASES"/lorenz.yaml | head -n 1
> to t = 100 with 20 decimals:

= a case with numerics, and one with neither: 10 decimals
$ cat > n.yaml; grep -v numerics n.yaml > m.yaml
$ for f in n m; do cns plan $f.yaml | head -n 1; done
| model: lorenz
| initial: {x: 1, y: 1, z: 20}
| time: {end: 3}
| numerics: {method: rk4, arithmetic: double, step: 1e-3}
> to t = 3 with 10 decimals:
> to t = 3 with 10 decimals:

= more digits than max_digits allows
$ cns plan "$CASES"/case4.yaml --until 5 --decimals 30 --set goal.max_digits=30 --yaml | grep -c digits
2> cns: more digits than max_digits (30) allows
> 2

= no plan beyond a singularity
$ cat > s.yaml; cns plan s.yaml
| model: apw
| parameters: {A: -2}
| initial: {Vy: -1}
| time: {end: 50, every: 0.5}
2> re:^cns: no plan beyond t = 5\.5: .* t = 5\.99585.*a pole$
? 3

= times and decimals that are none
$ for a in 'until 0' 'until -1' 'until x' 'until pi' 'decimals 0' 'decimals ten' 'decimals 10001'; do cns plan "$CASES"/case4.yaml --${a% *} ${a#* } || echo $?; done
> 2
> 2
> 2
> 2
> 2
> 2
> 2
2> re:--until .*'0'
2> re:--until .*'-1'
2> re:--until .*'x'
2> re:--until .*'pi'
2> re:--decimals .*'0'
2> re:--decimals .*'ten'
2> re:--decimals .*'10001'

= --until is for plans only
$ cns run "$CASES"/case4.yaml --until 5
2> re:--until does not go with
? 2

= a time that no double holds
$ for t in 0.001 0.1 1/3 1.1; do cns plan "$CASES"/case4.yaml --until $t | head -n 1; done
> to t = 0.001 with 10 decimals:
> to t = 0.1 with 10 decimals:
> to t = 1/3 with 10 decimals:
> to t = 1.1 with 10 decimals:

= ten thousand decimals are planned from steps of fewer; their measured times are right on a quiet machine
$ plan() { cns plan -q "$CASES"/lorenz.yaml --until 10 --decimals $1 --set goal.max_digits=20000 --yaml > $1; }
$ seconds() { plan $1; sed -n 's/^seconds: //p' $1; }
$ wait_for 'echo "$(seconds 1000) $(seconds 10000)" | awk "{exit !(\$2 > 100 * \$1)}"'
$ sed -n 's/^memory_bytes: //p' 10000 | awk '{print ($1 > 1e9)}'
> 1

= stopped, it says nothing rather than too little
$ cns plan "$CASES"/case4.yaml --until 1e7 --set time.every=2 & wait_for "catches $!"; kill -INT $!; wait $!
2> re:^cns: stopped by signal INT
? 130
if test -r /proc/self/status

= too many rows
$ cns plan "$CASES"/case4.yaml --until 1e8
2> re:rows
? 2
