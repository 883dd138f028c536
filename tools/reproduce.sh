#!/bin/sh
# All methods on eight scenes against brute force, as in docs/reproduction.md: tools/reproduce.sh PROGRAM OUT.
# Six shared rooms (MYRIALUX_SCENES), a hair ball and a foliage scene (tools/make_scene.py); 640x360, one sample a pixel,
# 100 000 virtual lights. Some two hours on two cores; a run that was stopped goes on where it was. Ends with the page
# OUT/bench/index.html and the tables of the document.
set -eu
program=$(realpath "$1")
mkdir -p "$2"
out=$(realpath "$2")
cd "$(dirname "$0")/.."
shared=$(realpath "${MYRIALUX_SCENES:-../shared/scenes}")
for room in kitchen bathroom2; do
  [ -d "$out/$room" ] || tar xJf "$shared/$room.tar.xz" -C "$out"
done
for kind in hair-ball foliage; do
  [ -f "$out/$kind/scene.xml" ] || python3 tools/make_scene.py "$kind" "$out/$kind"
done
scenes=""
for name in living-room kitchen foliage veach-ajar staircase2 bathroom2 classroom hair-ball; do
  folder=$out/$name
  [ -d "$folder" ] || folder=$shared/$name
  scenes="$scenes $folder/scene.xml"
done
# Paths have no blanks here, so the lists may fall apart into words.
run() {
  scene=$1 methods=$2 budgets=$3
  shift 3
  "$program" bench $scene -o "$out/bench" --size 640x360 --spp 1 --vpls 100000 --clusters 1000 --repeats 1 \
    --methods "$methods" --budgets "$budgets" "$@"
}
for scene in $scenes; do
  run "$scene" slice-lightcuts,bamc,amc,gauss-jordan,matrix-separation 0.25,1 --no-page
  run "$scene" slice-lightcuts,bamc 4 --no-page
  run "$scene" lightcuts,illumination-cut,illumination-cut-sampling,lightslice,mdlc 1 --no-page
done
run "$scenes" slice-lightcuts 1
python3 tools/bench_table.py "$out/bench"
python3 tools/bench_table.py "$out/bench" --against bamc
