"""Checks that sets get to S3-like storage and back, although connections are lost and several machines write at once.
Needs a program built with the feature ``cloud``, and ``pip install 'moto[s3,server]'``, a local S3 server. Not in CI.

    cargo build --release --features cloud
    python bucket.py [--underbrush ../../target/release/underbrush]

Makes a set in one process and in three parts. Each part is pushed by two processes at the same time, through a proxy
that cuts connections, and pulled again. The parts are merged. A push of the result is killed, and two processes then
push it again. After that the script pushes two different sets to one address at the same time, and damages objects. It
prints the hash of each set, and fails if one differs from the set of one process, or if anything that is not whole is
taken for a set.
"""

from __future__ import annotations

import argparse
import hashlib
import logging
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import boto3
from moto.server import DomainDispatcherApplication, create_backend_app
from werkzeug.serving import make_server

ROOT = Path(__file__).parents[2]
# A finger of two joints, whose reaches take milliseconds.
SCENE = ROOT / "fuzz/seeds/thicket.toml"
REACHES = 12
PARTS = 3
# The proxy cuts two of three connections, after one of these numbers of bytes from the client or from the server.
CUTS = [0, 300, 900, 5_000, 20_000]


class OneAtATime:
    """An application that answers one request after the other. Real storage checks in one step whether an object is
    there and puts it. moto does so only if requests come one by one."""

    def __init__(self, application: Any) -> None:
        self.application, self.lock = application, threading.Lock()

    def __call__(self, environment: Any, start: Any) -> Iterable[bytes]:
        with self.lock:
            return self.application(environment, start)


class Proxy:
    """Passes connections on to a server, and cuts some of them."""

    def __init__(self, port: int) -> None:
        self.to, self.connections, self.cut = port, 0, 0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self) -> None:
        while True:
            client, _ = self.listener.accept()
            server = socket.create_connection(("127.0.0.1", self.to))
            self.connections += 1
            left = None
            if self.connections % 3:
                left, self.cut = CUTS[self.connections % len(CUTS)], self.cut + 1
            # Half of these connections lose the request, and the others the answer, after the server has acted.
            sides = [(client, server), (server, client)]
            for number, (source, sink) in enumerate(sides):
                own = left if self.connections % 2 == number else None
                threading.Thread(target=self.forward, args=(source, sink, own), daemon=True).start()

    @staticmethod
    def forward(source: socket.socket, sink: socket.socket, left: int | None) -> None:
        try:
            while data := source.recv(16_384):
                sink.sendall(data[:left])
                if left is not None and len(data) >= left:
                    break
                left = None if left is None else left - len(data)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass


def hash_of(files: Iterable[tuple[str, bytes]]) -> str:
    total = hashlib.sha256()
    for name, data in sorted(files):
        total.update(name.encode() + b"\0" + data)
    return total.hexdigest()[:16]


def in_folder(folder: Path) -> Iterable[tuple[str, bytes]]:
    return ((str(path.relative_to(folder)), path.read_bytes()) for path in folder.rglob("*") if path.is_file())


