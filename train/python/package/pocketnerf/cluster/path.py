"""Renders a camera path: some frames a task."""

from __future__ import annotations

import hashlib
import os
from typing import Any, Dict, List, Optional, Sequence, Union, cast

import numpy as np
import pocketnerf
import ray
from numpy.typing import NDArray
from pocketnerf import Camera, Error, Model
from pocketnerf._native import encode_png

from . import driver, files
from .worker import Outcome, Task


def render_path(
    model: Union[Model, files.Path],
    cameras: Sequence[Camera],
    out: files.Path,
    *,
    frames_per_task: int = 8,
    num_cpus: float = 2,
    max_retries: int = 3,
    memory: Optional[int] = None,
    progress: Optional[bool] = None,
    address: Optional[str] = None,
    **options: Any,
) -> List[str]:
    """Renders a picture for each camera, as ``model.render`` does, on the nodes of a cluster.

    Frames that are there already are skipped, so the same call continues after an interruption.
    ``out/path.json`` says what they are made of; another model, path or option is refused.

    Args:
        model: ``pocketnerf.Model``, or path of a model file that the driver sees. It goes to each
            node once.
        cameras: one for each frame.
        out: folder on the driver's machine, for 00000.png and so on (8 bits a channel).
        frames_per_task: frames that a task renders one after another, and a lost worker loses.
        num_cpus, max_retries, memory, progress, address: as for ``train_many``. The bar counts
            tasks.
        options: of ``Model.render``: ``quality``, ``background``, ``alpha``, ``antialias``.

    Returns:
        Paths of the frames, in the order of ``cameras``.

    Raises:
        pocketnerf.Error: a task failed. All other frames are there.

    Example:
        >>> import pocketnerf
        >>> from pocketnerf.cluster import render_path
        >>> model = pocketnerf.Model.open("lego.pnerf")  # doctest: +SKIP
        >>> turn = [model.orbit(azimuth=i * 0.01) for i in range(629)]  # doctest: +SKIP
        >>> frames = render_path(model, turn, "frames", quality=1.0)  # doctest: +SKIP
    """
    wrong = set(options) - {"quality", "background", "alpha", "antialias"}
    if wrong:
        raise Error(
            f"render_path: found the option {min(wrong)!r}, expected quality, background, alpha "
            "or antialias; sizes are those of the cameras"
        )
    if frames_per_task < 1:
        raise Error(f"frames_per_task: found {frames_per_task}, expected at least 1")
    content = model.to_bytes() if isinstance(model, Model) else files.read(model)
    folder = files.make_folder(out)
    made_of = _made_of(content, cameras, options)
    files.check_made_of(os.path.join(folder, "path.json"), made_of)
    paths = [os.path.join(folder, f"{index:05}.png") for index in range(len(cameras))]
    left = [index for index, path in enumerate(paths) if not os.path.exists(path)]

    def save(_: str, frames: Dict[str, bytes]) -> None:
        for file, data in frames.items():
            files.write(os.path.join(folder, file), data)

    jobs = []
    if left:
        driver.connect(address)
        stored = ray.put(content)
        for begin in range(0, len(left), frames_per_task):
            some = left[begin : begin + frames_per_task]
            views = {os.path.basename(paths[index]): cameras[index] for index in some}
            arguments = {"model": stored, "views": views, "options": options}
            jobs.append(driver.Job(f"frames {some[0]}-{some[-1]}", arguments, lambda: memory))
    driver.run_all(
        jobs,
        _render,
        save,
        folder,
        num_cpus=num_cpus,
        max_retries=max_retries,
        unit="task",
        address=address,
        progress=progress,
    )
    return paths


def _made_of(
    model: bytes, cameras: Sequence[Camera], options: Dict[str, Any]
) -> Dict[str, Any]:
    path = hashlib.sha256()
    for camera in cameras:
        size = (camera.width, camera.height, camera.focal, camera.center)
        path.update(repr(size).encode() + camera.camera_to_world.tobytes())
    return {
        "model": hashlib.sha256(model).hexdigest(),
        "cameras": path.hexdigest(),
        "options": {key: str(value) for key, value in sorted(options.items())},
    }


def _render(
    task: Task, model: bytes, views: Dict[str, Camera], options: Dict[str, Any]
) -> Outcome:
    """Runs on a node."""
    frames = {}
    with pocketnerf.Model.open(model) as opened:
        for name, camera in views.items():
            pixels = cast("NDArray[np.uint8]", opened.render(camera, dtype=np.uint8, **options))
            frames[name] = encode_png(pixels)
    return Outcome({}, frames)
