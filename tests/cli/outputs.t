# What is read is never overwritten, and no file is written twice, whatever the names.

= the table onto the case: by its name, another, a hard link, a symbolic link, and through standard input
$ cat > a.yaml; cp a.yaml keep; ln a.yaml hard; ln -s a.yaml soft; mkdir d
$ for name in a.yaml ./d/../a.yaml hard soft; do cns run -q a.yaml -o $name || echo $?; done
$ cns run -q hard -o soft || echo $?; cns run -q - -o a.yaml < a.yaml || echo $?; cns run -q /dev/stdin -o a.yaml < a.yaml || echo $?
$ cns lyapunov -q a.yaml -o hard || echo $?
$ cmp a.yaml keep; ls
| model: apw
| initial: {theta: 1}
| time: {end: 1}
| goal: {decimals: 4}
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> a.yaml
> d
> hard
> keep
> soft
2> cns: --output a.yaml would overwrite a.yaml, which is read
2> cns: --output ./d/../a.yaml would overwrite a.yaml, which is read
2> cns: --output hard would overwrite a.yaml, which is read
2> cns: --output soft would overwrite a.yaml, which is read
2> cns: --output soft would overwrite hard, which is read
2> cns: --output a.yaml would overwrite standard input, which is read
2> cns: --output a.yaml would overwrite /dev/stdin, which is read
2> cns: --output hard would overwrite a.yaml, which is read

= events onto the case or the table, which may not be there yet
$ cat > a.yaml; cp a.yaml keep; mkdir d; ln -s .. d/up
$ cns run -q a.yaml --events a.yaml || echo $?
$ cns run -q a.yaml --events t.csv -o t.csv || echo $?; cns run -q a.yaml --events t.csv -o "$PWD"/d/up/t.csv || echo $?
$ cns run -q a.yaml --events /dev/stdout > t || echo $?; cns run -q a.yaml --events /dev/stdout --yaml > t || echo $?
$ echo old > t.csv; ln t.csv u.csv; cns run -q a.yaml --events t.csv -o u.csv || echo $?; cat t.csv u.csv
$ cmp a.yaml keep; ls
| model: apw
| initial: {theta: 1}
| time: {end: 1}
| goal: {decimals: 4}
> 2
> 2
> 2
> 2
> 2
> 2
> old
> old
> a.yaml
> d
> keep
> t
> t.csv
> u.csv
2> cns: --events a.yaml would overwrite a.yaml, which is read
2> cns: --output t.csv and --events t.csv are the same file
2> re:^cns: --output /.* and --events t\.csv are the same file$
2> cns: --events /dev/stdout and standard output are the same file
2> cns: --events /dev/stdout and standard output are the same file
2> cns: --output u.csv and --events t.csv are the same file

= standard output onto what is read, by any command
$ cat > a.yaml; cp a.yaml keep; printf 't,x\n0,1\n' > t.csv; cp t.csv keep.csv; cp t.csv u.csv
$ for c in run check plan 'run -o /dev/stdout' 'run --yaml -o x.csv' equilibria; do cns $c a.yaml >> a.yaml || echo $?; done
$ cns run -q - < a.yaml >> a.yaml || echo $?
$ cns compare t.csv u.csv >> t.csv || echo $?; cns compare t.csv u.csv >> u.csv || echo $?; cns compare t.csv - < u.csv >> u.csv || echo $?
$ cns check a.yaml 1<> a.yaml || echo $?
$ cmp a.yaml keep; cmp t.csv keep.csv; cmp u.csv keep.csv; ls
| model: apw
| initial: {theta: 1}
| time: {end: 1}
| goal: {decimals: 4}
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> a.yaml
> keep
> keep.csv
> t.csv
> u.csv
2> cns: standard output would overwrite a.yaml, which is read
2> cns: standard output would overwrite a.yaml, which is read
2> cns: standard output would overwrite a.yaml, which is read
2> cns: --output /dev/stdout would overwrite a.yaml, which is read
2> cns: standard output would overwrite a.yaml, which is read
2> cns: standard output would overwrite a.yaml, which is read
2> cns: standard output would overwrite standard input, which is read
2> cns: standard output would overwrite t.csv, which is read
2> cns: standard output would overwrite u.csv, which is read
2> cns: standard output would overwrite standard input, which is read
2> cns: standard output would overwrite a.yaml, which is read

= what is no file, or another one, may be named freely
$ cat > a.yaml; cp a.yaml b.yaml; cns run -q a.yaml -o /dev/null --events /dev/null; cns run -q a.yaml -o /dev/stdout > t.csv; tail -n 1 t.csv
$ cns run -q a.yaml --yaml -o /dev/stdout | grep -c '^# complete\|^end:'; cns run -q a.yaml --events /dev/stdout | grep -c '^# complete'
$ cns run -q a.yaml -o b.yaml --events t.csv; tail -qn 1 b.yaml t.csv; cns compare b.yaml b.yaml > /dev/null; cns run -q a.yaml -o none/t.csv || echo $?
| model: apw
| initial: {theta: 1}
| time: {end: 1}
| goal: {decimals: 4}
> # complete
> 2
> 2
> # complete
> # complete
> 4
2> re:^cns: cannot write none/t\.csv: 

= a file of another kind among kept runs stays as it is
$ mkdir d; cp "$CASES"/modes.yaml d/I=1.1; cns classify -q d/I=1.1 --sweep I=1.1:1.1:1 -o d || echo $?
$ cmp d/I=1.1 "$CASES"/modes.yaml; ls d
> re:^(#|I,)
> ...
> 2
> I=1.1
2> cns: d/I=1.1 is no kept run, and would be overwritten
