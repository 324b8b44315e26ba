#!/bin/bash
# SPDX-License-Identifier: MIT
# The program as most tests know it. What it prints with --json is kept in $JSON_SEEN too, with its arguments, for
# cli.test_schemas to validate. Not under mpirun, which ends the others with the first that leaves.
program=$RAYMAP_PROGRAM
for word in "$@"; do
    [[ $word != --json ]] || json=yes
done
[[ ${json-} && $1 != session && ! ${OMPI_COMM_WORLD_RANK-} ]] || exec "$program" "$@"
[[ -d $JSON_SEEN ]] || mkdir -p "$JSON_SEEN"
seen=$JSON_SEEN/$$-$SRANDOM
"$program" "$@" >"$seen"
status=$?
cat "$seen"
if ((status == 0)); then
    printf '%s\n' "$@" >"$seen.words"
else
    rm -f "$seen"
fi
exit $status
