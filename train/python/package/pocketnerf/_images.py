"""Pictures as files."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._native import encode_png, write_file
from ._run import Path


def write_png(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Writes a picture of shape (height, width, 3), or (height, width, 4) with straight alpha, as a
    PNG file. An older file is replaced by a whole one.
    """
    write_file(path, encode_png(np.ascontiguousarray(pixels)))
