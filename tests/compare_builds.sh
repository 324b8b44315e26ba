#!/bin/bash
# SPDX-License-Identifier: MIT
#
#   tests/compare_builds.sh OLD NEW      runs two programs (or builds' folders) over the examples, shows what differs
#   tests/compare_builds.sh --write NEW  what NEW answers is the golden answer from now on (tests/golden)
#   tests/compare_builds.sh --check NEW  does it answer that?
#   tests/compare_builds.sh --check NEW SCENE...  of the other example scenes only what `check` and `info` answer
#
# What may differ is taken out: times, sizes in bytes, versions. Exit 0: all the same; 1: not. A new command is a line
# in `outputs`.
set -u -o pipefail
source=$(cd "$(dirname "$0")/.." && pwd)
golden=$source/tests/golden
work=$(mktemp -d "${TMPDIR:-/tmp}/raymap-compare.XXXXXX")
trap 'rm -rf "$work"' EXIT
. "$source/jobs/mpi-environment.sh"

program_of() { # A build's folder, or a program.
    local name=$1
    [ ! -d "$name" ] || name=$name/raymap
    [ -x "$name" ] || { echo "compare_builds: there is no program $name" >&2; exit 2; }
    realpath "$name"
}

# Without what may differ, as what each rank traced; of JSON numbers 9 digits, with one key a line. On a loaded machine
# `check` may be cut before its last rays.
normalise() { # FOLDER
    /usr/bin/python3 - "$1" "$source" <<'END'
import json, pathlib, re, sys
LEFT_OUT = re.compile("bytes|seconds|per_second|^versions$|^threads$|^shards$|^portions$|^of_pieces$")
CUT = "probing was cut after"
def plain(value):
    if isinstance(value, dict):
        if value.get("cut") is True:
            value = {**value, "rays": value["wanted"], "cut": False}
        return {k: plain(v) for k, v in value.items()
                if not LEFT_OUT.search(k) and not (k == "share" and "map_bytes" in value)}
    if isinstance(value, list):
        return [plain(v) for v in value if not (isinstance(v, dict) and str(v.get("text")).startswith(CUT))]
    return float("%.9g" % value) if isinstance(value, float) else value
for path in pathlib.Path(sys.argv[1]).iterdir():
    text, status = path.read_text(encoding="utf-8"), ""
    last = text.splitlines(keepends=True)[-1:]
    if last and last[0].startswith(path.name + ": "):
        text, status = text[:-len(last[0])], last[0]
    if path.suffix == ".json":
        documents = text.splitlines() if path.name.startswith("session") else [text]
        text = "".join(json.dumps(plain(json.loads(one)), indent=1) + "\n" for one in documents if one.strip())
    else:
        text = re.sub(r"raymap [0-9]+\.[0-9]+\.[0-9]+[^<\"\n]*", "raymap VERSION", text)
        text = re.sub(r"[0-9.]+ bytes per segment", "BYTES", text)
    path.write_text(text.replace(sys.argv[2], "SOURCE") + status, encoding="utf-8")
END
}

put() { # NAME COMMAND [ARGUMENTS]: what the program prints
    local name=$1
    shift
    "$program" "$@" 2>/dev/null >"$out/$name" || echo "$name: status $?" >>"$out/$name"
}

file() { # NAME COMMAND [ARGUMENTS]: the file that it writes
    local name=$1
    shift
    "$program" "$@" -o "$out/$name" --force --quiet >/dev/null 2>&1
    [ -e "$out/$name" ] || echo "$name: no such file" >>"$out/$name"
}

