# Where results go, and what happens when they cannot go there.

= a table: provenance, header, rows, the last line
$ cat > a.yaml; cns run -q a.yaml
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 10}
> re:^# 
> ...
> t,x,y,theta,Vx,Vy,omega,decimals,growth
> re:^0(\.0*)?,0\.0000000000,0\.0000000000,1\.0000000000,0\.0000000000,0\.0100000000,1\.0000000000,
> re:^0\.50*,(-?[0-9]+\.[0-9]{10},){6}10,
> re:^1(\.0*)?,(-?[0-9]+\.[0-9]{10},){6}10,
> # complete

= the same bytes on standard output, in a file, and again
$ cat > a.yaml; cns run -q a.yaml > a.csv; cns run -q a.yaml -o b.csv; cns run -q a.yaml -o b.csv
$ cmp a.csv b.csv; ls
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 2, every: 0.5}
| goal: {decimals: 6}
> a.csv
> a.yaml
> b.csv

= fewer decimals are the more, rounded
$ cat > a.yaml; for d in 6 9; do cns run -q a.yaml --set goal.decimals=$d | grep '^[0-9]' | cut -d, -f2-7 | tr ',' '\n' > $d; done
$ paste 6 9 | awk '{d = $1 - $2; if (d * d > 0.2501e-12) print "no rounding: " $0} END {print NR}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 2, every: 0.5}
| goal: {decimals: 6}
> 30

= the chosen columns
$ cat > a.yaml; cns run -q a.yaml | grep -v '^#' | head -n 2
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
| output: {columns: [t, omega]}
> re:^t,omega
> re:^0(\.0*)?,1\.0000(,|$)

= the chosen columns, from the command line
$ cat > a.yaml; cns run -q a.yaml --set 'output.columns=[t, y]' --set 'initial={theta: 1}' | grep '^[^#]\|override\|initial:' | head -n 6
| model: apw
| initial: {theta: 2, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
> # | initial: {theta: 2, Vy: 0.01, omega: 1}
> # override: output.columns=[t, y]
> # override: initial={theta: 1}
> # initial: x = 0, y = 0, theta = 1, Vx = 0, Vy = 0, omega = 0
> t,y,decimals,growth
> 0,0.0000,4,0.000

= a run by hand is not proven, and says so
$ cat > a.yaml; cns run -q a.yaml | grep -c '^# UNPROVEN'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 1

= --prove bounds the error of a Taylor run, and gives decimals in every row
$ cat > a.yaml; cns run -q --prove a.yaml > a.csv; grep -c '^# UNPROVEN' a.csv || true
$ grep '^# proof' a.csv; grep '^1,' a.csv | cut -d, -f8
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 0
> re:^# proof: an enclosure: 
> re:^2[0-9]$

= a run in double by hand: Runge-Kutta, with its step
$ cat > a.yaml; cns run -q a.yaml | grep -E '^# (method|UNPROVEN)|^1,' | cut -d, -f1-4
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| numerics: {method: rk4, arithmetic: double, step: 1e-3}
> re:^# method: double .*Runge-Kutta.*, fixed step 1e-3
> # UNPROVEN
> re:^1,0\.0235664[0-9]*,-0\.2173947[0-9]*,1\.767439[0-9]*$

= provenance: the case, its hash, what was overridden, how it was computed
$ cat > a.yaml; cns run -q a.yaml --set time.end=1 --set parameters.I=2 > a.csv
$ grep '^# [^|]' a.csv | grep -v equations
$ sed -n 's/^# | //p' a.csv | cmp - a.yaml
$ grep -c "SHA-256 $(sha256sum a.yaml | cut -d' ' -f1)$" a.csv
if command -v sha256sum
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 50, every: 0.5}
| goal: {decimals: 4}
> re:^# cns [0-9.]+: 
> # format: 1
> re:^# case: a\.yaml, SHA-256 [0-9a-f]{64}$
> # override: time.end=1
> # override: parameters.I=2
> re:^# parameters: I = 2, CT = 1\.2, CR = pi, 
> re:^# initial: x = 0, y = 0, theta = 1, Vx = 0, Vy = 0\.01, omega = 1$
> # abs: exact
> re:^# method: [0-9]+ digits \([0-9]+ bits\), Taylor series of order [0-9]+
> re:^# proof: an enclosure: the exact solution
> ...
> re:^# libraries: MPFR .*GMP
> # complete
> 1

