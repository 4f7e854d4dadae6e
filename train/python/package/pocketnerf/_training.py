"""Training."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Optional

from ._native import Error, Interrupted, Model
from ._run import Data, OnProgress, Path, run

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import TrainOptions


@dataclass(frozen=True)
class Training:
    """A finished run."""

    figures: dict[str, Any]
    """What ``pocketnerf train --json`` prints: ``seconds, steps, train_psnr, held_out_psnr, bytes,
    peak_memory_bytes`` and so on."""
    path: Optional[str]
    """The model file; ``None`` if the model is in memory alone."""
    _bytes: Optional[bytes] = field(default=None, repr=False)

    @cached_property
    def model(self) -> Model:
        """The model, open. What ``method="llff"``, ``"srn"`` and ``"neural-volumes"`` train is no
        model: ``evaluate`` and ``render`` take its file."""
        return Model.open(self.path if self._bytes is None else self._bytes)  # type: ignore[arg-type]

    @property
    def warnings(self) -> list[str]:
        """What may spoil the result, a line each."""
        return list(self.figures["warnings"])


def train(
    data: Data,
    out: Optional[Path] = None,
    *,
    seconds: Optional[float] = None,
    steps: Optional[int] = None,
    seed: Optional[int] = None,
    resume: Optional[Path] = None,
    save_every: Optional[float] = None,
    threads: Optional[int] = None,
    on_progress: Optional[OnProgress] = None,
    progress: Optional[bool] = None,
    **options: Unpack[TrainOptions],
) -> Training:
    """Trains a model on photographs with known cameras.

    Other threads of Python go on meanwhile. Ctrl-C saves a checkpoint and raises
    :class:`Interrupted`, whose ``checkpoint`` is its path.

    :param data: a dataset's folder (COLMAP, nerfstudio, Blender, LLFF and others), ``"builtin"`` or
        ``"builtin:NAME"``, or a :class:`Dataset` in memory.
    :param out: the model file to write. Without it the model is in memory alone.
    :param seconds: wall time from the call to the finished model (default: 120).
    :param steps: trains so many steps instead: the same bytes on any number of threads.
    :param seed: of random numbers (default: 0).
    :param resume: a checkpoint to go on from, with the same data; its settings are used again.
    :param save_every: seconds from one checkpoint to the next. It lies beside ``out``:
        ``scene.ckpt.pnerf`` beside ``scene.pnerf``.
    :param threads: number of threads (default: all cores).
    :param on_progress: is called with a :class:`Progress` a few times a second, in this thread. What
        it raises ends the run, which saves a checkpoint, and is raised again.
    :param progress: whether to show a bar of tqdm (default: if it is installed and standard error
        is a terminal).
    :param options: the other options of ``pocketnerf train``, with underscores in place of dashes:
        ``max_bytes=500_000``, ``refine_poses=True``, ``aabb=(-1, -1, -1, 1, 1, 1)``.

    >>> training = train("photographs", steps=60, seed=1)
    >>> training.figures["steps"]
    60
    """
    given: dict[str, Any] = {
        "seconds": seconds,
        "steps": steps,
        "seed": seed,
        "resume": resume,
        "save_every": save_every,
        **options,
    }
    how: dict[str, Any] = {"threads": threads, "on_progress": on_progress, "progress": progress}
    if out is not None:
        path = os.fspath(out)
        return Training(run("train", [data], {**given, "out": path}, **how), path)
    # What the user goes on from, if the run is stopped, must stay.
    folder = tempfile.mkdtemp(prefix="pocketnerf-")
    path = os.path.join(folder, "model.pnerf")
    saved = None
    try:
        figures = run("train", [data], {**given, "out": path}, **how)
        with open(path, "rb") as file:
            return Training({**figures, "out": None}, None, file.read())
    except BaseException as error:
        saved = getattr(error, "checkpoint", None)
        raise
    finally:
        for name in os.listdir(folder):
            if os.path.join(folder, name) != saved:
                os.remove(os.path.join(folder, name))
        if saved is None:
            os.rmdir(folder)


__all__ = ["Error", "Interrupted", "Training", "train"]
