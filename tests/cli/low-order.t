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

= the steps that numerics take are predicted, and said first
$ cat > a.yaml
$ for n in 'order: 8' 'order: 12' 'order: 30' 'order: 60' 'step: 1/64, order: 16' 'method: rk4, step: 1/256' 'tolerance: 1e-9'; do
$ cns run -v a.yaml --set "numerics={digits: 20, $n}" 2>&1 > /dev/null | sed -n 's/^cns: \(about \)*\([0-9]*\) steps.*/\2/p' | tr '\n' ' ' | awk '{if ($1 > 1.25 * $2 || $1 < 0.8 * $2) print "'"$n"'", $0; n++} END {print n}'; done
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 2, every: 1/4}
> 1
> 1
> 1
> 1
> 1
> 1
> 1

= what cannot end is refused, with what would do
$ cat > a.yaml
$ for o in 1 2 3 4; do cns run -q a.yaml --set numerics.order=$o > out || echo $?; done; grep -c '^[0-9]' out || true
$ cns run -q a.yaml --set 'numerics={method: rk4, arithmetic: double, step: 1e-12}' > out || echo $?
$ cns run -q a.yaml --set initial.x=1e10 > out || echo $?
$ cns tc -q a.yaml --set numerics.order=2 || echo $?
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 20, every: 10}
| numerics: {digits: 50}
> 2
> 2
> 2
> 2
> 0
> 2
> 2
> 2
2> re:^cns: with about [0-9]e\+[0-9]+ steps up to t = 20 the run does not end: order 76, that of `order: auto`, needs about 3[0-9][0-9]; with max_time
2> re:^cns: with about [0-9]e\+[0-9]+ steps up to t = 20 the run does not end: order 76,
2> re:^cns: with about [0-9]e\+[0-9]+ steps up to t = 20 the run does not end: order 76,
2> re:^cns: with about [0-9]e\+[0-9]+ steps up to t = 20 the run does not end: order 76,
2> re:^cns: with about 2e\+13 steps up to t = 20 the run does not end: take a longer step;
2> re:the run does not end: no order needs fewer than 1e\+10
2> re:^cns: the run under test: t = [0-9.e-]+: with steps of [0-9.e-]+, more than 1e\+10 up to t = 20, the run does not end

= a goal whose run would have no end, in double precision or beyond its range, is refused as well
$ cat > a.yaml; for x in 1e10 1e40; do cns run -q a.yaml --set initial.x=$x > out || echo $?; done; cns plan a.yaml --set initial.x=1e10
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 20}
| goal: {decimals: 10}
> 2
> 2
2> re:^cns: t = [0-9.e-]+: with steps of [0-9.e-]+, more than 1e\+10 up to t = 20, the run does not end; with max_time
2> re:^cns: t = [0-9.e-]+: with steps of [0-9.]+e-40, more than 1e\+10 up to t = 20, the run does not end
2> re:^cns: t = [0-9.e-]+: with steps of
? 2

= with a limit of time it goes as far as it comes, and says how far
$ cat > a.yaml; (cns run -q a.yaml || echo $?) | tail -n 2
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 20, every: 10}
| max_time: 0.01
| numerics: {digits: 50, order: 2}
> re:^# stopped: max_time of 0\.01 s (at t = 0|before the first row)$
> 1
2> re:^cns: stopped by max_time of 0\.01 s (at t = 0; the rows up to there are printed|before the first row)
