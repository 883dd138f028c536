#!/bin/sh
# Runs all tests of a build folder: the fast ones side by side, then the slow ones one by one (they use all threads).
set -eu
build=$1
root=$(cd "$(dirname "$0")/.." && pwd)
: "${MYRIALUX_SCENES:=$root/../shared/scenes}"
export MYRIALUX_SCENES
export MYRIALUX_PYTHON="$root/.venv/bin/python"
[ -d "$MYRIALUX_SCENES" ] || echo "shared scenes not found (MYRIALUX_SCENES=$MYRIALUX_SCENES): tests that need them skip"
ctest --test-dir "$build" --output-on-failure -j "$(nproc)" -L fast
ctest --test-dir "$build" --output-on-failure -L slow
