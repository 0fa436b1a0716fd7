"""The live stream in Foxglove, received by a client that knows only Foxglove's protocol of WebSockets."""

from __future__ import annotations

import base64
import json
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import underbrush as ub

client = pytest.importorskip("websockets.sync.client")
pytest.importorskip("foxglove")


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory, trials: ub.Trials) -> Path:
    path = tmp_path_factory.mktemp("live") / "model.json"
    ub.fit(trials, states=2).save(path)
    return path


@contextmanager
def running(model: Path) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """The command, and the port that it opened."""
    command = [sys.executable, "-P", "-m", "underbrush", "classify", str(model), "-", "--foxglove", "0"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1
    ) as process:
        assert process.stderr is not None
        yield process, int(process.stderr.readline().rsplit(":", 1)[1])
        process.communicate()
        assert process.returncode == 0


def messages(socket: Any, topics: dict[int, str]) -> dict[str, Any]:
    """The message of each topic that has come, by topic."""
    found: dict[str, Any] = {}
    while True:
        try:
            data = socket.recv(timeout=0.2)
        except TimeoutError:
            return found
        if isinstance(data, bytes):
            # A message: 1, the subscription, and the time, then the message.
            kind, subscription, _ = struct.unpack_from("<BIQ", data)
            if kind == 1:
                found[topics[subscription]] = json.loads(data[13:])


def test_frames_and_verdicts_come_in_foxglove(model: Path) -> None:
    """Tests that a viewer gets each answer as it is printed, and the forces and the pose of the frame."""
    with running(model) as (process, port), client.connect(
        f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1", "foxglove.websocket.v1"]
    ) as socket:
        assert process.stdin is not None and process.stdout is not None
        channels: dict[str, int] = {}
        while len(channels) < 5:
            message = json.loads(socket.recv(timeout=10))
            channels |= {own["topic"]: own["id"] for own in message.get("channels", [])}
        assert set(channels) == {"/verdicts", "/tf", "/skin/forearm", "/skin/forearm/pressed", "/skin/flipper/pressed"}
        topics = dict(enumerate(channels))
        subscriptions = [{"id": number, "channelId": channels[topic]} for number, topic in topics.items()]
        socket.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))
        found: dict[str, Any] = {}
        for number in range(50):
            pose = {"forearm": {"position": [0.1, 0.2, 0.3], "orientation": [0, 0, 0, 1]}}
            taxels = [{"patch": "forearm", "taxel": 18, "sensed_force_n": 0.25 + 0.01 * number}]
            frame = {"time_s": 0.01 * (number + 1), "taxels": taxels, "patch_pose_world": pose}
            process.stdin.write(json.dumps(frame) + "\n")
            answer = json.loads(process.stdout.readline())
            found = messages(socket, topics)
            if set(found) == set(channels):
                break
        assert found["/verdicts"] == answer and answer["taxels"][0]["taxel"] == 18
        points = struct.unpack("<4d", base64.b64decode(found["/skin/forearm/pressed"]["data"]))
        taxel = ub.Arm.cody().skin.layout["patches"][0]["taxels"][18]
        assert list(points) == [*taxel["position_link"], taxels[0]["sensed_force_n"]]
        grid = base64.b64decode(found["/skin/forearm"]["data"])
        assert struct.unpack_from("<d", grid, 8 * 18) == (taxels[0]["sensed_force_n"],)
        link = [own for own in found["/tf"]["transforms"] if own["child_frame_id"] == "forearm"]
        assert [own["translation"] for own in link] == [{"x": 0.1, "y": 0.2, "z": 0.3}]


def test_bad_lines_and_resets_are_answered_as_without_foxglove(model: Path) -> None:
    """Tests that the output is byte for byte that of the command without a viewer, whatever the bytes of a line and its poses are."""
    lines = b'\xef\xbb\xbf{"time_s":0.01,"taxels":[]}\n\n\f\n\v\n\xff\nnothing\n{"reset":true}\n'
    lines += b'{"time_s":0.01,"taxels":[{"taxel":9999,"sensed_force_n":1}]}\n{"time_s":0.02,"taxels":[],"patch_pose_world":5}\n'
    lines += b'{"time_s":0.03,"taxels":[],"patch_pose_world":{"forearm":{},"flipper":null,"hat":{}}}\n'
    command = [sys.executable, "-P", "-m", "underbrush", "classify", str(model), "-"]
    alone = subprocess.run(command, input=lines, capture_output=True, check=True)
    beside = subprocess.run([*command, "--foxglove", "0"], input=lines, capture_output=True, check=True)
    assert beside.stdout == alone.stdout and alone.stdout.count(b"\n") == 8


def test_the_skin_may_be_that_of_a_data_set(model: Path, data: ub.Dataset) -> None:
    """Tests that a data set can be given with ``--skin``, as without a viewer."""
    command = [sys.executable, "-P", "-m", "underbrush", "classify", str(model), "-", "--foxglove", "0", "--skin", str(data.path)]
    found = subprocess.run(command, input='{"time_s":0.01,"taxels":[]}\n', capture_output=True, text=True, check=True)
    assert found.stdout == '{"time_s":0.01,"taxels":[]}\n'


def test_files_and_wrong_ports_are_refused(model: Path, data: ub.Dataset) -> None:
    """Tests that a data set in place of ``-``, whose verdicts would not be shown, and a port that cannot exist are errors."""
    for given, part in ((str(data.path), "0"), "standard input"), (("-", "65536"), "0 to 65535"):
        command = [sys.executable, "-P", "-m", "underbrush", "classify", str(model), given[0], "--foxglove", given[1]]
        found = subprocess.run(command, input="", capture_output=True, text=True, check=False)
        assert found.returncode == 2 and part in found.stderr and "Traceback" not in found.stderr, found.stderr


def test_a_model_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    """Tests the exit status and the message."""
    command = [sys.executable, "-P", "-m", "underbrush", "classify", str(tmp_path / "no.json"), "-", "--foxglove", "0"]
    found = subprocess.run(command, input='{"time_s":0.01,"taxels":[]}\n', capture_output=True, text=True, check=False)
    assert found.returncode == 2 and "no.json" in found.stderr
