"""Chromium without a window, told what to do over the DevTools protocol's pipe."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import signal
import subprocess
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Callable

# After which something hangs: many times what a busy machine needs.
PATIENCE = 60.0


def name() -> str | None:
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((name for name in names if shutil.which(name)), None)


class Page:
    """A page in a browser of its own, which ends with it."""

    def __init__(self, browser: str, profile: Path, width: int, height: int) -> None:
        ours, theirs = os.pipe(), os.pipe()
        self._read, self._write = theirs[0], ours[1]
        command = [browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run"]
        command += ["--disable-background-networking", "--disable-dev-shm-usage"]
        command += ["--remote-debugging-pipe", f"--user-data-dir={profile}"]
        command += [f"--window-size={width},{height}", "about:blank"]
        # The browser reads file descriptor 3 and writes 4.
        pipes = f'exec "$@" 3<&{ours[0]} 4>&{theirs[1]}'
        self._process = subprocess.Popen(
            ["bash", "-c", pipes, "bash", *command],
            pass_fds=(ours[0], theirs[1]),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        os.close(ours[0])
        os.close(theirs[1])
        self._buffer = b""
        self._last = 0
        self._session: str | None = None
        self.complaints: list[str] = []
        """Errors of the console, exceptions, and requests to others."""
        self.on_call: Callable[[str], None] = lambda payload: None
        """Is told what the page passes to its function ``python``."""
        self._calls: list[str] = []
        session = self.call("Target.attachToTarget", targetId=self._first_page(), flatten=True)
        self._session = session["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Runtime.addBinding", name="python")
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=False,
        )  # fmt: skip

    def __enter__(self) -> Page:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        # Its children are in its process group.
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        os.close(self._read)
        os.close(self._write)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """What the browser answers to a command of the protocol."""
        self._last += 1
        message = {"id": self._last, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        text = json.dumps(message).encode() + b"\0"
        while text:
            text = text[os.write(self._write, text) :]
        number, end = self._last, time.monotonic() + PATIENCE
        while True:
            answer = self._receive(method, end)
            if answer.get("id") == number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                result: dict[str, Any] = answer["result"]
                return result
            self._event(answer.get("method", ""), answer.get("params", {}))

    def _first_page(self) -> str:
        """The page that the browser opens when it has started."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for target in self.call("Target.getTargets")["targetInfos"]:
                if target["type"] == "page":
                    return str(target["targetId"])
            time.sleep(0.02)
        raise AssertionError("the browser opens no page")

    def _receive(self, method: str, end: float) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._read], [], [], max(end - time.monotonic(), 0))
            assert ready, f"{method} is not answered"
            some = os.read(self._read, 1 << 20)
            assert some, "the browser ended"
            self._buffer += some
        message, self._buffer = self._buffer.split(b"\0", 1)
        answer: dict[str, Any] = json.loads(message)
        return answer

    def _event(self, method: str, about: dict[str, Any]) -> None:
        if method == "Runtime.bindingCalled":
            self._calls.append(about["payload"])
        is_bad = method == "Runtime.exceptionThrown"
        is_bad |= method == "Runtime.consoleAPICalled" and about["type"] in ("error", "warning")
        is_bad |= method == "Log.entryAdded" and about["entry"]["level"] == "error"
        if method == "Network.requestWillBeSent":
            is_bad = not about["request"]["url"].startswith(("file:", "blob:", "data:", "about:"))
        if is_bad:
            self.complaints.append(json.dumps(about))

    def value(self, expression: str) -> Any:
        """The value of an expression of the page's, awaited."""
        answer = self.call(
            "Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer
        # What the page says is handled here, where no answer is waited for.
        while self._calls:
            self.on_call(self._calls.pop(0))
        return answer["result"].get("value")

    def until(self, expression: str) -> None:
        """Waits until an expression is true."""
        end = time.monotonic() + PATIENCE
        while self.value(expression) is not True:
            text = time.monotonic() < end or self.value("document.body.innerText")
            assert text is True, f"{expression}: never; {text}; {self.complaints}"
            time.sleep(0.02)

    def go(self, url: str) -> None:
        self.call("Page.navigate", url=url)
        self.until(f"location.href === '{url}' && document.readyState === 'complete'")

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, start: tuple[float, float], end: tuple[float, float], steps: int = 4) -> None:
        """Drags with the left button, a little at a time."""
        left: dict[str, Any] = {"button": "left", "buttons": 1, "clickCount": 1}
        self.mouse("mousePressed", *start, **left)
        for step in range(1, steps + 1):
            x, y = (a + (b - a) * step / steps for a, b in zip(start, end))
            self.mouse("mouseMoved", x, y, **left)
        self.mouse("mouseReleased", *end, **left)

    def screenshot(self, path: Path) -> None:
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))
