#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `raymap bench --json` gives every documented measurement on both example scenes,
each as a ratio of two figures taken in turns. How large the ratios are, the performance page says:
a machine that others use as well cannot evaluator them."""
import json
import os
import subprocess

PROGRAM = os.environ["RAYMAP"]
NAMES = ["trace_vs_roofline", "record_vs_trace", "record_vs_seed", "bytes_per_segment",
         "durable_vs_not", "checksums_vs_trace", "durability_vs_trace", "resume_vs_anew",
         "decode_vs_seed", "verify_vs_decode", "query_vs_seed",
         "query_several_vs_slowest", "session_second_vs_first", "ranks_vs_threads",
         "stats_vs_query", "paths_vs_query", "energy_vs_query", "uniform_vs_gradient_code",
         "scatter_vs_roofline"]
# And those that have scenes of their own.
OTHERS = {("bytes_per_segment", "double-gauss-31"), ("tm25_write_vs_plain", "rays"),
          ("tm25_read_vs_plain", "rays"), ("timed_vs_plain", "scintillator"),
          ("move_vs_build", "instances"), ("moved_trace_vs_fresh", "instances"), ("cache_vs_none", "instances"),
          *(("gradient_evaluations_vs_seed", scene) for scene in ("luneburg", "parabolic-rod")),
          *((name, scene) for name in ("render_preview", "render_overhead")
            for scene in ("gradient-sphere", "gradient-noise"))}
FOLDS = ["stats_vs_query", "paths_vs_query", "energy_vs_query"]
BOTH_ENCODINGS = ["record_vs_trace", "record_vs_seed", "bytes_per_segment", "durable_vs_not",
                  "checksums_vs_trace", "durability_vs_trace", "decode_vs_seed",
                  "verify_vs_decode", "query_vs_seed", "query_several_vs_slowest",
                  "session_second_vs_first", *FOLDS]


def bench(*arguments):
    done = subprocess.run([PROGRAM, "bench", "--quick", "--json", *arguments], capture_output=True,
                          text=True, timeout=1500)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


document = bench("--repeats", "1")
assert document["machine"]["cores"] >= 1
found = {(result["name"], result["scene"]) for result in document["results"]}
wanted = {(name, scene) for name in NAMES for scene in ("room", "double-gauss")}
assert found == wanted | OTHERS, found ^ (wanted | OTHERS)
for name in BOTH_ENCODINGS:
    encodings = {result["encoding"] for result in document["results"] if result["name"] == name}
    assert encodings == {"plain", "compact"}, name
classes = set()
for result in document["results"]:
    assert result["value"] > 0 and result["reference"] > 0, result
    assert result["spread"][0] <= result["ratio"] <= result["spread"][1], result
    if result["name"] == "query_vs_seed":
        assert result["criterion"] and result["matched"] > 0, result
        classes.add((result["scene"], result["class"]))
assert classes == {(scene, word) for scene in ("room", "double-gauss")
                   for word in ("objects", "never", "numbers", "path")}, classes
for name in FOLDS:  # every class in both encodings against both queries, once
    rows = [(result["scene"], result["encoding"], result["against"], result["class"])
            for result in document["results"] if result["name"] == name]
    assert sorted(rows) == sorted(
        (scene, encoding, against, word) for scene in ("room", "double-gauss")
        for encoding in ("plain", "compact") for against in ("count", "columns")
        for word in ("objects", "never", "numbers", "path", "every ray")), (name, rows)

alone = bench("--repeats", "1", "--only", "trace_vs_roofline", "--scene", "room")
assert [result["name"] for result in alone["results"]] == ["trace_vs_roofline"]
wrong = subprocess.run([PROGRAM, "bench", "--only", "speed"], capture_output=True, text=True)
assert wrong.returncode == 2 and "trace_vs_roofline" in wrong.stderr, wrong.stderr
print("every measurement, on both scenes")
