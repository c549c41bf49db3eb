"""Pages in a headless Chromium, driven by its DevTools protocol over two pipes: no port, no driver, no package."""

from __future__ import annotations

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

#: What Chromium is called, wherever it is installed.
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
#: How long an answer may take [s]: machines that build something besides are slow.
PATIENCE = 120.0

CHROMIUM = next((found for name in NAMES if (found := shutil.which(name))), None)
#: Chromium reads commands from 3 and answers on 4; no shell knows the numbers of more than one digit that the pipes have here.
_AS_CHROMIUM = "import os, sys; os.dup2(int(sys.argv[1]), 3); os.dup2(int(sys.argv[2]), 4); os.execv(sys.argv[3], sys.argv[3:])"
#: For tests that ask for a browser.
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")


#: What is answered where a page was asked something and left before it could answer.
GONE = (
    "Inspected target navigated or closed",
    "Execution context was destroyed",
    "Cannot find context with specified id",
)


class BrowserError(Exception):
    """The browser refused something, or did not answer."""


class PageLeft(BrowserError):
    """The page that was asked was left before it answered: another one comes."""


class Page:
    """One page of a browser. messages: all that its console and its errors said; requests: all addresses that it asked for."""

    def __init__(self, browser: _Pipe, session: str) -> None:
        self._browser, self._session = browser, session
        self._loaded = False
        self.messages: list[str] = []
        self.requests: list[str] = []
        browser.pages[session] = self
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """A command of the protocol, and its result; raises BrowserError."""
        return self._browser.call(method, params, self._session)

    def open(self, page: Path, fragment: str = "") -> None:
        """Load a file, and wait until it is loaded. Only a fragment that differs is followed without loading."""
        self._loaded = False
        self.call("Page.navigate", url="about:blank")
        self._browser.wait(lambda: self._loaded)
        self._loaded = False
        self.requests.clear()
        self.call("Page.navigate", url=page.resolve().as_uri() + fragment)
        self._browser.wait(lambda: self._loaded)

    def size(self, width: int, height: int) -> None:
        """The size of the window in CSS pixels."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def media(self, media: str = "", **features: str) -> None:
        """How the page is shown: `print`, and features such as prefers_color_scheme="dark"."""
        given = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        self.call("Emulation.setEmulatedMedia", media=media, features=given)

    def evaluate(self, script: str) -> Any:
        """The value of an expression, as JSON has it; raises BrowserError for what throws."""
        found = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise BrowserError(str(found["exceptionDetails"].get("exception", found["exceptionDetails"])))
        return found["result"].get("value")

    def until(self, script: str) -> None:
        """Wait until an expression, which may await, holds on whatever page there is by then; raises BrowserError."""
        end = time.monotonic() + 2 * PATIENCE
        while time.monotonic() < end:
            try:
                if self.evaluate(f"(async () => Boolean({script}))()"):
                    return
            except PageLeft:
                pass
            time.sleep(0.02)
        raise BrowserError(f"never so: {script}")

    def key(self, key: str) -> None:
        """Press a key such as ArrowRight on whatever has the focus."""
        code = {"ArrowLeft": 37, "ArrowRight": 39, "Home": 36, "End": 35, "Enter": 13}.get(key, 0)
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)

    def click(self, x: float, y: float) -> None:
        """Press the mouse at a place of the window."""
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def pdf(self) -> bytes:
        """The page as it is printed on A4."""
        found = self.call("Page.printToPDF", printBackground=True, paperWidth=8.27, paperHeight=11.69)
        return base64.b64decode(found["data"])

    def picture(self, to: Path, whole: bool = True) -> None:
        """The page as it looks: all of it, or what the window shows."""
        found = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        to.write_bytes(base64.b64decode(found["data"]))

    def hear(self, event: str, params: Mapping[str, Any]) -> None:
        """What the browser tells of this page by itself."""
        match event:
            case "Page.loadEventFired":
                self._loaded = True
            case "Runtime.consoleAPICalled":
                self.messages.append(
                    " ".join(str(one.get("value", one.get("description"))) for one in params["args"])
                )
            case "Runtime.exceptionThrown":
                self.messages.append(str(params["exceptionDetails"]))
            case "Log.entryAdded":
                self.messages.append(str(params["entry"]["text"]))
            case "Network.requestWillBeSent":
                self.requests.append(params["request"]["url"])


class _Pipe:
    """Commands and answers, each a JSON text that ends with a zero byte."""

    def __init__(self, to: int, back: int) -> None:
        self._to, self._back = to, back
        self._number = 0
        self._rest = b""
        self._answers: dict[int, dict[str, Any]] = {}
        self.pages: dict[str, Page] = {}

    def call(self, method: str, params: Mapping[str, Any], session: str = "") -> dict[str, Any]:
        self._number += 1
        number = self._number
        message = {"id": number, "method": method, "params": params}
        if session:
            message["sessionId"] = session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        self.wait(lambda: number in self._answers)
        answer = self._answers.pop(number)
        if "error" in answer:
            left = any(said in answer["error"].get("message", "") for said in GONE)
            raise (PageLeft if left else BrowserError)(f"{method}: {answer['error']}")
        found: dict[str, Any] = answer["result"]
        return found

    def wait(self, until: Any) -> None:
        """Listen until something is so; raises BrowserError where it does not come to that."""
        end = time.monotonic() + PATIENCE
        while not until():
            ready, _, _ = select.select([self._back], [], [], max(0.0, end - time.monotonic()))
            read = os.read(self._back, 1 << 20) if ready else b""
            if not read:
                raise BrowserError("the browser is gone, or does not answer")
            *whole, self._rest = (self._rest + read).split(b"\0")
            for text in whole:
                self._take(json.loads(text))

    def _take(self, message: dict[str, Any]) -> None:
        if "id" in message:
            self._answers[message["id"]] = message
        elif (page := self.pages.get(message.get("sessionId", ""))) is not None:
            page.hear(message["method"], message["params"])


@contextmanager
def browser_page(width: int = 1400, height: int = 1000) -> Iterator[Page]:
    """A page of a browser of its own, without a network: every name leads nowhere."""
    assert CHROMIUM is not None, "for tests with `needs_browser`"
    theirs, ours = _pipe(), _pipe()  # each (read, write)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        started = subprocess.Popen(
            [sys.executable, "-c", _AS_CHROMIUM, str(theirs[0]), str(ours[1]), CHROMIUM, "--headless", "--no-sandbox",
             "--disable-gpu", "--remote-debugging-pipe", f"--user-data-dir={profile}", "--host-resolver-rules=MAP * ~NOTFOUND", "--no-first-run",
             "--disable-dev-shm-usage", "about:blank"],
            pass_fds=(theirs[0], ours[1]), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(theirs[0])
        os.close(ours[1])
        try:
            pipe = _Pipe(theirs[1], ours[0])
            target = pipe.call("Target.createTarget", {"url": "about:blank"})["targetId"]
            session = pipe.call("Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
            page = Page(pipe, session)
            page.size(width, height)
            yield page
        finally:
            started.kill()
            started.wait()
            os.close(theirs[1])
            os.close(ours[0])


def _pipe() -> tuple[int, int]:
    """A pipe with numbers above those that Chromium wants."""
    ends = os.pipe()
    high = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in ends]
    for end in ends:
        os.close(end)
    return high[0], high[1]
