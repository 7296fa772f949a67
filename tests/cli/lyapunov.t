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
