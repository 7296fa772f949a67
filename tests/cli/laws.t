# cns laws: critical predictable times against digits, step and smoothing.

= the summary's keys, and the same bytes whatever the threads
$ cat > a.yaml; cns laws -q --yaml a.yaml --threads 1 > one; cns laws -q --yaml a.yaml --threads 2 | cmp - one
$ sed 's/: .*/:/' one | awk '!seen[$0]++'
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 500, every: 1/4}
| laws: {digits: {from: 6, to: 9}, steps: {method: rk4, digits: 20, from: 1e-2, to: 2e-3, per_decade: 6}}
> delta:
> criterion:
> observable:
> reference_digits:
> reference_end:
> digits_law:
>   slope:
>   slope_se:
>   slope_95:
>   intercept:
>   intercept_se:
>   r2:
>   slope_robust:
>   slope_gls:
>   slope_gls_se:
>   growth_slope:
>   growth_slope_se:
>   growth_scatter:
>   points:
>   - digits:
>     tc:
>     growth:
>   left_out:
> step_law:
>   - step:
> kappa:
> lambda:
> lambda_se:

= what is left out is named, and a text for people says how good the lines are
$ cat > a.yaml; cns laws -q a.yaml > text; grep -c 'left out: no T_c up to t = 30' text; grep -c 'standard error' text
$ grep -o 'observable y, delta = 0.1' text; grep -c 'lambda = .* +- ' text
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 30, every: 1/4}
| laws: {delta: 0.1, observable: y, digits: {from: 5, to: 17, by: 4}}
> 1
> 4
> observable y, delta = 0.1
> 2

= the criterion is named, a T_c by the envelope does not hang on the rows, and no error is printed as nothing
$ cat > a.yaml; laws() { cns laws -q a.yaml "$@"; }; laws > text; sed -n 2,3p text; grep -c ' 0\.00*[,;]* \| 0\.00*$' text || true; grep -o 'scatter [0-9.]*e-' text | sed 's/[0-9.]*e-/some/'
$ points() { sed -n 's/^  \([0-9.e-]*\)  *\([0-9.]*\)  *[0-9.]*  .*/ /p'; }; points < text > 8; laws --set time.every=1/16 | points > 16
$ paste -d' ' 8 16 | awk '{d = $2 - $4; n += $1 == $3 && d * d < 1e-7} END {print n}'
$ laws --set laws.criterion=rows --yaml | sed -n '/criterion/,/observable/p'; laws --set initial.x=0 --set initial.y=0 2>&1 | grep -o 'tangents, .*'
| model: lorenz
| initial: {x: 1e-11, y: 2.18277e-11}
| time: {end: 30, every: 1/8}
| laws: {delta: 1e-10, steps: {method: taylor, order: 2, digits: 40, from: 5e-4, to: 4.7e-4, per_decade: 100}}
> criterion envelope: the first time of |u1 - u2| > delta max |u2|, the maximum up to then
> (norm: of distance > delta)
> 0
> scatter some
> 3
> criterion: rows
> every: 1/8
> observable: norm
> tangents, 0 by a second reference

= stopped by a signal, it prints nothing, and keeps what is done: not the steps that would take days
$ cat > a.yaml; cns laws -q --threads 12 -o runs a.yaml & wait_for 'ls runs/step-*-1e-2-*'
$ kill -TERM $!; wait $! || echo $?; ls runs | grep -c 'step-.*-1e-[89]' || true; grep -L '^# complete' runs/*
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 500, every: 1/4}
| laws: {steps: {method: rk4, digits: 60, from: 1e-2, to: 1e-9, per_decade: 1}}
> 143
> 0

= it goes on from what is there
$ cat > a.yaml; cns laws -q --yaml -o runs a.yaml > first; cns laws -q --yaml a.yaml | cmp - first
$ names() { sed 's|^runs/||; s/-reference.*//; s/-growth.*//' | sort; }; ls runs | names
$ rm runs/digits-28-* runs/digits-68-*; touch -d '2001-01-01' runs/*
$ cns laws -q --yaml -o runs a.yaml | cmp - first; echo again:; find runs -type f -newermt '2002-01-01' | names
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 500, every: 1/4}
| laws: {digits: {from: 8, to: 68, by: 20}}
> check
> digits-28
> digits-48
> digits-68
> digits-8
> re:^reference-[0-9]+$
> again:
> digits-28
> digits-68

= a case without the section, and what cannot be done
$ cat > a.yaml; cns laws a.yaml && exit || echo $?
$ echo 'laws: {delta: 0.01}' >> a.yaml; cns laws a.yaml && exit || echo $?
| model: lorenz
| time: {end: 3}
> 2
> 2
2> re:a\.yaml:1:1: no 'laws'
2> re:none of 'digits', 'steps' and 'smoothing'

= a law without a line is an exit of its own, and its points are printed
$ cat > a.yaml; cns laws -q --yaml a.yaml > y || echo $?; grep -c 'tc:' y
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 500, every: 1/4}
| laws: {digits: {from: 6, to: 7}}
> 1
> 2
2> cns: no line for digits_law: fewer than three points, or no exponential growth

= a directory that cannot be made
$ cat > a.yaml; cns laws -q -o no/such a.yaml
| model: lorenz
| initial: {x: 1}
| time: {end: 300, every: 1/4}
| laws: {digits: {from: 5, to: 6}}
2> re:no/such
? 4

= rows too far apart for the time and the growth in between
$ cat > a.yaml; cns laws -q a.yaml
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 500, every: 20}
| laws: {digits: {from: 5, to: 9}}
2> re:^cns: 'time: every' is too coarse: differences grow by 10\^[0-9.]+ from t = [0-9]+ to [0-9]+
? 2

= a periodic motion has no line, however its points lie
$ sed 's/^goal.*/laws: {digits: {from: 4, to: 7}}/; s/I: [0-9.]*/I: 1.4/; s/^time.*/time: {end: 1100, every: 1}/' "$CASES/case4.yaml" > a.yaml; cns laws -q a.yaml > text || echo $?; grep -c '^  [4-7]  *[0-9]' text; grep -c 'no line' text
> 1
> 4
> 1
2> cns: no line for digits_law: fewer than three points, or no exponential growth

= the least delta is that of the message
$ cat > a.yaml; cns laws -q --set laws.delta=1e-11 a.yaml | grep -c 'delta = 1e-11'; cns laws a.yaml
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 500, every: 1/8}
| laws: {delta: 9e-12, digits: {from: 16, to: 20, by: 2}}
> 1
2> cns: 'laws: delta' is too small: at least 1e-11
? 2
