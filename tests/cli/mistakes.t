# Mistakes that people make in case files and on the command line: each message names the mistake and its cure.

= a decimal comma
$ t='time: {end: 1}'; check() { printf 'model: apw\n%s\n%s\ngoal: {decimals: 5}\n' "$1" "${2-$t}" > a.yaml; cns check a.yaml || true; }
$ check 'initial: {theta: 1,5}'; check 'initial: {theta: -1,5e-3, Vy: 2}'; check 'initial: {theta: "0,5"}'; check 'initial:
$   x: 0,5'; check 'initial: {x: 1}' 'time: {end: 1, every: 0,5}'; cns check a.yaml --set time.every=0.5 --set initial.x=1,5 || true
2> a.yaml:2:18: '1,5' is two values; write a point for the decimal comma: 1.5
2> a.yaml:2:18: '-1,5e-3' is two values; write a point for the decimal comma: -1.5e-3
2> a.yaml:2:18: 'theta' in 'initial': '0,5' is not a number: write a point for the decimal comma, as in 1.5
2> a.yaml:3:6: 'x' in 'initial': '0,5' is not a number: write a point for the decimal comma, as in 1.5
2> a.yaml:3:23: '0,5' is two values; write a point for the decimal comma: 0.5
2> a.yaml:3:23: '0,5' is two values; write a point for the decimal comma: 0.5
2> --set initial.x=1,5: 'x' in 'initial': '1,5' is not a number: write a point for the decimal comma, as in 1.5

= no space after a colon, an equals sign: once, and nothing is missing as well
$ t='time: {end: 1}'; check() { printf 'model: apw\n%s\n%s\ngoal: {decimals: 5}\n' "$1" "${2-$t}" > a.yaml; cns check a.yaml || true; }
$ check 'initial: {theta: 1,Vy:0.01}'; check 'initial: {theta=1, Vy=-2}'; check 'initial: {x: 1}' 'time: {end:1, every:0.5}'; check 'initial: theta=1'
$ check 'initial: {π: 1, θ:2}'; check 'initial:
$   theta:1'; check 'initial:
$   theta:1
$   Vy: 2'
$ sed 's/:/=/' "$CASES"/rest.yaml | sed '/^#/d' > b.yaml; cns check b.yaml || true; printf 'model:apw\n' > b.yaml; cns check b.yaml || true
2> a.yaml:2:20: a space is missing after the colon: write 'Vy: 0.01'
2> a.yaml:2:11: write 'theta: 1', with a colon and a space, not 'theta=1'
2> a.yaml:2:20: write 'Vy: -2', with a colon and a space, not 'Vy=-2'
2> a.yaml:3:8: a space is missing after the colon: write 'end: 1'
2> a.yaml:3:15: a space is missing after the colon: write 'every: 0.5'
2> a.yaml:2:10: 'initial' must be a mapping of keys to values, not a single value; write 'key: value', with a colon and a space, not 'theta=1'
2> a.yaml:2:11: unknown state 'π' of model apw; use x, y, theta, Vx, Vy or omega
2> a.yaml:2:17: a space is missing after the colon: write 'θ: 2'
2> a.yaml:3:3: 'initial' must be a mapping of keys to values, not a single value; a space is missing after the colon in 'theta:1'
2> a.yaml:4:5: not YAML: the line above is not 'key: value', with a space after the colon
2> re:^b.yaml:[0-9]+:[0-9]+: .*with a (colon and a space|space after the colon)
2> b.yaml:1:1: a case file is a mapping of keys to values, not a single value; a space is missing after the colon, as in 'model: apw'

