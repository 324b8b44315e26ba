#!/bin/bash
# SPDX-License-Identifier: MIT
# A map that is being traced: it can be looked at and queried, and a second trace keeps its hands
# off it. Once its writer was killed, --resume takes it over.
set -euo pipefail
scene=$SOURCE_DIR/examples/double-gauss/scene.yaml
fail() { echo "FAILED: $*" >&2; exit 1; }

rm -rf live.raymap
"$RAYMAP" trace "$scene" -o live.raymap -n 100M --flush 0.2 --threads 1 --piece-size 64Gi --quiet &
writer=$!
trap 'kill -9 $writer 2>/dev/null || true' EXIT
rays=0
for _ in $(seq 300); do
    rays=$("$RAYMAP" info live.raymap --json 2>/dev/null |
        /usr/bin/python3 -c 'import json, sys; print(json.load(sys.stdin)["rays"])' 2>/dev/null) || rays=0
    [ "${rays:-0}" -gt 0 ] && break
    sleep 0.1
done
[ "${rays:-0}" -gt 0 ] || fail "a live map shows no rays"
"$RAYMAP" query live.raymap 'source(star)' --count --json >counted.json 2>remark.txt || fail "a live map answers no query"
grep -q 'live.raymap is not complete (see: raymap info): it holds [0-9,]* rays' remark.txt || fail "query does not say that the map is not complete"
"$RAYMAP" query live.raymap 'ray < 5' --limit 1 --quiet 2>&1 >/dev/null | grep -q "is not complete" || fail "query --quiet keeps silent"

# All ranks work on what one of them found: none need find the same at the same moment.
mpirun -np 3 "$RAYMAP" query live.raymap 'source(star)' --count --json >counted.json || fail "a live map answers no query of ranks"
/usr/bin/python3 - <<'EOF' || fail "other rays on other ranks: $(cat counted.json)"
import json
rays = json.load(open("counted.json"))["rays"]
assert 0 < rays["matched"] < rays["total"] and abs(4 * rays["matched"] - rays["total"]) < 4, rays
EOF
"$RAYMAP" info live.raymap | grep -q 'NOT complete: it is being traced' || fail "info does not say that it is being traced"

"$RAYMAP" verify live.raymap | grep -q 'not complete: it is being traced' || fail "verify does not say that it is being traced"

# A session sees what was flushed since it opened the map, once it is told to, and answers of the old map are forgotten.
/usr/bin/python3 - <<'EOF' || fail "a session does not see what was flushed"
import json, os, subprocess, time
for launch in ([], ["mpirun", "-np", "2"]):
    session = subprocess.Popen([*launch, os.environ["RAYMAP"], "session", "live.raymap", "--quiet"], text=True, bufsize=1,
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    def ask(line):
        print(line, file=session.stdin, flush=True)
        return json.loads(session.stdout.readline())
    first = ask("source(star)")["rays"]
    more, n = first, 0
    while more["total"] == first["total"] and n < 100:
        time.sleep(0.2)
        assert ask("source(star)")["rays"] == more, "the same map until it is told"
        told = ask("refresh")
        assert told["refreshed"]["rays_before"] == more["total"] and told["rays_traced"] == told["refreshed"]["rays"], told
        more, n = ask("source(star)")["rays"], n + 1
        assert more["total"] == told["refreshed"]["rays"], (more, told)
    assert more["total"] > first["total"] and abs(4 * more["matched"] - more["total"]) < 4, (first, more)
    os.rename("live.raymap/map.h5", "gone.h5")
    assert "as it was" in ask("refresh")["error"] and ask("source(star)")["rays"] == more, "a map that is gone"
    os.rename("gone.h5", "live.raymap/map.h5")
    session.stdin.close()
    assert session.wait() == 3, "one line was wrong"
EOF

refused() { # WHAT COMMAND...
    local what=$1 status=0
    shift
    "$RAYMAP" "$@" --quiet >/dev/null 2>refused.txt || status=$?
    [ $status -eq 2 ] || fail "$what a live map ended with $status: $(cat refused.txt)"
    grep -q "being written to by another raymap (raymap trace, process" refused.txt || fail "it does not say why: $(cat refused.txt)"
    kill -0 $writer || fail "the writer did not survive $what"
}
refused 'a second trace of' trace "$scene" -o live.raymap --resume
refused 'replacing' trace "$scene" -o live.raymap -n 10 --force
refused 'repair of' repair live.raymap

kill -9 $writer
wait $writer 2>/dev/null || true
# Rays of a journal are not thrown away for want of an index.
mv live.raymap/map.h5 aside.h5
status=0
"$RAYMAP" trace "$scene" -o live.raymap --resume --time-limit 1s --quiet 2>refused.txt || status=$?
[ $status -eq 4 ] || fail "without an index, taking over ended with $status: $(cat refused.txt)"
compgen -G "live.raymap/shard-*/.piece-*.journal" >/dev/null || fail "the journal is gone"
mv aside.h5 live.raymap/map.h5
status=0
"$RAYMAP" trace "$scene" -o live.raymap --resume --time-limit 1s --quiet 2>resumed.txt || status=$?
[ $status -eq 6 ] || fail "taking over ended with $status: $(cat resumed.txt)"
"$RAYMAP" verify live.raymap --quiet || fail "the map does not verify"
rm -rf live.raymap

# Also before anything was flushed.
"$RAYMAP" trace "$scene" -o live.raymap -n 100M --flush 1000 --threads 1 --piece-size 64Gi --quiet &
writer=$!
for _ in $(seq 1200); do
    compgen -G "live.raymap/shard-*/.piece-*.part" >/dev/null && break
    sleep 0.1
done
refused 'repair of' repair live.raymap
kill -9 $writer
rm -rf live.raymap
echo "a live map is read and left alone"
