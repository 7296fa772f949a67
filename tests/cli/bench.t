# cns bench: short ones, for its shape; nobody checks how fast a machine is.

= a table: what was measured, what is right, and what there was no time for
$ cns bench --seconds 0.01 > table; sed -n 1p table; grep -c '^\(apw\|lorenz\)' table
$ awk '/^(apw|lorenz)/ && $NF != "-" { n++; if ($NF < $(/eps/ ? 4 : 2) - 2) print "too few right:", $0 } END { print (n > 0) }' table
> seconds of processor time per unit of integrated time, one thread; medians
> 12
> 1

= what does not fit into the time is said to be left out
$ cns bench --seconds 0.01 | tail -n 1
> re:^-: left out, 0\.01 s are too short

= the kernel asked for in the environment does not change what is measured
$ CNS_KERNEL=portable cns bench --seconds 0.01 -q | sed -n 2p
> re:mpfr +portable +x +avx512ifma

= a summary, and the table with -o
$ cns bench --seconds 0.01 --yaml -o table > summary; sed -n 1,5p summary; grep -q seconds_per_unit summary; head -n 1 table
> rows:
> - model: apw
>   digits: 60
>   until: 2
>   engines:
> seconds of processor time per unit of integrated time, one thread; medians

= -o leaves an old file when it cannot write
$ cns bench --seconds 0.01 -o nowhere/table
2> re:^cns: cannot write nowhere/table
? 4

= a device is written to, not replaced
$ cns bench --seconds 0.01 -o /dev/null; test -c /dev/null

= an interrupt ends it
$ cns bench --seconds 9999 & wait_for "catches $!"; kill -INT $!; wait $!
2> re:^cns: stopped by signal INT
? 130
if test -r /proc/self/status

= seconds are checked
$ cns bench --seconds 0
2> re:^cns: --seconds takes
? 2

= seconds go with bench only
$ cns models --seconds 1
2> re:--seconds does not go with
? 2