= tabs, indentation, brackets and quotes
$ check() { printf "model: apw\n$1\ngoal: {decimals: 5}\n" > a.yaml; cns check a.yaml || true; }
$ check 'time:\n\tend: 1'; check 'time:\n  end: 1\n\tevery: 1'; check 'time:\n  end: 1\n   every: 1'; check 'time:\n  end: 1\n every: 1'
$ check 'time: end: 1'; check 'time: {end: 1, every: 1'; check 'time: {end: 1}}'; check 'time: {end: 1 every: 1}'; check 'time: {end: "1, every: 1}'; check 'time: [end: 1]'
$ printf '[model]\nname = apw\n' > a.yaml; cns check a.yaml || true
2> a.yaml:3:1: not YAML: a tab; indent with spaces
2> a.yaml:4:1: not YAML: a tab; indent with spaces
2> a.yaml:4:9: not YAML: indented deeper than the line above, which has its value; keys of a section begin in one column
2> a.yaml:4:2: not YAML: indented unlike the lines above; keys of a section begin in one column
2> a.yaml:2:10: not YAML: a second ': ' on one line; keys of a section stand in braces, as in time: {end: 1}, or on lines of their own
2> a.yaml:3:5: not YAML: the '{' of line 2 is not closed
2> a.yaml:2:15: not YAML: this bracket closes nothing
2> a.yaml:2:20: not YAML: a comma must separate one value from the next, as in {end: 1, every: 0.5}
2> a.yaml:4:1: not YAML: the quotation mark of line 2 is not closed
2> a.yaml:2:7: 'time' must be a mapping of keys to values, not a list; keys and values stand in braces, as in {key: value}, or on lines of their own
2> a.yaml:2:1: not YAML: text after the end of the first value; a case file is lines of 'key: value'; is this a table?

= numbers as other programs and keyboards write them
$ for x in 1.5e 1d-3 1.0D+00 '−1' '1.5e−3' "$(printf '1\302\240')" 2pi 'π/2' Pi 1_000 "1'000" '1 000' 1.000.000 2^3 2**3 30deg '90°' 1+2 0x1F 01 .5 5. 1/0 sqrt.2; do
$ cns check "$CASES"/rest.yaml --set "initial.theta=$x" > table 2> message && echo "taken: $x"; sed 's/.*initial.: //' message; done
$ cns check "$CASES"/rest.yaml --set 'initial.theta=pi/2' | grep -o 'theta: .*'; cns check "$CASES"/rest.yaml --set 'time.end=pi/2'
> '1.5e' is not a number: digits must follow the e of an exponent
> '1d-3' is not a number: write the exponent with an e, as in 1e-3
> '1.0D+00' is not a number: write the exponent with an e, as in 1e-3
> '−1' is not a number: it holds the character U+2212; write the minus as a plain -
> '1.5e−3' is not a number: it holds the character U+2212; write the minus as a plain -
> re:^'1.*' is not a number: it holds a no-break space \(U\+00A0\); take it out$
> '2pi' is not a number: write * between factors, as in 2*pi
> 'π/2' is not a number: write pi in two letters
> 'Pi' is not a number: write pi in small letters
> '1_000' is not a number: digits are written without separators
> '1'000' is not a number: digits are written without separators
> '1 000' is not a number: no blanks inside a number
> '1.000.000' is not a number: one point is enough; thousands are not separated
> '2^3' is not a number: powers are not computed: write 1e-3, or the number itself
> '2**3' is not a number: powers are not computed: write 1e-3, or the number itself
> '30deg' is not a number: angles are in radians: write degrees as 90*pi/180
> '90°' is not a number: angles are in radians: write degrees as 90*pi/180
> '1+2' is not a number: sums are not computed: write the number itself
> '0x1F' is not a number: numbers are decimal here
> '01' is not a number: a leading zero could mean octal; leave it out
> '.5' is not a number: a digit must stand before the point, as in 0.5
> '5.' is not a number: a digit must follow the point
> '1/0' divides by zero
> 'sqrt.2' is not a number: use decimals, fractions and pi, as in 2.2, 1e-30, 8/3, 2*pi/3
> theta: pi/2
2> --set time.end=pi/2: 'end' in 'time' must be a decimal or a fraction, not 'pi/2'
? 2

= a value in place of its section
$ for s in time=300 goal=10 numerics=40 numerics=rk4 abs=1e-30 lyapunov=1000 'output=[t, x]'; do cns check -q "$CASES"/rest.yaml --set "$s" || true; done
2> --set time=300: 'time' must be a mapping of keys to values: write 'time: {end: 300}'
2> --set goal=10: 'goal' must be a mapping of keys to values: write 'goal: {decimals: 10}'
2> --set numerics=40: 'numerics' must be a mapping of keys to values: write 'numerics: {digits: 40}'
2> --set numerics=rk4: 'numerics' must be a mapping of keys to values: write 'numerics: {method: rk4}'
2> --set abs=1e-30: 'abs' must be a mapping of keys to values: write 'abs: {smooth: 1e-30}'
2> --set lyapunov=1000: 'lyapunov' must be a mapping of keys to values: write 'lyapunov: {time: 1000}'
2> --set output=[t, x]: 'output' must be a mapping of keys to values: write 'output: {columns: [...]}'

