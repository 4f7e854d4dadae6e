"""The programs ``stress`` and ``chart``: what can be distributed, and what cannot."""

from __future__ import annotations

import csv
import io
import os
import subprocess
import sys
from typing import Any, Dict, List, Mapping, Optional, Sequence

import pocketnerf
import ray
from pocketnerf import Error
from pocketnerf._run import arguments

from . import driver, files
from .progress import OnProgress
from .scenes import READING
from .sweep import sweep
from .table import Row, Table, value
from .worker import Outcome, Task


def stress(
    data: files.Path = "builtin",
    out: files.Path = "stress",
    *,
    modes: Optional[Sequence[str]] = None,
    modes_per_task: int = 4,
    num_cpus: float = 2,
    max_retries: int = 3,
    memory: Optional[int] = None,
    progress: Optional[bool] = None,
    address: Optional[str] = None,
    **options: Any,
) -> Table:
    """Tests where radiance fields fail, as ``pocketnerf stress``: some ways to fail a task.

    Each task also trains the unspoilt scene that it compares with, so that small groups cost
    more in all. Runs are counted in steps: rows are those of ``pocketnerf stress`` on one machine.
    Groups that are done are skipped. A lost task begins its group again.

    There is no page of all groups: each has its own, ``out/MODES/index.html``.

    Args:
        data: folder that all nodes see, or a built-in scene.
        out: folder on the driver's machine; ``stress.csv`` has all rows.
        modes: ways to fail, by name. Default: all.
        modes_per_task: ways to fail in a group.
        num_cpus, max_retries, memory, progress, address: as for ``train_many``.
        options: further options of ``pocketnerf stress``: ``quick=True``, ``seeds``, ``steps``.

    Returns:
        The rows of all groups: ``mode``, ``strength``, ``seed``, ``figure``, ``value``, ``bar``,
        ``verdict``, ``warning`` and so on, in the order of the modes.

    Raises:
        pocketnerf.Error: a group failed, or ``out`` has rows of other data or options. Groups
            that are done are kept.
    """
    chosen = list(modes) if modes is not None else _modes()
    if modes_per_task < 1 or not chosen:
        raise Error(
            f"stress: found {len(chosen)} modes, {modes_per_task} a task, expected at least 1"
        )
    folder = files.make_folder(out)
    made_of = {"data": files.everywhere(data), "options": {k: str(v) for k, v in options.items()}}
    files.check_made_of(os.path.join(folder, "options.json"), made_of)
    parts = (chosen[i : i + modes_per_task] for i in range(0, len(chosen), modes_per_task))
    groups = {"+".join(part): part for part in parts}
    left = [name for name in groups if not os.path.exists(_csv(folder, name))]

    def save(name: str, pages: Dict[str, bytes]) -> None:
        _save(os.path.join(folder, name), pages, last="stress.csv")

    jobs = []
    for name in left:
        own = {**options, "modes": ",".join(groups[name])}
        job = driver.Job(name, {"data": files.everywhere(data), "options": own}, lambda: memory)
        jobs.append(job)
    driver.run_all(
        jobs,
        _stress,
        save,
        folder,
        num_cpus=num_cpus,
        max_retries=max_retries,
        unit="group",
        address=address,
        progress=progress,
    )
    rows: List[Row] = []
    for name in groups:
        text = io.StringIO(files.read(_csv(folder, name)).decode(), newline="")
        rows += [{key: value(key, cell) for key, cell in r.items()} for r in csv.DictReader(text)]
    table = Table(rows)
    table.to_csv(os.path.join(folder, "stress.csv"))
    return table


