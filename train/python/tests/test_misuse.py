"""Whatever is wrong is an exception of one line, never a crash."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import pickle
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pocketnerf
from conftest import REPOSITORY, python

EYE = np.eye(4)


def camera(**changes: Any) -> pocketnerf.Camera:
    given: dict[str, Any] = {"width": 8, "height": 6, "camera_to_world": EYE, "fov_x": 1.0, **changes}
    return pocketnerf.Camera(**given)


def image(*shape: int, dtype: Any = np.uint8) -> np.ndarray:
    return np.zeros(shape, dtype)


MISUSES: list[tuple[type[BaseException], str, Callable[[pocketnerf.Model], object]]] = [
    (ValueError, "expected 1 to 16384", lambda m: camera(width=0)),
    (ValueError, "expected (4, 4) or (3, 4)", lambda m: camera(camera_to_world=np.eye(3))),
    (ValueError, "expected unit vectors", lambda m: camera(camera_to_world=2 * EYE - np.diag([0, 0, 0, 1]))),
    (ValueError, "position", lambda m: camera(camera_to_world=EYE + np.array([[0, 0, 0, np.nan]] + 3 * [[0] * 4]))),
    (TypeError, "expected fov_x", lambda m: camera(fov_x=None)),
    (TypeError, "one of them", lambda m: camera(focal=10)),
    (ValueError, "radians", lambda m: camera(fov_x=60.0)),
    (ValueError, "focal: shape (3,)", lambda m: camera(fov_x=None, focal=[1, 2, 3])),
    (ValueError, "opencv", lambda m: camera(convention="colmap")),
    (TypeError, "array of numbers", lambda m: camera(camera_to_world="eye")),
    (ValueError, "quality: 2", lambda m: m.render(quality=2)),
    (ValueError, "quality: NaN", lambda m: m.render(quality=float("nan"))),
    (ValueError, "dtype: float64", lambda m: m.render(dtype=np.float64)),
    (TypeError, "", lambda m: m.render(dtype="nonsense")),
    (ValueError, "background: \"red\"", lambda m: m.render(background="red")),
    (ValueError, "background: shape (4,)", lambda m: m.render(background=[0, 0, 0, 0])),
    (ValueError, "expected 0 to 1", lambda m: m.render(background=[0, 0, 300])),
    (ValueError, "one of them", lambda m: m.render(background="white", alpha=True)),
    (ValueError, "antialias: 0", lambda m: m.render(antialias=0)),
    (OverflowError, "", lambda m: m.render(width=-1)),
    (ValueError, "16384", lambda m: m.render(width=100_000)),
    (ValueError, "shape (8, 8, 4)", lambda m: m.render(width=8, height=8, out=image(8, 8, 4))),
    (ValueError, "dtype float32", lambda m: m.render(width=8, height=8, dtype="uint8", out=image(8, 8, 3, dtype=np.float32))),
    (ValueError, "dtype: float64", lambda m: m.render(width=8, height=8, out=image(8, 8, 3, dtype=float))),
    (ValueError, "strides", lambda m: m.render(width=8, height=8, out=image(8, 16, 3)[:, ::2])),
    (TypeError, "NumPy array", lambda m: m.render(width=8, height=8, out=[[0]])),
    (ValueError, "depth_out", lambda m: m.render(width=8, height=8, depth_out=image(8, 8))),
    (ValueError, "(..., 3)", lambda m: m.density([1, 2])),
    (ValueError, "(..., 3)", lambda m: m.density(3)),
    (TypeError, "points", lambda m: m.density("abc")),
    (TypeError, "points", lambda m: m.density([[1, 2, 3], [4, 5]])),
    (ValueError, "", lambda m: m.density([np.nan, 0, 0])),
    (ValueError, "", lambda m: m.radiance([0, 0, 0], [0, 0, 0])),
    (ValueError, "one shape", lambda m: m.radiance([0, 0, 0], [[0, 0, 1]] * 2)),
    (ValueError, "kind", lambda m: m.ray_depths([0, 0, 0], [0, 0, 1], kind="mean")),
    (ValueError, "threshold", lambda m: m.ray_depths([0, 0, 0], [0, 0, 1], kind="first_sigma")),
    (ValueError, "", lambda m: m.ray_depths([0, 0, 0], [0, 0, 1], kind="first_opacity", threshold=2)),
    (ValueError, "", lambda m: m.collision_probability([0, 0, 0], volume=-1, particle_area=1)),
    (ValueError, "", lambda m: m.sphere_clear([[0, 0, 0]] * 2, [1, 2, 3])),
    (ValueError, "distance", lambda m: m.orbit(0, distance=-1)),
    (FileNotFoundError, "nowhere.pnerf", lambda m: pocketnerf.Model.open("nowhere.pnerf")),
    (pocketnerf.ModelError, "", lambda m: pocketnerf.Model.open(b"")),
    (pocketnerf.ModelError, "", lambda m: pocketnerf.Model.open(np.zeros(100))),
    (pocketnerf.ModelError, "test_misuse.py", lambda m: pocketnerf.Model.open(__file__)),
    (TypeError, "path or the bytes", lambda m: pocketnerf.Model.open(3.5)),
    (ValueError, "one for each of 2 images", lambda m: pocketnerf.Dataset([image(6, 8, 3)] * 2, [camera()])),
    (ValueError, "(6, 8, 3 or 4)", lambda m: pocketnerf.Dataset([image(8, 6, 3)], [camera()])),
    (TypeError, "float32", lambda m: pocketnerf.Dataset([image(6, 8, 3, dtype=np.float32)], [camera()])),
    (ValueError, "mask", lambda m: pocketnerf.Dataset([image(6, 8, 3)], [camera()], masks=[image(6, 8)])),
    (ValueError, "no pixel counts", lambda m: pocketnerf.Dataset([image(6, 8, 3)], [camera()], masks=[image(6, 8, dtype=bool)])),
    (ValueError, "view 5", lambda m: pocketnerf.Dataset([image(6, 8, 3)], [camera()], test=[5])),
    (ValueError, "train on", lambda m: pocketnerf.Dataset([image(6, 8, 3)], [camera()], test=[0])),
    (ValueError, "largest", lambda m: pocketnerf.Dataset([image(6, 8, 3)], [camera()], aabb=[[1] * 3, [0] * 3])),
    (ValueError, "no such split", lambda m: pocketnerf.Dataset([image(6, 8, 3)], [camera()]).images("val")),
    (pocketnerf.DatasetError, "no such folder", lambda m: pocketnerf.Dataset.load("nowhere")),
    (pocketnerf.DatasetError, "no such folder", lambda m: pocketnerf.train("nowhere", steps=1)),
    (TypeError, "there is no option 'colour'", lambda m: pocketnerf.train("builtin", steps=1, colour="red")),
    (ValueError, "max-bytes", lambda m: pocketnerf.train("builtin", steps=1, max_bytes="many")),
    (ValueError, "cannot be used with", lambda m: pocketnerf.train("builtin", steps=1, seconds=1)),
    (ValueError, "1 to 1024", lambda m: pocketnerf.train("builtin", steps=1, threads=0)),
    (ValueError, "1 to 1024", lambda m: pocketnerf.set_num_threads(0)),
    (pocketnerf.Error, "nowhere", lambda m: pocketnerf.evaluate("nowhere.pnerf", "builtin")),
    (pocketnerf.DatasetError, "memory: no test images: it has train", lambda m: pocketnerf.evaluate(m, pocketnerf.Dataset([image(6, 8, 3)], [camera()]))),
    (TypeError, "there is no option 'json'", lambda m: pocketnerf.train("builtin", steps=1, json=True)),
    (OSError, "/nowhere does not exist", lambda m: m.save("/nowhere/model.pnerf")),
    (OSError, "this is a folder", lambda m: pocketnerf.write_png(".", image(3, 3, 3))),
    (ValueError, "height, width", lambda m: pocketnerf.write_png("x.png", image(3, 3))),
]


@pytest.mark.parametrize("number", range(len(MISUSES)))
def test_misuse_is_refused(model: pocketnerf.Model, number: int) -> None:
    kind, text, misuse = MISUSES[number]
    with pytest.raises(kind) as caught:
        misuse(model)
    line = str(caught.value)
    assert text in line and "\n" not in line, line


def test_arrays_that_are_read_only_are_refused(model: pocketnerf.Model) -> None:
    out = image(8, 8, 3)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="writable"):
        model.render(width=8, height=8, out=out)
    # The same memory twice.
    both = np.zeros((8, 8, 3), np.float32)
    with pytest.raises(ValueError, match="borrow"):
        model.render(width=8, height=8, out=both, depth_out=both.reshape(-1)[:64].reshape(8, 8))


def test_closed_models_answer_nothing(demo: Path) -> None:
    with pocketnerf.Model.open(demo) as model:
        assert not model.closed
    assert model.closed and repr(model) == "Model(closed)"
    for use in (model.render, model.to_bytes, lambda: model.density([0, 0, 0]), lambda: pickle.dumps(model)):
        with pytest.raises(ValueError, match="closed"):
            use()
    model.close()


def test_models_and_cameras_can_be_pickled(model: pocketnerf.Model) -> None:
    same = pickle.loads(pickle.dumps(model))
    assert same.to_bytes() == model.to_bytes()
    view = model.orbit(0.7, 0.2, width=40, height=30)
    assert pickle.loads(pickle.dumps(view)) == view != model.camera
    assert np.array_equal(same.render(view), model.render(view))


def test_threads_share_a_model(model: pocketnerf.Model) -> None:
    views = [model.orbit(angle, width=40, height=40) for angle in np.linspace(0, 6, 12)]
    expected = [model.render(view) for view in views]
    with concurrent.futures.ThreadPoolExecutor(6) as threads:
        for found, wanted in zip(threads.map(model.render, views * 4), expected * 4):
            assert np.array_equal(found, wanted)


def _child(model: pocketnerf.Model, queue: Any) -> None:
    queue.put((model.render(width=32, height=32).sum(), pocketnerf.num_threads()))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_forked_processes_render(model: pocketnerf.Model) -> None:
    expected = model.render(width=32, height=32).sum()
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_child, args=(model, queue))
    child.start()
    assert queue.get(timeout=60) == (expected, pocketnerf.num_threads())
    child.join(60)
    assert child.exitcode == 0


def test_the_number_of_threads_can_be_set(model: pocketnerf.Model) -> None:
    usual, picture = pocketnerf.num_threads(), model.render(width=50, height=50)
    try:
        for n in (1, 3):
            pocketnerf.set_num_threads(n)
            assert pocketnerf.num_threads() == n
            assert np.array_equal(model.render(width=50, height=50), picture)
    finally:
        pocketnerf.set_num_threads(usual)


def test_damaged_files_are_refused() -> None:
    """10,000 files with bytes that are changed, cut off or doubled, of all golden files."""
    golden = sorted((REPOSITORY / "tests" / "golden").glob("**/*.pnerf"), key=lambda path: path.stat().st_size)
    files = [path.read_bytes() for path in golden if path.stat().st_size < 40_000]
    assert len(files) >= 3
    chance, opened = random.Random(7), 0
    for number in range(10_000):
        bytes_ = bytearray(files[number % len(files)])
        for _ in range(chance.randint(1, 4)):
            kind, at = chance.randrange(4), chance.randrange(len(bytes_) or 1)
            if kind == 0:
                bytes_[at : at + 1] = bytes([chance.randrange(256)])
            elif kind == 1:
                bytes_[at : at + 4] = chance.randbytes(4)
            elif kind == 2:
                del bytes_[at:]
            else:
                bytes_[at:at] = bytes_[: chance.randrange(64)]
        try:
            model = pocketnerf.Model.open(bytes_)
        except pocketnerf.ModelError as error:
            assert "\n" not in str(error)
            continue
        opened += 1
        model.render(width=4, height=4)
    # A change may restore what was there.
    assert opened < 100


def test_a_missing_package_is_named() -> None:
    """Neither Ray nor anywidget is needed to import the package."""
    script = """
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("ray", "anywidget", "tqdm", "PIL"):
            raise ImportError(f"no {name}")
sys.meta_path.insert(0, Missing())
import pocketnerf
print(pocketnerf.__version__)
"""
    assert python("-c", script).strip() == pocketnerf.__version__
