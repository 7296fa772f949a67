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
> # T_c: first common row beyond delta = 0.01; norm of u, v (all common columns)
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
> delta: 0.01
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
> 0,1,,1
> # first difference: t = 0, v: 2.0000 and 2.01
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
> # first difference: none
> # T_c: first common row beyond delta = 0.01; norm of theta, Vx, Vy, omega (dynamic states of apw)
> re:^# T_c of norm: > 2$
> ...

= a run of few digits leaves the reference where tc says, but for the row
$ cat > a.yaml; cns run -q a.yaml --set numerics.arithmetic=double --set numerics.order=20 > a.csv
$ cns run -q a.yaml --set numerics.digits=45 > b.csv; cns compare --yaml a.csv b.csv | sed -n 's/^  norm: //p' > table
$ cns tc -q a.yaml --set numerics.arithmetic=double --set numerics.order=20 | sed -n 's/.*norm.*first row: \(.*\))/\1/p' | cmp - table
| model: lorenz
| initial: {x: -15.8, y: -17.48, z: 35.64}
| time: {end: 60, every: 0.25}
| numerics: {method: taylor}

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
2> re:^cns: A B is missing
? 2
