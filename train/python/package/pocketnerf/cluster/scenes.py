"""Trains many scenes: a task each."""

from __future__ import annotations

import json
import os
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple, Union

import pocketnerf
import ray
from pocketnerf import Dataset, Error

from . import driver, files
from .driver import Job
from .progress import OnProgress
from .table import Row, Table
from .worker import Outcome, Task

Data = Union[files.Path, Dataset]
Scene = Union[Data, Tuple[Data, Mapping[str, Any]]]

WORKER = 200_000_000
"""Bytes that Python and Ray take in a worker."""
RUN = 400_000_000
"""Bytes that a run takes beside its photographs, about, with the default options."""
UNSEEN = 2_000_000_000
"""Bytes for data that the driver does not see."""

READING = ("downscale_factor", "hold_every", "spherify")
"""Options of training that evaluation needs to compare with the same photographs."""
_NOT_SHARED = {"out", "resume", "view", "json", "quiet", "threads", "help"}
"""Options of training that the cluster sets itself, or that make no sense there."""
_FIGURES = (
    "seconds",
    "steps",
    "bytes",
    "train_psnr",
    "held_out_psnr",
    "held_out_psnr_min",
    "restarts",
    "seed",
    "peak_memory_bytes",
)
_SCORES = ("psnr", "psnr_min", "worst_view", "ssim")


def train_many(
    scenes: Mapping[str, Scene],
    out: files.Path,
    *,
    num_cpus: float = 2,
    seconds: Optional[float] = None,
    steps: Optional[int] = None,
    max_retries: int = 3,
    memory: Optional[int] = None,
    storage: Optional[files.Path] = None,
    evaluate: Optional[str] = None,
    save_every: float = 30.0,
    on_progress: Optional[OnProgress] = None,
    progress: Optional[bool] = None,
    address: Optional[str] = None,
    **options: Any,
) -> Table:
    """Trains a model of each scene, as ``pocketnerf.train`` does, on the nodes of a Ray cluster.

    A scene is one task. If its worker or node is lost, it goes on elsewhere from its last
    checkpoint. With ``steps`` and the same ``seed`` its model has the same bytes as one that is
    trained alone on one machine, on any node and after any loss.

    Models are written to ``out/NAME.pnerf`` and the table to ``out/results.csv`` on the driver's
    machine, each as soon as it is there. The same call again skips scenes that are done, so it
    continues after an interruption, and tries those that failed once more.

    Args:
        scenes: name -> data, or name -> (data, the scene's own options of ``pocketnerf.train``).
            Data is a path that all nodes see, ``"builtin:NAME"`` or a ``pocketnerf.Dataset``.
            A name is that of the model file.
        out: folder on the driver's machine.
        num_cpus: cores of a task, and its threads.
        seconds, steps: length of training, as for ``pocketnerf.train``.
        max_retries: how often a scene may lose its worker. Only losses count, not errors.
        memory: bytes that a task needs. Default: what ``pocketnerf.info`` estimates for a folder
            that the driver sees; from the number of pixels for a Dataset; else 2 GB.
        storage: folder that all nodes see, for checkpoints, which then survive the driver. Use
            one for each ``out``. Default: the object store of the driver's node.
        evaluate: ``"val"`` or ``"test"``: also compares each model with these views.
        save_every: seconds between two checkpoints: the most work that a loss costs.
        on_progress: called as ``on_progress(name, progress)`` about once a second for each scene
            under way, with the ``progress`` of ``pocketnerf.train``. An exception ends the run.
        progress: shows a bar (tqdm). Default: if tqdm is there and stderr is a terminal.
        address: the cluster's, as for ``ray.init``, where Ray is not initialised yet. Default:
            the cluster of this machine if one runs, else this machine alone.
        options: further options of ``pocketnerf.train``, for all scenes.

    Returns:
        A row for each scene, in the order of ``scenes``: ``name``, ``status`` ("trained",
        "skipped" or "failed"), ``error``, ``attempts``, ``resumed_at_step`` (0: from the start),
        ``node``, figures of training (``seconds``, ``steps``, ``bytes``, ``train_psnr`` in dB,
        ...), with ``evaluate`` also ``split``, ``psnr``, ``psnr_min`` (the worst view), ``ssim``,
        and ``warnings`` and ``options``.

    Raises:
        pocketnerf.Error: nothing can start: a name is no file name, or ``out`` has a model of
            the same name with other options. Afterwards a scene's error is in its row, and the
            others go on.
        TypeError: an option is unknown.

    Example:
        >>> from pocketnerf.cluster import train_many
        >>> table = train_many({"ball": "builtin:white"}, "models", steps=500)  # doctest: +SKIP
        >>> table[0]["status"], table[0]["attempts"]  # doctest: +SKIP
        ('trained', 1)
    """
    shared = {"seconds": seconds, "steps": steps, "save_every": save_every, **options}
    runs = [run_of(name, scene, shared, evaluate) for name, scene in scenes.items()]
    return train(
        runs,
        out,
        memory=memory,
        num_cpus=num_cpus,
        max_retries=max_retries,
        storage=None if storage is None else os.fspath(storage),
        on_progress=on_progress,
        progress=progress,
        address=address,
    )


