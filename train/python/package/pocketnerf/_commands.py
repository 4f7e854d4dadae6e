"""The program's other commands."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import TYPE_CHECKING, Any, Optional, Union

from ._native import Error, Interrupted, Model
from ._run import Data, OnProgress, Path, arguments, model_file, run

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import Color, EvaluateOptions

#: Exit status of a program that Ctrl-C ended.
_INTERRUPTED = 130


def evaluate(
    model: Union[Path, Model],
    data: Data,
    *,
    split: str = "test",
    background: Optional[Color] = None,
    threads: Optional[int] = None,
    on_progress: Optional[OnProgress] = None,
    **options: Unpack[EvaluateOptions],
) -> dict[str, Any]:
    """Compares pictures of a model with the photographs of a split: ``train``, ``val`` or ``test``.

    Returns what ``pocketnerf eval --json`` prints: ``psnr`` (dB, the mean over views), ``psnr_min``,
    ``worst_view``, ``ssim``, ``per_view``, ``seconds_per_frame`` and so on.

    >>> evaluate("model.pnerf", "photographs")["views"]
    3
    """
    with model_file(model) as path:
        found = {"split": split, "background": background, **options}
        places = [path, data]
        result = run("eval", places, found, threads=threads, on_progress=on_progress)
    if isinstance(model, Model):
        result["model"] = None
    return result


def convert(
    source: Path, out: Path, *, threads: Optional[int] = None, **options: Any
) -> dict[str, Any]:
    """Makes a ``.pnerf`` model of another program's checkpoint, or writes a model in another
    precision; options are those of ``pocketnerf convert``.
    """
    return run("convert", [source, out], options, threads=threads)


def export(
    model: Union[Path, Model],
    *,
    mesh: Optional[Path] = None,
    points: Optional[Path] = None,
    threads: Optional[int] = None,
    on_progress: Optional[OnProgress] = None,
    **options: Any,
) -> dict[str, Any]:
    """Writes the surface of a model: a mesh (``.glb``, ``.obj`` or ``.ply``) or points (``.ply``), in
    the dataset's coordinates and units; options are those of ``pocketnerf export``, such as
    ``triangles=30_000`` and ``texture=True``, or ``texture=1024`` texels a side.
    """
    with model_file(model) as path:
        found = {"mesh": mesh, "points": points, **options}
        return run("export", [path], found, threads=threads, on_progress=on_progress)


def info(path: Path, **options: Any) -> dict[str, Any]:
    """What is in a model file, a checkpoint or a dataset; of a dataset also what training on it
    costs, and in ``warnings`` what is suspicious.

    >>> info("model.pnerf")["method"]
    'hash-grid'
    """
    return run("info", [path], options)


def repack(
    source: Path, out: Path, *, max_bytes: Optional[int] = None, **options: Any
) -> dict[str, Any]:
    """Packs a model: the same pictures from fewer bytes; with ``max_bytes`` nearly the same from at
    most so many.
    """
    return run("repack", [source, out], {"max_bytes": max_bytes, **options})


def unpack(source: Path, out: Path) -> dict[str, Any]:
    """Unpacks a model to an ordinary file, which is read in place."""
    return run("unpack", [source, out], {})


def chart(*data: Path, out: Path, **options: Any) -> dict[str, Any]:
    """Charts accuracy against speed, as ``pocketnerf chart`` does in a process of its own, and
    returns what it prints with ``--json``. What is measured already is kept in the folder ``out``.
    """
    return _in_process("chart", data, {"out": out, **options})


def stress(*data: Path, out: Path, **options: Any) -> dict[str, Any]:
    """Tests where radiance fields fail, as ``pocketnerf stress`` does in a process of its own, and
    returns what it prints with ``--json``. What is measured already is kept in the folder ``out``.
    """
    return _in_process("stress", data, {"out": out, **options})


def _in_process(command: str, data: tuple[Path, ...], options: dict[str, Any]) -> dict[str, Any]:
    places = [os.fspath(place) for place in data]
    line = [sys.executable, "-m", "pocketnerf", *arguments(command, places, options), "--json"]
    # The child hears Ctrl-C too, and says when it has stopped.
    with subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        try:
            output, errors = child.communicate()
        except KeyboardInterrupt:
            output, errors = child.communicate()
    lines = errors.strip().splitlines()
    said = lines[-1].removeprefix("pocketnerf: ") if lines else f"exit status {child.returncode}"
    if child.returncode == _INTERRUPTED:
        raise Interrupted(said)
    if child.returncode == 2:
        raise ValueError(lines[0].removeprefix("error: ") if lines else said)
    if child.returncode != 0:
        raise Error(said)
    result: dict[str, Any] = json.loads(output)
    return result
