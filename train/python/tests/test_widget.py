"""The notebook widget, in a browser where there is one."""

from __future__ import annotations

import base64
import json
import os
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any, Callable, Iterator

import chromium
import comm
import numpy as np
import pytest
import traitlets
from comm.base_comm import BaseComm
from pocketnerf import Camera, Model
from pocketnerf.widget import View

HERE = Path(__file__).resolve().parent
AT_REST = "canvas.dataset.state === 'rest'"


class Wire(BaseComm):
    """Keeps what the widget sends to the browser, for the test to pass on."""

    def __init__(self, *args: Any, **options: Any) -> None:
        self.sent: list[tuple[dict[str, Any], list[bytes]]] = []
        super().__init__(*args, **options)

    def publish_msg(
        self,
        msg_type: str,
        data: dict[str, Any] | None = None,
        metadata: dict[str, Any] | None = None,
        buffers: list[bytes] | None = None,
        **_: Any,
    ) -> None:
        # Of what the browser said, a notebook's manager takes no notice of the echo.
        if msg_type in ("comm_open", "comm_msg") and data and data.get("method") != "echo_update":
            self.sent.append((data, buffers or []))


class Notebook:
    """A page that shows a view, and what passes between them."""

    def __init__(self, page: chromium.Page, view: View) -> None:
        self.page, self.view = page, view
        page.on_call = self.from_page
        page.go((HERE / "notebook.html").as_uri())
        self.to_page()
        page.value("show(cell)")
        page.until(AT_REST)

    def from_page(self, text: str) -> None:
        data = {"method": "update", "state": json.loads(text), "buffer_paths": []}
        self.view.comm.handle_msg({"content": {"data": data}, "buffers": []})

    def to_page(self) -> int:
        """Passes on what the view has sent; returns how much that was."""
        sent, self.view.comm.sent = self.view.comm.sent, []
        for data, buffers in sent:
            binary = [base64.b64encode(buffer).decode() for buffer in buffers]
            named = {path[0]: text for path, text in zip(data["buffer_paths"], binary)}
            self.page.value(f"model.update({json.dumps(data['state'])}, {json.dumps(named)})")
        return len(sent)

    def picture(self) -> np.ndarray[Any, np.dtype[np.uint8]]:
        """The complete picture, once nothing moves."""
        self.page.until(AT_REST)
        width, height = self.page.value("[canvas.width, canvas.height]")
        pixels = np.frombuffer(base64.b64decode(self.page.value("seen()")), np.uint8)
        return pixels.reshape(height, width, 4)[..., :3]

    def after(self, action: Callable[[], object]) -> np.ndarray[Any, np.dtype[np.uint8]]:
        """The complete picture after something that changes it."""
        self.picture()
        self.page.value("globalThis.before = seen()")
        action()
        self.page.until(f"{AT_REST} && seen() !== before")
        return self.picture()

    def agrees(self) -> bool:
        """Whether it is what the model renders for the view's camera, but for last bits."""
        view = self.view
        return psnr(self.picture(), view.model.render(view.camera, quality=view.quality, antialias=1)) > 40

    def distance(self) -> float:
        """Of the view's camera from the middle of the scene."""
        bounds = self.view.model.bounds
        assert bounds is not None
        return float(np.linalg.norm(self.view.camera.position - bounds.mean(axis=0)))


@pytest.fixture
def page(tmp_path: Path) -> Iterator[chromium.Page]:
    browser = chromium.name()
    if browser is None:
        assert "POCKETNERF_REQUIRE_TOOLS" not in os.environ, "no chromium on this machine"
        pytest.skip("no chromium on this machine")
    with chromium.Page(browser, tmp_path, 400, 320) as page:
        yield page


def psnr(a: np.ndarray[Any, Any], b: np.ndarray[Any, Any]) -> float:
    assert a.shape == b.shape
    error = np.mean((a.astype(float) - b.astype(float)) ** 2)
    return float(10 * np.log10(255**2 / max(error, 1e-9)))


