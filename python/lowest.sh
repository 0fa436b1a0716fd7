#!/usr/bin/env bash
# Tests the Python package with the oldest versions of its direct dependencies that pyproject.toml allows, in a virtual
# environment of its own. Prints the versions.
#
#     python/lowest.sh [WHEEL]          # default: the wheel that .ci/package has built
#
# Some of these versions have no wheels for newer Pythons, so it needs Python 3.11: set PYTHON=/path/to/python3.11 if
# `python3` is another version.
set -euo pipefail
cd "$(dirname "$0")"
target=$(realpath -m "${CARGO_TARGET_DIR:-../target}")
wheel=$(realpath "${1:-$(echo "$target"/sdist/underbrush-*.whl)}")
venv=$(mktemp -d)
trap 'rm -rf "$venv"' EXIT
"${PYTHON:-python3}" -m venv "$venv"
python=$venv/bin/python
"$python" -m pip install --quiet 'uv>=0.5'
# The dependencies are read from pyproject.toml, because uv does not treat the requirements of a wheel as direct ones.
"$venv/bin/uv" pip install --quiet --python "$python" --resolution lowest-direct --requirements pyproject.toml --extra test
"$venv/bin/uv" pip install --quiet --python "$python" --no-deps "$wheel"
"$venv/bin/uv" pip list --python "$python" --format freeze | grep -v '^pip=\|^uv=\|^setuptools='
export UNDERBRUSH=${UNDERBRUSH:-$target/release/underbrush}
"$venv/bin/pytest" tests
