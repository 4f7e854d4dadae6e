"""Pictures as files."""

from __future__ import annotations

import os
import tempfile

import numpy as np
from numpy.typing import NDArray

from ._native import encode_png
from ._run import Path


def write_png(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Writes a picture of shape (height, width, 3), or (height, width, 4) with straight alpha, as a
    PNG file. An older file is replaced by a whole one.
    """
    name = os.fspath(path)
    encoded = encode_png(np.ascontiguousarray(pixels))
    handle, part = tempfile.mkstemp(dir=os.path.dirname(name) or ".", prefix=".png-")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(encoded)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(part, 0o666 & ~mask)
        os.replace(part, name)
    except BaseException:
        os.unlink(part)
        raise
