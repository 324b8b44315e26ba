#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: threads of a trace, a query, a session and a server share nothing without synchronising, as the
# thread sanitiser sees it (preset tsan; it takes a build of its own).
. "$(dirname "$0")/../cli/expect.bash"
command -v clang-14 >/dev/null || { echo "no clang-14 here"; exit 77; }
rm -rf ./*.raymap ./*.txt race.*
write_scene scene.yaml
(cd "$SOURCE_DIR" && cmake --preset tsan -G Ninja -B "$OLDPWD/build" -DBUILD_TESTING=OFF) >build.log 2>&1 &&
    cmake --build build >>build.log 2>&1 || { tail -20 build.log; exit 1; }
export TSAN_OPTIONS="suppressions=$SOURCE_DIR/tests/tsan.supp exitcode=66 log_path=$PWD/race"
raymap=build/raymap
for encoding in plain compact; do
    map=$encoding.raymap
    expect 0 '' $raymap trace scene.yaml -o $map -n 200000 --encoding $encoding --threads 3 --flush 100ms --quiet
    expect 0 'rays' $raymap query $map 'registered(sensor) and hit(*, transmit_specular) >= 2' 'x(sensor) > 0' --threads 3
    expect 0 'rays' $raymap paths $map --threads 3
    printf '%s\n' 'registered(sensor)' 'x(sensor) > 0' 'registered(sensor)' 'hit(lens) >= 2' >asked.txt
    $raymap session $map --threads 3 <asked.txt >told.txt 2>session.txt || { cat session.txt; failures=1; }
    [ "$(grep -c '"matched"' told.txt)" -eq 4 ] || { echo "FAILED: session: $(cat told.txt)"; failures=1; }
    expect 0 '0 findings' $raymap verify $map --threads 3
    expect 0 '' $raymap detector $map sensor --threads 3 -o image.png --force
    expect 0 '' $raymap trace scene.yaml --set limits.steps=50 --from $map -o from.raymap -n 50000 --threads 3 --quiet --force
done
expect 0 '' $raymap trace "$SOURCE_DIR/examples/selfoc/scene.yaml" -o curved.raymap -n 3000 --threads 3 --quiet
expect 0 '' mpirun -np 2 $raymap trace scene.yaml -o two.raymap -n 100000 --threads 2 --quiet
mkdir -p serve && (cd serve && RAYMAP=$OLDPWD/$raymap RAYMAP_PROGRAM=$OLDPWD/$raymap /usr/bin/python3 "$SOURCE_DIR/tests/cli/test_serve.py") >serve.txt 2>&1 ||
    { tail -20 serve.txt; failures=1; }
if compgen -G 'race.[0-9]*' >race.txt; then
    echo "FAILED: $(wc -l <race.txt) processes with races"
    grep -hm1 -A20 WARNING race.[0-9]*
    failures=1
fi
finish