= times: decimals as they are, others so that they can be had back, whatever the decimals of the values
$ cat > a.yaml; cns run -q a.yaml | grep '^# times\|^[0-9]' | cut -d, -f1 > a; cat a
$ cns run -q a.yaml --set goal.decimals=20 | grep '^# times\|^[0-9]' | cut -d, -f1 | cmp - a
$ cns run -q a.yaml --set time.end=1e-6 --set time.every=1e-7/3 | grep '^# times\|^[0-9]' | cut -d, -f1 > a; sed -n '1,6p;$p' a; sort -u a | wc -l
$ cns run -q a.yaml --set time.every=1/4 | grep -c '^# times' || true
| model: lorenz
| initial: {x: 1}
| time: {end: 1, every: 1/3}
| goal: {decimals: 5}
> # times: each the nearest fraction with a denominator up to 3
> 0
> 0.33333333333333333
> 0.66666666666666667
> 1
> # times: each the nearest fraction with a denominator up to 30000000
> 0
> 0.000000033333333333333333
> 0.000000066666666666666667
> 0.0000001
> 0.000000133333333333333333
> 0.000001
> 32
> 0

= each case that comes with the program, shortly; those of orbits have no goal of their own
$ for c in "$CASES"/*.yaml; do case $c in */orbit-*) continue ;; esac; cns run -q "$c" --set time.end=5 > a.csv || echo "$c: $?"; tail -n 1 a.csv; done | sort -u
> # complete

= from standard input
$ cat "$CASES"/case4.yaml | cns run -q - --set time.end=1 | tail -n 2
> re:^1,0\.0235664610,-0\.2173947277,1\.7674394518,-0\.4459101886,-0\.0246984619,0\.5828787535,10,
> # complete

= fewer decimals than asked: the honest table, and exit 1
$ cat > a.yaml; cns run -q a.yaml > a.csv || echo $?
$ awk -F, '/^[0-9]/ {n++; if ($8 < 30 && $8 > 0) few++; sub(/.*\./, "", $2); if (length($2) != $8) print "row: " $0} END {print n, (few > 0)}' a.csv
$ tail -n 1 a.csv
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5, every: 0.5}
| goal: {decimals: 30, max_digits: 32}
> 1
> 11 1
> # complete
2> re:^cns: .*30 decimals

= a singularity: where, and exit 3; the rows before it stand
$ cat > a.yaml; cns run -q a.yaml > a.csv || echo $?
$ grep -c '^[0-9]' a.csv; tail -n 1 a.csv
| model: apw
| parameters: {A: -2}
| initial: {Vy: -1}
| time: {end: 50, every: 0.5}
| numerics: {arithmetic: double, order: 22}
> 3
> re:^[1-9][0-9]*$
> re:^# stopped: t = [0-9.]+: 
2> re:^cns: t = [0-9.]+: 

= -q is silent, and without a terminal nothing moves the cursor
$ cat > a.yaml; cns run -q a.yaml 2> quiet > a.csv; cns run a.yaml 2> plain > b.csv; cns run -v a.yaml 2> much > c.csv
$ wc -c < quiet | tr -d ' '; cat plain much | tr -d '\r\033' > clean; cat plain much | cmp - clean; cmp a.csv b.csv; cmp a.csv c.csv
$ grep -c 'digits, order' plain; tail -n 1 much
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
> 0
> 1
> re:^cns: [0-9]+ steps, [0-9]+ landings, 

= a summary of a run that has not begun, and of one that ended early
$ cat > a.yaml; cns run -q a.yaml --yaml --set goal.max_time=1e-9 | grep -v wall_s
$ cns run -q a.yaml --yaml --set goal.max_digits=26 --set goal.decimals=10 --set time.end=500 | sed -n 's/^end: [0-9]*\.[0-9]$/a decimal/p'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.1}
| goal: {decimals: 4}
> end: 0
> digits: 0
> order: 0
> steps: 0
> landings: 0
> events: 0
> a decimal
2> cns: max_time of 1e-09 s is used up while planning
2> re:^cns: no decimal can be proven from t = 

= a file has the mode that the user's mask gives it
$ cat > a.yaml; umask 027; cns run -q a.yaml -o a.csv; ls -l a.csv | cut -c1-10
| model: apw
| time: {end: 1, every: 0.5}
| initial: {Vy: 0.5}
| goal: {decimals: 4}
> -rw-r-----

= a place that cannot be written, before the work
$ cat > a.yaml; cns run a.yaml -o nowhere/a.csv
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100000, every: 100}
| goal: {decimals: 100}
2> re:nowhere/a\.csv.*No such file
? 4

= a directory as the output
$ mkdir d; cat > a.yaml; cns run -q a.yaml -o d
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
2> re:^cns: .* d: Is a directory
? 4

