# Sweeps: the study of a command for many values of one number.

= downwards, with a second table: one row for every maximum
$ cat > a.yaml; cns classify -q a.yaml --sweep R=350:300:50 --observable x --maxima m.csv > t.csv
$ grep -v '^#' t.csv | cut -d, -f1-4; grep -v '^#' m.csv; tail -n 1 m.csv; sed -n 's/^# sweep/sweep/p' t.csv m.csv
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
> R,mode,symmetry,returns
> 350,periodic,half-turn,1
> 300,periodic,none,1
> R,n,x
> 350,1,50.3158889433
> 300,1,49.0306299986
> # complete
> sweep: R=350:300:50
> sweep: R=350:300:50

= any number of maxima, those of the second half of the time: with half of it there are half as many
$ cat > a.yaml; for t in 400 800; do cns classify -q a.yaml --until $t --sweep R=28:28:1 --maxima m$t > t
$ grep -c '^28,' m$t > n$t; done; paste n400 n800 | awk '{print ($1 > 200 && $2 > 1.9 * $1 && $2 < 2.1 * $1)}'
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
> 1

= of a state at the start; each half of the plane falls to its own fixed point
$ cat > a.yaml; cns lyapunov -q a.yaml --sweep initial.x=-1:1:2 | grep -v '^#' | cut -d, -f1-2
$ cns run -q a.yaml --sweep initial.x=1:-1:2 | grep -v '^#'
| model: lorenz
| parameters: {R: 10}
| time: {end: 40, every: 40}
| goal: {decimals: 3}
| lyapunov: {time: 1000}
> initial.x,lambda
> re:^-1,-0\.595
> re:^1,-0\.595
> initial.x,t,x,y,z,decimals,growth
> re:^1,0,1\.000,0\.000,0\.000,
> re:^1,40,4\.899,4\.899,9\.000,3,
> re:^-1,0,-1\.000,0\.000,0\.000,
> re:^-1,40,-4\.899,-4\.899,9\.000,3,

= finished values are kept, whatever the threads, and the second table with them
$ cat > a.yaml; cns classify -q a.yaml --sweep R=300:350:50 --keep kept --maxima m1 --threads 3 > t1; ls kept
$ cns classify -q a.yaml --sweep R=300:350:50 --keep kept --maxima m2 --max-time 1e-9 > t2; cmp t1 t2; cmp m1 m2
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
> R=300
> R=350

= a sweep that is stopped replaces no complete table
$ cat > a.yaml; cns run -q a.yaml --sweep R=1:2:1 -o t.csv; cp t.csv old.csv
$ cns run -q a.yaml --sweep R=1:2:1 -o t.csv --max-time 1e-9 || echo $?; cmp t.csv old.csv; ls
| model: lorenz
| initial: {x: 1}
| time: {end: 1}
| goal: {decimals: 3}
> 1
> a.yaml
> old.csv
> t.csv
2> re:stopped by max_time of 1e-09 s

= a value that cannot be done says so in its table; the others are there
$ cat > a.yaml; cns run -q a.yaml --sweep sigma=10:-10000000000:10000000010 > t || echo $?; grep -v '^#' t | cut -d, -f1-2; tail -n 2 t
| model: lorenz
| initial: {x: 1}
| time: {end: 1}
| goal: {decimals: 3, max_digits: 40}
> 1
> sigma,t
> 10,0
> 10,1
> -10000000000,0
> re:^# sigma=-10000000000: t = .*the run does not end
> # complete
2> cns: 1 of 2 values could not be done as asked: the table says why

= T_c: a row for every observable
$ cat > a.yaml; cns tc -q a.yaml --sweep R=28:27:1 | grep -v '^#'
$ cns tc -q a.yaml --yaml | sed -n 's/^  x: //p'
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 40}
| numerics: {digits: 6}
> R,observable,tc,beyond,note
> re:^28,norm,[0-9]+\.[0-9]{6},,$
> re:^28,x,[0-9]+\.[0-9]{6},,$
> re:^28,y,[0-9]+\.[0-9]{6},,$
> re:^28,z,[0-9]+\.[0-9]{6},,$
> re:^27,norm,
> re:^27,x,
> re:^27,y,
> re:^27,z,
> re:^[0-9]+\.[0-9]{6}$

= what a sweep does not go with
$ for c in 'run --yaml' 'run --events e.csv' 'lyapunov --yaml' 'tc --yaml' 'orbit --yaml'; do cns $c "$CASES"/flutter.yaml --sweep I=1:2:1 || echo $?; done
$ cns run "$CASES"/flutter.yaml --keep kept || echo $?
$ cns run "$CASES"/flutter.yaml --sweep initial.I=1:2:1 || echo $?
> 2
> 2
> 2
> 2
> 2
> 2
> 2
2> ...
