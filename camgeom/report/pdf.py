"""The report page as PDF, printed by a browser of the Chromium family that is installed here."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from camgeom.errors import ExportError
from camgeom.export.files import write_whole

CHOICE = "CAMGEOM_BROWSER"
"""environment variable that names the browser"""
NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge"),
    *("brave-browser", "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome"),
)
SECONDS = 120
SETTLE = 15_000
"""ms of the page's own time in which the 3D view draws its first picture"""


def find_browser() -> str:
    """The browser that prints. Raises ExportError that says how to get one."""
    named = os.environ.get(CHOICE)
    for name in (named,) if named else NAMES:
        if found := shutil.which(name):
            return found
    if named:
        raise ExportError(f"{CHOICE} names {named!r}, which is no program here")
    raise ExportError(
        "there is no Chromium or Chrome; on Debian or Ubuntu, as root: apt-get install chromium; "
        f"or name one in {CHOICE}; or open report.html in any browser and print it"
    )


def write_pdf(page: Path, path: Path) -> Path:
    """Print an HTML file as PDF and give the PDF's path. Raises ExportError where no browser is here or it fails."""
    browser = find_browser()
    with TemporaryDirectory(prefix="camgeom-", ignore_cleanup_errors=True) as place:
        made = Path(place) / "report.pdf"
        words = [browser, "--headless", "--disable-gpu", "--no-first-run", "--disable-extensions", "--disable-sync"]
        words += ["--disable-background-networking", "--disable-component-update", "--hide-scrollbars"]
        words.append("--window-size=1280,1000")  # the 3D view has the size it has on a desktop
        words += ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        words += [f"--user-data-dir={place}/profile", f"--virtual-time-budget={SETTLE}", "--no-pdf-header-footer"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:  # its sandbox refuses to start as root
            words.append("--no-sandbox")
        words += [f"--print-to-pdf={made}", page.resolve().as_uri()]
        try:
            done = subprocess.run(words, capture_output=True, timeout=SECONDS, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise ExportError(f"{path}: {browser} does not print: {error}") from error
        if not made.is_file() or not made.read_bytes().startswith(b"%PDF-"):
            reason = " ".join(done.stderr.decode(errors="replace").split())[-200:]
            raise ExportError(f"{path}: {browser} does not print: {reason or f'exit status {done.returncode}'}")
        write_whole(path, made.read_bytes())
    return path
