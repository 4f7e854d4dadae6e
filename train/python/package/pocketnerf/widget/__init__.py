"""A model in a notebook: dragging turns it, the wheel zooms. Needs the extra ``widget``.

>>> import pocketnerf
>>> from pocketnerf.widget import View
>>> model = pocketnerf.Model.open("model.pnerf")
>>> view = View(model, width=64)
>>> view.camera.width, view.camera.height
(64, 64)

As the last line of a cell, ``view`` shows the picture. The browser renders it, without a server
and without a network.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .. import Camera, Model

try:
    import anywidget
    import traitlets
except ImportError:
    raise ImportError("the widget needs anywidget: pip install pocketnerf[widget]") from None

__all__ = ["View"]

_HERE = Path(__file__).parent
# Of a picture's side.
_MOST_PIXELS = 16384


def _front_end() -> str:
    try:
        return (_HERE / "dist" / "widget.js").read_text("utf-8")
    except FileNotFoundError:
        raise ImportError("the widget is not built: run train/python/widget-build") from None


def _camera_to_json(camera: Camera, _: object) -> dict[str, Any]:
    """The camera as the web page has it: ``pose`` is camera-to-world, row after row."""
    return {
        "width": camera.width,
        "height": camera.height,
        "focal": list(camera.focal),
        "center": list(camera.center),
        "pose": camera.camera_to_world.ravel().tolist(),
    }


def _camera_from_json(value: dict[str, Any], _: object) -> Camera:
    pose = np.reshape(np.asarray(value["pose"], np.float32), (4, 4))
    focal, center = value["focal"], value["center"]
    return Camera(value["width"], value["height"], pose, focal=focal, center=center)


class View(anywidget.AnyWidget):
    """An interactive picture of a model.

    Drag, arrow keys: turn. Wheel, pinch, + and -: zoom. Right drag, two fingers: move. Home: back
    to the model's own camera. While the camera moves, the picture is coarser.

    ``width`` and ``height`` are the picture's size in pixels of the page; without ``height`` it
    has the shape of the model's own picture. ``quality`` is that of the picture at rest, from 0,
    the fastest, to 1, the finest; None is the model's default.

    ``camera`` follows the hand, and ``model.render(view.camera, antialias=1)`` is the picture that is seen. A
    camera that is set is shown, as wide a view, and dragging goes on from there. All four are
    traits: ``view.observe(f, "camera")`` tells of changes.
    """

    _esm = _front_end()
    _css = (_HERE / "widget.css").read_text("utf-8")
    _file = traitlets.Bytes().tag(sync=True)

    width = traitlets.Int(480, min=1, max=_MOST_PIXELS).tag(sync=True)
    height = traitlets.Int(480, min=1, max=_MOST_PIXELS).tag(sync=True)
    quality = traitlets.Float(None, min=0.0, max=1.0, allow_none=True).tag(sync=True)
    camera = traitlets.Instance(Camera).tag(
        sync=True, to_json=_camera_to_json, from_json=_camera_from_json
    )

    def __init__(
        self,
        model: Model,
        *,
        width: int = 480,
        height: int | None = None,
        quality: float | None = None,
    ) -> None:
        own = model.camera
        if height is None:
            height = max(1, round(width * own.height / own.width))
        self._model = model
        super().__init__(
            _file=model.to_bytes(), width=width, height=height, quality=quality, camera=own
        )

    @property
    def model(self) -> Model:
        """The model that is shown."""
        return self._model

    @traitlets.validate("camera")
    def _fit(self, proposal: dict[str, Any]) -> Camera:
        camera: Camera = proposal["value"]
        return camera.resized(self.width, self.height)

    @traitlets.observe("width", "height")
    def _resized(self, _: object) -> None:
        if self.trait_has_value("camera"):
            self.camera = self.camera.resized(self.width, self.height)
