#!/bin/sh
# Renders the furnished room that comes with Myrialux: tools/demo.sh PROGRAM. Pictures and numbers go to out/.
set -eu
program=$(realpath "$1")
cd "$(dirname "$0")/.."
mkdir -p out
exec "$program" render scenes/living-room/scene.xml --method lbamc --size 1280x720 --spp 4 --vpls 100000 \
  -o out/living-room.exr -o out/living-room.png --stats out/living-room.stats.json
