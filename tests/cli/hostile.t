# Files that are no case files: each is refused at once, in small memory, with one message.

= a file that is not there
$ cns run nowhere.yaml
2> re:nowhere\.yaml.*No such file
? 4

= a directory
$ mkdir d; cns run d
2> re:d.*directory
? 4

= an empty file
$ : > bad.yaml; cns run bad.yaml
2> re:^bad.yaml:
2> ...
? 2

= only a comment
$ echo '# nothing' > bad.yaml; cns run bad.yaml
2> re:^bad.yaml:
2> ...
? 2

= a scalar
$ echo apw > bad.yaml; cns run bad.yaml
2> re:^bad.yaml:1:1: 
? 2

= a list
$ echo '[apw]' > bad.yaml; cns run bad.yaml
2> re:^bad.yaml:1:1: 
? 2

= broken syntax
$ cat > bad.yaml; cns run bad.yaml
| model: apw
| time: {end: 300
| goal: {decimals: 10}
2> re:^bad.yaml:3:[0-9]+: 
? 2

= two documents
$ cat > bad.yaml; cns run bad.yaml
| model: apw
| time: {end: 1, every: 1}
| goal: {decimals: 10}
| ---
| model: apw
2> re:^bad.yaml:4:1: .*document
? 2

= a binary file
$ cp "$CNS" bad.yaml; cns run bad.yaml
2> re:^bad.yaml:
? 2

= bytes that are not UTF-8
$ printf 'model: a\377\376w\n' > bad.yaml; cns run bad.yaml
2> re:^bad.yaml:[0-9]+:[0-9]+: 
? 2

= a NUL byte after a good case
$ cat > bad.yaml; printf '\000x: 1\n' >> bad.yaml; cns check bad.yaml
| model: apw
| time: {end: 1, every: 1}
| goal: {decimals: 10}
2> re:^bad.yaml:
? 2

= a file of 100 MB
$ truncate -s 100M bad.yaml; cns run bad.yaml
2> re:^bad.yaml:
? 2

= a device that never ends
$ cns run /dev/zero
2> re:/dev/zero
? 2 4

= lists in lists
$ printf 'model: ' > bad.yaml; printf '%0100000d' 0 | tr 0 '[' >> bad.yaml; cns run bad.yaml
2> re:^bad.yaml:
? 2

= blocks in blocks
$ printf '%020000d' 0 | sed 's/0/- /g' > bad.yaml; cns run bad.yaml
2> re:^bad.yaml:
? 2

= balanced nesting under a known key
$ { printf 'model: '; printf '%0900d' 0 | tr 0 '['; printf '%0900d\n' 0 | tr 0 ']'; } > bad.yaml; cns run bad.yaml
2> re:^bad.yaml:1:[0-9]+: .*nested
2> ...
? 2

= aliases of aliases, 10^9 of them
$ cat > bad.yaml; cns run bad.yaml
| a: &a [x,x,x,x,x,x,x,x,x,x]
| b: &b [*a,*a,*a,*a,*a,*a,*a,*a,*a,*a]
| c: &c [*b,*b,*b,*b,*b,*b,*b,*b,*b,*b]
| d: &d [*c,*c,*c,*c,*c,*c,*c,*c,*c,*c]
| e: &e [*d,*d,*d,*d,*d,*d,*d,*d,*d,*d]
| f: &f [*e,*e,*e,*e,*e,*e,*e,*e,*e,*e]
| g: &g [*f,*f,*f,*f,*f,*f,*f,*f,*f,*f]
| h: &h [*g,*g,*g,*g,*g,*g,*g,*g,*g,*g]
| model: *h
2> re:^bad.yaml:
2> ...
? 2

= an alias of itself
$ printf 'model: &a [*a]\n' > bad.yaml; cns run bad.yaml
2> re:^bad.yaml:
2> ...
? 2

= an alias of nothing
$ printf 'model: *nothing\n' > bad.yaml; cns run bad.yaml
2> ...
2> re:^bad.yaml:1:8: .*nothing
2> ...
? 2

= a merge key
$ cat > bad.yaml; cns run bad.yaml
| model: apw
| time: &t {end: 1, every: 1}
| goal: {<<: *t, decimals: 3}
2> ...
2> re:^bad.yaml:3:
2> ...
? 2

= a number of a million digits
$ cat > bad.yaml; printf 'initial: {x: %01000000d}\n' 1 >> bad.yaml; cns run bad.yaml 2>&1 | cut -c1-200
| model: apw
| time: {end: 1, every: 1}
| goal: {decimals: 10}
> re:^bad.yaml:4:[0-9]+: .*

= a key with control characters does not reach the terminal raw
$ printf 'model: apw\n"\\e[31mred": 1\ntime: {end: 1, every: 1}\ngoal: {decimals: 3}\n' > bad.yaml
$ cns check bad.yaml 2>&1 | grep -c "$(printf '\033')" || true
> 0

= a name with a newline and a format in it
$ cns run "$(printf 'a%%s%%n\nb.yaml')" 2>&1 | grep -c '%s%n'
> 1

= a newline in the name of a case file breaks no line of a table
$ name=$(printf 'a\n1,2\nb.yaml'); cp "$CASES"/flutter.yaml "$name"
$ cns run -q "$name" --set time.end=1 --events e.csv -o t.csv
$ cns classify -q "$name" --sweep I=1:1:1 > s.csv
$ cns lyapunov -q "$name" --set lyapunov.time=100 > l.csv
$ for f in t e s l; do grep '^# case' $f.csv; grep -c -x 1,2 $f.csv || true; done
> re:^# case: a\?1,2\?b.yaml, SHA-256 
> 0
> re:^# case: a\?1,2\?b.yaml, SHA-256 
> 0
> re:^# case: a\?1,2\?b.yaml, SHA-256 
> 0
> re:^# case: a\?1,2\?b.yaml, SHA-256 
> 0

= nor does a control character in an override that a later one replaces
$ cns run -q "$CASES"/flutter.yaml --set "time.end=$(printf '\302\205')" --set time.end=1 | grep '^# override'
> # override: time.end=?
> # override: time.end=1

= an event that its error would let lie at the start, where nothing counts, is not proven
$ cat > g.yaml; s=0; cns run -q --prove g.yaml --events e.csv --section x=extremum > table || s=$?; grep -c "^x extremum" e.csv || exit $s
| model: apw
| initial: {omega: 2.76}
| time: {end: 3, every: 0.5}
| numerics: {method: rk4, arithmetic: mpfr, digits: 11, step: 5e-3}
> 0
2> re:do not agree on the event at t = 0.0
? 1