class Run(NamedTuple):
    """A scene with all that matters to its model."""

    name: str
    data: Data
    options: Dict[str, Any]
    evaluate: Optional[str]

    def key(self) -> str:
        """Tells in the table what a model was made of."""
        data = f"Dataset {self.data.name}" if isinstance(self.data, Dataset) else str(self.data)
        options = {key: value for key, value in self.options.items() if key != "save_every"}
        return json.dumps(
            {"data": data, "evaluate": self.evaluate, **options}, sort_keys=True, default=str
        )


def run_of(name: str, scene: Scene, shared: Mapping[str, Any], evaluate: Optional[str]) -> Run:
    data, own = scene if isinstance(scene, tuple) else (scene, {})
    options = {key: value for key, value in {**shared, **own}.items() if value is not None}
    known = pocketnerf._native.options("train")
    for option in options:
        if option in _NOT_SHARED or option.replace("_", "-") not in known:
            raise TypeError(
                f"scene {name!r}: found the option {option!r}, expected those of pocketnerf.train "
                "that say how a model is trained; leave it out"
            )
    if evaluate not in (None, "val", "test"):
        raise Error(f"evaluate: found {evaluate!r}, expected 'val', 'test' or None")
    data = data if isinstance(data, Dataset) else files.everywhere(data)
    return Run(name, data, options, evaluate)


def train(runs: List[Run], out: files.Path, *, memory: Optional[int], **how: Any) -> Table:
    """Does the runs that are not done, and gives the table of all."""
    files.check_names(run.name for run in runs)
    folder = files.make_folder(out)
    results = os.path.join(folder, "results.csv")
    earlier = _earlier(results)
    rows: Dict[str, Row] = {}
    for run in runs:
        row = earlier.get(run.name)
        if row is not None and os.path.exists(_model(folder, run.name)):
            if row.get("options") != run.key():
                raise Error(
                    f"{_model(folder, run.name)}: found a model of {row.get('options')}, expected "
                    f"one of {run.key()}; choose another folder, or delete the model"
                )
            rows[run.name] = {**row, "status": "skipped"}
    left = {run.name: run for run in runs if run.name not in rows}

    def finished(outcomes: Dict[str, Outcome]) -> None:
        for name, outcome in outcomes.items():
            if "model" in outcome.files:
                files.write(_model(folder, name), outcome.files["model"])
            rows[name] = _row(left[name], outcome)
        _table(runs, rows, earlier).to_csv(results)

    if left:
        driver.connect(how["address"])
        jobs = _jobs(list(left.values()), memory)
        driver.run(jobs, _train, finished, unit="scene", **how)
    table = Table([rows[run.name] for run in runs])
    _table(runs, rows, earlier).to_csv(results)
    return table


