# A limit of time ends every command that computes, with what it has; the limit here is used up at once.

= each command says so, also with -q, and where it was
$ cat > a.yaml; limit='--max-time 1e-9'
$ for c in 'run -o r.csv' plan lyapunov classify equilibria orbit; do cns $c -q a.yaml --set 'goal={decimals: 10}' $limit || echo $?; done; ls
$ cns tc -q a.yaml --set numerics.digits=20 $limit || echo $?
$ cns bisect -q "$CASES"/heteroclinic.yaml $limit || echo $?
$ cns laws -q "$CASES"/laws-smoke.yaml -o kept $limit || echo $?
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 1e7, every: 1e5}
> 1
> 1
> 1
> mode        undecided   stopped at t = 0
> 1
> 1
> 1
> a.yaml
> 1
> 1
> 1
2> cns: max_time of 1e-09 s is used up while planning
2> cns: max_time of 1e-09 s is used up while planning
2> re:^cns: stopped by max_time of 1e-09 s at 0 % \(largest exponent\); nothing is kept
2> re:^cns: stopped by max_time of 1e-09 s
2> re:^cns: stopped by max_time of 1e-09 s at 0 %
2> re:^cns: stopped by max_time of 1e-09 s
2> re:^cns: stopped by max_time of 1e-09 s at 0 %
2> re:^cns: stopped by max_time of 1e-09 s.*with -o DIR it would go on$
2> re:^cns: stopped by max_time of 1e-09 s.*kept in kept: the same command goes on from there$

= a run by hand: the rows up to there, and the last line
$ cat > a.yaml; cns run -q a.yaml | tail -n 2 | cut -d, -f1-2; cns check a.yaml | grep max_time
| model: lorenz
| initial: {x: 1}
| time: {end: 1e7, every: 1e5}
| max_time: 1e-9
| numerics: {digits: 20}
> 0,1
> # stopped: max_time of 1e-09 s at t = 0
> max_time: 1e-09
2> cns: stopped by max_time of 1e-09 s at t = 0; the rows up to there are printed; the same command begins anew

= a sweep: its table says how many rows there are
$ cns classify -q "$CASES"/flutter.yaml --sweep I=1.1:1.2:0.1 --max-time 1e-9 | tail -n 1
> # stopped: max_time of 1e-09 s, 0 of 2 values
2> re:^cns: stopped by max_time of 1e-09 s

= of two limits the smaller one counts; one that is never reached changes nothing
$ cat > a.yaml; cns run -q a.yaml --max-time 1000 > /dev/null || echo $?
$ cns run -q a.yaml --set goal.max_time=1000 > a; cns run -q a.yaml --set goal.max_time=1000 --max-time 999 | cmp - a
| model: lorenz
| initial: {x: 1}
| time: {end: 1}
| goal: {decimals: 10, max_time: 1e-9}
> 1
2> cns: max_time of 1e-09 s is used up while planning

= limits that are none
$ cns classify "$CASES"/flutter.yaml --max-time 0 || echo $?
$ cns classify "$CASES"/flutter.yaml --set max_time=soon || echo $?
> 2
> 2
2> re:--max-time
2> re:max_time
