"""What the cluster costs beside the work: python cluster_overhead.py [--tasks 1000] [--seconds 2]

Runs tasks that sleep, through the same driver, keeper and workers as train_many, on this machine:
each reports its progress once a second and gives back a model's bytes, which are written to disk.
Sleeping takes no core, so many tasks run at once; what a task takes beyond its sleep is overhead.

The duration is scaled down; the overhead of a task is absolute, and is set against a task of 60
seconds. Driver, keeper and all workers share this machine's cores, where a cluster has more. What
one machine cannot show: the time for a model over a network, and Ray's start on more nodes. The
first start of a worker process is told apart, as a node has it once, not with every task.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from typing import Any

import ray

import pocketnerf
from pocketnerf.cluster import driver, files
from pocketnerf.cluster.worker import Outcome, Task

REAL = 60.0
"""Seconds of the task that overhead is compared with."""


def work(task: Task, seconds: float, model: int, checkpoint: int) -> Outcome:
    """Sleeps; reports and keeps checkpoints as training does."""
    begun = time.time()
    saved = os.path.join(task.folder, "scene.ckpt.pnerf")
    if checkpoint:
        files.write(saved, os.urandom(checkpoint))
    steps = 100
    while time.time() < begun + seconds:
        step = int(steps * (time.time() - begun) / seconds)
        task.watch(pocketnerf.Progress("training", step, steps, None, None, 0), saved)
        time.sleep(min(0.25, max(0.0, begun + seconds - time.time())))
    return Outcome({"begun": begun, "ended": time.time()}, {"model": os.urandom(model)})


def simulate(tasks: int, slots: int, arguments: dict[str, Any]) -> tuple[float, list[float]]:
    """Wall time, and the gaps between one task's end and the next one's begin in a slot."""
    spans: list[tuple[float, float]] = []
    with tempfile.TemporaryDirectory() as out:

        def finished(outcomes: dict[str, Outcome]) -> None:
            for name, outcome in outcomes.items():
                if outcome.row.get("error"):
                    raise SystemExit(f"{name}: {outcome.row['error']}")
                spans.append((outcome.row["begun"], outcome.row["ended"]))
                files.write(os.path.join(out, f"{name}.pnerf"), outcome.files["model"])

        jobs = [driver.Job(f"scene-{i:04}", arguments) for i in range(tasks)]
        begun = time.time()
        driver.run(jobs, work, finished, num_cpus=1, max_retries=3, unit="scene")
        wall = time.time() - begun
    return wall, gaps(spans, slots)


def gaps(spans: list[tuple[float, float]], slots: int) -> list[float]:
    """Sorted begins and ends: the k-th task to begin after the first ones follows the k-th end."""
    begins = sorted(begin for begin, _ in spans)[slots:]
    ends = sorted(end for _, end in spans)
    return [begin - end for begin, end in zip(begins, ends)]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--tasks", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=2.0, help="sleep of a task")
    parser.add_argument("--slots", type=int, default=24, help="tasks at once")
    parser.add_argument("--model-bytes", type=int, default=3_000_000)
    parser.add_argument("--checkpoint-bytes", type=int, default=0, help="one for each task")
    given = parser.parse_args()
    # Cores are what Ray counts; sleeping tasks need none.
    ray.init(
        num_cpus=given.slots,
        object_store_memory=500_000_000,
        include_dashboard=False,
        log_to_driver=False,
    )
    arguments = {
        "seconds": given.seconds,
        "model": given.model_bytes,
        "checkpoint": given.checkpoint_bytes,
    }
    cold, _ = simulate(given.slots, given.slots, {**arguments, "seconds": 1.0})
    wall, between = simulate(given.tasks, given.slots, arguments)
    ideal = given.seconds * given.tasks / given.slots
    overhead = (wall - ideal) * given.slots / given.tasks
    print(f"{given.tasks} tasks of {given.seconds:g} s, {given.slots} at once, {os.cpu_count()} cores")
    print(f"first start of {given.slots} workers: {cold - 1:.1f} s")
    print(f"wall time {wall:.1f} s, without overhead {ideal:.1f} s")
    print(f"from one task to the next in a slot: median {1e3 * statistics.median(between):.0f} ms")
    print(f"overhead of a task {1e3 * overhead:.0f} ms: {100 * overhead / REAL:.2f} % of {REAL:g} s")


if __name__ == "__main__":
    main()
