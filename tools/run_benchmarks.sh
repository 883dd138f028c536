#!/bin/sh
# Runs every benchmark program of a build folder; ratios inside one process count, absolute times depend on the machine.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
: "${MYRIALUX_SCENES:=$root/../shared/scenes}"
export MYRIALUX_SCENES
for program in "$1"/bench/*_bench; do
  echo "== $(basename "$program")"
  "$program" "--benchmark_min_time=0.5"
done
