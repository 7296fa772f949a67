# Modes of motions, sweeps over a parameter, and tables of events.

= flutter, and what is known of it
$ cns classify -q --yaml "$CASES"/flutter.yaml
> mode: flutter
> period: 15.9529832448
> symmetry: mirror
> winding: 0
> returns: 1
> multiplier: 0.05695
> re:^amplitude: 1\.518
> re:^descent: 0\.584
> drift:
> re:^  x: 0\.0000000000$
> ...
> lambda: 0
> re:^lambda_note: 'exact: a shift along the cycle
> observable: omega
> maxima:
> ...
> re:^transient: 
> re:^time: 
> digits: 30

= tumbling just above the critical value
$ cns classify -q "$CASES"/tumble-1.2192.yaml | head -n 5
> mode        tumble
> re:^period      55\.9797|^period      55\.9794
> symmetry    turn
> re:^winding     -?1 
> re:^returns     1 

= period two
$ cns classify -q "$CASES"/modes.yaml | sed -n '1,2p;5p'
> mode        tumble
> re:^period      13\.35873794
> re:^returns     2 

= chaos, by its exponent, over a time that is told
$ cns classify -q --yaml "$CASES"/case4.yaml > t; grep -e '^mode' -e '^lambda:' -e '^note' t
$ awk '/^time:/ {t = $2} /^note:/ {print ($NF == t)}' t
> mode: chaotic
> re:^lambda: 0\.1[234]
> re:^note: up to t = [0-9.]+$
> 1

= chaos beside fixed points that attract may be a transient, as it is below R = 24.06
$ cat > a.yaml; cns classify -q a.yaml | head -n 1
| model: lorenz
| parameters: {R: 23.8}
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
> re:^mode        chaotic   up to t = [0-9.]+; it may end later: fixed points that attract: C\+, C-$

= a symmetry that the model declares: at R = 350 a half-turn after half of the period, at R = 300 none
$ cat > a.yaml; for r in 350 300; do cns classify -q a.yaml --set parameters.R=$r | sed -n '2,3p;6p' | cut -c1-26; done
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
> period      0.3884875818
> symmetry    half-turn
> multiplier  0.8676   of a 
> period      0.4198562256
> symmetry    none
> multiplier  0.7975   of a 

= the multiplier, by another route: that of the orbit in many digits
$ for c in flutter tumble; do cns classify -q --yaml "$CASES"/$c.yaml | sed -n 's/^multiplier: //p' > c
$ cns orbit -q --yaml "$CASES"/$c.yaml | sed -n '/^multipliers_of_repetition/{n;s/.*re: -*//p}' > o; paste c o; done | awk '{print ($1 > 0 && ($1 - $2) ^ 2 < (0.6e-4 * $1) ^ 2 + 1e-12)}'
> 1
> 1

= a cycle that is approached slowly is found: the multiplier at R = 313.5 is 0.998
$ cat > a.yaml; cns classify -q a.yaml | sed -n '1,3p;6p' | cut -c1-26
| model: lorenz
| parameters: {R: 313.5}
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
> mode        periodic
> period      0.4108152414
> symmetry    half-turn
> re:^multiplier  0\.998[0-9]   of a 

= chaos that ends is not chaos: below R = 24.06 Lorenz's equations settle, after long chaotic transients
$ cat > a.yaml; cns classify -q --sweep R=22.5:22.5:1 a.yaml > t; grep -v '^#' t | cut -d, -f1,2,13
$ grep -v '^#' t | tr -cd ',\n' | uniq | wc -l
| model: lorenz
| initial: {x: 3, y: 0, z: 20}
| time: {end: 1}
| goal: {decimals: 10}
> R,mode,note
> re:^22.5,(steady|undecided),
> 1

= a long stay near a saddle is no steady motion; one on its stable manifold for ever is
$ cat > a.yaml; cns classify -q a.yaml | head -n 1; cns classify -q --set initial.x=0 a.yaml | head -n 1
$ cns classify -q "$CASES"/case1.yaml | head -n 1
$ cns classify -q "$CASES"/case1.yaml --set initial.theta=1e-1000 | head -n 1
| model: lorenz
| initial: {x: 1e-5000, y: 0, z: 1}
| time: {end: 1}
| goal: {decimals: 10}
> re:^mode        undecided   .*does not attract
> mode        steady
> mode        steady
> re:^mode        undecided

= undecided is status 1
$ cns classify -q --until 20 "$CASES"/flutter.yaml
> re:^mode        undecided   .*up to t = 20
? 1

