#!/bin/sh
# Installs what a fresh Debian 12 machine lacks: tools/setup.sh build [test] [check]. Does nothing when all is there.
# As root or through sudo; without either it prints the exact packages that are missing and stops.
# Without apt-get it lists them and goes on: what is truly absent, CMake names.
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
missing=""
for group in "$@"; do
  for package in $(sed -n "s/^$group //p" "$here/tools/packages.txt"); do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q "^install ok installed" || missing="$missing $package"
  done
done
[ -z "$missing" ] && exit 0
if ! command -v apt-get >/dev/null 2>&1; then
  echo "This is not Debian; what Myrialux needs there, under Debian's names:$missing" >&2
  exit 0
fi
if [ "$(id -u)" -eq 0 ]; then
  as_root=""
elif command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
  as_root="sudo"
elif command -v sudo >/dev/null 2>&1 && [ -t 0 ]; then
  as_root="sudo"
else
  echo "Packages are missing and this user may not install them. As root, run:" >&2
  echo "  apt-get install --no-install-recommends$missing" >&2
  exit 1
fi
echo "installing:$missing"
$as_root apt-get update -q >/dev/null
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing >/dev/null
