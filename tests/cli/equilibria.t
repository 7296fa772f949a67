# Fixed points and eigenvalues.

= the four of a falling disk, as a table
$ cns equilibria "$CASES"/flutter.yaml --set parameters.I=1.2191 --digits 7
> edge-on: saddle-focus, 1 unstable direction
>   theta  1.5707963
>   Vx    -2.8024956
>   Vy     0.0000000
>   omega  0.0000000
>   eigenvalues
>          0.3812957
>         -0.5853906
>         -0.9861176 + 2.5950357 i
>         -0.9861176 - 2.5950357 i
> re:^$
> broadside: saddle-focus, 2 unstable directions
> ...

= more digits are the same digits
$ cns equilibria "$CASES"/lorenz.yaml --digits 60 > a
$ cns equilibria "$CASES"/lorenz.yaml --digits 30 > b
$ cut -c1-40 a | grep -c "8.485281374238570292810132345258"
$ grep -c "8.485281374238570292810132345258" b
> 4
> 4

= the summary is YAML: a list of name, state, eigenvalues
$ cns equilibria "$CASES"/lorenz.yaml --digits 5 --yaml | head -n 18

> decimals: 5
> equilibria:
> - name: origin
>   stability: saddle
>   unstable: 1
>   state:
>     x: 0.00000
>     y: 0.00000
>     z: 0.00000
>   eigenvalues:
>   - re: 11.82772
>     im: 0
>   - re: -2.66667
>     im: 0
>   - re: -22.82772
>     im: 0
> - name: C+
>   stability: saddle-focus

= what cannot be proven is not printed, and the status says so
$ cns equilibria "$CASES"/lorenz.yaml --set parameters.R=1
2> re:^cns: .*origin
? 1

= --digits wants a number of digits
$ cns equilibria "$CASES"/lorenz.yaml --digits 0
2> re:--digits.*1 to
? 2

= without fixed points there is nothing to look for
$ cns equilibria "$CASES"/flutter.yaml --set parameters.A=0 --set parameters.B=0
2> re:no fixed points
? 2
