"""The example notebook runs, and its results are what it says."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import nbformat
import numpy as np
from nbclient import NotebookClient
from PIL import Image

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_the_first_notebook_runs() -> None:
    notebook = nbformat.read(EXAMPLES / "first_radiance_field.ipynb", as_version=4)
    NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    scores = "".join(cells[1].outputs[0].text)
    assert float(scores.split(" dB")[0]) > 26, scores
    shown = cells[2].outputs[0].data["image/png"]
    picture = np.asarray(Image.open(io.BytesIO(base64.b64decode(shown))))
    assert picture.ndim == 3 and picture.max() == 255 and picture.min() < 128
    assert "(200, 200, 3) uint8" in "".join(cells[3].outputs[0].text)
    clear = cells[4].outputs[0].data["text/plain"]
    # The camera's own place is free, the surface is not.
    assert clear.startswith("array([ True") and "False])" in clear, clear
