# cns lyapunov.

= a table of t, lambda and its error
$ cns lyapunov -q "$CASES"/case4.yaml --set lyapunov.time=64 > table
$ sed -n 1p table; grep -c '^[0-9]' table; grep -A1 '^t,' table | cut -d, -f1; tail -n 1 table
> re:^# cns .*: largest Lyapunov exponent: disk
> 32
> t
> 8.4
> # complete

= the last row is the result
$ cns lyapunov -q "$CASES"/case4.yaml --set lyapunov.time=64 -o table --yaml > sum
$ l=$(sed -n 's/^lambda: //p' sum); e=$(sed -n 's/^lambda_se: //p' sum)
$ grep -q "^70.4,$l,$e\$" table; grep -q "^# lambda = $l +- $e over T = 64\$" table; grep '^time:\|^discarded:' sum
> time: 64
> discarded: 6.4

= a saddle's exponent, from double and from both arithmetics of many digits
$ cat > e.yaml; for a in double fast mpfr; do cns lyapunov -q e.yaml --yaml --set lyapunov.arithmetic=$a | sed -n 's/^lambda: //p' | cut -c 1-4; done
| model: lorenz
| parameters: {R: 0.5}
| initial: {x: 1, y: 2, z: 3}
| time: {end: 1}
| lyapunov: {time: 100}
> -0.4
> -0.4
> -0.4

= a chaotic transient that ends is left out: the rest has the real part of the eigenvalues where it ends
$ cat > a.yaml; cns lyapunov -q a.yaml -o t --yaml > y
$ grep '^# transient\|^# the rate\|^# lambda' t; sed -n '/^lambda\|^time\|^disc\|^changes/p' y
$ cns equilibria -q a.yaml | sed -n '/^C+/,/i$/{/ i$/{s/ [-+] .*//;p;q;}}' > e
$ sed -n '/^lambda/s/.* //p' y | cat e - | tr '\n' ' ' | awk '{d = $2 - $1; print (d * d < 9 * $3 * $3)}'
| model: lorenz
| parameters: {R: 23.3}
| initial: {x: 1, y: 0, z: 35}
| time: {end: 1}
| lyapunov: {time: 1000}
> # transient left out: t < 475
> re:^# the rate of lambda changes at t about 3[3-7][0-9], from 0\.[67][0-9]* to -0\.0[34]
> re:^# lambda = -0\.044[0-9]* \+- 0\.001[0-9]* over T = 625$
> re:^lambda: -0\.044
> re:^lambda_se: 0\.001
> time: 625
> discarded: 475
> changes:
> 1

= one that ends too late, or in the middle of batches that vary together, gives no figure
$ cat > a.yaml; for R in 23 23.3; do cns lyapunov -q a.yaml --set parameters.R=$R > t || echo status $?; grep '^# no fig\|^t,' t; grep -c '^[0-9]' t; done
$ cns lyapunov -q a.yaml --yaml 2> e > y || true; grep '^lambda\|^time\|^note\|^dim' y; grep -c 'se: null' y
| model: lorenz
| parameters: {R: 23}
| initial: {x: 3, y: 0, z: 35}
| time: {end: 1}
| lyapunov: {time: 1000}
> status 1
> re:^# no figure: the rate of the tangent's growth changes at t about 9[0-9]*, from 0\.[0-9]* to -0\.0[0-9]*, and too little time follows$
> t,rate
> 32
> status 1
> re:^# no figure: the rate of the tangent's growth varies over longer than the 31\.2 that a batch lasts$
> t,rate
> 32
> lambda: null
> lambda_se: null
> time: 1000
> re:^note: the rate of the tangent's growth changes
> 6
2> re:^cns: no figure: .*too little time follows: take a longer lyapunov.time$
2> re:^cns: no figure: .*varies over longer .*: take a longer lyapunov.time$

