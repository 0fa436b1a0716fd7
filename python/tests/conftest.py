"""A small data set that the tests share, and the command line to compare with."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import underbrush as ub

# Programs that a shell script runs in the background ignore Ctrl-C, and so would tests of it.
signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).parents[2]
# Goals at the far side, so that the forearm reaches through the plants.
QUICK = {"goals": {"count": 1, "retries": 0, "patience_s": 1.0, "x_m": {"uniform": [0.62, 0.72]}}}


def quick(name: str) -> ub.Scene:
    """A scene that ships, with one goal. A reach takes a few seconds of simulated time."""
    return ub.Scene(name).changed(QUICK, name=f"{name}-quick")


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> ub.Dataset:
    out = tmp_path_factory.mktemp("data") / "set"
    return ub.generate([quick("leaf"), quick("trunk")], 4, out, seed=1, progress=False)


@pytest.fixture(scope="session")
def trials(data: ub.Dataset) -> ub.Trials:
    return data.trials(labels="environment", min_samples=20)


@pytest.fixture(scope="session")
def command() -> Callable[..., Any]:
    """Runs the command line of the same build and returns what it prints as JSON."""
    default = ROOT / "target" / "release" / "underbrush"
    program = Path(os.environ.get("UNDERBRUSH", default))
    if not program.exists():
        pytest.skip(f"no command line at {program}")

    def run(*arguments: object) -> Any:
        words = [str(program), *map(str, arguments), "--json"]
        found = subprocess.run(words, capture_output=True, text=True, check=False)
        assert found.returncode == 0, found.stderr
        return json.loads(found.stdout)

    return run
