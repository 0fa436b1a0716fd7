"""The command ``underbrush`` that the package installs."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import underbrush
import underbrush.__main__
import underbrush.mcap

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


def test_warnings_are_those_of_the_program(trials: underbrush.Trials, tmp_path: Path) -> None:
    """Tests that the command prints warnings as lines in the words of the command line, and that calls give them in Python's."""
    table, model = str(tmp_path / "trials.csv"), str(tmp_path / "model.json")
    trials.save(table)
    assert run("train", table, "--classifier", "naive-bayes", "--out", model).returncode == 0
    expected = "the model was fitted to these data, so its accuracy on them is too high; evaluate it on other data"
    assert f"warning: {table}: {expected}" in run("evaluate", table, "--model", model).stderr.splitlines()
    with pytest.warns(UserWarning, match='^allow a higher false_positive_rate, or use classify with decision="argmax"$'):
        underbrush._errors.warn("warning: allow a higher --false-positive-rate, or use classify --decision argmax")


def test_exit_status_and_json() -> None:
    """Bad input gives the status 2 and one JSON object, and good input 0."""
    good, bad = run("inspect", "mixed", "--json"), run("inspect", "nothing", "--json")
    assert (good.returncode, bad.returncode) == (0, 2)
    assert json.loads(good.stdout)["scene"] == "mixed"
    assert json.loads(bad.stdout)["error"]["file"] == "nothing"


def test_bad_usage_is_that_of_the_given_arguments() -> None:
    """Tests that --json is looked for among the arguments of the call, and not among those of the process."""
    code = "from underbrush._core import run_command_line as run; run(['underbrush', 'inspect', '--nope', '--json'])"
    found = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True)
    assert json.loads(found.stdout)["error"]["kind"] == "usage"
    assert "--nope" in found.stderr


def test_it_writes_what_only_the_package_can(data: underbrush.Dataset, tmp_path: Path) -> None:
    """Tests that exports and films are those of the modules, with the options of the command line and its remedies."""
    out = [tmp_path / name for name in ("command.mcap", "module.mcap", "bag", "set.hdf5", "film.mp4", "film.webp")]
    data[1].save(tmp_path / "reach.parquet")
    reach = str(tmp_path / "reach.parquet")
    for kind, path in (("mcap", out[0]), ("ros2", out[2]), ("hdf5", out[3])):
        assert run("export", reach, "--to", kind, "--out", str(path)).stdout == f"1 reach in {path}\n"
        refused = run("export", "--to", kind, reach, "--out", str(path))
        assert refused.returncode == 2 and "--force" in refused.stderr
        # An export takes whole sets.
        unknown = run("export", reach, "--to", kind, "--out", str(path), "--force", "--reaches", "0")
        assert unknown.returncode == 2 and "--reaches" in unknown.stderr
        assert run("export", reach, f"--to={kind}", "--out", str(path), "--force").returncode == 0
    underbrush.mcap.export(data[1], out[1])
    assert out[0].read_bytes() == out[1].read_bytes()
    options = ["--reaches", "1", "--size", "128x96", "--fps", "10", "--speed", "4"]
    for path in out[4:]:
        filmed = run("replay", str(data.path), "--video", str(path), *options)
        assert filmed.stdout == f"{(len(data[1]) - 1) // 40 + 1} pictures in {path}\n", filmed.stderr
    assert all(path.exists() for path in out)


def test_the_rest_is_left_to_the_command_line(tmp_path: Path) -> None:
    """Tests the errors of the command line for other formats, options without a value, and numbers of threads."""
    assert "possible values" in run("export", "reach.parquet", "--to", "csv", "--out", "file").stderr
    assert "a value is required" in run("export", "reach.parquet", "--to").stderr
    assert ".gif" in run("replay", str(tmp_path), "--video", "film.avi").stderr
    assert "1 to 1024" in run("export", "reach.parquet", "--to", "ros2", "--out", "bag", "--jobs", "0").stderr


@pytest.mark.parametrize(
    "words",
    [
        "--jobs 1 export REACH --to mcap --out OUT --json",
        "--json export REACH --to hdf5 --out OUT --jobs 1",
        "export REACH --to=ros2 --json --out OUT",
        "replay REACH --video OUT.webp --json --fps 1 --size 64x64",
        "--json replay --jobs=1 --video=OUT.webp --fps 1 --size=64x64 -- REACH",
    ],
)
def test_options_stand_anywhere(data: underbrush.Dataset, tmp_path: Path, words: str) -> None:
    """Tests that exports and films take --json and --jobs before and after the command, and print the size of what they wrote."""
    data[0].save(tmp_path / "reach.parquet")
    places = {"REACH": str(tmp_path / "reach.parquet"), "OUT": str(tmp_path / "out")}
    arguments = [re.sub("REACH|OUT", lambda word: places[word[0]], one) for one in words.split()]
    found = run(*arguments)
    assert found.returncode == 0, found.stderr
    (tmp_path / "reach.parquet").unlink()
    printed = json.loads(found.stdout)
    assert Path(printed["file"]) in tmp_path.iterdir()
    assert printed["bytes"] == sum(path.stat().st_size for path in tmp_path.rglob("*") if path.is_file())


def test_errors_of_exports_are_json_too(tmp_path: Path) -> None:
    """Tests that an export with --json prints the keys of the command line's errors, and what it prints without."""
    export = ["export", str(tmp_path / "none.parquet"), "--to", "mcap", "--out", str(tmp_path / "out")]
    found, plain = run(*export, "--json"), run(*export)
    error = json.loads(found.stdout)["error"]
    assert found.returncode == plain.returncode == 2 and f"error: {error['message']}\n" == plain.stderr
    assert set(error) == set(json.loads(run("inspect", "nothing", "--json").stdout)["error"])


