#!/bin/sh
# clang-tidy over the library and the program, all processors; findings are errors (.clang-tidy).
set -eu
build=$1
git ls-files 'src/*.cpp' 'apps/*.cpp' | xargs -P "$(nproc)" -n 4 clang-tidy -p "$build" --quiet --extra-arg=-Wno-unknown-warning-option --warnings-as-errors='*'
