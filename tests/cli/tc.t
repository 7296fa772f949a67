# cns tc: the critical predictable time of a run by numerics.

= times of every state and the norm, as YAML
$ cat > a.yaml; cns tc -q --yaml a.yaml
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100, every: 0.5}
| numerics: {digits: 5}
> delta: 0.01
> criterion: envelope
> digits: 5
> reference_digits: 27
> times:
> re:^  norm: [0-9]+\.[0-9]{6}$
> re:^  x: [0-9]+\.[0-9]{6}$
> re:^  y: [0-9]+\.[0-9]{6}$
> re:^  theta: [0-9]+\.[0-9]{6}$
> re:^  Vx: [0-9]+\.[0-9]{6}$
> re:^  Vy: [0-9]+\.[0-9]{6}$
> re:^  omega: [0-9]+\.[0-9]{6}$

= more digits last longer, whatever the kernel, the arithmetic of many digits and the reference
$ cat > a.yaml; tc() { cns tc -q --yaml a.yaml "$@" | sed -n 's/^  norm: //p'; }
$ tc > 5; tc --set numerics.digits=10 > 10; paste 5 10 | awk '{print ($2 > $1 + 30)}'
$ CNS_KERNEL=portable tc | cmp - 5; tc --reference-digits 40 | cmp - 5
$ tc --set numerics.arithmetic=mpfr | paste - 5 | awk '{d = $1 - $2; print (d * d < 900)}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 200, every: 0.5}
| numerics: {digits: 5}
> 1
> 1

= a text for people, with derived quantities that the case asks for
$ cat > a.yaml; cns tc -q a.yaml
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 2, every: 0.5}
| numerics: {digits: 20}
| output: {columns: [t, theta, tau]}
> T_c of a.yaml, 20 digits, delta = 0.01, against 42 digits
> criterion envelope: the first time of |u1 - u2| > delta max |u2|, the maximum up to then
> (norm: of distance > delta)
> re:^  norm +> 2$
> re:^  x +> 2$
> re:^  y +> 2$
> re:^  theta +> 2$
> re:^  Vx +> 2$
> re:^  Vy +> 2$
> re:^  omega +> 2$
> re:^  tau +> 2$

= double and Runge-Kutta
$ cat > a.yaml; cns tc -q --yaml a.yaml | grep -E '^digits|norm'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 200, every: 0.5}
| numerics: {method: rk4, arithmetic: double, step: 0.05}
> digits: double
> re:^  norm: [0-9]+\.[0-9]{6}$

= T_c is the same whatever the rows and the end; rows of two tables come as near to it as they are to each other
$ cat > a.yaml; tc() { cns tc -q --yaml a.yaml "$@"; }
$ tc > one; for every in 1 0.1 0.01 131.7; do tc --set time.every=$every | cmp - one; done
$ tc --set time.end=133 | sed 's/beyond: 133/beyond: 132/' | cmp - one; sed -n 's/^  \([A-Za-z]*\): /\1,/p' one > times
$ sed 's/numerics.*/goal: {decimals: 9}/' a.yaml > b.yaml
$ for f in a b; do cns run -q --set time.every=0.02 $f.yaml | grep -v '^#' > $f.csv; done
$ awk -F, 'FNR == 1 {f++; if (f == 2) split($0, name)} f == 1 {tc[$1] = $2} f == 2 {for (i = 2; i <= 7; i++) u[FNR, i] = $i}
$   f == 3 && FNR > 1 {for (i = 2; i <= 7; i++) {v = u[FNR, i]; d = $i - v; if (d < 0) d = -d; if (v < 0) v = -v; if (v > e[i]) e[i] = v; if (!(i in row) && d > 0.01 * e[i]) row[i] = $1}}
$   END {for (i in row) {n++; good += tc[name[i]] <= row[i] && tc[name[i]] > row[i] - 0.02}; print n, good}' times b.csv a.csv
| model: apw
| initial: {theta: 1, Vy: 0.01}
| time: {end: 132, every: 0.5}
| numerics: {method: rk4, arithmetic: double, step: 0.01}
> 3 3

= the criterion of the rows: named with its rows, which are those of two tables, and T_c hangs on them
$ cat > a.yaml; tc() { cns tc -q a.yaml "$@"; }
$ tc > text; sed -n 2,3p text; cns tc -q --yaml a.yaml | sed -n '/criterion/,/digits/p'
$ sed 's/numerics.*/goal: {decimals: 9}/' a.yaml > b.yaml; for f in a b; do cns run -q $f.yaml > $f.csv; done
$ sed -n 's/^  \([A-Za-z]*\) .*first row: \(.*\))$/\1: \2/p' text > rows; cns compare a.csv b.csv | sed -n 's/^# T_c of \(.*: [0-9.]*\)$/\1/p' | cmp - rows; wc -l < rows | tr -d ' '
$ for every in 1 0.5 0.1; do tc --set time.every=$every --set laws.observable=Vx | awk '/Vx/ {print substr($2, 1, 6)}'; done
| model: apw
| initial: {theta: 1, Vy: 0.01}
| time: {end: 132, every: 0.5}
| numerics: {method: rk4, arithmetic: double, step: 0.01}
| laws: {criterion: rows}
> criterion rows: |u1 - u2| > delta |u2| (norm: distance > delta) at a row, rows every 0.5;
> from the time between that row and the one before from which on it holds
> criterion: rows
> every: 0.5
> digits: double
> 4
> 129.86
> 118.07
> 98.105

