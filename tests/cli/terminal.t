# On a terminal, wide or narrow, and without one.

= help is at most 80 columns wide, in a pipe, too
$ for c in '' case $(cns help | sed -n 's/^  cns \([a-z]*\) .*/\1/p'); do cns help $c; done > help; cns models >> help
$ awk '{if (length > n) n = length} END {print (n <= 80), (n > 75)}' help
> 1 1

= on a narrow terminal help is as wide as that, and says the same
$ for c in run classify case; do script -qec "stty cols 40; cns help $c" /dev/null | tr -d '\r' > narrow; cns help $c > wide
$ awk 'length > 40' narrow; for f in narrow wide; do tr -s ' \n' '\n\n' < $f > $f.words; done; cmp narrow.words wide.words; done
if script -qec 'stty cols 40' /dev/null </dev/null

= notes and messages are folded at words, under their text
$ script -qec "stty cols 40; cns run -q nowhere.yaml; cns check '$CASES/case4.yaml' --set goal.digits=3; cns frobnicate" /dev/null | tr -d '\r'
> cns: cannot read nowhere.yaml: No such
>      file or directory
> --set goal.digits=3: unknown key
>      'digits' in 'goal'; it belongs in
>      'numerics'
> cns: unknown command 'frobnicate'; `cns
>      help` lists the commands
if script -qec 'stty cols 40' /dev/null </dev/null

= without a terminal a message is one line, whatever its length
$ cns run -q a-directory-with-a-rather-long-name/and-a-file-in-it-with-a-name-that-is-not-short-either/nowhere.yaml
2> cns: cannot read a-directory-with-a-rather-long-name/and-a-file-in-it-with-a-name-that-is-not-short-either/nowhere.yaml: No such file or directory
? 4

= progress gets out of the way of the rows on the same terminal
$ cat > a.yaml; script -qec "cns run a.yaml" /dev/null > shown; cns run -q a.yaml > quiet
$ awk '/ left / && !/\033\[K\r\033\[K[^\033]*$/' shown
$ sed "s/.*$(printf '\033')\[K//" shown | tr -d '\r' | grep '^[0-9#t]' | cmp - quiet
if script -qec 'stty cols 40' /dev/null </dev/null
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 12, every: 1/2}
| goal: {decimals: 300}

= a control character in what the user wrote does not reach the terminal raw
$ e=$(printf 'a\033[31m\nb'); for o in "run $e.yaml" "frob$e" "run --x$e" "models $e" "help $e" "compare $e $e" "run $CASES/rest.yaml -o $e/t" "plan $CASES/rest.yaml --until $e" "classify -q $CASES/rest.yaml --sweep $e" "run -q $CASES/rest.yaml --events e --section $e=1" "check $CASES/rest.yaml --set $e"; do
$ c=${o%% *}; cns $c "${o#* }" 2>&1 | grep -c "$(printf '\033')" || true; done | sort -u
$ CNS_KERNEL=$e cns plan "$CASES"/rest.yaml 2>&1 | grep -c "$(printf '\033')" || true
> 0
> 0