@pytest.mark.parametrize("reaches", [[], ["--reaches", "0,1"], ["--reaches", "8"]])
def test_a_film_is_of_one_reach(data: underbrush.Dataset, tmp_path: Path, reaches: list[str]) -> None:
    """Tests that films as MP4 are refused as those as GIF, which the command line writes, unless one of the reaches is chosen."""
    gif, mp4 = (run("replay", str(data.path), "--video", str(tmp_path / f"film.{kind}"), *reaches) for kind in ("gif", "mp4"))
    assert gif.returncode == mp4.returncode == 2
    assert mp4.stderr == gif.stderr and list(tmp_path.iterdir()) == []


def test_a_folder_of_recordings_stands_for_them(data: underbrush.Dataset, tmp_path: Path) -> None:
    """Tests that films as MP4 and as GIF, which the command line writes, are of a reach in a folder of recordings, that a reach
    that is not there is refused alike, and that exports hold all reaches of the folder."""
    folder = tmp_path / "felt"
    folder.mkdir()
    for index in (0, 1):
        data[index].save(folder / f"reach-{index}.parquet")
    options = ["--size", "128x96", "--fps", "10", "--speed", "4"]
    gif, mp4 = ([run("replay", str(folder), "--video", str(tmp_path / f"{number}.{kind}"), "--reaches", number, *options)
                 for number in ("1", "2")] for kind in ("gif", "mp4"))
    assert [found.returncode for found in gif] == [found.returncode for found in mp4] == [0, 2], mp4[0].stderr
    assert mp4[0].stdout == f"{(len(data[1]) - 1) // 40 + 1} pictures in {tmp_path / '1.mp4'}\n"
    assert mp4[1].stderr == gif[1].stderr
    for kind in ("mcap", "ros2", "hdf5"):
        exported = run("export", str(folder), "--to", kind, "--out", str(tmp_path / kind))
        assert exported.stdout == f"2 reaches in {tmp_path / kind}\n", exported.stderr
    underbrush.mcap.export([data[0], data[1]], tmp_path / "module")
    expected = [file.read_bytes() for file in sorted((tmp_path / "module").iterdir())]
    assert [file.read_bytes() for file in sorted((tmp_path / "mcap").iterdir())] == expected and len(expected) == 2


@pytest.mark.parametrize(("option", "value"), [("--reaches", "-1"), ("--reaches", "x"), ("--size", "160")])
def test_values_of_films_that_are_wrong_are_named(data: underbrush.Dataset, tmp_path: Path, option: str, value: str) -> None:
    """Tests that a wrong reach or size is an error with the option and the value that were given."""
    found = run("replay", str(data.path), "--video", str(tmp_path / "film.mp4"), option, value)
    assert found.returncode == 2 and option in found.stderr and repr(value) in found.stderr


def test_a_missing_extra_is_named(
    data: underbrush.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Tests that the error without rosbags, PyAV, mcap or h5py says what to install."""
    calls = {
        "rosbags": ["export", str(data.path), "--to", "ros2", "--out", str(tmp_path / "bag")],
        "mcap": ["export", str(data.path), "--to", "mcap", "--out", str(tmp_path / "log")],
        "h5py": ["export", str(data.path), "--to", "hdf5", "--out", str(tmp_path / "set.hdf5")],
        "av": ["replay", str(data.path), "--video", str(tmp_path / "film.mp4"), "--reaches", "0"],
    }
    extras = {"rosbags": "ros2", "mcap": "mcap", "h5py": "hdf5", "av": "video"}
    for package, arguments in calls.items():
        with monkeypatch.context() as patched:
            for name in [name for name in sys.modules if name.split(".")[0] == package] + [package]:
                patched.setitem(sys.modules, name, None)
            patched.setattr(sys, "argv", ["underbrush", *arguments])
            assert underbrush.__main__.main() == 2
        assert f"pip install 'underbrush[{extras[package]}]'" in capsys.readouterr().err


@pytest.mark.skipif(os.name != "posix", reason="signals of a shell")
def test_it_ends_at_ctrl_c() -> None:
    """SIGINT ends the command as it ends any program of the shell."""
    program = subprocess.Popen(
        [COMMAND, "validate"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    time.sleep(1.0)
    program.send_signal(signal.SIGINT)
    assert program.wait(timeout=20) == -signal.SIGINT


@pytest.mark.skipif(os.name != "posix", reason="signals of a shell")
@pytest.mark.parametrize("words", ["mcap export", "hdf5 export", "ros2 export", "video film --reaches 0", "video lerobot"])
def test_an_export_ends_at_ctrl_c(data: underbrush.Dataset, tmp_path: Path, words: str) -> None:
    """SIGINT while an export writes ends it as a program of the shell, without a traceback and without unfinished files."""
    module, command, *options = words.split()
    inputs = [str(data.path)] * (20 if command == "export" else 1)
    arguments = [f"underbrush.{module}", command, *inputs, "--out", str(tmp_path / "out.mp4"), *options]
    program = subprocess.Popen([sys.executable, "-P", "-m", *arguments], stderr=subprocess.PIPE, text=True)
    while not list(tmp_path.rglob(".*")):
        assert program.poll() is None
        time.sleep(0.01)
    program.send_signal(signal.SIGINT)
    assert (program.communicate(timeout=20)[1], program.returncode) == ("", -signal.SIGINT)
    assert list(tmp_path.rglob(".*")) == []