= all exponents: their columns, errors and dimension; the sum is the trace of the Jacobian, exactly
$ cns lyapunov -q "$CASES"/lorenz.yaml --set lyapunov.time=300 --set lyapunov.exponents=all -o t --yaml > y
$ grep '^t,\|^# Kaplan\|^# sum' t; sed -n '/^exponents/,$p' y
$ tail -n 8 t | grep -c '^# lambda[123] = .* over T = 300$'
> t,lambda1,se1,lambda2,se2,lambda3,se3
> re:^# Kaplan-Yorke dimension = 2\.06[0-9]* \+- 0\.0
> # sum of the exponents = -13.666666667, mean trace of the Jacobian = -13.666666667, -41/3 everywhere
> exponents:
> re:^- lambda: 0\.[89]
> re:^  se: 0\.0
> re:^- lambda: -?0\.0
> re:^  se: 0\.0
> re:^- lambda: -14\.[56]
> re:^  se: 0\.0
> re:^dimension: 2\.06
> re:^dimension_se: 0\.0
> sum: -13.666666667
> trace: -13.666666667
> exact_trace: -41/3
> 3

= the multiplier of a cycle is the second exponent, by another route
$ cns classify -q --yaml "$CASES"/tumble.yaml | sed -n 's/^period: //p; s/^multiplier: //p' > c
$ cns lyapunov -q "$CASES"/tumble.yaml --yaml --set lyapunov.time=1000 --set lyapunov.exponents=2 | sed -n '/^exponents/,$s/^[ -]*\(lambda\|se\): //p' > l
$ tr '\n' ' ' < c | cat - l | tr '\n' ' ' | awk '{d = log($2) / ($1 / 2) - $5; print (d * d < 9 * $6 * $6), ($6 < 0.01), ($3 * $3 < 9 * $4 * $4)}'
> 1 1 1

= more exponents than there are, or none
$ cns lyapunov -q "$CASES"/case4.yaml --set lyapunov.exponents=5
2> cns: 5 exponents are asked for; there are 4, as many as states that feed back
? 2

= zero exponents
$ cns lyapunov -q "$CASES"/case4.yaml --set lyapunov.exponents=0
2> re:lyapunov.exponents=0
? 2

= an error is never printed as nothing
$ cat > a.yaml; cns lyapunov -q a.yaml | grep '^# lambda'
| model: lorenz
| parameters: {R: 1/2}
| initial: {z: 1}
| time: {end: 1}
| lyapunov: {time: 400}
> re:^# lambda = -0\.4[0-9]{8} \+- 0\.000000001 over T = 400$

= the same bytes again
$ cns lyapunov -q "$CASES"/case2.yaml --set lyapunov.time=30 > a
$ cns lyapunov -q "$CASES"/case2.yaml --set lyapunov.time=30 > b
$ cmp a b

= the arithmetic is named
$ cns lyapunov -q "$CASES"/lorenz.yaml --set lyapunov.time=10 --set lyapunov.arithmetic=fast --set lyapunov.digits=40 | grep '^# arithmetic'
> re:fast, 40 digits \([0-9]+ bits\), Taylor series of order

= a motion without exponent ends where it is singular
$ cat > s.yaml; cns lyapunov -q s.yaml
| model: apw
| parameters: {A: -2}
| initial: {Vy: -1}
| time: {end: 1}
| lyapunov: {time: 100}
2> re:^cns: t = 5\.99585.*a pole$
? 3

= a time of zero
$ cns lyapunov "$CASES"/case4.yaml --set lyapunov.time=0
2> re:lyapunov.time=0
? 2

= Ctrl-C
$ cns lyapunov -q "$CASES"/case4.yaml --set lyapunov.time=1e9 & wait_for "catches $!"; kill -INT $!; wait $!
? 130
if test -r /proc/self/status

= chaos that fixed points attract beside is told to be, perhaps, a transient; at R = 28 none attracts
$ cat > a.yaml; for r in 24 28; do cns lyapunov -q a.yaml --set parameters.R=$r | grep '^# chaos' || echo none; done
$ cns lyapunov -q a.yaml --yaml | grep attract; cns lyapunov -q a.yaml --sweep R=24:23:1 | grep -v '^#' | cut -d, -f1,6
| model: lorenz
| parameters: {R: 24}
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
| lyapunov: {time: 400}
> # chaos up to t = 440 may end later: fixed points attract as well: C+, C-
> none
> attracting_points: C+, C-
> R,note
> 24,chaos may end later: fixed points attract as well: C+; C-
> re:^23,
