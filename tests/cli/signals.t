# What is left when a run ends too early: by a signal, a limit, or by itself.

= each signal that stops: its status, and the last line of the table names it
$ cat > a.yaml
$ for s in INT TERM HUP XCPU USR1 USR2; do
$ rm -f a.csv; cns run -q a.yaml -o a.csv & wait_for 'grep "^[0-9]" a.csv.*'
$ kill -$s $!; wait $! || echo $?; tail -n 1 a.csv; done; ls
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 130
> re:^# stopped: signal INT \(Ctrl-C\) at t = [0-9.]+$
> 143
> re:^# stopped: signal TERM at t = [0-9.]+$
> 129
> re:^# stopped: signal HUP .* at t = [0-9.]+$
> 152
> re:^# stopped: signal XCPU .* at t = [0-9.]+$
> 138
> re:^# stopped: signal USR1 at t = [0-9.]+$
> 140
> re:^# stopped: signal USR2 at t = [0-9.]+$
> a.csv
> a.yaml

= the time in the last line is that of the last row
$ cat > a.yaml; cns run -q a.yaml -o a.csv & wait_for 'grep "^[0-9]" a.csv.*'
$ kill -INT $!; wait $! || true; tail -n 2 a.csv | awk -F'[,=]' 'NR == 1 {t = $1} END {print (NR == 2 && t == $2 + 0)}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 1

= a complete table stays, and the rows of a stopped run go beside it
$ cat > a.yaml; cns run -q a.yaml -o a.csv --set time.end=1; cp a.csv old.csv
$ for q in '' -q; do cns run $q a.yaml -o a.csv & wait_for 'grep "^[0-9]" a.csv.??????'
$ kill -INT $!; wait $! || echo $?; cmp a.csv old.csv; done; ls
$ tail -n 1 a.csv.partial
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 130
> 130
2> re:^cns: about [0-9.e+]+ steps, [0-9]+ s$
> a.csv
> a.csv.partial
> a.yaml
> old.csv
> re:^# stopped: signal INT
2> re:^cns: stopped by signal INT \(Ctrl-C\) at t = [0-9.]+; the rows up to there are in a\.csv\.partial: a\.csv is .*, and stays; the same command begins anew$
2> re:^cns: the rows up to there are in a\.csv\.partial: a\.csv is .*, and stays$

= so does whatever else is there, but a stopped table is replaced
$ cat > a.yaml; echo 'my notes' > a.csv; : > b.csv
$ for i in 1 2; do for f in a b; do cns run -q a.yaml -o $f.csv 2> note || echo $?; done; done; cat a.csv; tail -n 1 b.csv a.csv.partial; ls
| model: apw
| parameters: {A: -2}
| initial: {Vy: -1}
| time: {end: 50, every: 0.5}
| numerics: {arithmetic: double, order: 22}
> 3
> 3
> 3
> 3
> my notes
> ==> b.csv <==
> re:^# stopped: t = [0-9.]+: 
>
> ==> a.csv.partial <==
> re:^# stopped: t = [0-9.]+: 
> a.csv
> a.csv.partial
> a.yaml
> b.csv
> note

= stopped before its first row, a run leaves nothing and replaces nothing
$ cat > a.yaml; echo '# stopped: long ago' > old.csv
$ for f in old new; do cns run a.yaml -o $f.csv & wait_for "catches $!"; kill -TERM $!; wait $! || echo $?; done; cat old.csv; ls
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1e7, every: 100}
| goal: {decimals: 10}
> 143
> 143
> # stopped: long ago
> a.yaml
> old.csv
2> cns: stopped by signal TERM before the first row; nothing is written to old.csv; the same command begins anew
2> cns: stopped by signal TERM before the first row; nothing is written to new.csv; the same command begins anew

= on standard output there is a table all the same
$ cat > a.yaml; cns run -q a.yaml > a.csv & wait_for "catches $!"; kill -TERM $!; wait $! || echo $?
$ grep -v '^# |' a.csv
| model: lorenz
| time: {end: 1e7, every: 100}
| goal: {decimals: 10}
> 143
> re:^# cns [0-9.]+: 
> ...
> re:^# equations: 
> re:^# case: a\.yaml, SHA-256 
> re:^# parameters: 
> re:^# initial: 
> # abs: exact
> t,x,y,z,decimals,growth
> # stopped: signal TERM before the first row

= a limit ends a table by its name
$ cat > a.yaml; cns run -q a.yaml || echo $?
| model: lorenz
| initial: {x: 1}
| time: {end: 1e7, every: 1e5}
| goal: {decimals: 10, max_time: 1e-9}
> re:^# cns 
> ...
> t,x,y,z,decimals,growth
> # stopped: max_time of 1e-09 s is used up while planning
> 1
2> cns: max_time of 1e-09 s is used up while planning

