"""The page of `camgeom serve` in a real browser: skipped without playwright or Chromium (scripts/page_tests)."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from threading import Event, Thread
from typing import Any

import pytest

from camgeom.errors import ExportError
from camgeom.report.pdf import find_browser
from camgeom.report.server import Server
from tests.places import PROFILES, ROOT

sync_api = pytest.importorskip("playwright.sync_api", reason="no playwright: scripts/page_tests installs it")
DISC = (PROFILES / "disc_offset_roller.toml").read_text(encoding="utf-8")
FLAGS = ["--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    try:
        program = find_browser()
    except ExportError as error:
        pytest.skip(str(error))
    with sync_api.sync_playwright() as play:
        made = play.chromium.launch(executable_path=program, args=FLAGS)
        yield made
        made.close()


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    (tmp_path / "my.toml").write_text(DISC, encoding="utf-8")
    with Server(tmp_path / "my.toml") as made:
        Thread(target=made.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
        made.warm()
        yield made
        made.shutdown()


@pytest.fixture
def page(browser: Any, server: Server) -> Iterator[Any]:
    # The tests' own conditions are evaluated, which the page forbids.
    context = browser.new_context(viewport={"width": 1400, "height": 900}, bypass_csp=True)
    made = context.new_page()
    said: list[str] = []
    made.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    made.on("pageerror", lambda error: said.append(str(error)))
    made.goto(server.url)
    settled(made)
    yield made
    context.close()
    assert [text for text in said if not re.search("GPU|WebGL|Failed to load resource|ERR_CONNECTION", text)] == []


def settled(page: Any) -> None:
    page.wait_for_selector("body[data-idle=true][data-done-ms]", timeout=60_000)


def change(page: Any, key: str, value: object) -> None:
    page.evaluate("delete document.body.dataset.doneMs; document.body.dataset.idle = 'false'")
    box = page.locator(f'.field[data-key="{key}"] input[type=number]')
    box.fill(str(value))
    box.press("Tab")


def figure(page: Any, label: str) -> str:
    return str(page.locator("#figures tr", has_text=label).locator("td").nth(1).inner_text())


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1040, 800), (390, 844)])
def test_the_page_fits_its_screen(browser: Any, server: Server, scheme: str, width: int, height: int) -> None:
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
    page = context.new_page()
    page.goto(server.url)
    settled(page)
    assert page.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    assert "Passes what was judged" in page.locator("#judged").inner_text()
    assert page.locator("#plots figure").count() == 2
    assert page.locator("#diagram circle").count() == 4
    assert page.locator("figure.scene canvas").count() >= 1
    plots = "[...document.querySelectorAll('svg.plot')]"
    share = page.evaluate(f"Math.min(...{plots}.map((one) => one.clientWidth / one.viewBox.baseVal.width))")
    assert share > 0.75  # letters of 13 px are 10 at least
    context.close()


def test_a_slider_moves_figures_picture_and_text(page: Any) -> None:
    before, picture = figure(page, "Largest pressure angle"), page.locator("figure.scene canvas").first.screenshot()
    slider = page.locator('.field[data-key="cam.base_radius"] input[type=range]')
    box = slider.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    for step in range(8):
        page.mouse.move(box["x"] + box["width"] * (0.5 + 0.04 * step), box["y"] + box["height"] / 2)
    page.mouse.up()
    page.wait_for_function("was => !document.querySelector('#figures').innerText.includes(was)", arg=before)
    page.wait_for_function("document.querySelector('#toml').value.includes('base_radius = 4')")
    settled(page)
    assert page.locator("figure.scene canvas").first.screenshot() != picture
    assert page.locator("#dirty").is_visible()
    page.click("#undo")  # one drag is one step
    page.wait_for_function("was => document.querySelector('#figures').innerText.includes(was)", arg=before)
    assert page.locator("#dirty").is_hidden()


def test_what_a_former_value_left_looks_so_until_its_own_answer_comes(page: Any, server: Server) -> None:
    stalled = Event()

    def judged(route: Any) -> None:
        answer = route.fetch()
        lines = answer.text().splitlines()
        if not stalled.is_set():  # the connection ends after the coarse bodies: nothing more is known of this value
            lines = lines[: 1 + next(i for i, line in enumerate(lines) if '"stage":"coarse"' in line)]
        route.fulfill(response=answer, body="\n".join(lines) + "\n")

    page.route("**/answer", judged)
    page.evaluate("delete document.body.dataset.coarseMs")
    change(page, "cam.base_radius", 41)
    page.wait_for_selector("body[data-idle=true][data-coarse-ms]")
    old = page.locator("#figures tr.old td:first-child").all_inner_texts()
    now = page.locator("#figures tbody tr:not(.old) td:first-child").all_inner_texts()
    assert "Stroke" in now
    assert "Largest pressure angle" in now
    assert "Peak contact pressure" in old
    assert page.locator("#judged.old").count() == 1
    assert page.locator("#plots .old").count() == 0
    stalled.set()
    change(page, "cam.base_radius", 42)
    settled(page)
    assert page.locator(".old").count() == 0


def test_a_bad_value_is_marked_and_the_last_picture_stays(page: Any) -> None:
    change(page, "cam.base_radius", -3)
    page.wait_for_selector('.field.bad[data-key="cam.base_radius"]')
    assert "base_radius" in page.locator(".field.bad .wrong").inner_text()
    assert figure(page, "Stroke")
    change(page, "cam.base_radius", 40)
    settled(page)
    assert page.locator(".field.bad").count() == 0


def test_a_kept_variant_stands_beside(page: Any) -> None:
    before = figure(page, "Largest pressure angle")
    page.click("#keep")
    page.wait_for_selector("#figures td.was")
    change(page, "cam.base_radius", 45)
    settled(page)
    row = page.locator("#figures tr", has_text="Largest pressure angle").locator("td")
    assert row.nth(2).inner_text() == before
    assert row.nth(1).inner_text() != before
    page.click("#swap")
    page.wait_for_function("was => document.querySelector('#figures').innerText.includes(was)", arg=before)
    page.click("#drop")
    page.wait_for_selector("#figures td.was", state="detached")


def test_the_timing_diagram_is_dragged(page: Any) -> None:
    end = page.locator("#diagram circle").first
    end.scroll_into_view_if_needed()
    box = end.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 40, y + 30, steps=6)
    page.mouse.up()
    page.wait_for_function("parseFloat(document.querySelector('#segments input').value) < 105")
    page.wait_for_function("parseFloat(document.querySelectorAll('#segments input')[1].value) < 19")
    settled(page)
    page.locator("#diagram circle").first.focus()
    now = float(page.locator("#segments input").first.input_value())
    page.keyboard.press("ArrowRight")
    page.wait_for_function(f"parseFloat(document.querySelector('#segments input').value) === {now + 0.5}")


def test_saving_keeps_what_the_file_held(page: Any, tmp_path: Path) -> None:
    change(page, "cam.base_radius", 40)
    settled(page)
    page.keyboard.press("Control+s")
    page.wait_for_selector("#notice-save")
    assert "my.1.toml" in page.locator("#notice-save").inner_text()
    assert (tmp_path / "my.1.toml").read_text() == DISC
    assert "base_radius = 40" in (tmp_path / "my.toml").read_text()
    assert page.locator("#dirty").is_hidden()


def test_a_change_outside_is_shown_or_asked_about(page: Any, tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(DISC.replace('name = "', 'name = "other '), encoding="utf-8")
    page.wait_for_function("document.querySelector('#title').innerText.startsWith('other')", timeout=20_000)
    change(page, "cam.base_radius", 41)
    settled(page)
    (tmp_path / "my.toml").write_text(DISC, encoding="utf-8")
    page.wait_for_selector("#notice-file button")
    assert "base_radius = 41" in page.input_value("#toml")
    page.click("#notice-file button:has-text('Keep mine')")
    page.keyboard.press("Control+s")
    page.wait_for_selector("#notice-save:has-text('my.1.toml')")
    assert "base_radius = 41" in (tmp_path / "my.toml").read_text()


def test_of_two_tabs_none_loses_its_changes(page: Any, server: Server, tmp_path: Path) -> None:
    other = page.context.new_page()
    other.goto(server.url)
    settled(other)
    change(page, "cam.base_radius", 41)
    change(other, "cam.width", 17)
    settled(page)
    settled(other)
    page.click("#save")
    other.wait_for_selector("#notice-file button", timeout=20_000)
    assert "width = 17" in other.input_value("#toml")
    other.click("#notice-file button:has-text('Show the file')")
    other.wait_for_function("document.querySelector('#toml').value.includes('base_radius = 41')")
    other.click("#undo")
    other.wait_for_function("document.querySelector('#toml').value.includes('width = 17')")


def test_changes_outlive_a_reload_and_a_killed_server(page: Any, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "camgeom", "serve", str(tmp_path / "my.toml"), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=ROOT) as server:
        assert server.stdout is not None
        page.goto(server.stdout.readline().strip())
        _outlives(page, server)


def _outlives(page: Any, server: subprocess.Popen[str]) -> None:
    settled(page)
    change(page, "cam.base_radius", 41)
    settled(page)
    page.on("dialog", lambda dialog: dialog.accept())
    page.reload()
    settled(page)
    assert "base_radius = 41" in page.input_value("#toml")
    assert page.locator("#notice-left").is_visible()
    server.kill()
    page.wait_for_selector("#notice-gone", timeout=60_000)
    with page.expect_download() as download:
        page.click("#notice-gone button:has-text('Download')")
    assert "base_radius = 41" in Path(download.value.path()).read_text()
