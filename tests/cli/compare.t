# cns compare: two tables.

= agreed decimals, the first difference, and T_c
$ cat > a.csv; sed 's/1\.2500/1.2600/' a.csv > b.csv; cns compare a.csv b.csv; cns compare --yaml a.csv b.csv
| t,u,v
| 0,1.0000,2.0000
| 0.5,1.2500,2.0000
> t,decimals
> 0,4
> 0.5,1
> # common rows: 2 of 2 and 2
> # first difference: t = 0.5, u: 1.2500 and 1.2600
> # T_c, criterion rows: first common row beyond delta = 0.01; norm of u, v (all common columns)
> # T_c of norm: > 0.5
> # T_c of u: > 0.5
> # T_c of v: > 0.5
> agreed:
> - t: 0
>   decimals: 4
> - t: 0.5
>   decimals: 1
> first_difference:
>   t: 0.5
>   column: u
>   a: 1.2500
>   b: 1.2600
> not_compared: []
> delta: 0.01
> criterion: rows
> times:
>   norm:
>     beyond: 0.5
>   u:
>     beyond: 0.5
>   v:
>     beyond: 0.5
> norm_of: u, v (all common columns)
> rows:
>   a: 2
>   b: 2
>   common: 2

= with -v, every column
$ cat > a.csv; printf 'v;t;u\n2.01;0;\n' | cns compare -v --delta 0.001 a.csv - | grep -v '^# T_c:\|rows'
| t,u,v
| 0,1.0000,2.0000
> t,decimals,u,v
> 0,-inf,-inf,1
> # not compared: 1 value of u, missing in B, first at t = 0
> # first difference: t = 0, u: 1.0000 and no number
> # T_c of norm: 0
> # T_c of u: no value in common
> # T_c of v: 0

= a table of ten decimals agrees with one of twenty, in the states of the model
$ cat > a.yaml; cns run -q a.yaml > a.csv; cns run -q a.yaml --set goal.decimals=20 --set time.every=0.5 > b.csv; cns compare a.csv b.csv
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 2, every: 1}
| goal: {decimals: 10}
> t,decimals
> 0,10
> 1,10
> 2,10
> # common rows: 3 of 3 and 5
> # not compared: 2 rows only in B, first at t = 0.5
> # first difference: none
> # T_c, criterion rows: first common row beyond delta = 0.01; norm of theta, Vx, Vy, omega (dynamic states of apw)
> re:^# T_c of norm: > 2$
> ...

= a run of few digits leaves the reference where tc says, but for the row
$ cat > a.yaml; cns run -q a.yaml --set numerics.arithmetic=double --set numerics.order=20 > a.csv
$ cns run -q a.yaml --set numerics.digits=45 > b.csv; cns compare --yaml a.csv b.csv | sed -n 's/^  norm: //p' > table
$ cns tc -q a.yaml --set laws.criterion=rows --set numerics.arithmetic=double --set numerics.order=20 | sed -n 's/.*norm.*first row: \(.*\))/\1/p' | cmp - table
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 60, every: 0.25}
| numerics: {method: taylor}

= times that are no finite decimals are common whatever the decimals and the method
$ cat > a.yaml; cns run -q a.yaml > 15.csv; cns run -q a.yaml --set goal.decimals=10 > 10.csv
$ sed 's/goal.*/numerics: {method: rk4, arithmetic: double, step: 1e-3}/' a.yaml > rk4.yaml; cns run -q rk4.yaml > rk4.csv
$ for f in 10 rk4; do cns compare --decimals 6 15.csv $f.csv | grep '^[0-9]\|common rows\|not compared\|first diff'; done
$ cns run -q a.yaml --set time.end=1e-6 --set time.every=1e-7/3 --set goal.decimals=5 > f.csv; cns compare --decimals 5 f.csv f.csv | grep 'common rows\|not compared\|first diff'
$ grep -v '^# times' 15.csv > plain.csv; cns compare 15.csv plain.csv | grep 'common rows'
| model: lorenz
| initial: {x: 1}
| time: {end: 1, every: 1/3}
| goal: {decimals: 15}
> 0,10
> 0.33333333333333333,10
> 0.66666666666666667,10
> 1,10
> # common rows: 4 of 4 and 4
> # first difference: none
> 0,0
> re:^0\.33333333333333333,[78]$
> re:^0\.66666666666666667,[78]$
> re:^1,[78]$
> # common rows: 4 of 4 and 4
> re:^# first difference: t = 0\.33333333333333333, [xyz]: 
> # common rows: 31 of 31 and 31
> # first difference: none
> # common rows: 2 of 4 and 4

