"""Commands of the program, run in this process."""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Optional, Union

from . import _native
from ._native import Camera, Dataset, Model

#: A path.
Path = Union[str, "os.PathLike[str]"]
#: A dataset's folder, ``builtin`` or ``builtin:NAME``, or photographs in memory.
Data = Union[Path, Dataset]

#: Stands for a dataset in memory among arguments.
_IN_MEMORY = "memory:"


class PocketnerfWarning(UserWarning):
    """Something that may spoil a result: what was found, what was expected, what to do."""


@dataclass(frozen=True)
class Progress:
    """How far work is."""

    phase: str
    """What is being done, such as ``reading the images`` or ``training``."""
    step: int = 0
    """Steps, pictures or the like that are done."""
    steps: Optional[int] = None
    """Of so many; ``None`` while that is not known."""
    train_psnr: Optional[float] = None
    """PSNR of the training rays lately, dB."""
    held_out_psnr: Optional[float] = None
    """PSNR of the views that are held out, when they were last looked at, dB."""
    restarts: int = 0
    """How often the run began anew."""


OnProgress = Callable[[Progress], object]


def arguments(command: str, places: Sequence[str], options: Mapping[str, Any]) -> list[str]:
    """A command line: names of options with underscores in place of dashes.

    ``None`` and ``False`` leave an option out, ``True`` gives it without a value. A sequence gives an
    option several times where that is possible; else it becomes values with commas between them.
    """
    known = _native.options(command)
    found = [command, *places]
    for name, value in options.items():
        option = name.replace("_", "-")
        if option not in known:
            names = ", ".join(sorted(known)).replace("-", "_")
            raise TypeError(f"{command}: there is no option {name!r}; there are {names}")
        if value is None or value is False:
            continue
        if value is True:
            found.append(f"--{option}")
            continue
        parts = [value] if isinstance(value, (str, int, float, os.PathLike)) else list(value)
        texts = [os.fspath(part) if isinstance(part, os.PathLike) else str(part) for part in parts]
        if known[option] != "values":
            texts = [",".join(texts)]
        # With an equals sign, so that negative numbers are values.
        found.extend(f"--{option}={text}" for text in texts)
    return found


def run(
    command: str,
    places: Sequence[Union[Path, Dataset]],
    options: Mapping[str, Any],
    *,
    threads: Optional[int] = None,
    on_progress: Optional[OnProgress] = None,
    progress: Optional[bool] = None,
) -> dict[str, Any]:
    """Runs a command; returns what the program prints with ``--json``."""
    datasets = [place for place in places if isinstance(place, Dataset)]
    names = [_IN_MEMORY if isinstance(place, Dataset) else os.fspath(place) for place in places]
    with _bar(progress) as bar:
        reported = [report for report in (on_progress, bar) if report is not None]
        return _native.run(
            arguments(command, names, options),
            datasets[0] if datasets else None,
            _Listener(reported).hear,
            threads,
        )


class _Listener:
    """Passes on what a command says."""

    def __init__(self, reported: Sequence[OnProgress]) -> None:
        self._reported = reported
        self._phase = ""

    def hear(self, kind: str, facts: Mapping[str, Any]) -> None:
        if kind == "warning":
            # Where the caller's own code is: train() and its like are three frames above.
            warnings.warn(facts["warning"], PocketnerfWarning, stacklevel=4)
            return
        self._phase = facts.get("phase", self._phase)
        at = Progress(**{**facts, "phase": self._phase})
        for report in self._reported:
            report(at)


def bars(wanted: Optional[bool]) -> Any:
    """The bars of tqdm, or ``None``; without a wish, where there is tqdm and somebody sees them."""
    if wanted is False or (wanted is None and not (sys.stderr and sys.stderr.isatty())):
        return None
    try:
        return importlib.import_module("tqdm.auto").tqdm
    except ImportError:
        if wanted:
            raise ImportError("progress=True: no tqdm, expected it; pip install tqdm") from None
        return None


@contextmanager
def _bar(wanted: Optional[bool]) -> Iterator[Optional[OnProgress]]:
    tqdm = bars(wanted)
    if tqdm is None:
        yield None
        return
    bar = tqdm(unit="step", leave=False)

    def report(at: Progress) -> None:
        bar.set_description(at.phase, refresh=False)
        bar.total = at.steps
        bar.n = at.step
        if at.train_psnr is not None:
            bar.set_postfix_str(f"{at.train_psnr:.2f} dB", refresh=False)
        bar.refresh()

    try:
        yield report
    finally:
        bar.close()


@contextmanager
def model_file(model: Union[Path, Model]) -> Iterator[str]:
    """The file of a model, for as long as a command needs it."""
    if not isinstance(model, Model):
        yield os.fspath(model)
        return
    with tempfile.TemporaryDirectory(prefix="pocketnerf-") as folder:
        path = os.path.join(folder, "model.pnerf")
        with open(path, "wb") as file:
            file.write(model.to_bytes())
        yield path


def load_cameras(path: Path, split: str = "train") -> list[Camera]:
    """The cameras of a dataset: COLMAP, nerfstudio, Blender and whatever else ``train`` reads.

    What bends the rays of a lens is left out: a picture of such a camera is straight.

    >>> len(load_cameras("photographs"))
    48
    """
    return Dataset.load(path).cameras(split)