def main() -> None:
    parser = argparse.ArgumentParser(description="Data sets in S3-like storage")
    parser.add_argument("--underbrush", default=ROOT / "target/release/underbrush")
    logging.getLogger("werkzeug").disabled = True
    underbrush = str(Path(parser.parse_args().underbrush).absolute())
    server = make_server("127.0.0.1", 0, OneAtATime(DomainDispatcherApplication(create_backend_app)), threaded=True)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    proxy = Proxy(server.port)
    keys = {"AWS_ACCESS_KEY_ID": "key", "AWS_SECRET_ACCESS_KEY": "secret", "AWS_REGION": "us-east-1", "AWS_ALLOW_HTTP": "true"}
    direct = os.environ | keys | {"AWS_ENDPOINT_URL": f"http://127.0.0.1:{server.port}"}
    cut = direct | {"AWS_ENDPOINT_URL": f"http://127.0.0.1:{proxy.port}"}
    storage: Any = boto3.client(
        "s3",
        endpoint_url=direct["AWS_ENDPOINT_URL"],
        region_name="us-east-1",
        aws_access_key_id="key",
        aws_secret_access_key="secret",
    )
    storage.create_bucket(Bucket="data")

    def start(*words: object, env: dict[str, str] = cut) -> subprocess.Popen[str]:
        return subprocess.Popen([underbrush, *map(str, words)], env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def ended(process: subprocess.Popen[str], status: int = 0) -> str:
        answer, said = process.communicate(timeout=600)
        if process.returncode != status:
            sys.exit(f"{process.args} ended with {process.returncode}, not {status}: {said}{answer}")
        return said

    def in_bucket(prefix: str) -> Iterable[tuple[str, bytes]]:
        for entry in storage.list_objects_v2(Bucket="data", Prefix=f"{prefix}/").get("Contents", []):
            yield entry["Key"].removeprefix(f"{prefix}/"), storage.get_object(Bucket="data", Key=entry["Key"])["Body"].read()

    wrong = 0

    def step(name: str, do: Callable[[], str], expected: str | None = None) -> str:
        nonlocal wrong
        began, found = time.monotonic(), do()
        wrong += expected is not None and found != expected
        print(f"{name:58} {found}  {time.monotonic() - began:5.1f} s", flush=True)
        return found

    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)

        def generate(name: str, *further: object, seed: int = 5) -> Path:
            out = folder / name
            ended(start("generate", SCENE, "--reaches", REACHES, "--seed", seed, "--out", out, *further))
            return out

        whole = generate("whole")
        expected = step("one process", lambda: hash_of(in_folder(whole)))
        other = generate("other", seed=6)

        def parts() -> str:
            made = [generate(f"part-{part}", "--shard", f"{part}/{PARTS}") for part in range(1, PARTS + 1)]
            pushes = [start("push", part, f"s3://data/parts/{part.name}") for part in made for _ in range(2)]
            for push in pushes:
                ended(push)
            pulled = [folder / f"pulled-{part.name}" for part in made]
            for part, out in zip(made, pulled, strict=True):
                ended(start("pull", f"s3://data/parts/{part.name}", "--out", out))
            ended(start("merge", *pulled, "--out", folder / "merged"))
            return hash_of(in_folder(folder / "merged"))

        step(f"{PARTS} parts, each pushed twice at once, pulled and merged", parts, expected)

        def killed() -> str:
            process = start("push", folder / "merged", "s3://data/sets/mine")
            while not any(in_bucket("sets/mine")):
                time.sleep(0.001)
            process.kill()
            process.communicate()
            if "meta/info.json" in dict(in_bucket("sets/mine")):
                sys.exit("the push had ended before it was killed")
            ended(start("pull", "s3://data/sets/mine", "--out", folder / "half"), status=2)
            ended(start("inspect", folder / "half"), status=2)
            for push in [start("push", folder / "merged", "s3://data/sets/mine") for _ in range(2)]:
                ended(push)
            return hash_of(in_bucket("sets/mine"))

        step("the merged set in storage, after a push that was killed", killed, expected)

        def pulled() -> str:
            # Continues from what the refused pull has left.
            ended(start("pull", "s3://data/sets/mine", "--out", folder / "half"))
            return hash_of(in_folder(folder / "half"))

        step("pulled", pulled, expected)

        def contest() -> str:
            pushes = [start("push", data, "s3://data/sets/contested", env=direct) for data in (whole, other)]
            said = [push.communicate(timeout=600)[1] for push in pushes]
            ends = sorted(push.returncode for push in pushes)
            if ends != [0, 2] or "another data set" not in "".join(said):
                sys.exit(f"two sets at one address: {ends}, {said}")
            winner = (whole, other)[pushes[1].returncode == 0]
            if hash_of(in_bucket("sets/contested")) != hash_of(in_folder(winner)):
                sys.exit("the sets are mixed")
            return "one of the two"

        step("two sets to one address at the same time", contest)

        def damaged() -> str:
            key = "sets/mine/data/chunk-000/file-000.parquet"
            data = bytearray(storage.get_object(Bucket="data", Key=key)["Body"].read())
            data[len(data) // 2] ^= 1
            storage.put_object(Bucket="data", Key=key, Body=bytes(data))
            said = ended(start("pull", "s3://data/sets/mine", "--out", folder / "damaged"), status=2)
            return "refused" if key.removeprefix("sets/mine/") in said else "not named"

        step("an object with one changed bit", damaged, "refused")

        def torn() -> str:
            key = "sets/mine/truth/poses/chunk-000/file-000.parquet"
            storage.put_object(Bucket="data", Key=key, Body=b"PAR1")
            said = ended(start("push", folder / "merged", "s3://data/sets/mine"), status=2)
            return "refused" if key in said and "4 bytes" in said else "not named"

        step("a push onto an object that was cut short", torn, "refused")
        step("an address without a set", lambda: ended(start("pull", "s3://data/none", "--out", folder / "none"), 2)[:0] or "refused")
    print(f"{proxy.cut} of {proxy.connections} connections were cut")
    if wrong:
        sys.exit("not all is as it should be")
    print("all sets are equal")


if __name__ == "__main__":
    main()