= a table of a newer format is refused
$ cat > a.csv; cns compare a.csv a.csv
| # cns 9.9.9: disk falling through water
| # format: 2
| t,x
| 0,1
? 2
2> cns: a.csv:2:1: a table of format 2, from a newer cns: this one reads tables up to format 1

= what is not compared is named, and is no agreement; --decimals makes an exit status of it
$ printf 't,x\n0,1\n1,nan\n' > a.csv; printf 't,x,y\n0,1,3\n1,-7,1\n3,3,3\n' > b.csv
$ cns compare a.csv b.csv | grep -v T_c; cns compare -v --yaml a.csv b.csv | sed '/^delta/,$d'
$ cns compare --decimals 3 a.csv b.csv > out || echo $?; cns compare --decimals 1 a.csv a.csv > out || echo $?
$ printf 't,x\n0,1.25\n1,2.5\n' > c.csv; printf 't,x\n0,1.250000\n1,2.5001\n' > d.csv
$ cns compare --decimals 1 c.csv d.csv > out; cns compare --decimals 2 c.csv d.csv | tail -n 1; cns compare --decimals 9 c.csv c.csv > out
$ cns compare --decimals 2 c.csv d.csv > out
> t,decimals
> 0,0
> 1,-inf
> # common rows: 2 of 2 and 3
> # not compared: column y, only in B
> # not compared: 1 row only in B, first at t = 3
> # not compared: 1 value of x, missing in A, first at t = 1
> # first difference: t = 1, x: no number and -7
> agreed:
> - t: 0
>   decimals: 0
>   columns:
>     x: 0
> - t: 1
>   decimals: -.inf
>   columns:
>     x: -.inf
> first_difference:
>   t: 1
>   column: x
>   a: null
>   b: -7
> not_compared:
> - column: y
>   only_in: b
> - rows: 1
>   only_in: b
>   first: 3
> - column: x
>   values: 1
>   missing_in: a
>   first: 1
> 1
> 1
> # T_c of x: > 1
2> cns: not all was compared: the lines or the list 'not compared' say what was not
2> cns: not all was compared: the lines or the list 'not compared' say what was not
2> cns: 1 value agrees to fewer than 2 decimals, first at t = 1, x: 2.5 and 2.5001
2> cns: 1 value agrees to fewer than 2 decimals, first at t = 1, x: 2.5 and 2.5001
? 1

= names of others that hold commas and quotes stay one name
$ printf 't,"x, ""left"""\n0,1\n' > a.csv; cns compare -v a.csv a.csv | head -n 2
> t,decimals,"x, ""left"""
> 0,0,0

= faults are shown where they are
$ printf 't,u\n0,1\n1,2x\n' > a.csv; printf 't,u\n0,1\n' > b.csv; cns compare a.csv b.csv || echo $?; cns compare b.csv a.csv || echo $?
$ cns compare a.csv none.csv || echo $?; cns compare - - || echo $?; cns compare a.csv
> 2
> 2
> 4
> 2
2> cns: a.csv:3:3: '2x' in column 'u': not a number
2> cns: a.csv:3:3: '2x' in column 'u': not a number
2> re:^cns: cannot read none\.csv: 
2> re:standard input
2> cns: only 'a.csv' is given: cns compare A B
? 2
