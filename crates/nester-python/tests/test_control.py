"""A running search: callbacks, other threads, and Ctrl-C."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
import threading
import time

import pytest
from conftest import VOLUME, Box

import nestd_nester as nn


def test_on_better_gets_falling_heights_down_to_the_result(box: Box) -> None:
    calls: list[tuple[float, float]] = []
    caller = threading.current_thread()

    def on_better(height: float, seconds: float) -> None:
        assert threading.current_thread() is caller
        calls.append((height, seconds))

    solution = nn.pack({box: 8, Box(9, 7, 5): 8}, VOLUME, 2, evaluations=4000, on_better=on_better)
    heights, seconds = zip(*calls)
    assert len(calls) > 1
    assert all(before > after for before, after in zip(heights, heights[1:])) and list(seconds) == sorted(seconds)
    assert heights[-1] == pytest.approx(solution.height)
    assert [(when, height) for height, when in calls] == solution.heights


def test_on_better_ends_the_search_with_what_it_has(box: Box) -> None:
    solution = nn.pack({box: 12, Box(9, 7, 5): 12}, VOLUME, 2, seconds=60, on_better=lambda height, seconds: False)
    assert solution.seconds < 5 and solution.ended == "stopped" and len(solution.placements) == 24
    solution.verify()


def test_an_exception_of_on_better_ends_the_search_and_arrives(box: Box) -> None:
    def on_better(height: float, seconds: float) -> None:
        raise LookupError("enough")

    began = time.monotonic()
    with pytest.raises(LookupError, match="enough"):
        nn.pack({box: 12}, VOLUME, 2, seconds=60, on_better=on_better)
    assert time.monotonic() - began < 5


def test_other_threads_run_while_the_search_does(box: Box) -> None:
    counted, is_over = 0, threading.Event()

    def count() -> None:
        nonlocal counted
        while not is_over.is_set():
            counted += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    nn.pack({box: 12, Box(9, 7, 5): 12}, VOLUME, 2, seconds=1.5)
    is_over.set()
    counter.join()
    # With the lock held, it would have counted once.
    assert counted > 100


def test_searches_run_side_by_side(box: Box) -> None:
    found: dict[int, nn.Solution] = {}

    def pack(seed: int) -> None:
        found[seed] = nn.pack({box: 6}, VOLUME, 2, evaluations=800, seed=seed)

    threads = [threading.Thread(target=pack, args=(seed,)) for seed in (1, 2, 3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone = nn.pack({box: 6}, VOLUME, 2, evaluations=800, seed=2)
    assert all((one == other).all() for one, other in zip(found[2].poses, alone.poses))


INTERRUPTED = """
    import sys, time
    import numpy as np
    import nestd_nester as nn

    rows, columns = 150, 150
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, rows, endpoint=False), np.linspace(0, 2 * np.pi, columns, endpoint=False))
    ring = 20 + 6 * np.cos(v) * (1 + 0.2 * np.sin(9 * u))
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), 6 * np.sin(v)], axis=-1).reshape(-1, 3)
    at = np.arange(rows * columns).reshape(columns, rows)
    right, up, both = np.roll(at, -1, 1), np.roll(at, -1, 0), np.roll(np.roll(at, -1, 1), -1, 0)
    faces = np.concatenate([np.stack([at, right, both], -1).reshape(-1, 3), np.stack([at, both, up], -1).reshape(-1, 3)])
    print("begins", flush=True)
    try:
        nn.pack([((vertices, faces), 30)], (150, 150, 300), 2, seconds=60, threads=2)
    except KeyboardInterrupt:
        print(f"interrupted {time.time():.6f}", flush=True)
        sys.exit(5)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process")
@pytest.mark.parametrize("after", [0.05, 0.4, 1.5, 4.0])
def test_ctrl_c_ends_within_half_a_second(after: float) -> None:
    program = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(INTERRUPTED)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert program.stdout is not None and program.stdout.readline() == "begins\n"
    time.sleep(after)
    sent, began = time.time(), time.monotonic()
    program.send_signal(signal.SIGINT)
    out, err = program.communicate(timeout=30)
    ended = time.monotonic() - began
    assert program.returncode == 5, err
    raised = float(out.split()[1]) - sent
    print(f"Ctrl-C after {after} s: raised after {1000 * raised:.0f} ms, the process ended after {1000 * ended:.0f} ms")
    # How long the interpreter takes to end depends on what else the machine does.
    assert raised < 0.5 and ended < 5.0
