#!/usr/bin/env bash
# Builds the wheel of the Python package, installs it into a virtual environment of its own, and runs tests, type
# checks, examples and docs. Needs Python 3.11 or later. Reuses the engine that `cargo test --workspace` has built.
# Arguments are those of `maturin build`.
set -euo pipefail
cd "$(dirname "$0")"
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/../target}
venv=$CARGO_TARGET_DIR/python-venv
python=$venv/bin/python

if [ ! -x "$python" ]; then
    python3 -m venv "$venv"
fi
"$python" -m pip install --quiet 'maturin>=1.16,<2'
wheels=$(mktemp -d)
trap 'rm -rf "$wheels"' EXIT
# The lock file decides the version that data sets carry. pyproject.toml does not require it, because a source
# distribution has fewer crates than the lock file, and cargo must be free to drop the others from it.
"$venv/bin/maturin" build --release --locked --quiet --interpreter "$python" --out "$wheels" "$@"
"$python" -m pip install --quiet --force-reinstall --no-deps "$wheels"/*.whl
"$python" -m pip install --quiet "underbrush[test,docs] @ file://$(echo "$wheels"/*.whl)"

# The wheel is small, and works where nothing else is.
"$python" -P wheel.py "$wheels"/*.whl

# The installed package is tested, not the folder beside this file: separate programs and -P keep this folder out of the
# module path.
export UNDERBRUSH=${UNDERBRUSH:-$CARGO_TARGET_DIR/release/underbrush}
"$venv/bin/pytest" tests
# The stub and the native module have the same contents.
"$venv/bin/stubtest" underbrush._core
"$venv/bin/mypy" --strict examples
# The examples run as notebooks, whose cells and pictures are those that are stored. The policy takes minutes to learn.
policy=examples/policy.py
"$python" -P notebooks.py --check $(ls examples/*.py | grep -v "$policy")
"$python" -P notebooks.py --check --cells "$policy"
MPLBACKEND=agg "$python" "$policy" --quick > /dev/null
# The page of all calls matches the docstrings.
"$python" -P docs.py --check ../docs/python-api.md
# The documentation is a site without broken links, with pages of all commands and files. axe-core and Chromium are those of
# replay/ci.sh, which .ci/run runs before.
"$venv/bin/mkdocs" build --strict --config-file ../mkdocs.yml --site-dir "$wheels/site"
if [ -d ../replay/page/node_modules ] && [ -x "${CHROMIUM:-/usr/bin/chromium}" ]; then
    node ../docs/site/check.mjs "$wheels/site"
else
    echo "The site was not checked in Chromium: run replay/ci.sh before, which installs what that needs" >&2
fi
