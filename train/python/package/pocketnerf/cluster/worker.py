"""What runs on a node: one attempt at one task."""

from __future__ import annotations

import contextlib
import os
import platform
import tempfile
import time
import traceback
import warnings
from typing import Any, Callable, Dict, Iterator, NamedTuple, Optional

import pocketnerf
import ray

from . import files, keeper

REPORT_EVERY = 1.0
"""Least seconds between two reports of a task."""


class Setup(NamedTuple):
    """What all tasks of a run have in common."""

    keeper: Any
    storage: Optional[str]
    threads: int
    max_retries: int
    version: str


class Outcome(NamedTuple):
    """What a task gives back."""

    row: Dict[str, Any]
    files: Dict[str, bytes]


class Task:
    """An attempt, as the function that does the work sees it."""

    def __init__(self, setup: Setup, name: str, start: keeper.Start, folder: str) -> None:
        self.name = name
        self.threads = setup.threads
        self.attempt = start.attempt
        self.folder = folder
        """An empty folder of this node, which is deleted afterwards."""
        self._setup = setup
        self._start = start
        self._saved: Optional[int] = None
        self._sending: Any = None
        self._reported = float("-inf")

    def restore(self, path: str) -> bool:
        """Writes the last checkpoint of an earlier attempt to a file; False if there is none."""
        if self._start.checkpoint:
            data = wait_for(self._start.checkpoint[0])
        elif self._setup.storage is not None:
            try:
                data = files.read(keeper.checkpoint_file(self._setup.storage, self.name))
            except FileNotFoundError:
                return False
        else:
            return False
        files.write(path, data)
        return True

    def watch(self, progress: Any, checkpoint: str) -> None:
        """Reports progress, and keeps the checkpoint if its file is a new one."""
        self.keep(checkpoint)
        now = time.monotonic()
        if now - self._reported >= REPORT_EVERY:
            self._reported = now
            self._setup.keeper.report.remote(self.name, self.attempt, progress)

    def keep(self, checkpoint: str) -> None:
        """Keeps the checkpoint where a lost worker does not take it along, if it is a new one."""
        try:
            # The file is replaced, never changed, so that another one has another time.
            changed = os.stat(checkpoint).st_mtime_ns
            if changed == self._saved:
                return
            if self._sending is not None and not self._sending.done():
                return  # A slow network: the next one is newer.
            data = files.read(checkpoint)
        except FileNotFoundError:
            return
        self._saved = changed
        if self._setup.storage is not None:
            files.write(keeper.checkpoint_file(self._setup.storage, self.name), data)
        else:
            save = self._setup.keeper.save
            self._sending = save.remote(self.name, self.attempt, data).future()


def attempt(
    function: Callable[..., Outcome], setup: Setup, name: str, **arguments: Any
) -> Outcome:
    """Does a task. What goes wrong with it is its row's ``error``; lost workers are up to Ray."""
    pocketnerf.set_num_threads(setup.threads)
    node = ray.get_runtime_context().get_node_id()
    start = wait_for(setup.keeper.begin.remote(name, node))
    row: Dict[str, Any] = {"node": platform.node()}
    if start.attempt > setup.max_retries + 1:
        # Ray does not count workers that it ends itself because memory runs out.
        return Outcome({**row, "error": lost(start.attempt - 1, "out of memory")}, {})
    if pocketnerf.__version__ != setup.version:
        error = (
            f"node {platform.node()}: found pocketnerf {pocketnerf.__version__}, expected "
            f"{setup.version} as the driver has; install the same version on all nodes"
        )
        return Outcome({**row, "error": error}, {})
    try:
        with tempfile.TemporaryDirectory(prefix="pocketnerf-") as folder, quiet():
            outcome = function(Task(setup, name, start, folder), **arguments)
    except pocketnerf.Error as error:
        return Outcome({**row, "error": str(error)}, {})
    except Exception as error:
        traceback.print_exc()
        return Outcome({**row, "error": f"{type(error).__name__}: {error}".splitlines()[0]}, {})
    return Outcome({**row, **outcome.row}, outcome.files)


def wait_for(reference: Any) -> Any:
    """As ``ray.get``, but the task keeps its cores meanwhile. Ray lends those of a task that waits
    in ``ray.get`` to another one, and then both run on them to their ends."""
    return reference.future().result()


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Warnings are in the table; a thousand scenes' would bury the driver's own output."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def lost(times: int, why: str) -> str:
    return (
        f"the worker was lost {times} times, the last time: {why}; call again, with more memory or "
        "max_retries"
    )
