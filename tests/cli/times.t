# Times: against time, from another start than 0, at a list of times.

= forwards and then backwards comes home, with the same rows and the same events
$ cat > a.yaml; cns run -q a.yaml --events e.csv --section z=27 --section z=extremum > a.csv
$ at() { grep '^2,' a.csv | cut -d, -f$1; }
$ cns run -q a.yaml --set goal.decimals=15 --set "initial={x: $(at 2), y: $(at 3), z: $(at 4)}" --set 'time={start: 2, end: 0, every: 1/3}' --events f.csv --section z=27 --section z=extremum > b.csv
$ grep '^0,' b.csv | cut -d, -f1-5
$ for f in a b; do grep '^[0-9]' $f.csv | sort -g | cut -d, -f1-4 | LC_ALL=C awk -F, '{print $1, substr($2, 1, 15), substr($3, 1, 15), substr($4, 1, 15)}' > $f; done; cmp a b; wc -l < a
$ cut -d, -f1-3 e.csv | grep '^z' | awk -F, '{print $1, $2, substr($3, 1, 14)}' > e; tac f.csv | cut -d, -f1-3 | grep '^z' | awk -F, '{print $1, $2, substr($3, 1, 14)}' | cmp - e; wc -l < e
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 2, every: 1/3}
| goal: {decimals: 40}
> 0,1.000000000000000,1.000000000000000,1.000000000000000,15
> 7
> 13

= a Taylor series with a goal and Runge-Kutta's method by hand agree against time
$ cat > a.yaml; cns run -q a.yaml > a.csv; cns run -q a.yaml --set 'numerics={method: rk4, arithmetic: double, step: 1e-4}' > b.csv
$ cns run -q a.yaml --set 'numerics={method: taylor, digits: 20}' --prove > c.csv
$ cns compare a.csv b.csv --decimals 7 > /dev/null; cns compare a.csv c.csv --decimals 12 > /dev/null
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: -0.25, every: 1/16}
| goal: {decimals: 15}

= a start moves the times and nothing else; they are exact when read back
$ cat > a.yaml; cns run -q a.yaml | grep '^[0-9]' | cut -d, -f2- > a
$ cns run -q a.yaml --set time.start=-1/3 --set time.end=2/3 > b.csv; grep '^[-0-9]' b.csv | cut -d, -f2- | cmp - a; grep '^# start\|^# times' b.csv; grep '^[-0-9]' b.csv | cut -d, -f1
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1, every: 1/4}
| goal: {decimals: 10}
> # start: t = -1/3
> # times: each the nearest fraction with a denominator up to 12
> re:^-0\.33333333333333333
> re:^-0\.08333333333333333
> re:^0\.16666666666666666
> re:^0\.41666666666666666
> re:^0\.66666666666666666

= a list of times has the rows of a grid that has these times
$ cat > a.yaml; cns run -q a.yaml | grep '^[0-9]' | grep -E '^(0\.5|0\.66666666666666667|3|4),' > a; cns run -q a.yaml --set 'time={at: [0.5, 2/3, 3, 4]}' | grep '^[0-9]' | cmp - a; wc -l < a
$ cns run -q a.yaml --set 'time={start: 0.5, at: [0.25, 0]}' | grep '^[0-9]' | cut -d, -f1
$ cns plan a.yaml --set 'time={at: [0.5, 4]}' | head -n 1; cns plan a.yaml --set 'time={start: 0.5, end: 0}' --until 0.2 | head -n 1
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 4, every: 1/6}
| goal: {decimals: 15}
> 4
> 0.25
> 0
> to t = 4 with 15 decimals:
> to t = 0.2 with 15 decimals:

= messages name the time, not what has passed
$ cat > a.yaml; cns run -q a.yaml > out || echo $?; cns run -q a.yaml --set time.start=100 --set time.end=50 > out || echo $?
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| parameters: {I: 1.1}
| time: {end: -50}
| numerics: {digits: 20}
> 3
> 3
2> re:^cns: t = -1\.363.*a pole$
2> re:^cns: t = 98\.636.*a pole$

= what cannot be
$ cat > a.yaml; for t in '{end: 0}' '{start: 1, end: 1}' '{at: [1, 2, 1.5]}' '{at: [0]}' '{at: [1], end: 2}' '{at: [1], every: 2}' '{at: 3}' '{at: [1, pi]}' '{start: pi, end: 4}'; do cns check -q a.yaml --set "time=$t" || true; done
$ for t in '{end: -1}' '{start: 1, end: 2}' '{at: [1, 2]}'; do cns tc a.yaml --set "time=$t" || echo $?; done; cns plan a.yaml --set time.end=-1 --until 1 || echo $?
| model: lorenz
| initial: {x: 1}
| time: {end: 1}
| numerics: {digits: 20}
> 2
> 2
> 2
> 2
2> re:must differ from the start, 0$
2> re:must differ from the start, 1$
2> re:go away from the start in one direction: 1\.5 does not$
2> re:go away from the start in one direction: 0 does not$
2> re:'end' in 'time' does not go with 'at'
2> re:'every' in 'time' does not go with 'at'
2> re:'at' in 'time' must be a list of times
2> re:a multiple of pi is none$
2> re:'start' in 'time' must be a decimal or a fraction
2> re:it takes no end before the start$
2> re:it takes no other start$
2> re:it takes no list of times$
2> re:--until takes a rational number below 0, not '1'

= the studies of what the motion does for ever take no notice of the times
$ cat > a.yaml; cns lyapunov -q a.yaml > a; cns lyapunov -q a.yaml --set time.end=-1 | grep '^# lambda' > b; grep '^# lambda' a | cmp - b
| model: lorenz
| initial: {x: 1}
| time: {end: 1}
| lyapunov: {time: 100}
