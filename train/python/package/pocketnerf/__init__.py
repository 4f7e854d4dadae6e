"""Radiance fields on ordinary CPUs: photographs with known cameras in, a compact model file out, new
views from any side.

>>> import pocketnerf
>>> model = pocketnerf.train("photographs", steps=60).model
>>> model.render(width=64, height=64).shape
(64, 64, 3)
"""

from ._commands import chart, convert, evaluate, export, info, repack, stress, unpack
from ._images import write_png
from ._native import (
    Camera,
    Dataset,
    DatasetError,
    Error,
    Interrupted,
    Model,
    ModelError,
    __version__,
    num_threads,
    set_num_threads,
)
from ._run import PocketnerfWarning, Progress, load_cameras
from ._training import Training, train

__all__ = [
    "Camera",
    "Dataset",
    "DatasetError",
    "Error",
    "Interrupted",
    "Model",
    "ModelError",
    "PocketnerfWarning",
    "Progress",
    "Training",
    "__version__",
    "chart",
    "convert",
    "evaluate",
    "export",
    "info",
    "load_cameras",
    "num_threads",
    "repack",
    "set_num_threads",
    "stress",
    "train",
    "unpack",
    "write_png",
]
