#!/bin/sh
# Makes .venv with the Python packages that tests compare against (tests/requirements.txt); again only if that changed.
set -eu
cd "$(dirname "$0")/.."
stamp=.venv/installed-requirements.txt
cmp -s tests/requirements.txt "$stamp" && exit 0
echo "installing the Python packages of tests/requirements.txt into .venv"
python3 -m venv .venv
.venv/bin/python -m pip install -q --disable-pip-version-check -r tests/requirements.txt
cp tests/requirements.txt "$stamp"
