"""Several threads and processes."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import quick

import underbrush as ub


def reach_of(seed: int) -> tuple[int, float]:
    found = ub.reach(quick("leaf"), seed=seed)
    return len(found), float(found.sensed_force_n("forearm").sum())


def scores_of(given: tuple[ub.Model, ub.Trials]) -> np.ndarray:
    model, trials = given
    return model.scores(trials)


@pytest.mark.parametrize("method", ["spawn", "fork"])
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_processes_give_the_same(method: str, trials: ub.Trials) -> None:
    """Tests that processes that are spawned or forked after threads were used simulate and score the same, without
    hanging."""
    model = ub.fit(trials, states=3)
    expected = [reach_of(seed) for seed in (1, 2)]
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(reach_of, [1, 2]).get(timeout=120) == expected
        (scores,) = pool.map_async(scores_of, [(model, trials)]).get(timeout=120)
    assert np.array_equal(scores, model.scores(trials))


def test_the_interpreter_runs_meanwhile(data: ub.Dataset, trials: ub.Trials) -> None:
    """Tests that other Python threads run while a model is fitted, and while pictures are drawn. If the interpreter's lock
    were held, they could not."""
    ticks, done = [], threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks.append(1)
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    simulation, meanwhile = ub.Simulation("leaf"), []
    fit = lambda: ub.fit(trials, states=10, tolerance=0.0, iterations=40, jobs=1)
    for call in (fit, lambda: data[0].draw(), simulation.draw):
        before = len(ticks)
        call()
        meanwhile.append(len(ticks) - before)
    done.set()
    thread.join()
    assert min(meanwhile) > 2


def test_ctrl_c_ends_calls(data: ub.Dataset, trials: ub.Trials, tmp_path: Path) -> None:
    """Tests that Ctrl-C ends a fit, a cross-validation, a replay page and a look into a folder after the iteration or the reach that is
    under way."""
    endless = {"states": 10, "tolerance": 0.0, "iterations": 100_000}
    data[0].save(tmp_path / "0.parquet")
    for number in range(1, 1000):
        os.link(tmp_path / "0.parquet", tmp_path / f"{number}.parquet")
    for call in (
        lambda: ub.fit(trials, **endless),
        lambda: ub.evaluate(trials, ub.Options("hmm", **endless)),
        lambda: ub.replay(tmp_path),
        lambda: ub.inspect(tmp_path),
    ):
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        with pytest.raises(KeyboardInterrupt):
            call()


def test_threads_may_share_what_does_not_change(data: ub.Dataset, trials: ub.Trials) -> None:
    """Tests that several threads that read one data set and score with one model get the same numbers as one thread."""
    model = ub.fit(trials, states=3)
    expected = model.scores(trials)
    columns = [reach.column("action").copy() for reach in data]
    wrong: list[str] = []

    def work() -> None:
        for index, reach in enumerate(ub.Dataset(data.path)):
            if not np.array_equal(data[index].column("action"), columns[index]) or len(reach) != len(columns[index]):
                wrong.append(f"reach {index}")
        if not np.array_equal(model.scores(trials), expected):
            wrong.append("scores")

    threads = [threading.Thread(target=work) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert wrong == []


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the limit does not hold for root")
def test_threads_that_cannot_be_started_are_an_error() -> None:
    """Tests that a call raises RunError if no further thread may be started."""
    code = """
import resource, underbrush
resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))
try:
    underbrush.inspect("leaf")
except underbrush.RunError as error:
    print(error)
"""
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.startswith("cannot start threads")