= a second Ctrl-C ends it at once, and leaves no unfinished file
$ cat > a.yaml; cns run -q a.yaml -o a.csv --events e.csv & wait_for 'ls a.csv.* e.csv.*'; wait_for "catches $!"
$ kill -INT $!; while kill -INT $!; do :; done 2> /dev/null; wait $! || echo $?; ls
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1}
| numerics: {digits: 30000}
> 130
> a.yaml

= nor does a signal that is not for stopping in order
$ cat > a.yaml
$ for s in QUIT ABRT; do env --default-signal=$s sh -c 'ulimit -c 0; exec cns run -q a.yaml -o a.csv' & wait_for 'grep "^[0-9]" a.csv.*'
$ kill -$s $!; wait $! || echo $?; done 2> /dev/null; ls
if env --default-signal=QUIT true
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 131
> 134
> a.yaml

= what nohup has ignored stays ignored
$ cat > a.yaml; (trap '' HUP; exec cns run -q a.yaml > a.csv) & wait_for 'grep "^[0-9]" a.csv'
$ kill -HUP $!; n=$(grep -c '^[0-9]' a.csv || true); wait_for 'test $(grep -c "^[0-9]" a.csv) -gt $((n + 10))'
$ kill -TERM $!; wait $! || echo $?; tail -n 1 a.csv
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 143
> re:^# stopped: signal TERM at t = 

= a file that may not grow so large is a failed write
$ cat > a.yaml
$ (ulimit -f 8; cns run -q a.yaml -o a.csv) || echo $?
$ (ulimit -f 8; cns run -q a.yaml > b.csv) || echo $?
$ (ulimit -f 8; cns run -q a.yaml -o /dev/null --events e.csv --set time.every=5000 --set time.end=5000) || echo $?; ls
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 0.5}
| numerics: {arithmetic: double, order: 20}
> 4
> 4
> 4
> a.yaml
> b.csv
2> cns: cannot write a.csv: File too large
2> cns: cannot write to standard output: File too large
2> cns: cannot write e.csv: File too large

= events whose file cannot be written fail before the work
$ cat > a.yaml; cns run -q a.yaml -o a.csv --events nowhere/e.csv || echo $?; ls
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100000, every: 100}
| goal: {decimals: 100}
> 4
> a.yaml
2> re:nowhere/e\.csv.*No such file

= the events of a stopped run, too, stay off a complete table
$ cat > a.yaml; cns run -q a.yaml -o a.csv --events e.csv --set time.end=10; cp e.csv old.csv
$ cns run -q a.yaml -o /dev/null --events e.csv & wait_for "catches $!"; wait_for 'ls e.csv.*'; kill -INT $!; wait $! || echo $?
$ cmp e.csv old.csv; rm -f e.csv.partial; ls
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 0.5}
| numerics: {arithmetic: mpfr, digits: 30}
> 130
> a.csv
> a.yaml
> e.csv
> old.csv
2> ...

= a study that is stopped says where it was, what is kept, and how to go on
$ cat > a.yaml; cns tc a.yaml & wait_for "catches $!"; kill -INT $!; wait $! || echo $?
$ cns lyapunov a.yaml & wait_for "catches $!"; kill -INT $!; wait $! || echo $?
$ cns laws a.yaml -o kept & wait_for 'ls kept'; kill -INT $!; wait $! || echo $?
$ cns laws a.yaml & wait_for "catches $!"; kill -INT $!; wait $! || echo $?
$ cns bisect a.yaml > b.txt & wait_for "catches $!"; kill -INT $!; wait $! || echo $?
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5e6, every: 1}
| numerics: {arithmetic: mpfr, digits: 3000}
| lyapunov: {time: 1e9}
| laws: {digits: {from: 20, to: 1000, by: 20}}
| bisect: {parameter: I, lower: 1.2191, upper: 1.2192, decimals: 1000}
> 130
> 130
> 130
> 130
> 130
2> re:^cns: stopped by signal INT \(Ctrl-C\).*; nothing is kept: the same command begins anew$
2> re:^cns: stopped by signal INT \(Ctrl-C\).*; nothing is kept: the same command begins anew$
2> re:^cns: stopped by signal INT \(Ctrl-C\) at [0-9]+ % \(.*\); what is finished is kept in kept: the same command goes on from there$
2> re:^cns: stopped by signal INT \(Ctrl-C\).*; nothing is kept: the same command begins anew, with -o DIR it would go on$
2> re:^cns: stopped by signal INT \(Ctrl-C\).*; nothing is kept: the same command begins anew, with -o DIR it would go on$

= a sweep that is stopped prints the rows it has
$ cns classify "$CASES"/modes.yaml --sweep I=1.0:3.2:0.001 -o kept > a.csv & wait_for 'grep -l complete kept/*'
$ kill -INT $!; wait $! || echo $?; tail -n 1 a.csv
> 130
> re:^# stopped: signal INT \(Ctrl-C\), [1-9][0-9]* of 2201 values$
2> re:^cns: stopped by signal INT .* \([1-9].* of 2201 runs done\); what was found so far is printed; what is finished is kept in kept: the same
