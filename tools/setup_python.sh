#!/bin/sh
# Makes .venv with the Python packages of the HTML pages (python/requirements.txt) and of the tests
# (tests/requirements.txt, which includes the former); again only if one of them changed.
set -eu
cd "$(dirname "$0")/.."
stamp=.venv/installed-requirements.txt
cat tests/requirements.txt python/requirements.txt | cmp -s - "$stamp" && exit 0
echo "installing the Python packages of tests/requirements.txt into .venv"
python3 -m venv .venv
.venv/bin/python -m pip install -q --disable-pip-version-check -r tests/requirements.txt
cat tests/requirements.txt python/requirements.txt >"$stamp"
