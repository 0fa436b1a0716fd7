"""Verdicts in `Foxglove <https://foxglove.dev>`_ while a robot touches things.

    my-robot | underbrush classify model.json - --foxglove 8765

Frames come in and verdicts go out as lines, as without ``--foxglove`` (``docs/live-stream.md``). Foxglove opens
``ws://localhost:8765`` and finds these topics:

* ``/verdicts``: the answers, as they are. Plots take numbers such as ``/verdicts.objects[0].stiffness.median_n_per_m``.
* ``/skin/PATCH`` (a grid) and ``/skin/PATCH/pressed`` (points on the link of the patch) with ``sensed_force_n``, as in MCAP files.
* ``/tf``: the poses of the links under the patches, if frames have them.

Needs Foxglove's library: ``pip install 'underbrush[foxglove]'``.
"""

from __future__ import annotations

import argparse
import io
import json
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from . import _core, _export, mcap
from ._errors import InputError, refused

# What the command takes for white space. A line of nothing else gets no answer.
_BLANK = " \t\n\f\r"


class Server:
    """Sends frames and verdicts to Foxglove over a WebSocket.

    Parameters
    ----------
    skin : Skin
        The skin that frames are of.
    port : int
        The port on this machine; 0 takes a free one.

    Raises
    ------
    InputError
        If there is no such port.
    OSError
        If the port is in use.
    """

    def __init__(self, skin: _core.Skin, port: int = 8765) -> None:
        try:
            import foxglove
        except ImportError as error:
            raise ImportError("underbrush.live needs foxglove-sdk: pip install 'underbrush[foxglove]'") from error
        if not 0 <= port <= 65535:
            raise refused("port", str(port), "0 to 65535", "choose such a port, or 0 for a free one")
        self._context = foxglove.Context()
        try:
            self._server = foxglove.start_server(name="underbrush", port=port, context=self._context)
        except RuntimeError as error:
            raise OSError(f"port {port}: {error}; choose another port, or 0 for a free one") from error
        self._patches: list[dict[str, Any]] = skin.layout["patches"]
        schemas = {topic: schema for patch in self._patches for topic, schema in mcap.skin_topics(patch)}
        schemas["/tf"] = "foxglove.FrameTransforms"
        self._channels = {"/verdicts": foxglove.Channel("/verdicts", message_encoding="json", context=self._context)}
        for topic, name in schemas.items():
            text = json.dumps(mcap.schema(name)).encode()
            schema = foxglove.Schema(name=name, encoding="jsonschema", data=text)
            channel = foxglove.Channel(topic, schema=schema, message_encoding="json", context=self._context)
            self._channels[topic] = channel

    @property
    def port(self) -> int:
        """The port."""
        port: int = self._server.port
        return port

    def send(self, frame: dict[str, Any], answer: dict[str, Any]) -> None:
        """Send a frame and its answer, as ``docs/live-stream.md`` describes them. Foxglove shows them at the present time."""
        now = time.time_ns()
        self._log("/verdicts", now, answer)
        if "error" in answer or "reset" in answer:
            return
        names = [patch["name"] for patch in self._patches]
        force_n = {name: np.zeros(len(patch["taxels"])) for name, patch in zip(names, self._patches)}
        for taxel in frame["taxels"]:
            patch = taxel.get("patch") or 0
            force_n[patch if isinstance(patch, str) else names[patch]][taxel["taxel"]] = taxel["sensed_force_n"]
        given = frame.get("patch_pose_world")
        poses = given if isinstance(given, dict) else dict(zip(names, given if isinstance(given, list) else []))
        # A grid has no place on the arm. Patches stand beside it, one above the other.
        moved = [mcap.transform(now, f"skin/{name}", [0.0, 1.0, 0.5 * place], [0.0, 0.0, 0.0, 1.0]) for place, name in enumerate(names)]
        for patch in self._patches:
            pose: Any = poses.get(patch["name"])
            try:
                moved.append(mcap.transform(now, patch["link"], pose["position"], pose["orientation"]))
            except (KeyError, TypeError, ValueError):
                # There is no pose. Models that do not use motion take frames with anything in its place.
                continue
        self._log("/tf", now, {"transforms": moved})
        for patch in self._patches:
            for topic, message in mcap.skin_messages(now, patch, force_n[patch["name"]]):
                self._log(topic, now, message)

    def _log(self, topic: str, now: int, message: dict[str, Any]) -> None:
        self._channels[topic].log(message, log_time=now)

    def close(self) -> None:
        """Stop the server."""
        self._server.stop()


def classify(arguments: list[str], frames: Iterable[str], out: TextIO, server: Server) -> int:
    """Answer frames as ``underbrush classify`` does with these arguments, and send both to the server.

    Parameters
    ----------
    arguments : list of str
        Those after ``classify``: the model, ``-`` and options.
    frames : iterable of str
        Lines.
    out : text file
        Where the answers go.

    Returns
    -------
    int
        The exit status of the command.
    """
    command = [sys.executable, "-P", "-m", "underbrush", "classify", *arguments]
    # Bytes that are not UTF-8 reach the command as they are, and it answers them.
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8", errors="surrogateescape", bufsize=1
    ) as child:
        assert child.stdin is not None and child.stdout is not None
        for line in frames:
            try:
                child.stdin.write(line.rstrip("\n") + "\n")
                child.stdin.flush()
            except BrokenPipeError:
                break
            if not line.strip(_BLANK):
                continue
            answer = child.stdout.readline()
            if not answer:
                break
            out.write(answer)
            out.flush()
            found = json.loads(answer)
            server.send({} if "error" in found or "reset" in found else json.loads(line), found)
        # The command prints what it answered, and ends.
        child.communicate()
    return child.returncode


def _skin(path: Path | None) -> _core.Skin:
    """The skin that ``--skin`` names."""
    if path is None:
        return _core.Arm.cody().skin
    if path.is_dir():
        return _core.Dataset(path).skin
    return _core.Reach.load(path).skin if path.suffix == ".parquet" else _core.Skin.load(path)


def main(arguments: list[str] | None = None) -> int:
    """The command ``underbrush classify MODEL - --foxglove PORT``."""
    usage = "underbrush classify MODEL - --foxglove PORT [OPTIONS]"
    parser = argparse.ArgumentParser(prog="underbrush classify", usage=usage, add_help=False, allow_abbrev=False)
    parser.add_argument("--foxglove", type=int, required=True)
    parser.add_argument("--skin", type=Path)
    parser.set_defaults(json=False)
    options, others = parser.parse_known_args(arguments)
    status = 0

    def run() -> None:
        nonlocal status
        if "-" not in others:
            raise InputError("--foxglove is for frames on standard input; give `-` in place of the input, or leave --foxglove out")
        chosen = ["--skin", str(options.skin)] if options.skin else []
        server = Server(_skin(options.skin), options.foxglove)
        # A byte order mark is no part of the first line.
        frames = io.TextIOWrapper(sys.stdin.buffer, encoding="utf-8-sig", errors="surrogateescape", newline="\n")
        print(f"Foxglove: ws://localhost:{server.port}", file=sys.stderr)
        try:
            status = classify([*others, *chosen], frames, sys.stdout, server)
        finally:
            server.close()

    return _export.status(run, options) or status