= a smaller delta is reached earlier
$ cat > a.yaml; for d in 1e-2 1e-3; do cns tc -q --yaml --delta $d a.yaml | sed -n 's/^  norm: //p' > $d; done; paste 1e-2 1e-3 | awk '{print ($2 < $1)}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100, every: 0.5}
| numerics: {digits: 5}
> 1

= delta is that of the case, and --delta wins over it
$ cat > a.yaml; sed '/^laws/d' a.yaml > b.yaml
$ cns tc -q --yaml a.yaml > case; cns tc -q --yaml --delta 1e-6 b.yaml | cmp - case
$ cns tc -q --yaml --delta 0.01 a.yaml > wins; cns tc -q --yaml b.yaml | cmp - wins
$ paste case wins | awk '/^delta/ {print $2, $4} /norm/ {print ($2 < $4)}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100, every: 0.5}
| numerics: {digits: 5}
| laws: {delta: 1e-6}
> 1e-6 0.01
> 1

= a state as the observable of the case: its T_c alone, that of a run for all and that of the laws
$ cat > a.yaml; tc() { cns tc -q --yaml a.yaml "$@" | sed -n '/^times/,$p'; }
$ tc > one; wc -l < one | tr -d ' '; tc --set laws.observable=norm | grep '  y: ' > all; tail -n 1 one | cmp - all
$ grep -v numerics a.yaml > b.yaml; cns laws -q --yaml b.yaml > laws || echo $?
$ awk '/^  y:/ {a = $2} /tc:/ {b = $2} END {d = a - b; print (a > 10 && d * d < 1e-8)}' one laws
$ cns tc -q a.yaml | sed 's/[0-9.]*$//'
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 100, every: 1/4}
| numerics: {digits: 10}
| laws: {delta: 0.1, observable: y, digits: {from: 10, to: 10}}
> 2
> 1
> 1
> T_c of a.yaml, 10 digits, delta = 0.1, against 32 digits
> criterion envelope: the first time of |u1 - u2| > delta max |u2|, the maximum up to then
> (norm: of distance > delta)
>   y          
2> cns: no line for digits_law: fewer than three points, or no exponential growth

= case 1 as printed has no T_c: the line is invariant
$ sed 's/^goal.*/numerics: {digits: 16}/' "$CASES/case1.yaml" > a.yaml; cns tc -q --yaml a.yaml | tail -n +6
>   norm:
>     beyond: 50
>     none: the difference does not grow
>   x:
>     beyond: 50
>     none: the two runs are identical
>   y:
>     beyond: 50
>   theta:
>     beyond: 50
>     none: the two runs are identical
>   Vx:
>     beyond: 50
>     none: the two runs are identical
>   Vy:
>     beyond: 50
>     none: the difference does not grow
>   omega:
>     beyond: 50
>     none: the two runs are identical

= a goal has no predictable time; nor has a case without numerics
$ cat > a.yaml; cns tc a.yaml || echo $?; grep -v goal a.yaml | cns tc -
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
| goal: {decimals: 10}
> 2
2> re:^a\.yaml:1:1: a 'goal' .*needs 'numerics'
2> re:^<stdin>:1:1: no 'numerics': .*needs 'numerics'
? 2

= a reference without digits enough is not believed
$ cat > a.yaml; cns tc -q --yaml --reference-digits 20 a.yaml
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 50, every: 0.5}
| numerics: {digits: 16}
> delta: 0.01
> criterion: envelope
> digits: 16
> reference_digits: 20
> times:
>   norm:
> re:^    beyond: [0-9.]+$
>   x:
> re:^    beyond: [0-9.]+$
>   y:
> re:^    beyond: [0-9.]+$
>   z:
> re:^    beyond: [0-9.]+$
2> re:^cns: t = [0-9.]+: the error of the reference .* more digits$
? 1

= options that make no sense
$ cat > a.yaml; for o in '--delta 0' '--delta -1' '--delta pi' '--delta x' '--reference-digits 3' '--reference-digits x'; do cns tc a.yaml $o || echo $?; done
| model: lorenz
| time: {end: 1}
| numerics: {digits: 16}
> 2
> 2
> 2
> 2
> 2
> 2
2> re:--delta takes a number > 0
2> re:--delta takes a number > 0
2> re:--delta takes a number > 0
2> re:--delta takes a number > 0
2> re:--reference-digits takes an integer
2> re:--reference-digits takes an integer

= interrupted
$ cat > a.yaml; cns tc -q a.yaml & wait_for "catches $!"; kill -INT $!; wait $!
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5000, every: 0.5}
| numerics: {digits: 400}
? 130
if test -r /proc/self/status
