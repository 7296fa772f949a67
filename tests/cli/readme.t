# The tour of README.md, word for word.

= the commands of the tour print what README.md shows
$ sed -n 's/^    //p' "$CASES"/../README.md > tour; cat > three.yaml; sed 's/goal:.*/numerics: {method: rk4, arithmetic: double, step: 1e-3}/' three.yaml > hand.yaml
$ { cns run -q three.yaml | grep -v '^# libraries\|^# kernel'; cns run -q three.yaml --set goal.decimals=25 | grep '^3,'; } > got
$ { cns run -q --prove hand.yaml | grep '^3,'; cns run -q three.yaml --yaml | grep -v 'wall_s\|kernel'; } >> got
$ grep -vxFf tour got || true
| model: apw
| initial: {theta: 1, Vy: 0.01, omega: 1}
| time: {end: 3, every: 1}
| goal: {decimals: 10}

= every key of case files is in cases/README.md
$ cns help case | sed -n 's|^ *\([a-z_]*\)  .*|\1|p' | sort -u | grep . > keys
$ while read -r key; do grep -q "^| \`.*$key" "$CASES"/README.md || grep -q "\`$key\`\|{$key:" "$CASES"/README.md || echo "$key"; done < keys
$ test $(wc -l < keys) -gt 15

= every command is in README.md
$ cns help | sed -n 's/^  cns \([a-z]*\) .*/\1/p' | while read -r c; do grep -q "^| .cns $c " "$CASES"/../README.md || echo "$c"; done

= every case is in cases/README.md, and every case there is a file
$ cd "$CASES"; for f in *.yaml; do grep -q "^|.*\`$f\`" README.md || echo "$f"; done
$ grep -o '`[a-z0-9.-]*\.yaml`' README.md | tr -d '`' | sort -u | while read -r f; do test -f "$f" || echo "$f"; done

= every tool is in tools/README.md, every folder of src in src/README.md
$ cd "$CASES"/..; for f in tools/*; do f=${f#tools/}; test "$f" = README.md || grep -q "\`$f/*\`" tools/README.md || echo "$f"; done
$ for f in src/*/; do grep -q "^    $f " src/README.md || echo "$f"; done

= the outputs shown in cases/README.md are those of the program
$ cd "$CASES"/..; cns classify -q cases/tumble.yaml | head -6 > "$HOME"/got; cns bisect -q cases/heteroclinic.yaml >> "$HOME"/got
$ cns plan cases/case4.yaml --until 500 --decimals 10 | head -4 >> "$HOME"/got
$ sed -n 's/^    //p' cases/README.md > "$HOME"/shown; grep -vxFf "$HOME"/shown "$HOME"/got || true

= every program, header and folder of tests is in tests/README.md
$ cd "$CASES"/../tests; for f in *.h */ $(find * -prune -type f -perm -u+x); do grep -q "^| \`${f%/}" README.md || echo "$f"; done
