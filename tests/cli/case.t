# Case files: what is wrong with them is said with file, line and column, all of it in one pass.

= the resolved case is a case file that says the same
$ cat > a.yaml; cns check a.yaml > b.yaml; cns check b.yaml > c.yaml; cmp b.yaml c.yaml
| model: apw
| parameters: {I: 2.2}
| initial: {theta: 2*pi/3, Vy: 0.01, omega: 1}
| time: {end: 300, every: 1/3}
| goal: {decimals: 10}

= every case that comes with the program
$ for c in "$CASES"/*.yaml; do cns check -q "$c"; done

= by hand: numerics
$ cat > a.yaml; cns check a.yaml > b.yaml; cns check b.yaml > c.yaml; cmp b.yaml c.yaml
| model: apw
| time: {end: 300, every: 0.5}
| numerics: {method: taylor, arithmetic: mpfr, digits: 60, order: auto, step: adaptive, tolerance: auto}

= smoothed abs
$ cat > a.yaml; cns check a.yaml | grep -o 'smooth: 1e-30'
| model: apw
| abs: {smooth: 1e-30}
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
> smooth: 1e-30

= lines that end in CR LF
$ tr '\n' '@' | sed 's/@/\r\n/g' > a.yaml; cns check a.yaml > b.yaml
| model: apw
| time: {end: 1, every: 1}
| goal: {decimals: 5}

= an unknown key, guessed
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time:
|   end: 300
|   every: 0.5
| numerics:
|   method: taylor
|   digts: 60
2> ...
2> re:^bad.yaml:7:3: unknown key 'digts' in 'numerics'; did you mean 'digits'\?
? 2

= run says the same as check
$ cat > bad.yaml; cns check bad.yaml 2> a || cns run bad.yaml 2> b || cmp a b
| model: apw
| time: {end: 300, evry: 0.5}
| goal: {decimals: 10}

= all faults in one pass, in the order of the file
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| initial: {theta: one}
| time: {end: 300, every: 0}
| goal: {decimals: 10, digts: 3}
2> re:^bad.yaml:2:[0-9]+: .*'theta'
2> re:^bad.yaml:3:[0-9]+: .*'every'
2> re:^bad.yaml:4:[0-9]+: .*'digts'
? 2

= a doubled key
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
| time: {end: 3, every: 0.5}
2> re:^bad.yaml:4:1: .*'time'
? 2

= a doubled key inside a section
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5, end: 200}
| goal: {decimals: 10}
2> re:^bad.yaml:2:[0-9]+: .*'end'
? 2

= an unknown model
$ cat > bad.yaml; cns check bad.yaml
| model: awp
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
2> re:^bad.yaml:1:8: .*'awp'.*apw
2> ...
? 2

= an unknown parameter and an unknown state
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| parameters: {J: 2.2}
| initial: {Vz: 1}
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
2> re:^bad.yaml:2:14: .*'J'
2> re:^bad.yaml:3:11: .*'Vz'
? 2

= no model
$ cat > bad.yaml; cns check bad.yaml
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
2> re:^bad.yaml:.*'model'
2> ...
? 2

= no time
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| goal: {decimals: 10}
2> re:^bad.yaml:.*'time'
2> ...
? 2

= a goal and numerics
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
| numerics: {digits: 60}
2> re:^bad.yaml:[34]:[0-9]+: .*(goal.*numerics|numerics.*goal)
? 2

= run needs a goal or numerics
$ cat > bad.yaml; cns run bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
2> re:^bad.yaml:.*(goal.*numerics|numerics.*goal)
? 2

= decimals and significant
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| goal: {decimals: 10, significant: 10}
2> re:^bad.yaml:3:[0-9]+: .*'significant'
? 2

= an empty interval between rows
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0}
| goal: {decimals: 10}
2> re:^bad.yaml:2:[0-9]+: .*'every'
? 2

= an end that is not after the start
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 0, every: 1}
| goal: {decimals: 10}
2> re:^bad.yaml:2:[0-9]+: .*'end'
? 2

= times are rational numbers
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 2*pi, every: pi/3}
| goal: {decimals: 10}
2> re:^bad.yaml:2:[0-9]+: .*'end'
2> re:^bad.yaml:2:[0-9]+: .*'every'
? 2

= not a number
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| parameters: {I: NaN}
| time: {end: .inf, every: .nan}
| goal: {decimals: 10}
2> re:^bad.yaml:2:[0-9]+: .*'I'
2> re:^bad.yaml:3:[0-9]+: .*'end'
2> re:^bad.yaml:3:[0-9]+: .*'every'
? 2

= numbers outside every range
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| initial: {x: 1e999999999, y: 1e-999999999, theta: 1e99999999999999999999999999}
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
2> re:^bad.yaml:2:[0-9]+: .*'x'
2> re:^bad.yaml:2:[0-9]+: .*'y'
2> re:^bad.yaml:2:[0-9]+: .*'theta'
? 2

= a division by zero
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| initial: {x: 1/0}
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
2> re:^bad.yaml:2:[0-9]+: .*'x'
? 2

= negative digits
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| numerics: {digits: -60}
2> re:^bad.yaml:3:[0-9]+: .*'digits'
? 2

= no digits at all
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| numerics: {digits: 0}
2> re:^bad.yaml:3:[0-9]+: .*'digits'
? 2

= digits that are not an integer, or too large for one
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| numerics:
|   digits: 60.5
|   order: 99999999999999999999999999
2> re:^bad.yaml:4:[0-9]+: .*'digits'
2> re:^bad.yaml:5:[0-9]+: .*'order'
? 2

= a parameter outside its range
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| parameters: {I: 0}
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
2> re:^bad.yaml:2:[0-9]+: .*'I'
? 2

= an unknown column
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
| output: {columns: [t, x, z]}
2> re:^bad.yaml:4:26: .*'z'
2> ...
? 2

= a list where a section belongs, a section where a number belongs
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| initial: [1, 2]
| time: {end: {a: 1}, every: 0.5}
| goal: {decimals: [10]}
2> re:^bad.yaml:2:[0-9]+: .*'initial'
2> re:^bad.yaml:3:[0-9]+: .*'end'
2> re:^bad.yaml:4:[0-9]+: .*'decimals'
? 2

= rk4 has a fixed step
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| numerics: {method: rk4, digits: 60, step: adaptive}
2> re:^bad.yaml:3:[0-9]+: .*'step'
? 2

= double has no digits
$ cat > bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 300, every: 0.5}
| numerics: {method: rk4, arithmetic: double, digits: 60, step: 1e-3}
2> re:^bad.yaml:3:[0-9]+: .*'digits'
? 2

= sections of the studies are read, too
$ cat > a.yaml; cns check a.yaml > b.yaml
| model: apw
| time: {end: 300, every: 0.5}
| goal: {decimals: 10}
| lyapunov: {time: 20000, arithmetic: double}

= from a goal to numerics and back on the command line: the one replaces the other, and a note says so
$ cat > g.yaml; sed 's/^goal.*/numerics: {digits: 20}/' g.yaml > n.yaml
$ cns run g.yaml --set numerics.digits=20 | grep '^[0-9]' > a; cns run -q n.yaml | grep '^[0-9]' | cmp - a
$ cns run n.yaml --set goal.decimals=5 2> notes | grep '^[0-9]' > a; cns run -q g.yaml | grep '^[0-9]' | cmp - a; head -n 1 notes
$ cns check -q g.yaml --set numerics.digits=20; cns check g.yaml --set 'numerics={digits: 20}' 2> /dev/null | grep -c goal || true
| model: lorenz
| initial: {x: 1}
| time: {end: 1}
| goal: {decimals: 5}
> cns: --set goal... replaces 'numerics' of n.yaml
> 0
2> cns: --set numerics... replaces 'goal' of g.yaml
2> re:^cns: about 2[0-9] steps, [0-9.]+ s$

= what the new section lacks is said in one message, with what to type
$ cat > g.yaml; sed 's/^goal.*/numerics: {digits: 20}/' g.yaml > n.yaml
$ cns run g.yaml --set numerics.method=rk4 || cns run g.yaml --set numerics.arithmetic=mpfr || cns run n.yaml --set goal.max_time=5
| model: lorenz
| initial: {x: 1}
| time: {end: 1}
| goal: {decimals: 5}
2> --set numerics.method=rk4: missing in 'numerics': 'digits' and a fixed 'step'; add --set numerics.digits=40 --set numerics.step=1e-3
2> --set numerics.arithmetic=mpfr: missing in 'numerics': 'digits'; add --set numerics.digits=40
2> --set goal.max_time=5: missing key in 'goal': 'decimals' or 'significant'; add --set goal.decimals=10
? 2

= overrides of both are a contradiction
$ cat > g.yaml; cns run g.yaml --set goal.decimals=6 --set numerics.digits=20
| model: lorenz
| time: {end: 1}
| goal: {decimals: 5}
2> --set numerics.digits=20: 'goal' and 'numerics' exclude each other: keep one
? 2
