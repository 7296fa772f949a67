# cns orbit: periodic orbits.

= Lorenz's orbit AB, from three digits: all that Viswanath has published
$ cns orbit -q "$CASES"/orbit-lorenz.yaml --set orbit.decimals=49 | grep '^period'
$ cns orbit -q "$CASES"/orbit-lorenz.yaml
> period      1.5586522107161747275678702092126960705284805489972
> period      1.558652210716174727567870209212696070528480548997
> symmetry    half-turn after 1/2 of the period
> x          -13.763610682134200525014401054361653864100864854092
> y          -19.578751942451795538838041446009558866114240053428
> z           27.000000000000000000000000000000000000000000000000   held
> stability   unstable, 1 unstable direction
> multipliers of the period, besides the 1 along the orbit
> re:^            4.7129472734240821824985742843533929634143082552[0-9]*$
> re:^            0.00000000011900046996682777751202208112053352[0-9]*$
> multipliers of 1/2 of it, the image taken back
> re:^           -2.17093235118556427635642622189052929168454907[0-9]*$
> re:^           -0.00001090873365550868042239149001151450067348[0-9]*$
> re:^proof  .*digits, other orders and steps, differ by 10\^-
> ...

= the product of the multipliers is exp(-41/3 T), by bc
$ cns orbit -q "$CASES"/orbit-lorenz.yaml --yaml | sed -n '/^multipliers:/,/^[^m]*_of/s/^- re: //p; s/^period: /t=/p' > m
$ { echo 'scale=60'; sed -n '1p; 2s/^/a=/p; 3s/^/b=/p' m; echo 'd=a*b-e(-41*t/3); d<10^-46 && d>-(10^-46)'; } | bc -l
> 1

= from another section: the same period and multipliers, to a hundred decimals
$ cns orbit -q "$CASES"/orbit-lorenz.yaml --set orbit.decimals=100 > a
$ cns orbit -q "$CASES"/orbit-lorenz.yaml --set orbit.decimals=100 --set orbit.section=x > b
$ grep -c '[0-9]\.[0-9]\{100\}' a; diff a b | sed -n 's/^< \([a-z]*\).*/\1/p' | paste -sd ' '
> 8
> re:^x y z proof *$
= chaos comes near to it
$ cns orbit -q "$CASES"/orbit-lorenz.yaml --set initial='{x: 1, y: 1, z: 1}' --set orbit.period=none --set orbit.decimals=40 | sed -n '1,2p'
> period      1.5586522107161747275678702092126960705285
> symmetry    half-turn after 1/2 of the period

= the disk's tumbling, and its period against the trajectory of `cns run` from there, which knows nothing of tangents
$ cns orbit -q "$CASES"/orbit-tumble.yaml > o; sed -n '1,5p' o
$ v() { awk -v k="$1" '$1 == k {print $2}' o; }
$ cat > c.yaml <<E
$ model: apw
$ parameters: {I: 1.4}
$ initial: {theta: 0, Vx: $(v Vx), Vy: $(v Vy), omega: $(v omega)}
$ time: {end: $(v period)}
$ goal: {decimals: 48}
$ E
$ cns run -q c.yaml | sed -n '/^12/{s/,48,.*//;p}' | tr , '\n' | tail -n 3 > end
$ for k in Vx Vy omega; do v $k; done | paste end - | while read -r a b; do echo "scale=60; d=$a-($b); d<2*10^-48 && d>-2*10^-48"; done | bc
> period      12.84289008390577305183354898227984631999952309145456
> winding     1   whole revolutions in a period
> symmetry    half-turn after 1/2 of the period
> theta       0.00000000000000000000000000000000000000000000000000   held
> Vx          1.50051086980573254044336240081964138929580969182341
> 1
> 1
> 1

= where tumbling of period two begins: the simple orbit's multiplier is -1, and its own, as a polynomial in I, 1
$ cns orbit -q "$CASES"/orbit-tumble.yaml --set orbit.decimals=15 --sweep I=1.4202:1.419:0.0002 > t
$ grep '^1.419[0-9]*,s\|^1.4190*,\|^# I' t | cut -d , -f 1,2,4,12,13
$ awk -F , '/^1/ && $4 == 1 {n++; x[n] = $14; y[n] = $1}
$ END {for (k = 1; k < n; k++) for (i = 1; i <= n - k; i++) y[i] = ((1 - x[i+k]) * y[i] + (x[i] - 1) * y[i+1]) / (x[i] - x[i+k])
$ printf "%.10f of %d\n", y[1], n}' t
> 1.419074041853258,symmetry breaking,2,not hyperbolic,0
> # I=1.419: before this value the orbit becomes one that repeats after a part of its time
> 1.419,,2,stable,0
> 1.4190740419 of 6

= Lorenz: a fold, where the branch ends
$ cat > l.yaml; cns orbit l.yaml --sweep R=165:167:1 > t || echo $?
$ grep -v '^# [fcsv]' t | cut -d , -f 1,2,4; tail -n 1 t
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
| orbit: {decimals: 12}
2> cns: at R = 167: the branch turns back before that, in a fold
> 1
> R,crossing,repetitions
> 165,,2
> 166,,2
> 166.061492103860,fold,2
> # R=167: the branch turns back before that, in a fold
> # stopped: at R = 167: the branch turns back before that, in a fold

= a doubling
$ cat > l.yaml; cns orbit -q l.yaml --sweep R=229:230:1 | grep '^[0-9]' | cut -d , -f 1,2,4
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
| orbit: {decimals: 12}
> 229,,1
> 229.406708561443,doubling,1
> 230,,1

= where an orbit leaves its section another one is taken, with the same period and multipliers as from its own
$ a=$CASES/orbit-lorenz.yaml; cns orbit -q "$a" --set orbit.decimals=20 --sweep R=28:48:20 > t; sed -n '/^# R/p' t
$ cns orbit -q "$a" --set parameters.R=48 --set orbit.decimals=20 --set orbit.section=x --set initial='{x: -18.27, y: -26.1, z: 51.1}' --set orbit.period=1.11 > b
$ sed -n '/^48/p' t | tr , '\n' | grep -c "$(sed -n 's/^period *//p' b)\|$(grep -m 1 '^  *[0-9]' b | tr -d ' ')"
> # R=48: from here on the orbit begins on another section, which it crosses better
> 2

= what is missing, or makes no sense
$ cat > l.yaml
$ cns orbit -q l.yaml --set parameters.R=10 || echo $?
$ cns orbit -q l.yaml --set orbit.section=x || echo $?
$ cns orbit -q "$CASES"/orbit-tumble.yaml --set orbit.section=y --set orbit.period=12 || echo $?
$ cns orbit -q l.yaml --sweep initial.x=1:2:1 || echo $?
$ cns orbit -q l.yaml --sweep R=1:2:1 --yaml || echo $?
| model: lorenz
| initial: {x: 1, y: 1, z: 1}
| time: {end: 1}
2> re:comes to rest
2> re:section of the late motion
2> re:nothing feeds back on state 'y'
2> re:in a parameter, not in initial.x
2> re:--yaml
> 3
> 2
> 2
> 2
> 2
