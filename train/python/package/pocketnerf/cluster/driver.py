"""Runs tasks on Ray, and gives back what comes of each."""

from __future__ import annotations

import contextlib
import math
import os
import warnings
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence

import pocketnerf
import ray
from ray.exceptions import RayError, RayTaskError

from . import keeper
from .progress import OnProgress, Watch
from .worker import Outcome, Setup, attempt, lost

POLL = 0.5
"""Seconds between two looks at progress."""
GRACE = 10.0
"""Seconds in which interrupted tasks write a checkpoint."""


class Job(NamedTuple):
    """A task to do."""

    name: str
    arguments: Dict[str, Any]
    """Ray fetches references among the values."""
    memory: Callable[[], Optional[int]] = lambda: None
    """Bytes that the task needs, or None; called in a thread, as it may take long."""


def connect(address: Optional[str]) -> None:
    """Connects to the cluster, or to the one that runs on this machine, or starts Ray here."""
    if not ray.is_initialized():
        ray.init(address=address, include_dashboard=False)


def largest_node() -> Dict[str, float]:
    """The most cores and the most memory (bytes) that a node has now."""
    listed: List[Dict[str, Any]] = ray.nodes()  # type: ignore[no-untyped-call]
    nodes = [node["Resources"] for node in listed if node["Alive"]]
    kinds = ("CPU", "memory")
    return {kind: max((node.get(kind, 0.0) for node in nodes), default=0.0) for kind in kinds}


def run(
    jobs: Sequence[Job],
    function: Callable[..., Outcome],
    finished: Callable[[Dict[str, Outcome]], None],
    *,
    num_cpus: float,
    max_retries: int,
    unit: str,
    storage: Optional[str] = None,
    address: Optional[str] = None,
    on_progress: Optional[OnProgress] = None,
    progress: Optional[bool] = None,
) -> None:
    """Calls ``function(task, **arguments)`` for each job on some node.

    ``finished`` is told of outcomes as they come, some at a time. Lost workers' tasks begin again
    elsewhere. When it ends early, by Ctrl-C or an exception, all tasks are cancelled.
    """
    connect(address)
    num_cpus = _check_cpus(num_cpus)
    storage = None if storage is None else os.path.abspath(storage)
    kept = keeper.start(storage)
    threads = max(1, math.floor(num_cpus))
    setup = Setup(kept, storage, threads, max_retries, pocketnerf.__version__)
    remote = ray.remote(num_cpus=num_cpus, max_retries=max_retries)(attempt)
    watch = Watch(len(jobs), unit, progress, on_progress)
    running: Dict[Any, str] = {}
    with contextlib.ExitStack() as stack:
        stack.callback(watch.close)
        stack.callback(_cancel, running, kept)
        estimates = ThreadPoolExecutor(2)
        stack.callback(estimates.shutdown, wait=False, cancel_futures=True)
        waiting = deque((job, estimates.submit(job.memory)) for job in jobs)
        largest = largest_node()["memory"]
        while waiting or running:
            for job, memory in _estimated(waiting, block=not running):
                # More than any node has would wait for ever; Ray ends what does run out.
                wanted = None if memory is None else min(memory, int(largest))
                ref = remote.options(memory=wanted, name=f"{unit} {job.name}").remote(
                    function, setup, job.name, **job.arguments
                )
                running[ref] = job.name
            outcomes = _finished(running, kept, max_retries)
            failed = {name: bool(found.row.get("error")) for name, found in outcomes.items()}
            if outcomes:
                finished(outcomes)
            # Before the keeper forgets what has ended: short tasks are heard of too.
            news = ray.get(kept.news.remote())
            # Only now, with results on disk, may checkpoints go.
            ray.get([kept.finish.remote(name, not failed[name]) for name in failed])
            watch.news(news)
            for name in failed:
                watch.finished(name, failed[name])


def run_all(
    jobs: Sequence[Job],
    function: Callable[..., Outcome],
    save: Callable[[str, Dict[str, bytes]], None],
    folder: str,
    *,
    unit: str,
    **how: Any,
) -> None:
    """As ``run``, and saves the files of each job as they come.

    Raises pocketnerf.Error at the end if a job failed; what the others gave is saved.
    """
    errors: Dict[str, str] = {}

    def finished(outcomes: Dict[str, Outcome]) -> None:
        for name, outcome in outcomes.items():
            if outcome.row.get("error"):
                errors[name] = outcome.row["error"]
            save(name, outcome.files)

    if jobs:
        run(jobs, function, finished, unit=unit, **how)
    if errors:
        name, error = next(iter(errors.items()))
        raise pocketnerf.Error(f"{folder}: {len(errors)} {unit}s failed; the first, {name}: {error}")


def _estimated(waiting: Any, block: bool) -> Iterator[Any]:
    """Takes jobs whose memory is known from the front of the queue."""
    while waiting and (block or waiting[0][1].done()):
        job, memory = waiting.popleft()
        block = False
        yield job, memory.result()


def _finished(running: Dict[Any, str], kept: Any, max_retries: int) -> Dict[str, Outcome]:
    """Waits a little for tasks to end, and takes out those that have."""
    ray.wait(list(running), num_returns=1, timeout=POLL)
    ready, _ = ray.wait(list(running), num_returns=len(running), timeout=0)
    outcomes = {}
    for ref in ready:
        name = running.pop(ref)
        try:
            row, files = ray.get(ref)
        except RayTaskError as error:
            row, files = {"error": str(error).strip().splitlines()[-1]}, {}
        except RayError as error:
            row, files = {"error": lost(max_retries + 1, type(error).__name__)}, {}
        attempts = ray.get(kept.attempts.remote(name))
        outcomes[name] = Outcome({**row, "attempts": attempts}, files)
    return outcomes


def _cancel(running: Mapping[Any, str], kept: Any) -> None:
    """Ends what still runs; with ``storage``, training leaves a checkpoint."""
    refs: List[Any] = list(running)
    if refs and ray.is_initialized():
        for ref in refs:
            ray.cancel(ref)
        _, left = ray.wait(refs, num_returns=len(refs), timeout=GRACE)
        for ref in left:
            ray.cancel(ref, force=True)
    with contextlib.suppress(Exception):
        ray.kill(kept)


def _check_cpus(num_cpus: float) -> float:
    """At most the cores of the largest node, with a warning."""
    if num_cpus <= 0:
        raise pocketnerf.Error(f"num_cpus: found {num_cpus}, expected more than 0")
    largest = largest_node()["CPU"]
    if 0 < largest < num_cpus:
        warnings.warn(
            f"num_cpus={num_cpus}: the largest node has {largest:g} cores, so each task takes "
            f"{largest:g}",
            pocketnerf.PocketnerfWarning,
            stacklevel=5,
        )
        return largest
    return num_cpus
