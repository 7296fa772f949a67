# cns tc: the critical predictable time of a run by numerics.

= times of every state and the norm, as YAML
$ cat > a.yaml; cns tc -q --yaml a.yaml
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100, every: 0.5}
| numerics: {digits: 5}
> delta: 0.01
> digits: 5
> reference_digits: 27
> times:
> re:^  norm: [0-9]+\.[0-9]{6}$
> re:^  x: [0-9]+\.[0-9]{6}$
> re:^  y: [0-9]+\.[0-9]{6}$
> re:^  theta: [0-9]+\.[0-9]{6}$
> re:^  Vx: [0-9]+\.[0-9]{6}$
> re:^  Vy: [0-9]+\.[0-9]{6}$
> re:^  omega: [0-9]+\.[0-9]{6}$

= more digits last longer, whatever the kernel, the arithmetic of many digits and the reference
$ cat > a.yaml; tc() { cns tc -q --yaml a.yaml "$@" | sed -n 's/^  norm: //p'; }
$ tc > 5; tc --set numerics.digits=10 > 10; paste 5 10 | awk '{print ($2 > $1 + 30)}'
$ CNS_KERNEL=portable tc | cmp - 5; tc --reference-digits 40 | cmp - 5
$ tc --set numerics.arithmetic=mpfr | paste - 5 | awk '{d = $1 - $2; print (d * d < 900)}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 200, every: 0.5}
| numerics: {digits: 5}
> 1
> 1

= a text for people, with derived quantities that the case asks for
$ cat > a.yaml; cns tc -q a.yaml
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 2, every: 0.5}
| numerics: {digits: 20}
| output: {columns: [t, theta, tau]}
> T_c of a.yaml, 20 digits, delta = 0.01, against 42 digits
> re:^  norm +> 2$
> re:^  x +> 2$
> re:^  y +> 2$
> re:^  theta +> 2$
> re:^  Vx +> 2$
> re:^  Vy +> 2$
> re:^  omega +> 2$
> re:^  tau +> 2$

= double and Runge-Kutta
$ cat > a.yaml; cns tc -q --yaml a.yaml | grep -E '^digits|norm'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 200, every: 0.5}
| numerics: {method: rk4, arithmetic: double, step: 0.05}
> digits: double
> re:^  norm: [0-9]+\.[0-9]{6}$

= a smaller delta is reached earlier
$ cat > a.yaml; for d in 1e-2 1e-3; do cns tc -q --yaml --delta $d a.yaml | sed -n 's/^  norm: //p' > $d; done; paste 1e-2 1e-3 | awk '{print ($2 < $1)}'
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 100, every: 0.5}
| numerics: {digits: 5}
> 1

= case 1 as printed has no T_c: the line is invariant
$ sed 's/^goal.*/numerics: {digits: 16}/' "$CASES/case1.yaml" > a.yaml; cns tc -q --yaml a.yaml | tail -n +5
>   norm:
>     beyond: 50
>     none: the difference does not grow
>   x:
>     beyond: 50
>     none: the two runs are identical
>   y:
>     beyond: 50
>   theta:
>     beyond: 50
>     none: the two runs are identical
>   Vx:
>     beyond: 50
>     none: the two runs are identical
>   Vy:
>     beyond: 50
>     none: the difference does not grow
>   omega:
>     beyond: 50
>     none: the two runs are identical

= a goal has no predictable time; nor has a case without numerics
$ cat > a.yaml; cns tc a.yaml || echo $?; grep -v goal a.yaml | cns tc -
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
| goal: {decimals: 10}
> 2
2> re:^a\.yaml:1:1: a 'goal' .*needs 'numerics'
2> re:^<stdin>:1:1: no 'numerics': .*needs 'numerics'
? 2

= a reference without digits enough is not believed
$ cat > a.yaml; cns tc -q --yaml --reference-digits 20 a.yaml
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 50, every: 0.5}
| numerics: {digits: 16}
> delta: 0.01
> digits: 16
> reference_digits: 20
> times:
>   norm:
> re:^    beyond: [0-9.]+$
>   x:
> re:^    beyond: [0-9.]+$
>   y:
> re:^    beyond: [0-9.]+$
>   z:
> re:^    beyond: [0-9.]+$
2> re:^cns: t = [0-9.]+: the error of the reference .* more digits$
? 1

= options that make no sense
$ cat > a.yaml; for o in '--delta 0' '--delta -1' '--delta pi' '--delta x' '--reference-digits 3' '--reference-digits x'; do cns tc a.yaml $o || echo $?; done
| model: lorenz
| time: {end: 1}
| numerics: {digits: 16}
> 2
> 2
> 2
> 2
> 2
> 2
2> re:--delta takes a number > 0
2> re:--delta takes a number > 0
2> re:--delta takes a number > 0
2> re:--delta takes a number > 0
2> re:--reference-digits takes an integer
2> re:--reference-digits takes an integer

= interrupted
$ cat > a.yaml; timeout -s INT 1 "$CNS" tc -q a.yaml
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 5000, every: 0.5}
| numerics: {digits: 400}
? 124 130
