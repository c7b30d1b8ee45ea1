"""The documentation says what is so: the tutorial's commands run, the reference of keys is that of the schema."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from camgeom.cli import main
from camgeom.report import result_schema
from tests.places import ROOT

DOCS = ROOT / "docs"
BLOCK = re.compile(r"^```(sh|toml)\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)#:]+)\)")


def _steps() -> list[tuple[str, str, int]]:
    """What the tutorial does, in order: ("write", text) and ("run", command) with the exit status it states."""
    steps = []
    for kind, body in BLOCK.findall((DOCS / "tutorial.md").read_text(encoding="utf-8")):
        if kind == "toml":
            steps.append(("write", body, 0))
            continue
        for line in body.splitlines():
            command, _, remark = line.partition("  #")
            status = int(remark.rpartition(" ")[2]) if "exit status" in remark else 0
            steps.append(("run", command.strip(), status))
    return steps


@pytest.mark.slow
def test_tutorial_runs_as_it_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    seen = []
    for what, text, status in _steps():
        if what == "write":
            name = text.splitlines()[0].removeprefix("# ")
            Path(name).write_text(text, encoding="utf-8")
            continue
        words = shlex.split(text)
        assert words[0] == "camgeom"
        # A second process each would take longer than the commands themselves.
        extra = ["--jobs", "1"] if words[1] == "study" else []
        assert main([*words[1:], *extra]) == status, text
        seen.append((text, capsys.readouterr().out))
    written = {path.name for path in Path("exports").rglob("*")}
    assert {"feed-cam.3mf", "feed-cam.step", "report.html", "result.json", "study.csv", "feed-cam.stl"} <= written
    said = dict(seen)
    assert "42.4" in said["camgeom check feed.toml"] or any("42.4" in out for _, out in seen)
    assert "4 fails" not in said[next(text for text, _ in seen if "160:200:3" in text)]


DISC = """
[cam]
kind = "disc"
base_radius = 40
width = 12
[follower]
kind = "translating"
[roller]
diameter = 20
length = 12
[[motion]]
until = {until}
to = {rise}
law = "cycloidal"
[[motion]]
until = 360
to = 0
law = "cycloidal"
"""
TYPES = {"object": dict, "array": list, "string": str, "integer": int, "number": (int, float)}


def _astray(value: object, schema: dict[str, Any], at: str) -> Iterator[str]:
    """Where a value is not what a schema says: types, enum, required, properties, items."""
    if "enum" in schema and value not in schema["enum"]:
        yield f"{at} is {value!r}"
    if "type" in schema and not isinstance(value, TYPES[schema["type"]]):
        yield f"{at} is no {schema['type']}"
    elif isinstance(value, dict):
        yield from (f"{at} has no {key}" for key in schema.get("required", ()) if key not in value)
        rest = schema.get("additionalProperties", True)
        for key, item in value.items():
            own = schema.get("properties", {}).get(key, rest)
            if own is False:
                yield f"{at}.{key} is not described"
            elif isinstance(own, dict):
                yield from _astray(item, own, f"{at}.{key}")
    elif isinstance(value, list):
        for item in value:
            yield from _astray(item, schema["items"], f"{at}[]")


def test_result_and_manifest_are_as_described(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (DOCS / "result.md").read_text(encoding="utf-8")
    found = re.findall(r"^```json schema (\w+)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    schemas = {"products": result_schema.products(), **{name: json.loads(body) for name, body in found}}
    statuses = set()
    for case, rise, until in (("sound", 5, 90), ("undercut", 40, 15)):  # the steep one has no body
        (tmp_path / f"{case}.toml").write_text(DISC.format(rise=rise, until=until), encoding="utf-8")
        words = ["run", str(tmp_path / f"{case}.toml"), "--out", str(tmp_path / case), "--formats", "stl,rest.csv"]
        assert main([*words, "--tolerance", "0.1"]) == 1, capsys.readouterr().err
        products = json.loads((tmp_path / case / "result.json").read_text())["products"]
        assert list(_astray(products, schemas["products"], "products")) == []
        assert list(_astray(json.loads((tmp_path / case / "manifest.json").read_text()), schemas["manifest"], "")) == []
        statuses |= {product["status"] for product in products.values()}
        assert all(product.get("reason") for product in products.values() if product["status"] != "made")
    assert statuses == {"made", "not applicable", "refused"}
    assert list(_astray({"stl": {"status": "lost"}}, schemas["products"], "")) == [".stl.status is 'lost'"]
    more = {"stl": {"status": "made", "why": ""}}
    assert list(_astray(more, schemas["products"], "")) == [".stl.why is not described"]


def test_reference_of_keys_is_current() -> None:
    done = subprocess.run(
        [sys.executable, "scripts/profile_reference.py", "--check"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, f"run `python scripts/profile_reference.py` {done.stderr}"


PAGES = ("README.md", *(f"docs/{name}.md" for name in ("tutorial", "profile", "theory", "search")))


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in LINK.findall(text):
        assert ((ROOT / page).parent / target).exists(), target


def test_pictures_of_the_readme_are_small() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    pictures = [ROOT / target for target in LINK.findall(text) if target.endswith((".png", ".gif"))]
    assert pictures
    assert sum(path.stat().st_size for path in pictures) < 500_000


def test_files_that_the_readme_names_exist() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for name in re.findall(r"`((?:scripts|profiles|camgeom)/[\w./*-]+)`", text):
        assert list(ROOT.glob(name.rstrip("/"))), name


def test_the_reference_of_python_names_is_that_of_the_docstrings() -> None:
    done = subprocess.run([sys.executable, "scripts/api_reference.py", "--check"], cwd=ROOT, check=False)
    assert done.returncode == 0, "run scripts/api_reference.py"