def _table(runs: List[Run], rows: Dict[str, Row], earlier: Dict[str, Row]) -> Table:
    """What is known of all scenes in the folder, also of those of other calls."""
    known = {**rows, **{name: row for name, row in earlier.items() if name not in rows}}
    order = [run.name for run in runs if run.name in known]
    return Table([known[name] for name in dict.fromkeys([*order, *known])])


def _earlier(results: str) -> Dict[str, Row]:
    """Rows of models that an earlier call has trained."""
    try:
        table = Table.read_csv(results)
    except FileNotFoundError:
        return {}
    return {row["name"]: row for row in table if row.get("status") in ("trained", "skipped")}


def _model(folder: str, name: str) -> str:
    return os.path.join(folder, f"{name}.pnerf")


def _row(run: Run, outcome: Outcome) -> Row:
    found = outcome.row
    row: Row = {
        "name": run.name,
        "status": "failed" if found.get("error") else "trained",
        "error": found.get("error"),
        "attempts": found["attempts"],
        "resumed_at_step": found.get("resumed_at_step"),
        "node": found.get("node"),
    }
    row.update({figure: found.get(figure) for figure in _FIGURES})
    if run.evaluate is not None:
        row["split"] = run.evaluate
        row.update({score: found.get(score) for score in _SCORES})
    row["warnings"] = found.get("warnings")
    row["options"] = run.key()
    return row


def _jobs(runs: List[Run], memory: Optional[int]) -> List[Job]:
    stored: Dict[int, Any] = {}
    jobs = []
    for run in runs:
        data: Any = run.data
        if isinstance(data, Dataset):
            # One copy in the store, however many scenes use it.
            if id(data) not in stored:
                stored[id(data)] = ray.put(data)
            data = stored[id(data)]
        arguments = {"data": data, "options": run.options, "evaluate": run.evaluate}
        jobs.append(Job(run.name, arguments, _estimate(run.data, memory)))
    return jobs


def _estimate(data: Data, memory: Optional[int]) -> Callable[[], int]:
    """Tells how many bytes a task needs."""

    def estimate() -> int:
        if memory is not None:
            return memory
        if isinstance(data, Dataset):
            pixels = sum(camera.width * camera.height for camera in data.cameras())
            # As it comes from the store, and as training reads it.
            return WORKER + RUN + 2 * 4 * pixels
        if str(data).split(":")[0] == "builtin":
            return WORKER + RUN
        if not os.path.isdir(data):
            return UNSEEN
        try:
            return WORKER + int(pocketnerf.info(data)["cost"]["memory_bytes"])
        except Exception:  # What is wrong with it, training will say.
            return UNSEEN

    return estimate


def _train(task: Task, data: Any, options: Dict[str, Any], evaluate: Optional[str]) -> Outcome:
    """Runs on a node."""
    model = os.path.join(task.folder, "scene.pnerf")
    checkpoint = os.path.join(task.folder, "scene.ckpt.pnerf")
    resumed = 0
    if task.restore(checkpoint):
        resumed = pocketnerf.info(checkpoint)["checkpoint"]["step"]
    try:
        training = pocketnerf.train(
            data,
            model,
            resume=checkpoint if resumed else None,
            threads=task.threads,
            progress=False,
            on_progress=lambda progress: task.watch(progress, checkpoint),
            **options,
        )
    except pocketnerf.Interrupted:
        task.keep(checkpoint)
        raise
    figures = training.figures
    row = {key: figures.get(key) for key in _FIGURES}
    row["resumed_at_step"] = resumed
    row["warnings"] = "; ".join(training.warnings) or None
    if evaluate is not None:
        reading = {key: options[key] for key in READING if key in options}
        scores = pocketnerf.evaluate(model, data, split=evaluate, threads=task.threads, **reading)
        row.update({key: scores.get(key) for key in _SCORES})
    return Outcome(row, {"model": files.read(model)})