= a sweep: a row for every value, kept and used again, whatever the threads
$ cns classify -q --threads 1 "$CASES"/flutter.yaml --sweep I=1.1:1.2:1/10 > a
$ cns classify -q --threads 3 "$CASES"/flutter.yaml --sweep I=1.1:1.2:1/10 -o kept > b
$ cmp a b; ls kept
$ cns classify -q "$CASES"/flutter.yaml --sweep I=1.1:1.2:0.1 -o kept | sed 's/sweep.*/sweep/' > c; sed 's/sweep.*/sweep/' a | cmp - c
$ grep -v '^#' a | cut -d, -f1-6
> I=1.1
> I=1.2
> I,mode,symmetry,returns,winding,period
> 1.1,flutter,mirror,1,0,15.9529832448
> 1.2,flutter,mirror,1,0,25.2220502254

= a sweep names what was overridden
$ cns classify -q "$CASES"/flutter.yaml --set parameters.CT=1.2 --sweep I=1.1:1.1:1 | grep '^# override'
> # override: parameters.CT=1.2

= faults of the command line
$ cns classify "$CASES"/flutter.yaml --sweep I=1:2:-1 || echo $?
$ cns classify "$CASES"/flutter.yaml --sweep J=1:2:1 || echo $?
$ cns classify "$CASES"/flutter.yaml --observable foo || echo $?
$ cns classify "$CASES"/flutter.yaml --until soon || echo $?
$ cns classify "$CASES"/flutter.yaml -o there || echo $?
> 2
> 2
> 2
> 2
> 2
2> re:--sweep: the step -1 leads away from 2
2> re:--sweep: .*no such parameter
2> re:--observable: .*no state 'foo'
2> re:--until takes a time
2> re:needs --sweep

= events: proven like rows, fewer decimals are the more, rounded
$ cat > a.yaml; for d in 6 9; do cns run -q a.yaml --set goal.decimals=$d --events e$d --section Vy=extremum -o t; done
$ for d in 6 9; do grep -v '^#' e$d | tail -n +2 | cut -d, -f3-9 | tr ',' '\n' > $d; done
$ paste 6 9 | awk '{d = $1 - $2; if (d * d > 0.2501e-12) print "no rounding: " $0} END {print NR}'
$ cut -d, -f1,2,10 e9 | grep -v '^#'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 8, every: 4}
| goal: {decimals: 6}
> 28
> event,direction,decimals
> Vy extremum,1,9
> theta=1*pi,1,9
> Vy extremum,-1,9
> omega=0,-1,9

= events of a run by hand carry the digits of the arithmetic, and say so
$ cat > a.yaml; cns run -q a.yaml --events e -o t; grep -c UNPROVEN e; cns run -q --prove a.yaml --events p -o t
$ grep -c UNPROVEN p || true; grep '^theta' e | cut -d, -f1,3; grep '^theta' p | cut -d, -f1,3,10
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5, every: 5}
| numerics: {arithmetic: fast, digits: 20}
> 1
> 0
> re:^theta=1\*pi,3\.70660244594701[0-9]{5}$
> re:^theta=1\*pi,3\.70660244594701[0-9]*,1[0-9]$

= events are named by their conditions
$ cat > a.yaml; cns run -q a.yaml --events e -o t --section 'theta=1 mod 2' --section 'theta=0 mod 3' --section omega=extremum
$ grep -v '^#' e | tail -n +2 | cut -d, -f1 | sort -u
| model: apw
| initial: {theta: 0.5, Vy: 0.01, omega: 2}
| time: {end: 10, every: 10}
| goal: {decimals: 6}
> omega extremum
> omega=0
> theta=1*3
> theta=1*pi
> theta=1+0*2
> theta=1+1*2

= events can be read by those who can read the table
$ umask 027; cns run -q "$CASES"/flutter.yaml --set time.end=1 --events e -o t; stat -c %a e t
> 640
> 640

= events where the disk passes the singularity of rest at a distance of 1e-33
$ cat > a.yaml; cns run -q a.yaml --events e -o t; tail -n 1 e
| model: apw
| initial: {theta: 1e-30, Vy: 0.01}
| time: {end: 2, every: 1}
| goal: {decimals: 40}
> # complete

= sections that are none
$ for s in Vy Vy=x foo=1 'theta=0 mod 0'; do cns run -q "$CASES"/flutter.yaml --events e --section "$s" -o t || echo $?; done; ls
$ cns run -q "$CASES"/flutter.yaml --section Vy=0 || echo $?
$ cns run -q "$CASES"/lorenz.yaml --events e || echo $?
> 2
> 2
> 2
> 2
> 2
> 2
2> ...
