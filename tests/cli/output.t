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

= more decimals begin with the fewer, up to rounding
$ cat > a.yaml; for d in 6 9; do cns run -q a.yaml --set goal.decimals=$d | grep -v '^#' | cut -d, -f2-5 > $d; done
$ sed 's/\(\.[0-9]\{5\}\)[0-9]*/\1/g' 6 > a; sed 's/\(\.[0-9]\{5\}\)[0-9]*/\1/g' 9 > b; cmp a b
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 2, every: 0.5}
| goal: {decimals: 6}

= the chosen columns
$ cat > a.yaml; cns run -q a.yaml | grep -v '^#' | head -n 2
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
| output: {columns: [t, omega]}
> re:^t,omega
> re:^0(\.0*)?,1\.0000(,|$)

= a run by hand is not proven, and says so
$ cat > a.yaml; cns run -q a.yaml | grep -c '^# UNPROVEN'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 1

= a place that cannot be written, before the work
$ cat > a.yaml; cns run a.yaml -o nowhere/a.csv
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100000, every: 100}
| goal: {decimals: 100}
2> re:nowhere/a\.csv.*No such file
? 4
% 10

= a directory as the output
$ mkdir d; cat > a.yaml; cns run -q a.yaml -o d
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.5}
| goal: {decimals: 4}
2> re:^cns: d
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
$ { sleep 0.3; cns run -q a.yaml || echo "status $?" >&3; } | :
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 0.001}
| goal: {decimals: 4}
> status 141

= interrupted: the rows so far are whole, and nothing says complete
$ cat > a.yaml
$ timeout --preserve-status -s INT 2 "$CNS" run -q a.yaml > a.csv && exit || echo $?
$ grep -c '^# complete' a.csv || true
$ grep -v '^#' a.csv | awk -F, 'NR == 1 {n = NF} NF != n {print "short row: " $0} END {print (NR > 10)}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100000, every: 0.1}
| numerics: {arithmetic: mpfr, digits: 30}
> 130
> 0
> 1
2> ...
if command -v timeout
% 20

= interrupted with -o: no half file passes for a whole one
$ cat > a.yaml
$ timeout --preserve-status -s TERM 1 "$CNS" run -q a.yaml -o a.csv && exit || echo $?
$ ! grep -s '^# complete' *
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100000, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 143
2> ...
if command -v timeout
% 20

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

= check: standard output closed, and a pipe whose reader has gone
$ cat > a.yaml
$ cns check a.yaml >&- || echo "closed $?"
$ exec 3>&1
$ { sleep 0.3; cns check a.yaml || echo "pipe $?" >&3; } | :
| model: apw
| time: {end: 1}
| goal: {decimals: 4}
> closed 4
> pipe 141
2> ...
