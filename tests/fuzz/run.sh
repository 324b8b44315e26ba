#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Runs every libFuzzer target of the preset `fuzz` for some seconds, from its seeds:
#   cmake --preset fuzz -G Ninja && cmake --build --preset fuzz && tests/fuzz/run.sh 60
# Corpora grow in build/fuzz/corpus/NAME; what broke a target lies beside them. Needs clang-14 and
# libclang-rt-14-dev.
set -euo pipefail
seconds=${1:-30}
build=$(cd "$(dirname "$0")/../.." && pwd)/build/fuzz
failures=0
for program in "$build"/tests/fuzz_*; do
    name=$(basename "$program")
    name=${name#fuzz_}
    corpus=$build/corpus/$name
    mkdir -p "$corpus" "$corpus.seeds"
    cd "$build/corpus"
    "$build/tests/test_${name}_target" --seeds "$corpus.seeds"
    echo "$name: $seconds s"
    if ! "$program" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3072 \
        -malloc_limit_mb=2048 -max_len=65536 -verbosity=0 -print_final_stats=1 \
        -artifact_prefix="$corpus-" "$corpus" "$corpus.seeds" 2>"$corpus.log"; then
        tail -n 30 "$corpus.log"
        failures=$((failures + 1))
    fi
    grep -E 'number_of_executed|average_exec' "$corpus.log" || true
done
exit "$((failures > 0))"
