# Critical parameters.

= the heteroclinic value of the falling disk, to 30 decimals
$ cns bisect -q --yaml "$CASES"/heteroclinic.yaml

> parameter: I
> critical: 1.219146631202134125229662155225
> re:^lower: 1.21914663120213412522966215522[0-9]*$
> re:^upper: 1.21914663120213412522966215522[0-9]*$
> lower_mode: flutter
> upper_mode: tumble
> decimals: 30
> re:^probes: [0-9]+$

= threads do not change it, and what is asked is what is printed
$ cns bisect -q --threads 1 "$CASES"/heteroclinic.yaml --set bisect.decimals=12 > a
$ cns bisect -q --threads 4 "$CASES"/heteroclinic.yaml --set bisect.decimals=12 > b
$ cmp a b
$ head -n 1 a
> I = 1.219146631202, 12 decimals

= probes are kept, and used again
$ cns bisect -q "$CASES"/heteroclinic.yaml --set bisect.decimals=10 -o probes > a
$ ls probes | wc -l > before
$ cns bisect -q "$CASES"/heteroclinic.yaml --set bisect.decimals=10 -o probes > b
$ ls probes | wc -l | cmp - before
$ cmp a b

= the same mode at both ends: the honest result, and status 1
$ cns bisect -q "$CASES"/heteroclinic.yaml --set bisect.lower=1.22 --set bisect.upper=1.225
> tumble   at 1.22
> tumble   at 1.225
2> re:^cns: I is tumble at both ends
? 1

= a bracket too far from the connection is an error that says so
$ cns bisect -q "$CASES"/heteroclinic.yaml --set bisect.upper=1.4
2> re:^cns: I = 1.4: .*has not come near the next saddle
? 3

= without a section bisect
$ cp "$CASES"/flutter.yaml a.yaml; cns bisect a.yaml
2> a.yaml:1:1: no 'bisect': `cns bisect` needs that section
? 2

= by trajectory: the same, found in another way
$ cns bisect -q "$CASES"/heteroclinic-trajectory.yaml --set bisect.decimals=8 -o probes > a; head -n 1 a
$ cns bisect -q "$CASES"/heteroclinic-trajectory.yaml --set bisect.decimals=8 -o probes | cmp - a
> I = 1.21914663, 8 decimals

= by trajectory: the same mode at both ends
$ cns bisect -q "$CASES"/heteroclinic-trajectory.yaml --set bisect.lower=1.22 --set bisect.upper=1.225
> tumble   at 1.22
> tumble   at 1.225
2> re:no change of mode
? 1
