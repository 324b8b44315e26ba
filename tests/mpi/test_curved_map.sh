#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The promise: maps with curved legs are maps in every respect. Any number of ranks and either encoding
# give the same rays; kills, appending, converting, merging, picking and repairing lose no point of a
# curve; reports and exports tell it, and readers without our code find it.
. "$(dirname "$0")/../cli/expect.bash"
. "$(dirname "$0")/../faults/commits.bash"
command -v mpirun >/dev/null || { echo "no mpirun here"; exit 77; }
export OMPI_MCA_orte_abort_timeout=1 OMPI_MCA_odls_base_sigkill_timeout=0
python=/usr/bin/python3
rm -rf ./*
rays=30000
sed "/name: panel/d" "$(dirname "$0")/../data/curved-segments.yaml" >scene.yaml

facts() { # MAP
    "$RAYMAP" info "$1" --json | "$python" -c '
import json, sys
info = json.load(sys.stdin)
print(*(info[key] for key in ("digest", "rays", "segments", "registrations", "curve_points", "complete")))
print(json.dumps(info["sources"], sort_keys=True))'
}
same() { # MAP WHAT
    facts "$1" >got.txt
    cmp -s want.txt got.txt || { echo "FAILED: another map after $2"; diff want.txt got.txt; failures=$((failures + 1)); }
    expect 0 ' 0 findings' "$RAYMAP" verify "$1"
}

expect 0 '' "$RAYMAP" trace scene.yaml -o want.raymap -n $rays --threads 1 --encoding plain --quiet
facts want.raymap >want.txt
read -r _ _ legs _ points _ <want.txt
[ "$points" -gt $rays ] || { echo "FAILED: $points points of $legs legs"; failures=$((failures + 1)); }

# Ranks, threads, encodings.
for ranks in 2 ${SLOW:+3 4}; do
    encoding=$([ $ranks -eq 3 ] && echo plain || echo compact)
    expect 0 '' mpirun -np $ranks "$RAYMAP" trace scene.yaml -o np.raymap -n $rays --encoding $encoding --quiet --force
    same np.raymap "$ranks ranks"
done

# A rank dies at a commit; the run is resumed by another number of ranks.
for encoding in plain ${SLOW:+compact}; do
    map=kill-$encoding.raymap
    set_at_commit 2 kill
    timeout 120 "${at_commit[@]}" "$RAYMAP" trace scene.yaml -o $map -n $rays --encoding $encoding --quiet --threads 1 \
        --flush-portions 1 >/dev/null 2>&1
    held=$(facts $map | sed -n 1p)
    read -r _ n _ _ held complete <<<"$held"
    [ "$complete" = False ] && [ "$n" -gt 0 ] && [ "$held" -gt 0 ] || { echo "FAILED: killed: $n rays, $held points"; failures=$((failures + 1)); }
    expect 0 'rays' "$RAYMAP" query $map 'event(gradient)'
    expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o $map --resume --quiet
    same $map "a kill, $encoding"
done

# Appended, converted there and back, merged of parts.
expect 0 '' "$RAYMAP" trace scene.yaml -o grown.raymap -n 10000 --encoding plain --quiet
expect 0 '' mpirun -np 2 "$RAYMAP" trace scene.yaml -o grown.raymap --append -n $((rays - 10000)) --encoding compact --quiet
same grown.raymap appending
expect 0 '' "$RAYMAP" convert grown.raymap -o small.raymap --encoding compact
same small.raymap converting
expect 0 '' "$RAYMAP" convert small.raymap -o plain.raymap --encoding plain
same plain.raymap 'converting back'
expect 0 '' "$RAYMAP" trace scene.yaml -o late.raymap --first-ray 8192 -n $((rays - 8192)) --encoding plain --quiet
expect 0 '' "$RAYMAP" trace scene.yaml -o early.raymap -n 8192 --encoding compact --quiet
expect 0 '' "$RAYMAP" merge early.raymap late.raymap -o merged.raymap
same merged.raymap merging

# What a question picks, and the rest, are all of it.
expect 0 '' "$RAYMAP" query want.raymap 'event(gradient) >= 2' -o some.raymap --encoding compact
expect 0 '' "$RAYMAP" query want.raymap 'not event(gradient) >= 2' -o rest.raymap
expect 0 ' 0 findings' "$RAYMAP" verify some.raymap
expect 0 '' "$RAYMAP" merge some.raymap rest.raymap -o both.raymap
facts both.raymap >got.txt
[ "$(cut -d' ' -f1-5 <want.txt | head -1)" = "$(cut -d' ' -f1-5 <got.txt | head -1)" ] || { echo "FAILED: picked rays"; failures=$((failures + 1)); }

# Bytes of /curve are damaged: it is told, repaired, and traced again.
for map in plain small; do
    "$python" - $map.raymap <<'DAMAGE'
import glob, os, sys
import h5py
piece = sorted(glob.glob(sys.argv[1] + "/shard-*/piece-*.h5"))[0]
with h5py.File(piece) as file:
    at = file["curve/position"].id.get_chunk_info(0)
