"""Training: the same bytes as the command line, whatever interrupts it."""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import subprocess
import sys
import threading
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cluster_scenes
import pocketnerf
from conftest import program

#: A run of a second or two.
SMALL: dict[str, Any] = {"steps": 120, "seed": 5, **cluster_scenes.SMALL}

pytestmark = pytest.mark.filterwarnings("ignore::pocketnerf.PocketnerfWarning")


@pytest.fixture(scope="module")
def trained(photographs: Path, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The model that the command line trains."""
    out = tmp_path_factory.mktemp("trained") / "model.pnerf"
    options = [f"--{name.replace('_', '-')}={value}" for name, value in SMALL.items()]
    program("train", photographs, "--out", out, "--quiet", *options)
    return out.read_bytes()


def test_the_model_is_that_of_the_command_line(
    trained: bytes, photographs: Path, tmp_path: Path
) -> None:
    seen: list[pocketnerf.Progress] = []
    out = tmp_path / "model.pnerf"
    training = pocketnerf.train(photographs, out, threads=1, on_progress=seen.append, **SMALL)
    assert out.read_bytes() == trained and training.path == str(out)
    assert training.model.to_bytes() == trained
    assert training.figures["steps"] == 120 and training.figures["threads"] == 1
    assert [at.phase for at in seen if at.step == 0] == [
        "reading the images",
        "finding the scene",
        "training",
        "finishing the model",
    ]
    steps = [at.step for at in seen if at.step > 0]
    assert steps == sorted(steps) and steps[-1] == 120 and {at.steps for at in seen if at.step > 0} == {120}
    # Without a file.
    training = pocketnerf.train(photographs, **SMALL)
    assert training.model.to_bytes() == trained and training.path is None
    assert any("only 120 steps" in warning for warning in training.warnings)


def test_warnings_are_pythons(photographs: Path) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pocketnerf.train(photographs, **SMALL)
    found = [warning for warning in caught if warning.category is pocketnerf.PocketnerfWarning]
    assert any("only 120 steps" in str(warning.message) for warning in found)
    assert {Path(warning.filename) for warning in found} == {Path(__file__)}


def test_what_a_callback_raises_is_raised_and_the_run_goes_on_later(
    trained: bytes, photographs: Path, tmp_path: Path
) -> None:
    out = tmp_path / "model.pnerf"

    def stop(at: pocketnerf.Progress) -> None:
        if at.step > 0:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough") as caught:
        pocketnerf.train(photographs, out, on_progress=stop, **SMALL)
    checkpoint = caught.value.checkpoint  # type: ignore[attr-defined]
    assert checkpoint == str(tmp_path / "model.ckpt.pnerf") and not out.exists()
    assert pocketnerf.info(checkpoint)["checkpoint"]["step"] < 120
    pocketnerf.train(photographs, out, resume=checkpoint, threads=2)
    assert out.read_bytes() == trained


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_saves_a_checkpoint(photographs: Path) -> None:
    asked = threading.Event()

    def interrupt(at: pocketnerf.Progress) -> None:
        if at.step > 0 and not asked.is_set():
            asked.set()
            threading.Timer(0.01, os.kill, (os.getpid(), signal.SIGINT)).start()

    # Whoever started this process in the background may have had it ignore Ctrl-C.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(pocketnerf.Interrupted, match="resume with train") as caught:
            pocketnerf.train(photographs, on_progress=interrupt, **{**SMALL, "steps": 5000})
    finally:
        signal.signal(signal.SIGINT, before)
    assert isinstance(caught.value, KeyboardInterrupt)
    checkpoint = caught.value.checkpoint
    assert checkpoint is not None and Path(checkpoint).is_file()
    assert 0 < pocketnerf.info(checkpoint)["checkpoint"]["step"] < 5000
    os.remove(checkpoint)
    os.rmdir(os.path.dirname(checkpoint))


def test_photographs_in_memory_train_the_same_model(
    trained: bytes, photographs: Path, views: tuple[np.ndarray, list[pocketnerf.Camera]]
) -> None:
    # A file's field of view has more digits than a camera.
    read = pocketnerf.Dataset.load(photographs)
    focal = [[camera.focal for camera in cameras] for cameras in (read.cameras(), views[1])]
    assert np.allclose(focal[0], focal[1], rtol=1e-6)
    dataset = pocketnerf.Dataset(read.images(), read.cameras(), name=read.name, names=read.names())
    assert pocketnerf.train(dataset, **SMALL).model.to_bytes() == trained
    pickled = pickle.loads(pickle.dumps(dataset))
    assert repr(pickled) == repr(dataset)
    assert pocketnerf.train(pickled, threads=1, **SMALL).model.to_bytes() == trained
    read = pickle.loads(pickle.dumps(read))
    assert pocketnerf.train(read, **SMALL).model.to_bytes() == trained


def test_models_are_scored_on_photographs_in_memory(
    trained: bytes, views: tuple[np.ndarray, list[pocketnerf.Camera]]
) -> None:
    images, cameras = views
    model = pocketnerf.Model.open(trained)
    dataset = pocketnerf.Dataset(images, cameras, test=[3, 4])
    scores = pocketnerf.evaluate(model, dataset, background="white")
    assert scores["views"] == 2 and len(scores["per_view"]) == 2
    for number, view in zip((3, 4), scores["per_view"]):
        alpha = images[number][..., 3:] / np.float32(255)
        truth = images[number][..., :3] * alpha + 255 * (1 - alpha)
        picture = model.render(cameras[number], background="white").astype(np.float64)
        error = np.mean((picture - np.rint(truth)) ** 2) / 255**2
        assert view["psnr"] == pytest.approx(-10 * np.log10(error), abs=0.05)


def test_python_goes_on_while_it_trains(photographs: Path) -> None:
    counted, done = [0], threading.Event()

    def count() -> None:
        while not done.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    try:
        before = counted[0]
        pocketnerf.train(photographs, **SMALL)
        during = counted[0] - before
    finally:
        done.set()
        thread.join()
    assert during > 10_000


def test_pictures_do_not_wait_for_training(model: pocketnerf.Model, photographs: Path) -> None:
    usual = pocketnerf.num_threads()
    pocketnerf.set_num_threads(1)

    def look(at: pocketnerf.Progress) -> None:
        if at.step > 0:
            model.render(width=20)
            raise RuntimeError("seen")

    try:
        # Training that kept the only thread would end before the picture is there.
        with pytest.raises(RuntimeError, match="seen") as caught:
            pocketnerf.train(photographs, on_progress=look, **{**SMALL, "steps": 2000})
    finally:
        pocketnerf.set_num_threads(usual)
    checkpoint = caught.value.checkpoint  # type: ignore[attr-defined]
    assert pocketnerf.info(checkpoint)["checkpoint"]["step"] < 2000
    shutil.rmtree(os.path.dirname(checkpoint))


def test_models_are_exported_and_packed(demo: Path, tmp_path: Path) -> None:
    mesh, points = tmp_path / "mesh.ply", tmp_path / "points.ply"
    with pocketnerf.Model.open(demo) as model:
        figures = pocketnerf.export(model, mesh=mesh, points=points, resolution=48)
    assert figures["triangles"] > 500 and mesh.read_bytes().startswith(b"ply")
    assert points.read_bytes().startswith(b"ply")
    small = tmp_path / "small.glb"
    figures = pocketnerf.export(demo, mesh=small, resolution=48, triangles=500, texture=256)
    assert figures["triangles"] <= 500 and figures["texture"]["size"] == 256
    assert b"image/png" in small.read_bytes()
    plain, packed = tmp_path / "plain.pnerf", tmp_path / "packed.pnerf"
    pocketnerf.unpack(demo, plain)
    pocketnerf.repack(plain, packed)
    assert packed.stat().st_size < plain.stat().st_size
    pictures = [pocketnerf.Model.open(path).render(width=40) for path in (demo, plain, packed)]
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])
    assert pocketnerf.info(plain)["method"] == "hash-grid"
    floats = tmp_path / "floats.pnerf"
    pocketnerf.convert(plain, floats, precision="f32")
    assert floats.stat().st_size > plain.stat().st_size


def test_charts_and_stress_tests_run_as_processes(demo: Path, tmp_path: Path) -> None:
    with pytest.raises(pocketnerf.Error, match="--modes nonsense"):
        pocketnerf.stress(out=tmp_path, modes="nonsense")
    with pytest.raises(pocketnerf.Error, match="nowhere"):
        pocketnerf.chart(tmp_path / "nowhere", out=tmp_path / "chart", models=demo)


def test_the_command_line_is_there(tmp_path: Path) -> None:
    assert program("--version").strip() == f"pocketnerf {pocketnerf.__version__}"
    line = [sys.executable, "-m", "pocketnerf"]
    for arguments, status, text in ((["--nonsense"], 2, "nonsense"), (["info", "nowhere"], 1, "nowhere: ")):
        done = subprocess.run([*line, *arguments], capture_output=True, text=True, check=False, cwd=tmp_path)
        assert done.returncode == status and text in done.stderr