= a directory without permission
$ mkdir d; chmod a-w d; cat > a.yaml; cns run -q a.yaml -o d/a.csv
if test "$(id -u)" != 0
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
2> re:d/a\.csv.*Permission denied
? 4

= a failed run leaves the old file
$ echo old > a.csv; echo 'model: none' > a.yaml; cns run -q a.yaml -o a.csv 2> /dev/null || cat a.csv
> old

= a full device
$ cat > a.yaml; cns run -q a.yaml > /dev/full
if test -w /dev/full
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
2> re:No space left
? 4

= help and the version on a full device
$ cns help > /dev/full || echo $?
$ cns --version > /dev/full || echo $?
if test -w /dev/full
> 4
> 4
2> ...

= standard output closed
$ cat > a.yaml; cns run -q a.yaml >&-
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
2> ...
? 4

= a pipe whose reader has gone
$ cat > a.yaml; exec 3>&1
$ { wait_for 'test -e gone'; cns run -q a.yaml || echo "status $?" >&3; } | { exec <&-; : > gone; }
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.001}
| goal: {decimals: 4}
> status 141

= interrupted: the rows so far are whole, and nothing says complete
$ cat > a.yaml; cns run -q a.yaml > a.csv & wait_for 'test $(grep -c "^[0-9]" a.csv) -gt 10'
$ kill -INT $!; wait $! || echo $?
$ tail -n 1 a.csv; grep -v '^#' a.csv | awk -F, 'NR == 1 {n = NF} NF != n {print "short row: " $0}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1e6, every: 0.1}
| numerics: {arithmetic: mpfr, digits: 30}
> 130
> re:^# stopped: signal INT \(Ctrl-C\) at t = 

= interrupted while the reader is slow
$ cat > a.yaml; mkfifo p; { read -r first; : > began; wait_for 'test -e go'; cat > a.csv; } < p &
$ cns run -q a.yaml > p & run=$!; wait_for 'test -e began'; wait_for 'grep "^State:.S" /proc/$run/status'
$ kill -INT $run; : > go; wait $run || echo $?
$ wait; tail -n 1 a.csv; grep '^[0-9]' a.csv | awk -F, 'NF != 9 {print "short row: " $0}'
| model: apw
| initial: {Vy: 0.01}
| time: {end: 9999, every: 0.001}
| numerics: {arithmetic: mpfr, digits: 30}
> 130
> re:^# stopped: signal INT \(Ctrl-C\) at t = 
if test -r /proc/self/status

= interrupted with -o: no half file passes for a whole one
$ cat > a.yaml; cns run -q a.yaml -o a.csv & wait_for 'grep "^[0-9]" a.csv.*'
$ kill -TERM $!; wait $! || echo $?; ls; tail -n 1 a.csv
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 143
> a.csv
> a.yaml
> re:^# stopped: signal TERM at t = 

= a summary as YAML
$ cat > a.yaml; cns run -q --yaml a.yaml | grep -oE '^(end|decimals|digits|order|steps): [0-9]+' | sed 's/:.*//' | sort
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
> decimals
> digits
> end
> order
> steps

= a summary beside a table
$ cat > a.yaml; cns run -q --yaml a.yaml -o a.csv | grep -E '^(end|decimals)'; tail -n 1 a.csv
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
> end: 1
> decimals: 4
> # complete

= check: standard output closed, and a pipe whose reader has gone
$ cat > a.yaml
$ cns check a.yaml >&- || echo "closed $?"
$ exec 3>&1
$ { wait_for 'test -e gone'; cns check a.yaml || echo "pipe $?" >&3; } | { exec <&-; : > gone; }
| model: apw
| time: {end: 1}
| goal: {decimals: 4}
> closed 4
> pipe 141
2> ...

= every file has the mode of a new file, those of a study too
$ umask 027; cat > a.yaml; cns run -q a.yaml -o a.csv --events e.csv --section z=20
$ cns laws -q a.yaml -o runs >/dev/null
$ find . -type f ! -name a.yaml ! -perm 640; find runs -type f | grep -c .
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 40, every: 1/4}
| goal: {decimals: 3}
| laws: {digits: {from: 4, to: 6}}
> re:^[1-9]

= a summary counts the landings on kinks, under their older name, too
$ cat > a.yaml; cns run -q --yaml a.yaml | awk '/^landings/ {n = $2} /^events/ {print (n > 0 && $2 == n)}'
$ cns run -q --yaml a.yaml --set abs.smooth=1e-3 | grep landings
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 12}
| goal: {decimals: 4}
> 1
> landings: 0