def test_a_drag_moves_the_picture_and_pythons_camera(
    model: Model, page: chromium.Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(comm, "create_comm", Wire)
    view = View(model, width=200, height=150)
    notebook = Notebook(page, view)
    first, own = notebook.picture(), view.camera
    assert first.shape == (150, 200, 3)
    assert notebook.agrees()
    assert "hash-grid" in page.value("canvas.ariaLabel")

    # What Python knows of the camera is what the browser shows.
    seen: list[Camera] = []
    view.observe(lambda change: seen.append(change["new"]), "camera")
    x, y = page.value("(({ x, y }) => [x + 100, y + 75])(canvas.getBoundingClientRect())")
    turned = notebook.after(lambda: page.drag((x, y), (x + 40, y + 10)))
    assert psnr(first, turned) < 30
    assert seen and view.camera == seen[-1] != own
    # A drag to the right turns the scene with the hand: the camera goes to its left.
    moved = view.camera.position - own.position
    assert moved @ own.camera_to_world[:3, 0] < -0.1
    assert (view.camera.width, view.camera.height) == (200, 150)
    assert notebook.agrees()
    # Nothing comes back to disturb the hand.
    assert notebook.to_page() == 0

    # The wheel, and keys: nearer, and back home.
    before = notebook.distance()
    wheel = lambda: page.mouse("mouseWheel", x, y, deltaX=0, deltaY=-300)
    assert psnr(notebook.after(wheel), turned) < 35
    assert notebook.distance() < 0.85 * before
    page.value("canvas.focus()")
    home = lambda: page.call("Input.dispatchKeyEvent", type="keyDown", key="Home")
    assert psnr(notebook.after(home), first) > 50
    np.testing.assert_allclose(view.camera.camera_to_world, own.camera_to_world, atol=1e-6)

    # Python moves the camera; a drag goes on from there.
    view.camera = model.orbit(2.0, 0.6, width=200, height=150)
    assert notebook.to_page() == 1
    assert notebook.agrees()
    around = notebook.picture()
    assert psnr(around, first) < 30
    assert psnr(notebook.after(lambda: page.drag((x, y), (x - 20, y))), around) < 35
    assert notebook.agrees()

    # A camera off the middle, tilted and of another size shows what it sees.
    pose = np.array(own.camera_to_world)
    pose[:3, :2] = pose[:3, :2] @ [[0.8, -0.6], [0.6, 0.8]]
    view.camera = Camera(400, 400, pose, focal=(420, 400), center=(230, 190))
    notebook.to_page()
    assert (view.camera.width, view.camera.height) == (200, 150)
    assert notebook.agrees()

    # Quality and size.
    view.quality = 1.0
    notebook.to_page()
    assert notebook.agrees()
    view.width = 160
    notebook.to_page()
    page.until("canvas.width === 160")
    assert view.camera.width == 160
    assert notebook.agrees()
    if "POCKETNERF_SCREENSHOTS" in os.environ:
        page.screenshot(Path(os.environ["POCKETNERF_SCREENSHOTS"]) / "widget.png")

    # Two of one model follow each other.
    page.value("globalThis.first = { canvas, hide }; show(cell)")
    page.until(AT_REST)
    notebook.after(lambda: page.drag((x, y), (x - 30, y)))
    page.until(f"first.{AT_REST}")
    assert notebook.agrees()
    page.value("first.hide()")

    # A hidden widget leaves nothing behind.
    page.value("hide()")
    assert page.value("model.listeners") == 0
    assert page.complaints == []


def test_what_cannot_be_shown_is_one_line(
    model: Model, page: chromium.Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(comm, "create_comm", Wire)
    view = View(model, width=100)
    view._file = model.to_bytes()[:1000]
    page.go((HERE / "notebook.html").as_uri())
    page.on_call = lambda _: None
    state = {name: view.get_state()[name] for name in ("_esm", "_css", "width", "height")}
    bytes = base64.b64encode(view._file).decode()
    page.value(f"model.update({json.dumps(state)}, {{ _file: '{bytes}' }})")
    page.value("show(cell)")
    page.until("cell.querySelector('p').textContent !== ''")
    said = page.value("cell.querySelector('p').textContent")
    assert "\n" not in said and len(said) > 10
    assert page.complaints == []


def test_traits(model: Model) -> None:
    view = View(model, width=200)
    own = model.camera
    assert view.height == round(200 * own.height / own.width)
    assert view.model is model
    assert view.quality is None
    for name, value in [("quality", 2.0), ("width", 0), ("camera", None), ("camera", 3)]:
        with pytest.raises(traitlets.TraitError):
            setattr(view, name, value)
    with pytest.raises(traitlets.TraitError):
        View(model, quality=-1.0)
    # Another size is as wide a view, as in `model.render`.
    view.height = 400
    assert view.camera == own.resized(200, 400)


def test_the_bundle_asks_nobody() -> None:
    text = str(View._esm)
    assert "import.meta" not in text
    assert "://" not in text
    assert [line for line in text.splitlines() if line.startswith(("import", "export"))] == [
        "export default { render };"
    ]


@pytest.mark.parametrize(
    "other, error",
    [
        ('import x from "./b.js";', "cannot be bundled: import x"),
        ('export * from "./b.js";', "cannot be bundled: export"),
        ("export default 1;", "cannot be bundled: export"),
        ('await import("./b.js");', "cannot be bundled: import"),
        ("import.meta.url;", "cannot be bundled: import.meta"),
        ('new URL("./c.wasm", import.meta.url);', "c.wasm"),
        ('import { a } from "./b.js";', "b.js has no a"),
        ('import { run } from "./entry.js";', "entry.js imports itself"),
        ('import { gone } from "./gone.js";', "gone.js"),
    ],
)
def test_modules_are_bundled_or_refused(tmp_path: Path, other: str, error: str) -> None:
    def write(name: str, *lines: str) -> None:
        (tmp_path / name).write_text("\n".join(lines))

    script = runpy.run_path(str(HERE.parent / "widget-build"))
    write("b.js", "const hidden = 1;", "export class B {}", "export async function b() {}")
    write("c.js", "import {", "  B,", "  b as c,", '} from "./b.js";', "export const hidden = c;")
    imports = ('import { B } from "./b.js";', 'import { hidden } from "./c.js";')
    write("entry.js", *imports, "export default { B, hidden };")
    text = script["bundle"]([tmp_path], "entry")
    assert text.index("const $b") < text.index("const $c") < text.index("export default")
    assert text.count("class B") == 1 and "b: c," in text and "return { B, b };" in text
    write("c.js", other, "export const hidden = 2;")
    with pytest.raises((SystemExit, FileNotFoundError), match=error):
        script["bundle"]([tmp_path], "entry")


def test_anywidget_is_optional(tmp_path: Path) -> None:
    script = (
        "import sys; sys.modules['anywidget'] = None\n"
        "import pocketnerf\n"
        "assert 'ipywidgets' not in sys.modules and 'traitlets' not in sys.modules\n"
        "try: import pocketnerf.widget\n"
        "except ImportError as error: print(error)\n"
    )
    # Elsewhere than beside the sources, which have no compiled part.
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    expected = "the widget needs anywidget: pip install pocketnerf[widget]\n"
    assert done.stdout == expected, done.stderr
