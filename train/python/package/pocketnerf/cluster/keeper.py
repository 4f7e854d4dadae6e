"""What outlives a lost worker: attempts, checkpoints and progress of all tasks."""

from __future__ import annotations

import contextlib
import os
import uuid
from collections import Counter
from typing import Any, Dict, List, NamedTuple, Optional

import ray
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from . import files


class Start(NamedTuple):
    """What an attempt begins with."""

    attempt: int
    """From 1."""
    checkpoint: List[Any]
    """None or one reference to the bytes of the last checkpoint. In a list Ray leaves it a
    reference, so that these bytes go straight from store to worker."""


class Keeper:
    """An actor on the driver's node. It ends with the driver.

    Checkpoints are the keeper's own objects in the store of its node: they stay when the worker
    that made them is lost, and Ray spills them to disk when the store is full. With ``storage``
    they are files in that folder instead, and stay when the driver is lost, too.
    """

    def __init__(self, storage: Optional[str]) -> None:
        self._storage = storage
        self._attempts: Counter[str] = Counter()
        self._checkpoints: Dict[str, Any] = {}
        self._nodes: Dict[str, str] = {}
        self._news: Dict[str, Any] = {}

    def begin(self, name: str, node: str) -> Start:
        """A worker on a node begins a task, or begins it again."""
        self._attempts[name] += 1
        self._nodes[name] = node
        kept = self._checkpoints.get(name)
        return Start(self._attempts[name], [] if kept is None else [kept])

    def save(self, name: str, attempt: int, checkpoint: bytes) -> None:
        """Keeps a checkpoint; those of an attempt that is given up, but still runs, are late."""
        if attempt == self._attempts[name]:
            self._checkpoints[name] = ray.put(checkpoint)

    def report(self, name: str, attempt: int, progress: Any) -> None:
        if attempt == self._attempts[name]:
            self._news[name] = progress

    def news(self) -> Dict[str, Any]:
        """The latest progress of each task that has reported since the last call."""
        news, self._news = self._news, {}
        return news

    def attempts(self, name: str) -> int:
        return self._attempts[name]

    def finish(self, name: str, done: bool) -> None:
        """The driver has the result. Of a task that failed, a checkpoint in ``storage`` stays for
        another call."""
        self._checkpoints.pop(name, None)
        self._nodes.pop(name, None)
        self._news.pop(name, None)
        if done and self._storage is not None:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(checkpoint_file(self._storage, name))

    def running(self) -> Dict[str, Dict[str, Any]]:
        """Of each task that has begun and not finished: its node, and whether it has a
        checkpoint here."""
        return {
            name: {"node": node, "checkpoint": name in self._checkpoints}
            for name, node in self._nodes.items()
        }


def checkpoint_file(storage: str, name: str) -> str:
    return os.path.join(storage, f"{name}.ckpt.pnerf")


def start(storage: Optional[str]) -> Any:
    """Starts a keeper where the driver is; it takes no core from tasks."""
    here = NodeAffinitySchedulingStrategy(ray.get_runtime_context().get_node_id(), soft=False)
    options = {
        "num_cpus": 0,
        "name": f"pocketnerf-{uuid.uuid4().hex}",
        "scheduling_strategy": here,
    }
    if storage is not None:
        files.make_folder(storage)
    return ray.remote(Keeper).options(**options).remote(storage)
