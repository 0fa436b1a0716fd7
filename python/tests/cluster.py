"""Checks that a set made by Ray equals the set of one process, byte for byte, although a node is killed in the middle.
Needs Ray. Not in CI.

    python cluster.py

Makes the same set in four ways: in one process on one thread, in seven parts that are merged, on a Ray cluster of three
nodes of which one is killed while its parts run, and again on this cluster when all parts are there. Then it runs three
campaigns of an experiment, and a row of the benchmark, in one process and on the cluster. Prints the hash of each and
how long it took, and fails if they differ.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ray
from ray.cluster_utils import Cluster

import underbrush as ub
import underbrush.distributed

EXPERIMENT = Path(__file__).parents[2] / "experiments/examples/three-categories/three-categories.toml"
CAMPAIGNS = 3
REACHES = 14
SEED = 5
PARTS = 7


def hash_of(folder: Path) -> str:
    total = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        total.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    return total.hexdigest()[:16]


def results_of(study: dict[str, Any]) -> str:
    """The hash of all results except the times."""
    return hashlib.sha256(json.dumps(study | {"timing": None}).encode()).hexdigest()[:16]


def main() -> None:
    scene = ub.Scene("trunk").changed({"goals": {"count": 2, "retries": 0}})
    hashes = {}

    def timed(name: str, make: Callable[[], ub.Dataset]) -> None:
        start = time.monotonic()
        hashes[name] = hash_of(Path(make().path))
        print(f"{name:48} {hashes[name]}  {time.monotonic() - start:6.1f} s", flush=True)

    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        timed("one process, one thread", lambda: ub.generate(scene, REACHES, folder / "one", seed=SEED, jobs=1, progress=False))

        def parts() -> ub.Dataset:
            own = [
                ub.generate(scene, REACHES, folder / f"part{part}", seed=SEED, shard=(part, PARTS), jobs=1, progress=False).path
                for part in range(1, PARTS + 1)
            ]
            return ub.merge(own, folder / "merged")

        timed("seven parts, merged", parts)
        cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "object_store_memory": 80_000_000})
        nodes = [cluster.add_node(num_cpus=1, object_store_memory=80_000_000) for _ in range(2)]
        ray.init(address=cluster.address, log_to_driver=False)
        cluster.wait_for_nodes()
        seen: list[str] = []

        def progress(done: int, total: int, text: str) -> None:
            if not seen or seen[-1] != f"{done}/{total} {text}":
                seen.append(f"{done}/{total} {text}")
                print(f"    {time.monotonic() - start:5.1f} s: {seen[-1]}", flush=True)

        def kill() -> None:
            while not seen or seen[-1].startswith("0/"):
                time.sleep(0.1)
            cluster.remove_node(nodes[1], allow_graceful=False)
            print(f"    {time.monotonic() - start:5.1f} s: one node killed", flush=True)

        start = time.monotonic()
        killer = threading.Thread(target=kill)
        killer.start()
        timed(
            "three nodes, one killed",
            lambda: underbrush.distributed.generate(
                scene, REACHES, folder / "ray", parts=PARTS, seed=SEED, keep_parts=True, progress=progress
            ),
        )
        killer.join()
        start, seen[:] = time.monotonic(), []
        (folder / "ray").rename(folder / "ray-before")
        timed(
            "again, with all parts there",
            lambda: underbrush.distributed.generate(scene, REACHES, folder / "ray", parts=PARTS, seed=SEED, progress=progress),
        )
        studies = {}
        options: dict[str, Any] = {"experiment": EXPERIMENT, "quick": True, "campaigns": CAMPAIGNS}
        start, seen[:] = time.monotonic(), []
        for name, reproduce, shown in (
            ("campaigns on two nodes", underbrush.distributed.reproduce, progress),
            ("campaigns, one process", ub.reproduce, False),
        ):
            began = time.monotonic()
            studies[name] = results_of(reproduce(folder / name, progress=shown, **options))
            print(f"{name:48} {studies[name]}  {time.monotonic() - began:6.1f} s", flush=True)
        rows = {}
        start, seen[:] = time.monotonic(), []
        for name, benchmark, shown in (
            ("a row on two nodes", underbrush.distributed.benchmark, progress),
            ("a row, one process", ub.benchmark, False),
        ):
            began = time.monotonic()
            benchmark("reaching", folder / name, controller="cody-2013", quick=True, progress=shown)
            [row] = (folder / name / "quick-rows").iterdir()
            rows[name] = hashlib.sha256(row.read_bytes()).hexdigest()[:16]
            print(f"{name:48} {rows[name]}  {time.monotonic() - began:6.1f} s", flush=True)
        ray.shutdown()
        cluster.shutdown()
    if len(set(rows.values())) != 1:
        sys.exit("the rows of the benchmark differ")
    if len(set(studies.values())) != 1:
        sys.exit("the results of the campaigns differ")
    if len(set(hashes.values())) != 1:
        sys.exit("the sets differ")
    print("all sets, results and rows are equal")


if __name__ == "__main__":
    main()