scene_outputs() { # EXAMPLE [DETECTOR]
    local scene=$source/examples/$1/scene.yaml map=$1.raymap
    "$program" trace "$scene" -o "$map" -n 3000 --force --quiet >/dev/null
    put "$1-check.json" check "$scene" --json --quiet
    put "$1-info.json" info "$map" --json
    [ ${#whole[@]} -eq 0 ] || [[ " ${whole[*]} " = *" $1 "* ]] || return 0
    put "$1-verify.json" verify "$map" --json
    put "$1-rays.json" report "$scene" --rays 0..2 --json
    put "$1-query.json" query "$map" all 'bounces > 2' 'ended(left)' 'hit(*, absorb)' --json
    put "$1-list.json" query "$map" 'bounces > 1' --limit 3 --json
    put "$1-energy.json" report "$map" --energy --json
    put "$1-paths.json" paths "$map" --json
    put "$1-stats.json" stats "$map" --of path_length --of bounces --json
    file "$1-draw.svg" draw "$map" --limit 20
    [ "${2-}" ] || return
    put "$1-registered.json" query "$map" "registered($2)" "registered($2 where ghost_order >= 1)" --json
    put "$1-explain.json" query "$map" "registered($2)" --explain --json
    put "$1-orders.json" paths "$map" --detector "$2" --matrix all --json
    put "$1-detector.json" detector "$map" "$2" --json
    put "$1-values.json" stats "$map" --of "angle($2)" --json
    file "$1-image.csv" detector "$map" "$2" --cells 4x3
    file "$1-image.svg" detector "$map" "$2"
}

outputs() { # PROGRAM FOLDER
    local command encoding
    program=$1
    out=$2
    mkdir -p "$out" "$work/run"
    cd "$work/run" || exit 2
    rm -rf ./*
    put help.txt --help
    for command in check trace info query report detector stats compare paths ghosts draw render verify repair convert merge index session glass import update voxels irradiance glare events sweep bench; do
        put "help-$command.txt" $command --help
    done
    put glass.json glass 'N-*' 'crystal *' --json
    put glass-near.txt glass --near 1.5168,64.2
    cp "$source/tests/data/lenses/rayoptics_HoO-V2C18Ex46.zmx" tilted.zmx
    put import.json import tilted.zmx -o lens --force --json
    cp lens/scene.yaml "$out/import.yaml"
    file glass.svg glass N-LAK8 'metal A?'
    scene_outputs double-gauss sensor
    scene_outputs gradient-sphere
    scene_outputs luneburg focus
    scene_outputs mirage
    scene_outputs newton sensor
    scene_outputs room floor_map
    scene_outputs selfoc image
    scene_outputs telescope disturbed
    scene_outputs wls-fibre near
    scene_outputs light-guide front
    for encoding in plain compact; do
        mpirun -np 2 "$program" trace "$source/examples/double-gauss/scene.yaml" -o "two.raymap" -n 5000 --encoding $encoding \
            --force --quiet >/dev/null
        put "$encoding-info.json" info "two.raymap" --json
        put "$encoding-query.json" query "two.raymap" 'hit(lens, reflect_specular) >= 2' 'path(".* V@sensor .*")' --json
        # What counts pieces is asked of a map that one rank made: of two, one may have taken all blocks.
        "$program" trace "$source/examples/double-gauss/scene.yaml" -o "$encoding.raymap" -n 5000 --encoding $encoding --force --quiet >/dev/null
        put "$encoding-convert.json" convert "$encoding.raymap" -o again.raymap --encoding plain --force --json
        put "$encoding-index.json" index "$encoding.raymap" --large --json
    done
    "$program" trace "$source/examples/double-gauss/scene.yaml" -o more.raymap -n 5000 --first-ray 5000 --force --quiet >/dev/null
    put merge.json merge plain.raymap more.raymap -o both.raymap --force --json
    put compare.json compare plain.raymap more.raymap --json
    put spot.json detector plain.raymap sensor --where 'source(star)' --mtf --json
    put stats-two.json stats plain.raymap --of 'x(sensor)' --of 'y(sensor)' --by source --json
    put ghost-list.json ghosts plain.raymap sensor --top 3 --json
    put ghosts.json paths plain.raymap --detector sensor --top 5 --json
    file page.html report plain.raymap --html
    file picked.csv query plain.raymap 'registered(sensor where ghost_order == 2)'
    file receivers.svg detector plain.raymap sensor --which 'ghost_order >= 1'
    put session.json session plain.raymap <<<$'registered(sensor)\nlist 2 all'
    normalise "$out"
    cd / || exit 2
}

# Without the folder's: "NAME SUM". Ties of triangles are decided by the instruction set.
sums() {
    (cd "$1" && sha256sum -- * | awk '{print $2, substr($1, 1, 16)}')
}

whole=()
case ${1-} in
--write | --check)
    new=$(program_of "${2:?usage: compare_builds.sh --check NEW}")
    whole=("${@:3}")
    outputs "$new" "$work/new"
    if [ "$1" = --write ]; then
        mkdir -p "$golden"
        rm -f "$golden"/*
        sums "$work/new" >"$golden/sums.txt"
        cp "$work/new"/help*.txt "$work/new"/double-gauss-{query,info,detector,paths,rays}.json "$golden"
        echo "$(wc -l <"$golden/sums.txt") answers written"
        exit 0
    fi
    mkdir "$work/old"
    cp "$golden"/*.txt "$golden"/*.json "$work/old" && rm "$work/old/sums.txt"
    sums "$work/new" >"$work/sums.txt"
    differ=$(awk 'NR == FNR {asked[$1]; next} !some || $1 in asked' "$work/sums.txt" some=${#whole[@]} "$golden/sums.txt" |
        diff - "$work/sums.txt" | sed -n 's/^[<>] \([^ ]*\) .*/\1/p' | sort -u)
    for name in $differ; do
        echo "differs from the golden answer: $name"
        [ ! -f "$work/old/$name" ] || diff -u "$work/old/$name" "$work/new/$name" | head -40
    done
    ;;
*)
    old=$(program_of "${1:?usage: compare_builds.sh OLD NEW}")
    new=$(program_of "${2:?usage: compare_builds.sh OLD NEW}")
    outputs "$old" "$work/old"
    outputs "$new" "$work/new"
    diff -ru "$work/old" "$work/new"
    differ=$(diff -rq "$work/old" "$work/new")
    ;;
esac
n=$(find "$work/new" -type f | wc -l)
if [ -n "$differ" ]; then
    echo "$(wc -l <<<"$differ") of $n answers differ"
    exit 1
fi
echo "$n answers, all the same"