def chart(
    data: files.Path,
    out: files.Path,
    train: Mapping[str, Sequence[Any]],
    *,
    split: str = "test",
    num_cpus: float = 2,
    max_retries: int = 3,
    memory: Optional[int] = None,
    on_progress: Optional[OnProgress] = None,
    progress: Optional[bool] = None,
    address: Optional[str] = None,
    chart_options: Optional[Mapping[str, Any]] = None,
    **options: Any,
) -> Table:
    """Charts accuracy against speed, as ``pocketnerf chart``: models are trained on many nodes.

    All times are measured by one task on one node that has no other task meanwhile, as times of
    different machines are not comparable. For the same reason the chart has no seconds of
    training: where these matter, run ``pocketnerf chart`` on one machine.

    Args:
        data: folder that all nodes see, or a built-in scene.
        out: folder on the driver's machine: ``index.html``, ``chart.svg``, ``chart.png``,
            ``points.csv``, ``points.json``; models in ``out/models``.
        train: option of ``pocketnerf.train`` -> values; every combination is a model, as for
            ``sweep``.
        split: views to compare: ``"val"`` or ``"test"``.
        num_cpus, max_retries, memory, progress, address: as for ``train_many``, for training.
        chart_options: options of ``pocketnerf chart``, such as ``{"qualities": "0,0.5,1"}``.
        options: options of ``pocketnerf.train`` for all models, such as ``steps``.

    Returns:
        The points: rows of ``points.csv``.

    Example:
        >>> from pocketnerf.cluster import chart
        >>> sizes = {"log2_hashmap_size": [13, 15, 17]}
        >>> points = chart("builtin", "chart", sizes, steps=2000)  # doctest: +SKIP
        >>> points.best("ms_per_frame", least=True)["model"]  # doctest: +SKIP
        'log2_hashmap_size=13'
    """
    folder = files.make_folder(out)
    models = os.path.join(folder, "models")
    how: Dict[str, Any] = {
        "max_retries": max_retries,
        "memory": memory,
        "on_progress": on_progress,
        "progress": progress,
        "address": address,
    }
    table = sweep(data, models, train, split="val", num_cpus=num_cpus, **how, **options)
    if table.failed:
        raise Error(f"{models}: {len(table.failed)} models failed: {table.failed[0]['error']}")
    contents = {
        row["name"]: files.read(os.path.join(models, f"{row['name']}.pnerf")) for row in table
    }
    settings: Dict[str, Any] = {"x": "ms-per-frame,bytes", "split": split}
    settings.update({key: options[key] for key in READING if key in options})
    settings.update(chart_options or {})
    stored = ray.put(contents)
    where = files.everywhere(data)
    job = driver.Job("chart", {"data": where, "models": stored, "options": settings})
    how.pop("memory")
    driver.run_all(
        [job],
        _chart,
        lambda _, pages: _save(folder, pages, last="points.csv"),
        folder,
        # A whole node, so that nothing else disturbs the times.
        num_cpus=max(1.0, driver.largest_node()["CPU"]),
        unit="chart",
        **how,
    )
    return Table.read_csv(os.path.join(folder, "points.csv"))


def _stress(task: Task, data: str, options: Dict[str, Any]) -> Outcome:
    """Runs on a node."""
    pocketnerf.stress(data, out=task.folder, threads=task.threads, **options)
    return Outcome({}, _pages(task.folder))


def _chart(
    task: Task, data: str, models: Dict[str, bytes], options: Dict[str, Any]
) -> Outcome:
    """Runs on a node."""
    paths = []
    for name, content in models.items():
        paths.append(os.path.join(task.folder, f"{name}.pnerf"))
        files.write(paths[-1], content)
    out = os.path.join(task.folder, "chart")
    given = arguments("chart", [data], {**options, "out": out, "threads": task.threads})
    _program([*given, "--quiet", "--models", *paths])
    return Outcome({}, _pages(out))


def _modes() -> List[str]:
    return [line.split(":")[0] for line in _program(["stress", "--list"]).splitlines()]


def _program(given: List[str]) -> str:
    """Runs the command line in a process of its own; returns what it prints."""
    command = [sys.executable, "-m", "pocketnerf", *given]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Error(done.stderr.strip().split("\n")[-1] or f"{given[0]}: no answer")
    return done.stdout


def _csv(folder: str, name: str) -> str:
    return os.path.join(folder, name, "stress.csv")


def _pages(folder: str) -> Dict[str, bytes]:
    """Files at the top of a folder."""
    names = (name for name in os.listdir(folder) if os.path.isfile(os.path.join(folder, name)))
    return {name: files.read(os.path.join(folder, name)) for name in names}


def _save(folder: str, contents: Mapping[str, bytes], last: str) -> None:
    """Writes files; the one that says that all are there comes last."""
    if contents:
        files.make_folder(folder)
    for name in sorted(contents, key=lambda name: name == last):
        files.write(os.path.join(folder, name), contents[name])
