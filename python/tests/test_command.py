"""The command ``underbrush`` that the package installs."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import underbrush

COMMAND = Path(sys.executable).with_name("underbrush")


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([COMMAND, *arguments], capture_output=True, text=True)


def test_the_command_is_that_of_the_package() -> None:
    """The installed command has the package's version, and so has the module."""
    of_module = subprocess.run(
        [sys.executable, "-P", "-m", "underbrush", "--version"], capture_output=True, text=True
    )
    # The command adds the hash of its sources.
    assert run("--version").stdout == of_module.stdout
    assert of_module.stdout.startswith(f"underbrush {underbrush.__version__}+")


def test_it_writes_the_bytes_of_the_package(tmp_path: Path) -> None:
    """A reach by the command is the file that the package saves, byte for byte."""
    files = [tmp_path / "command.parquet", tmp_path / "package.parquet"]
    assert run("reach", "trunk", "--seed", "4", "--out", str(files[0])).returncode == 0
    underbrush.reach("trunk", seed=4).save(files[1])
    assert files[0].read_bytes() == files[1].read_bytes()


def test_exit_status_and_json() -> None:
    """Bad input gives the status 2 and one JSON object, and good input 0."""
    good, bad = run("inspect", "mixed", "--json"), run("inspect", "nothing", "--json")
    assert (good.returncode, bad.returncode) == (0, 2)
    assert json.loads(good.stdout)["scene"] == "mixed"
    assert json.loads(bad.stdout)["error"]["file"] == "nothing"


@pytest.mark.skipif(os.name != "posix", reason="signals of a shell")
def test_it_ends_at_ctrl_c() -> None:
    """SIGINT ends the command as it ends any program of the shell."""
    program = subprocess.Popen(
        [COMMAND, "validate"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    time.sleep(1.0)
    program.send_signal(signal.SIGINT)
    assert program.wait(timeout=20) == -signal.SIGINT
