"""What the tests of the page share: the program, and a real browser without a display."""

import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest
from playwright.sync_api import sync_playwright

REPOSITORY = Path(__file__).resolve().parents[4]
BROWSER_FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def until(page, condition, timeout_s=60):
    """Waits until a JavaScript expression holds. Playwright's own way is barred by the page's content policy."""
    end = time.monotonic() + timeout_s
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"never came true: {condition}"
        page.wait_for_timeout(40)


@pytest.fixture(scope="session")
def program():
    """The program that GAITSHIFT_PROGRAM names, or that cargo built last in the dev profile."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
    path = os.environ.get("GAITSHIFT_PROGRAM", str(target / "debug" / "gaitshift"))
    if not Path(path).exists():
        pytest.fail(f"{path} does not exist: run `cargo build -p gaitshift`, or set GAITSHIFT_PROGRAM")
    return path


@pytest.fixture(scope="session")
def browser():
    """Chromium without a window."""
    path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    if path is None:
        pytest.fail("no chromium: install Debian's package `chromium`, or set CHROMIUM to the browser")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, headless=True, args=BROWSER_FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def view(program):
    """Starts `gaitshift view` with arguments; gives the address it prints."""
    started = []

    def start(*arguments):
        command = [program, "view", "--no-open", "--port", "0", *map(str, arguments)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        started.append(process)
        url = process.stdout.readline().split(" ")[0]
        assert url.startswith("http://127.0.0.1:"), "the program ended without an address"
        return url

    yield start
    for process in started:
        process.kill()
        process.wait()


@pytest.fixture
def tab(browser):
    """Opens a page and fails the test if it writes an error to the console, or fetches from elsewhere."""
    contexts, mistakes = [], []

    def open_tab(url, width=1280, height=900, dark=False, language="en-GB"):
        context = browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme="dark" if dark else "light",
            locale=language,
            accept_downloads=True,
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(60_000)
        page.on("console", lambda m: mistakes.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda e: mistakes.append(str(e)))
        page.on("request", lambda r: mistakes.append(r.url) if not r.url.startswith((url, "data:", "blob:")) else None)
        page.goto(url)
        return page

    yield open_tab
    for context in contexts:
        context.close()
    assert mistakes == []
