# Values that never change, and values at a tie: what is known of them is used, and one attempt more is enough.

= a column that stays where it is, at a tie of rounding
$ cat > a.yaml; cns run a.yaml > a.csv 2> log; grep -c again log || true; grep -v '^#' a.csv | cut -d, -f1-8
| model: apw
| initial: {x: 0.00005, Vy: 0.01}
| time: {end: 2, every: 1}
| goal: {decimals: 4}
> 0
> t,x,y,theta,Vx,Vy,omega,decimals
> 0,0.0000,0.0000,0.0000,0.0000,0.0100,0.0000,4
> 1,0.0000,-0.1446,0.0000,0.0000,-0.2956,0.0000,4
> 2,0.0000,-0.5779,0.0000,0.0000,-0.5619,0.0000,4

= released edge-on: the product of two symmetries keeps theta, Vy and omega; its half-turn does, too
$ cat > a.yaml; for th in pi/2 -3*pi/2; do cns run -q a.yaml --set initial.theta=$th | grep ^12, | cut -d, -f2,3,5-7; done
| model: apw
| initial: {theta: pi/2}
| time: {end: 12}
| goal: {significant: 20}
> 0,-2.2002020291231781347e+01,-2.6904851882649605530e+00,0,0
> 0,-2.2002020291231781347e+01,-2.6904851882649605530e+00,0,0

= near the fixed point is not on it
$ cat > a.yaml; cns run -q a.yaml | grep ^12, | cut -d, -f6 | grep -c e-
| model: apw
| initial: {theta: 1.5707963267948966}
| time: {end: 12}
| goal: {significant: 5}
> 1

= a zero that nothing proves: one attempt more, the others keep their digits
$ cat > a.yaml; cns run a.yaml > a.csv 2> log || echo $?; grep -c again log; grep ^12, a.csv | cut -d, -f2-8; tail -n 1 log
| model: apw
| initial: {theta: pi/2}
| time: {end: 12}
| goal: {significant: 20}
| output: {columns: [t, Gamma, Fx, Fy, tau, speed, vx_lab, vy_lab]}
> 1
> 1
> 0,-9.2166125229529129457e-01,0,0,2.6904851882649605530e+00,0,-2.6904851882649605530e+00
> re:^cns: some rows have fewer than the 20 significant digits asked for: several columns are zero