with open(piece, "r+b") as file:
    file.seek(at.byte_offset + at.size // 2)
    byte = file.read(1)[0]
    file.seek(-1, os.SEEK_CUR)
    file.write(bytes([byte ^ 16]))
DAMAGE
    expect 4 '/curve/position' "$RAYMAP" verify $map.raymap
    expect 0 '' "$RAYMAP" repair $map.raymap
    expect 0 '' "$RAYMAP" trace scene.yaml -o $map.raymap --resume --quiet
    same $map.raymap "repairing $map"
done

# Indexed: answered without columns.
expect 0 '' "$RAYMAP" index want.raymap
"$RAYMAP" query want.raymap 'event(gradient)' --count --json --quiet >with.json
"$RAYMAP" query np.raymap 'event(gradient)' --count --json --quiet >without.json
"$python" - <<'COUNTS' || failures=$((failures + 1))
import json
a, b = (json.load(open(name)) for name in ("with.json", "without.json"))
a, b = (x[0] if isinstance(x, list) else x for x in (a, b))
assert a["rays"] == b["rays"] and a["rays"]["matched"] > 0, (a["rays"], b["rays"])
COUNTS

# Told by report and exports, traced again, and read without our code.
PYTHONDONTWRITEBYTECODE=1 "$python" - <<'READ' || failures=$((failures + 1))
import csv, json, os, subprocess, sys
import h5py, numpy as np
sys.path.insert(0, os.path.join(os.environ["SOURCE_DIR"], "examples", "python"))
import raymap_reader

def run(*arguments):
    return subprocess.run([os.environ["RAYMAP"], *arguments, "--quiet"], check=True, text=True,
                          stdout=subprocess.PIPE).stdout

plain, compact = raymap_reader.Map("want.raymap"), raymap_reader.Map("np.raymap")
a, b = plain.columns(), compact.columns()
assert set(a) == set(b) and "curve/position" in a
order = np.argsort(a["ray/id"], kind="stable")
assert np.array_equal(a["ray/id"][order], np.sort(b["ray/id"]))
for name in ("curve/ray", "curve/segment", "curve/position", "segment/event"):
    assert np.array_equal(a[name], b[name]), name   # portions stand in the order of first rays
assert len(a["curve/ray"]) == plain.n_curve_points > 0

with h5py.File("want.raymap/map.h5") as f:          # h5py alone
    assert list(f.attrs["version"]) == [5, 0] and b"curves" in f.attrs["features"].split() and f["curve/position"].shape == (plain.n_curve_points, 3)
    rows = f["curve/ray"][:] == 7
    view = f["curve/position"][:][rows]
    assert f["portion/n_row"].shape[1] == 4 and f["portion/n_row"][:, 3].sum() == plain.n_curve_points

told = json.loads(run("report", "want.raymap", "7", "--json"))
traced = json.loads(run("report", "scene.yaml", "--ray", "7", "--json"))
points = [p for step in told["steps"] for p in step.get("curve", [])]
assert np.array_equal(np.array(points, np.float32).reshape(-1, 3), view) and len(points) > 2
for step, again in zip(told["steps"], traced["steps"]):
    assert ("gradient" in step["events"]) == ("curve" in step) == ("curve" in again)
    if "curve" in step:
        assert np.array_equal(np.float32(step["curve"]), np.float32(again["curve"]))
        assert abs(step["length"] - again["length"]) < 2e-3 * again["length"]
        assert np.dot(step["direction"], again["direction"]) > 0.98
ray = plain.ray(7)
curved = [k for k, step in enumerate(told["steps"]) if step.get("curve")]
assert np.array_equal(ray.line(curved[0])[1:-1], np.float32(told["steps"][curved[0]]["curve"]))

run("query", "np.raymap", "ray == 7", "-o", "seven.csv")
rows = list(csv.DictReader(open("seven.csv")))
text = [p for row in rows for p in row["curve"].split(";") if p]
assert np.array_equal(np.float32([p.split() for p in text]), view)
READ
expect 0 '' "$RAYMAP" draw np.raymap -o rays.svg --limit 20
[ "$(wc -c <rays.svg)" -gt 10000 ] || { echo "FAILED: the drawing has no curves"; failures=$((failures + 1)); }

# Scenes without gradient media make maps of the format they always made.
sed -i 's/fish: .*/fish: {index: 1.5}/' scene.yaml
expect 0 '' "$RAYMAP" trace scene.yaml -o straight.raymap -n 5000 --quiet
"$python" -c '
import h5py
f = h5py.File("straight.raymap/map.h5")
assert list(f.attrs["version"]) == [5, 0] and b"curves" not in f.attrs["features"].split() and "curve" not in f and "curve_points" not in f.attrs' || failures=$((failures + 1))
echo "$failures failures"
exit "$((failures > 0))"
