#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: every command and every option of --help stands in the manual page and completes in
# bash, none of which is written by hand; options' texts fit a terminal of 80 columns.
. "$(dirname "$0")/expect.bash"
rm -rf ./*
"$RAYMAP" help --man >raymap.1
"$RAYMAP" help --completion >raymap.bash
. ./raymap.bash
complete_line() { # WORDS...: what the last of them may become
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
    _raymap
    printf '%s\n' "${COMPREPLY[@]}"
}

[ "$(complete_line raymap det)" = detector ] || { echo "FAILED: det"; failures=1; }
commands=$("$RAYMAP" --help | sed -n 's/^  \([a-z]*\)  .*/\1/p')
within() { # LINES LINE: one of them
    [[ $'\n'$1$'\n' == *$'\n'"$2"$'\n'* ]]
}
manual=$(<raymap.1)
completed=$(complete_line raymap '')
for command in $commands; do
    within "$completed" "$command" || { echo "FAILED: $command does not complete"; failures=1; }
    within "$manual" ".SS \"raymap $command\"" || { echo "FAILED: $command is not in the manual"; failures=1; }
    help=$("$RAYMAP" "$command" --help)
    all=$(complete_line raymap "$command" --)
    for option in $(sed -n 's/^  \(-.,\|   \) \(--[a-z-]*\).*/\2/p' <<<"$help"); do
        within "$all" "$option" || { echo "FAILED: $command $option does not complete"; failures=1; }
        [[ $manual == *"\\fB${option//-/\\-}\\fR"* ]] || { echo "FAILED: $option is not in the manual"; failures=1; }
    done
    [[ $manual =~ $'\n.BR raymap'[^$'\n']*"$command (1)" ]] || { echo "FAILED: raymap(1) does not name the page of $command"; failures=1; }
    wide=$(grep '.\{81\}' <<<"$help")
    [ -z "$wide" ] || { echo "FAILED: $command --help is wider than 80 columns: $wide"; failures=1; }
done
# What is installed has a page of every command (cli.test_install); what stands in them is in raymap(1), too.
"$RAYMAP" help --man query >raymap-query.1
grep -q "^.SH NAME" raymap-query.1 || { echo "FAILED: no page of query"; failures=1; }
! "$RAYMAP" --help | grep '.\{81\}' || { echo "FAILED: --help is wider than 80 columns"; failures=1; }
# Values of options, and names in a map.
"$RAYMAP" trace "$SOURCE_DIR/examples/double-gauss/scene.yaml" -o a.raymap -n 100 -q
[ "$(complete_line raymap query a.raymap --encoding p)" = plain ] || { echo "FAILED: --encoding"; failures=1; }
[ "$(complete_line "$RAYMAP" detector a.raymap s)" = sensor ] || { echo "FAILED: detector a.raymap"; failures=1; }
[ "$(complete_line "$RAYMAP" stats a.raymap --detector '')" = sensor ] || { echo "FAILED: --detector"; failures=1; }
[ "$(wc -w <<<"$commands")" -ge 7 ] || { echo "FAILED: only these commands: $commands"; failures=1; }
if command -v man >/dev/null; then
    # Names of options are words that man cannot break.
    for page in raymap-query.1 raymap.1; do
        warnings=$(LC_ALL=C.UTF-8 MANWIDTH=100 man --warnings -l "$page" 2>&1 >page.txt)
        [ -z "$warnings" ] || { echo "FAILED: $page: $warnings"; failures=1; }
    done
    grep -q 'raymap query MAP CRITERION' page.txt || { echo "FAILED: no synopsis of query"; failures=1; }
fi
# Ghosts are told by what came before the registration: no example counts a ray's reflections beside it.
cd "$SOURCE_DIR" || exit 1
taught=$(grep -nE "(reflect_specular\)|ghost_order) *[=<>]+ *[0-9]" README.md docs/manual.md docs/analysis.md docs/statistics.md docs/detectors.md docs/paths.md jobs/*.sh mpi/cli/cmd_*.c mpi/cli/manual.c |
    grep -v -e 'where [^)]*\(hit\|ghost_order\)' -e '--which .ghost_order')
[ -z "$taught" ] || { echo "FAILED: $taught"; failures=1; }
finish
