#!/bin/sh
# clang-tidy over the library and the program, all processors: tools/run_tidy.sh BUILD. Findings are errors (.clang-tidy).
set -eu
build=$(realpath "$1")
cd "$(dirname "$0")/.."
git ls-files 'src/*.cpp' 'apps/*.cpp' | xargs -P "$(nproc)" -n 2 clang-tidy -p "$build" --quiet \
  --extra-arg=-Wno-unknown-warning-option --warnings-as-errors='*'
