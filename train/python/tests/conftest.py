"""What all tests need."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

import pocketnerf

REPOSITORY = Path(__file__).parents[3]
DEMO = REPOSITORY / "embed-demo" / "still-life.pnerf"


@pytest.fixture(scope="session")
def demo() -> Path:
    """A model file of the built-in still life."""
    return DEMO


@pytest.fixture(scope="session")
def model(demo: Path) -> pocketnerf.Model:
    return pocketnerf.Model.open(demo)


@pytest.fixture(scope="session")
def views() -> tuple[np.ndarray, list[pocketnerf.Camera]]:
    """48 views of white bodies, of 50x50 pixels."""
    dataset = pocketnerf.Dataset.load("builtin:white", downscale_factor=8)
    return np.stack(dataset.images()[:48]), dataset.cameras()[:48]


@pytest.fixture(scope="session")
def photographs(
    views: tuple[np.ndarray, list[pocketnerf.Camera]], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """The same as a folder, with three of them for the split `test`, too."""
    folder = tmp_path_factory.mktemp("data") / "photographs"
    for split, numbers in (("train", range(48)), ("test", range(0, 48, 16))):
        (folder / split).mkdir(parents=True)
        frames = []
        for number in numbers:
            camera = views[1][number]
            pocketnerf.write_png(folder / split / f"{number:03}.png", views[0][number])
            frames.append(
                {
                    "file_path": f"{split}/{number:03}",
                    "transform_matrix": camera.camera_to_world.tolist(),
                }
            )
        listed = {"camera_angle_x": views[1][0].fov_x, "frames": frames}
        (folder / f"transforms_{split}.json").write_text(json.dumps(listed))
    return folder


def python(*arguments: object) -> str:
    """Standard output of another Python, which finds the package where it is installed."""
    line = [sys.executable, *map(str, arguments)]
    # Python looks into its folder first, and that of the sources has no compiled part.
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(line, check=False, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


def program(*arguments: object) -> str:
    """Standard output of the command line."""
    return python("-m", "pocketnerf", *arguments)
