"""Small scenes in files, and functions that run on nodes, for the tests of the cluster."""

from __future__ import annotations

import json
import math
import os
import time
from pathlib import Path
from typing import Any

import numpy as np

import pocketnerf
from pocketnerf.cluster.worker import Outcome, Task

#: A model that trains in a second or two on one core.
SMALL: dict[str, Any] = {
    "space": "contracted",
    "log2_hashmap_size": 10,
    "n_levels": 4,
    "hidden_width": 8,
    "batch_rays": 32,
}


def write_ball(folder: Path, size: int = 24, views: int = 10) -> None:
    """A shaded ball before black, in Blender's format."""
    folder.mkdir()
    y, x = (np.mgrid[:size, :size] + 0.5 - size / 2) / (0.35 * size)
    inside = x * x + y * y < 1
    for split, count in [("train", views), ("val", 2), ("test", 2)]:
        frames = []
        for view in range(count):
            turn = 2 * math.pi * (view + 0.3 * (split != "train")) / count
            back = np.array([0.9 * math.cos(turn), 0.9 * math.sin(turn), math.sqrt(0.19)])
            right = np.cross([0, 0, 1], back) / np.linalg.norm(np.cross([0, 0, 1], back))
            pose = np.eye(4)
            pose[:3] = np.stack([right, np.cross(back, right), back, 4 * back], axis=1)
            image = np.zeros((size, size, 3), np.uint8)
            image[inside] = [200, 60, 30]
            image[..., 1] += ((90 + 60 * x * math.sin(turn)) * inside).astype(np.uint8)
            pocketnerf.write_png(folder / f"{split}{view}.png", image)
            frames.append({"file_path": f"{split}{view}", "transform_matrix": pose.tolist()})
        listed = {"camera_angle_x": 0.7, "frames": frames}
        (folder / f"transforms_{split}.json").write_text(json.dumps(listed))


def die(task: Task, when: int) -> Outcome:
    """Ends its worker in the first attempts, as a lack of memory does."""
    if task.attempt <= when:
        os._exit(1)
    return Outcome({"attempt": task.attempt}, {})


def nap(task: Task, seconds: float) -> Outcome:
    """Says when it ran."""
    begun = time.time()
    time.sleep(seconds)
    return Outcome({"begun": begun, "ended": time.time()}, {})