= words of other programs
$ cat > a.yaml; for m in rk45 euler RK4 tayler; do cns check a.yaml --set numerics.method=$m || true; done; cns check a.yaml --set numerics.arithmetic=quad
| model: apw
| time: {end: 1}
| numerics: {step: 1e-3}
2> --set numerics.method=rk45: 'method' in 'numerics' must be taylor or rk4, not 'rk45'; taylor, of any order, chooses its steps by itself; rk4 is the classical method with a fixed 'step'
2> --set numerics.method=euler: 'method' in 'numerics' must be taylor or rk4, not 'euler'; taylor, of any order, chooses its steps by itself; rk4 is the classical method with a fixed 'step'
2> --set numerics.method=RK4: 'method' in 'numerics' must be taylor or rk4, not 'RK4'; did you mean 'rk4'?
2> --set numerics.method=tayler: 'method' in 'numerics' must be taylor or rk4, not 'tayler'; did you mean 'taylor'?
2> --set numerics.arithmetic=quad: 'arithmetic' in 'numerics' must be fast, mpfr or double, not 'quad'; fast and mpfr compute with as many 'digits' as asked for
? 2

= keys: the plural, an abbreviation, a name of the model where it does not belong
$ cat > a.yaml; cns check a.yaml --set theta=1 --set I=2 --set parameters.omega=1 --set initial.I=2
| model: apw
| time: {end: 1}
| parameter: {I: 2}
| params: {I: 2}
| initial_conditions: {theta: 1}
2> a.yaml:3:1: unknown key 'parameter'; did you mean 'parameters'?
2> a.yaml:4:1: unknown key 'params'; did you mean 'parameters'?
2> a.yaml:5:1: unknown key 'initial_conditions'; did you mean 'initial'?
2> --set theta=1: unknown key 'theta'; a state of model apw belongs in 'initial'
2> --set I=2: unknown key 'I'; a parameter of model apw belongs in 'parameters'
2> --set parameters.omega=1: unknown key 'omega' in 'parameters'; a state of model apw belongs in 'initial'
2> --set initial.I=2: unknown key 'I' in 'initial'; a parameter of model apw belongs in 'parameters'
? 2

= files: empty, of comments, of another encoding, with a byte order mark, with CR LF and CR
$ : > a; echo '# a' > b; printf '\377\376m\0' > c; printf 'mod\351le: apw\n' > d; for f in a b c d; do cns check $f || true; done
$ printf '\357\273\277model: lorenz\ntime: {end: 1,5}\n' > e; printf 'model: lorenz\r\ntime: {end: 1,5}\r\n' > f; printf 'model: lorenz\rtime: {end: 1,5}\r' > g
$ for f in e f g; do cns check $f || true; sed 's/,5//' $f > h; cns check -q h; done
2> a:1:1: the file is empty, or all comments; `cns help case` lists what a case file says
2> b:1:1: the file is empty, or all comments; `cns help case` lists what a case file says
2> c:1:1: byte 0xFF is not UTF-8 text; this is UTF-16: save the file as UTF-8
2> d:1:4: byte 0xE9 is not UTF-8 text; save the file as UTF-8
2> e:2:13: '1,5' is two values; write a point for the decimal comma: 1.5
2> f:2:13: '1,5' is two values; write a point for the decimal comma: 1.5
2> g:2:13: '1,5' is two values; write a point for the decimal comma: 1.5

