#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: a disk that fills up under one rank ends all of them with status 5 and one message
# that names the file; nothing hangs. A limit on the size of files stands in for the disk.
. "$(dirname "$0")/../cli/expect.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
rm -rf ./*
write_scene scene.yaml
cat >small-disk.sh <<'SCRIPT'
#!/usr/bin/env bash
# Runs a command that can write no more than 12 MiB into any file (MPI needs some too), and is told so by EFBIG.
trap '' XFSZ
ulimit -f 12288
exec "$@"
SCRIPT
chmod +x small-disk.sh

many=(-n 1500k --encoding plain --quiet)
expect 5 'piece-00000.*File too large' ./small-disk.sh "$RAYMAP" trace scene.yaml -o one.raymap "${many[@]}"
expect 5 'shard-00001' mpirun -np 1 "$RAYMAP" trace scene.yaml -o two.raymap "${many[@]}" : \
    -np 1 ./small-disk.sh "$RAYMAP" trace scene.yaml -o two.raymap "${many[@]}"
n=$(grep -c '^raymap:' stderr.txt)
[ "$n" -eq 1 ] || { echo "FAILED: told $n times"; cat stderr.txt; failures=1; }
expect 3 "no folder 'x.csv'" ./small-disk.sh "$RAYMAP" trace scene.yaml -o x.csv/x.raymap -n 10 --quiet

# The answer to a question that does not fit is no answer: no half file stays.
expect 0 '' "$RAYMAP" trace scene.yaml -o good.raymap -n 100k --quiet
expect 5 'out.csv' ./small-disk.sh "$RAYMAP" query good.raymap all -o out.csv
[ ! -e out.csv ] || { echo "FAILED: half a CSV file stays"; failures=1; }
expect 5 "cannot write 'out.json': File too large" ./small-disk.sh "$RAYMAP" query good.raymap all -o out.json
[ ! -e out.json ] || { echo "FAILED: half a JSON file stays"; failures=1; }
rm -rf ./*.raymap
finish
