#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# What docs/scene.md shows is a scene, free of warnings; and some input that only a shell can make
# is refused in good time.
. "$(dirname "$0")/expect.bash"
rm -rf ./*

sed -n '/^```yaml/,/^```$/p' "$SOURCE_DIR/docs/scene.md" | grep -v '^```' >page.yaml
expect 0 '' "$RAYMAP" check page.yaml
"$RAYMAP" check page.yaml 2>&1 >/dev/null | grep . && { echo 'FAILED: the page is not clean'; failures=1; }

mkfifo pipe.yaml
expect 3 'is empty' timeout 20 "$RAYMAP" check pipe.yaml
expect 0 '' timeout 20 "$RAYMAP" check <(cat page.yaml; sleep 0.2; echo '# the end')
expect 3 'bytes: a scene file has 64 MiB at most' timeout 60 "$RAYMAP" check <(yes '# a' | head -c 68000000)
expect 3 'neither a regular file nor a pipe' timeout 20 "$RAYMAP" check /dev/zero
printf 'raymap: 1\n\377\376: 2\n' >bytes.yaml
expect 3 'bytes.yaml:2:1: error: this is not YAML' "$RAYMAP" check bytes.yaml
yes -- '- {a: 1}' | head -n 300000 >wide.yaml
expect 3 'must be a mapping' timeout 60 "$RAYMAP" check wide.yaml
{ printf 'raymap: 1\nmedia:\n'; seq -f '  m%.0f: {index: 1, x: 2}' 60000; } >many.yaml
expect 3 'and 59[0-9]* more' timeout 60 "$RAYMAP" check many.yaml
finish