= the command line: what was meant, and how it is written
$ cp "$CASES"/rest.yaml g.yaml; printf 't,x\n0,1\n' > a.csv; say() { cns "$@" || true; }
$ say run g.yaml --out x; say run g.yaml -output x; say run g.yaml --set goal.decimals 7; say run g.yaml --set goal.decimals = 7; say run g.yaml --set =..; say run g.yaml --set=..
$ say run g.yaml goal.decimals=3; say run g.yaml --decimals 5; say run g.yaml --until 5; say run g.yaml --method rk4; say plan g.yaml --sweep I=1:2:1; say lyapunov g.yaml --until 5
$ say run g.yaml —set goal.decimals=3; say –h; say version; say plan g.yaml --until 1,5; say tc g.yaml --delta 0,01; say compare a.csv
2> cns: unknown option --out; did you mean --output?
2> cns: -output: write two hyphens, --output
2> cns: --set takes one argument, without spaces or in quotes: --set 'goal.decimals=VALUE'
2> cns: --set takes one argument, without spaces or in quotes: --set 'goal.decimals=VALUE'
2> --set =..: write SECTION.KEY=VALUE, as in numerics.digits=80
2> --set ..: write SECTION.KEY=VALUE, as in numerics.digits=80
2> cns: one argument too many, 'goal.decimals=3'; to override a value write --set goal.decimals=3
2> cns: --decimals does not go with `cns run`; write --set goal.decimals=VALUE
2> cns: --until does not go with `cns run`; write --set time.end=VALUE
2> cns: unknown option --method; it is a key of case files: --set numerics.method=VALUE
2> re:^cns: --sweep does not go with `cns plan`, but with .*classify
2> re:^cns: --until does not go with `cns lyapunov`, but with .*plan
2> cns: '—set' begins with a typographic dash: write plain hyphens, --
2> cns: '–h' begins with a typographic dash: write plain hyphens, --
2> cns: unknown command 'version'; did you mean --version?
2> cns: --until takes a rational number above 0; '1,5' is not a number: write a point for the decimal comma, as in 1.5
2> cns: --delta takes a number > 0, such as 0.01; '0,01' is not a number: write a point for the decimal comma, as in 1.5
2> cns: only 'a.csv' is given: cns compare A B

= a table given as a case, a case as a table, a directory as either
$ cns run -q "$CASES"/rest.yaml --set time.end=1 > a.csv; cp "$CASES"/lorenz.yaml g.yaml; mkdir d; : > empty
$ cns run a.csv || cns compare a.csv g.yaml || cns compare g.yaml a.csv || cns compare a.csv empty || cns run d || cns compare a.csv d
2> re:^a.csv:[0-9]+:1: .*is this a table\?
2> re:^cns: g.yaml:[0-9]+:1: this looks like a case file, not a table: `cns run` makes the table$
2> re:^cns: g.yaml:[0-9]+:1: this looks like a case file, not a table: `cns run` makes the table$
2> cns: empty:1:1: no header line: this is not a table
2> cns: cannot read d: Is a directory
2> cns: cannot read d: Is a directory
? 4

= a state or parameter that no double holds is refused before any work, a large angle runs
$ cns run "$CASES"/rest.yaml --set initial.theta=1e400 || cns run "$CASES"/lorenz.yaml --set initial.x=-1e400 --set parameters.R=1e301 || echo $?
$ cns run -q "$CASES"/rest.yaml --set initial.theta=1e12 --set initial.Vy=0.01 --set time.end=1 --set time.every=1 -o a.csv; tail -n 1 a.csv
> 2
> # complete
2> --set initial.theta=1e400: 'theta' in 'initial' must be between -1e300 and 1e300, where runs in double precision can plan for it, not '1e400'
2> --set initial.x=-1e400: 'x' in 'initial' must be between -1e300 and 1e300, where runs in double precision can plan for it, not '-1e400'
2> --set parameters.R=1e301: 'R' in 'parameters' must be between -1e300 and 1e300, where runs in double precision can plan for it, not '1e301'

= make where a library is missing says what to type, and compiles nothing
$ cat > nocc; chmod +x nocc; MAKEFLAGS= make -s --no-print-directory -C "$CASES"/.. B="$PWD/b" CC="$PWD/nocc" 2> said || echo $?
$ head -n 2 said; wc -l < said | tr -d ' '; find b -name '*.o'
if command -v make && command -v apt-get
| #!/bin/sh
| for a; do case $a in *.c) ! grep -q '<mpfr.h>' "$a" || { echo "$a:1:10: fatal error: mpfr.h: No such file or directory" >&2; exit 1; } ;; esac; done
| exec cc "$@"
> 2
> The compiler or a library is missing. Type this line, then make again; make run does both by itself:
> re:^(sudo )?apt-get update && (sudo )?apt-get install .*libmpfr-dev
> 3
