"""What is written: examples run, types and options are those that there are."""

from __future__ import annotations

import doctest
import inspect
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy
import pytest

import pocketnerf
from conftest import REPOSITORY
from pocketnerf import _native, _options

PUBLIC = [getattr(pocketnerf, name) for name in pocketnerf.__all__ if not name.startswith("_")]
MEMBERS = [
    member
    for thing in PUBLIC
    if inspect.isclass(thing)
    for name, member in vars(thing).items()
    if not name.startswith("_") and getattr(member, "__doc__", None)
]
THINGS = [thing for thing in [pocketnerf, *PUBLIC, *MEMBERS] if not isinstance(thing, str)]


@pytest.mark.filterwarnings("ignore::pocketnerf.PocketnerfWarning")
def test_examples_run(
    demo: Path, photographs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(demo, "model.pnerf")
    shutil.copytree(photographs, "photographs")
    names = {**vars(pocketnerf), "numpy": numpy, "model": pocketnerf.Model.open("model.pnerf")}
    parser, runner, tried = doctest.DocTestParser(), doctest.DocTestRunner(), 0
    for thing in THINGS:
        where = getattr(thing, "__qualname__", getattr(thing, "__name__", "?"))
        test = parser.get_doctest(inspect.getdoc(thing) or "", dict(names), where, None, None)
        assert runner.run(test).failed == 0, where
        tried += len(test.examples)
    assert tried > 25


def test_everything_says_what_it_is() -> None:
    for thing in THINGS:
        if not isinstance(thing, (int, float)):
            assert inspect.getdoc(thing), thing
    for function in ("render", "depth", "normals", "density", "radiance", "ray_depths"):
        text = inspect.getdoc(getattr(pocketnerf.Model, function)) or ""
        assert "shape" in text and ("unit" in text or "sRGB" in text), function
    # Signatures are seen by help().
    assert "quality" in inspect.signature(pocketnerf.Model.render).parameters


def test_keywords_are_the_options_that_there_are() -> None:
    # What Python says otherwise, and what programs with a window have.
    hosts = {"threads", "view"}
    cases = (
        ("train", _options.TrainOptions, pocketnerf.train),
        ("eval", _options.EvaluateOptions, pocketnerf.evaluate),
    )
    for command, options, function in cases:
        known = {name.replace("-", "_") for name in _native.options(command)} - hosts
        explicit = set(inspect.signature(function).parameters)
        typed = set(options.__annotations__)
        # Without the feature `gpu` there is no choice of a device.
        typed -= {"device"} - known
        assert typed | (explicit & known) == known | (explicit & known), command
        assert not typed & explicit, command


def test_types_are_strict(tmp_path: Path) -> None:
    example = tmp_path / "example.py"
    blocks = re.findall(r"```python\n(.*?)```", (REPOSITORY / "docs" / "python.md").read_text(), re.S)
    assert len(blocks) >= 3
    example.write_text("\n".join(blocks))
    package = Path(pocketnerf.__file__).parent
    line = [sys.executable, "-m", "mypy", "--strict", "--python-version", "3.10", "--cache-dir", str(tmp_path)]
    done = subprocess.run([*line, str(package), str(example)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    line = [sys.executable, "-m", "mypy.stubtest", "pocketnerf._native", "--ignore-missing-stub"]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
