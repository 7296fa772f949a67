# The command line itself: commands, options, help.

= the version
$ cns --version
> re:^cns [0-9]+\.[0-9]+\.[0-9]+
> ...

= help lists the commands
$ cns help
> ...
> re:^ *(cns )?run .*
> ...

= --help is help
$ cns help > a
$ cns --help > b
$ cmp a b

= help for a command
$ cns help run
> re:cns run .*CASE
> ...

= --help after a command is help for it
$ cns help run > a
$ cns run --help > b
$ cmp a b

= no command: what there is, on standard error
$ cns
2> ...
2> re:cns help
2> ...
? 2

= an unknown command is named
$ cns frobnicate
2> re:^cns: .*'frobnicate'
2> ...
? 2

= a mistyped command is guessed
$ cns rnu
2> re:'rnu'.*run
2> ...
? 2

= help for case files names every key
$ cns help case | grep -oE '(model|parameters|initial|time|every|smooth|decimals|digits|tolerance|columns)' | sort -u | wc -l | tr -d ' '
> 10

= help for an unknown command
$ cns help frobnicate
2> re:'frobnicate'
2> ...
? 2

= an unknown option is named
$ cns run --frobnicate x.yaml
2> re:--frobnicate
2> ...
? 2

= an unknown short option is named
$ cns run -Z x.yaml
2> re:-Z
2> ...
? 2

= run needs a case
$ cns run
2> re:^cns.*[Cc][Aa][Ss][Ee]
2> ...
? 2

= run takes one case
$ cns run a.yaml b.yaml
2> re:^cns.*b\.yaml
2> ...
? 2

= an option without its value
$ cns run x.yaml -o
2> re:^cns.*-o
2> ...
? 2

= --set without a value
$ cat > x.yaml; cns check x.yaml --set numerics.digits
| model: apw
| time: {end: 1, every: 1}
| goal: {decimals: 5}
2> re:--set|numerics.digits
2> ...
? 2

= --set with an unknown key
$ cat > x.yaml; cns check x.yaml --set goal.decimal=7
| model: apw
| time: {end: 1, every: 1}
| goal: {decimals: 5}
2> re:'decimal'.*decimals
2> ...
? 2

= --set with a bad value
$ cat > x.yaml; cns check x.yaml --set goal.decimals=lots
| model: apw
| time: {end: 1, every: 1}
| goal: {decimals: 5}
2> re:decimals.*lots|lots.*decimals
2> ...
? 2

= --set overrides the file
$ cat > x.yaml; cns check x.yaml --set goal.decimals=7 --set parameters.I=8/3 > y.yaml
$ grep -o 'decimals: 7' y.yaml; grep -o 'I: 8/3' y.yaml
| model: apw
| time: {end: 1, every: 1}
| goal: {decimals: 5}
> decimals: 7
> I: 8/3

= --set is like having written it: a key that the file leaves out
$ cat > x.yaml; cns check x.yaml --set time.every=0.5 | grep -o 'every: 0.5'
| model: apw
| time: {end: 1}
| goal: {decimals: 5}
> every: 0.5

= a case from standard input
$ cns check - | grep -o 'decimals: 5'
| model: apw
| time: {end: 1}
| goal: {decimals: 5}
> decimals: 5

= the models
$ cns models | grep -oE '\b(apw|lorenz)\b' | sort -u
> apw
> lorenz

= one model: its states and parameters
$ cns models lorenz | grep -oE '^ *(z|sigma|R|b) ' | tr -d ' '
> z
> sigma
> R
> b

= an unknown model
$ cns models lorentz
2> re:'lorentz'
2> ...
? 2

= -- ends the options
$ cns check -- -x.yaml
2> re:-x\.yaml.*No such file
? 4

= what is wrong with options is said, before the case is read
$ for o in '-o a --output=b' '--yaml=3' '--threads' '--threads 0' '--until 3' '-qv' '-qZ' '--output=' '--yamle'; do cns run x.yaml $o || echo $?; done
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> 2
> 2
2> cns: --output is given twice
2> cns: --yaml takes no value
2> cns: --threads needs a value: --threads N
2> cns: --threads takes an integer from 1 to 4096, not '0'
2> cns: --until does not go with `cns run`; write --set time.end=VALUE
2> cns: --quiet and --verbose contradict each other
2> cns: unknown option -Z; `cns help` lists the options
2> cns: --output needs a name
2> cns: unknown option --yamle; did you mean --yaml?

= options in all their forms, anywhere in the line
$ cat > a.yaml; cns -q run a.yaml -ot1; cns run --quiet --output t2 a.yaml; cns run -qo t3 -- a.yaml; cns --output=t4 -q run a.yaml; cmp t1 t2; cmp t1 t3; cmp t1 t4
| model: lorenz
| time: {end: 1}
| numerics: {digits: 16}

# Three operands are too many for any command: none begins to work.
= the help of a command lists the options that it takes, and no others are taken
$ for c in $(cns help | sed -n 's/^  cns \([a-z]*\) .*/\1/p'); do
$ for o in output yaml set prove events section delta reference-digits until decimals sweep observable digits seconds threads quiet verbose; do
$ v=; case $o in yaml | prove | quiet | verbose) ;; *) v==10 ;; esac
$ takes=$(cns help $c | grep -cE "^  +(-[a-z], )?--$o ") || true; cns $c --$o$v a b c 2>&1 | grep -q "does not go with" && refused=1 || refused=0
$ [ $takes != $refused ] || echo $c $o; done; done
