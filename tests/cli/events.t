# Events at the start: nothing at t = 0 counts.

= a start on three sections at once: with a goal, by hand, and in double
$ sed 's/NUMERICS/goal: {decimals: 10}/' > a.yaml
$ sed 's/^goal.*/numerics: {digits: 30}/' a.yaml > b.yaml; sed 's/^goal.*/numerics: {arithmetic: double}/' a.yaml > c.yaml
$ for f in a b c; do cns run -q $f.yaml --events $f.csv --section Vy=0.01 --section x=0 -o table; done
$ for f in a b c; do grep '^[a-z]*=' $f.csv | cut -d, -f1-3 | sed 's/\(\.[0-9]\{8\}\).*/\1/'; done > list; head -n 4 list
$ for n in 1 5 9; do tail -n +$n list | head -n 4; done | sort | uniq | wc -l
| model: apw
| initial: {theta: 0, Vy: 0.01, omega: 1}
| time: {end: 5}
| NUMERICS
> x=0,1,0.81024108
> omega=0,-1,2.41558746
> x=0,-1,3.32473544
> theta=0*pi,-1,4.64017460
> 4

= a start from rest, where omega, x and Vx have zeros of several orders
$ cat > a.yaml; cns run -q a.yaml --events a.csv --section Vx=0 --section x=0 -o table; grep '^[a-zV]*=' a.csv | cut -d, -f1-3
| model: apw
| initial: {theta: 1}
| time: {end: 6}
| goal: {decimals: 5}
> theta=0*pi,-1,3.80115
> Vx=0,1,5.18000

= a state that stays on a section for ever
$ cat > a.yaml; cns run -q a.yaml --events a.csv --section x=0 --section omega=extremum -o table; tail -n 2 a.csv
| model: apw
| initial: {Vy: 0.01}
| time: {end: 5}
| goal: {decimals: 5}
> event,direction,t,x,y,theta,Vx,Vy,omega,decimals
> # complete

= an orbit cut at an event: each piece has its own events, and the one at the cut is the first piece's
$ cat > a.yaml; cns run -q a.yaml --events a.csv --section z=20 -o table
$ first=$(grep -m 1 '^z' a.csv); xy="x: $(echo $first | cut -d, -f4), y: $(echo $first | cut -d, -f5), z: 20"
$ cns run -q a.yaml --events b.csv --section z=20 -o table --set "initial={$xy}" --set goal.decimals=10 --set time.end=1.5
$ grep ^z a.csv | wc -l; grep ^z b.csv | wc -l; for f in a b; do grep ^z $f.csv | tail -n 1 | cut -d, -f2,4 | cut -c1-12; done | uniq | wc -l
| model: lorenz
| initial: {x: 1, y: 1, z: 20}
| time: {end: 2}
| goal: {decimals: 30}
> 4
> 3
> 1

# The section is 1e-30 below the maximum of z: it is met sqrt(2e-30/2889) before and after that, where -2889 is the
# second derivative there. With the start cut to 20 decimals the maximum stays 9e-21 below the section.
= two events that only 17 decimals tell apart carry all the decimals that are asked for
$ cat > a.yaml; z=39.8234661207612731722452097408752498430986
$ cns run -q a.yaml --events a.csv --section z=$z -o t.csv; cns run -q a.yaml --events b.csv --section z=$z -o t.csv --set goal.decimals=30
$ cns run -q a.yaml --events c.csv --section z=extremum -o t.csv
$ grep '^z' a.csv | cut -d, -f2,7; for f in a b; do grep '^z' $f.csv | cut -d, -f3 | cut -c1-20; done | sort | uniq -c | sed 's/ *\([0-9]*\) .*/\1/'
$ cat a.csv c.csv | grep '^z' | cut -d, -f3 | cut -c15- | awk '{t[NR] = $1} END {print (t[1] + t[2]) / 2 - t[3], t[2] - t[1] - int(2e20 * sqrt(2e-30 / 2889.2))}' | tr -d -
$ cns run -q a.yaml --events d.csv --section z=$z -o t.csv --set initial.x=-13.76361068213420052501 --set initial.y=-19.57875194245179553883; grep -c '^z' d.csv || true
| model: lorenz
| initial: {x: -13.763610682134200525014401054361653864100864854092, y: -19.578751942451795538838041446009558866114240053428, z: 27}
| time: {end: 0.3}
| goal: {decimals: 20}
> 1,20
> -1,20
> 2
> 2
> re:^[01](.5)? [01]$
> 0
