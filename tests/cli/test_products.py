"""A run is a set of products: each is made, refused or failed on its own, and says so; the others come."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.cli import main
from camgeom.dynamics.linear.solve import Growing
from camgeom.errors import DesignError, ExportError, GeometryEngineError, NotConverged, Problem, ProfileError, unmade
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute
from tests.cli.small import GOOD
from tests.places import PROFILES, ROOT

sys.path.insert(0, str(ROOT / "scripts" / "stability"))
import faults  # type: ignore[import-not-found]
import products as runs  # type: ignore[import-not-found]


@pytest.fixture
def profile(tmp_path: Path) -> Path:
    file = tmp_path / "small.toml"
    file.write_text(GOOD)
    return file


def ran(profile: Path, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, dict[str, Any], str]:
    """Exit status, result.json and what stderr says of a run."""
    folder = profile.parent / "o"
    status = main(["run", str(profile), "--out", str(folder), *words])
    err = capsys.readouterr().err
    assert "Traceback" not in err
    return status, json.loads((folder / "result.json").read_text()), err


STARVED = "out of memory; a larger output.tolerance, fewer segments, states, impact.turns or rows of tables need less"


@pytest.mark.parametrize(
    ("error", "status", "exit_status", "said"),
    [
        (DesignError("too small"), "refused", 1, "too small"),
        (ProfileError([Problem("a.b", "bad"), Problem("c", "worse")]), "refused", 2, "a.b: bad; c: worse"),
        (ExportError("cam.stl: cannot be written"), "failed", 1, "cam.stl: cannot be written"),
        (NotConverged("lost\nits way"), "failed", 3, "lost its way"),
        (GeometryEngineError("status 3"), "failed", 3, "status 3"),
        (MemoryError(), "failed", 3, STARVED),
        (RuntimeError("can't start new thread"), "failed", 3, STARVED),
        (ImportError("x.so: failed to map segment from shared object"), "failed", 3, STARVED),
        (ModuleNotFoundError("No module named 'ezdxf'"), "failed", 1, "No module named 'ezdxf'"),
        (PermissionError(13, "Permission denied", "x.csv"), "failed", 1, "x.csv: Permission denied"),
        (ZeroDivisionError("by 0"), "failed", 3, "ZeroDivisionError: by 0; this is a bug"),
    ],
)
def test_what_an_exception_says_of_its_product(error: Exception, status: str, exit_status: int, said: str) -> None:
    why = unmade(error)
    assert (why.status, why.exit_status) == (status, exit_status)
    assert said in why.reason
    assert "\n" not in why.reason
    assert bool(why.trace) == isinstance(error, ZeroDivisionError)


@pytest.mark.parametrize(("inner", "said"), [(KeyboardInterrupt(), ""), (MemoryError(), "out of memory")])
def test_what_ends_the_making_of_a_class_is_not_a_bug(inner: BaseException, said: str) -> None:
    """Before Python 3.12 it comes out of an import as a RuntimeError; an interrupt stays one."""
    wrapped = RuntimeError("Error calling __set_name__")
    wrapped.__cause__ = inner
    if not said:
        with pytest.raises(KeyboardInterrupt):
            unmade(wrapped)
        return
    assert said in unmade(wrapped).reason


def test_a_refusal_within_a_file_keeps_its_meaning() -> None:
    wrapped = ExportError("cam.dxf: cannot be drawn: no step")
    assert unmade(wrapped).exit_status == 1
    wrapped.__cause__ = NotConverged("no step")
    assert unmade(wrapped).exit_status == 3


@pytest.mark.parametrize(
    ("error", "status", "exit_status"),
    [
        (NotConverged("no steps left"), "failed", 3),
        (MemoryError(), "failed", 3),
        (DesignError("too weak"), "refused", 1),
        (LookupError("0"), "failed", 3),
    ],
)
def test_one_product_that_cannot_be_made_takes_none_along(
    profile: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    error: Exception,
    status: str,
    exit_status: int,
) -> None:
    def lost(_: Model) -> None:
        raise error

    monkeypatch.setattr("camgeom.model.Model.carrier", property(lost))
    found, result, _ = ran(profile, capsys, "--formats", "stl,ply,dxf")
    products = result["products"]
    assert found == exit_status
    for name in ("contact", "fatigue"):
        assert products[name]["status"] == status
        assert result[name] == {status: products[name]["reason"]}
    others = ("motion", "flank", "solid", "stl", "ply", "dxf", "report")
    assert {products[name]["status"] for name in others} == {"made"}
    # In the report the reason stands in the place of the section, and in the table of what was made.
    page = (profile.parent / "o" / "report.html").read_text()
    reason = products["contact"]["reason"]
    assert page.count(reason.partition(" (")[0]) >= 2
    assert ("trace" in products["contact"]) == isinstance(error, LookupError)


def test_memory_that_is_not_enough_for_a_body_leaves_what_needs_none(
    profile: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = []

    def starved(*_: object) -> None:
        tried.append(1)
        raise MemoryError

    monkeypatch.setattr("camgeom.solid.drum.GroovedCylinder.solid", starved)
    monkeypatch.setattr("camgeom.solid.fewest.fewest", starved)
    found, result, _ = ran(profile, capsys, "--formats", "stl,ply,ecam.csv,points.csv,step")
    products = {name: one["status"] for name, one in result["products"].items()}
    assert found == 3
    assert {products[name] for name in ("solid", "stl", "ply")} == {"failed"}
    assert {products[name] for name in ("ecam.csv", "points.csv", "step", "contact", "report")} == {"made"}
    assert len(tried) <= 2  # the body, and the one for pictures: what has failed is not tried again
    assert "larger output.tolerance" in result["products"]["stl"]["reason"]


def test_a_product_whose_being_there_cannot_be_told_takes_none_along(monkeypatch: pytest.MonkeyPatch) -> None:
    """An undercut groove has no body to ask for its stress: the run once ended without its result."""

    def lost(_: Model) -> None:
        raise DesignError("undercut")

    monkeypatch.setattr("camgeom.model.Model.root_stress", property(lost))
    result = compute(Model(parse(GOOD)), ("motion", "body"))
    assert (result.products["body"].status, result.products["body"].reason) == ("refused", "undercut")
    assert result.products["motion"].status == "made"
    assert result.exit_status == 1


def test_a_turn_that_grows_can_be_told_with_its_file() -> None:
    error = Growing("a turn grows", 1.3)
    assert (type(error)(f"a.csv: {error}").radius, error.radius) == (np.inf, 1.3)


def test_a_check_without_figures_is_not_judged_and_the_others_are(monkeypatch: pytest.MonkeyPatch) -> None:
    def lost(_: Model) -> None:
        raise NotConverged("no steps left")

    monkeypatch.setattr("camgeom.model.Model.flanks", property(lost))
    result = compute(Model(parse(GOOD)), ("checks",), ("undercut", "continuity"))
    assert [finding.check for finding in result.findings] == ["continuity"]
    assert [word.as_dict() for word in result.verdict.not_judged] == [{"check": "undercut", "reason": "no steps left"}]
    assert result.exit_status == 3
    assert result.products["checks"].reason == "undercut: no steps left"


def test_check_and_run_tell_the_same_of_formats_before_anything_is_computed(
    profile: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile.write_text(GOOD.replace('["stl"]', '["stl", "outline.csv", "gcode", "polydyne.csv"]'))
    found, result, err = ran(profile, capsys)
    told = {name: one for name, one in result["products"].items() if one["status"] == "not applicable" and "." in name}
    assert found == 1
    assert result["products"]["gcode"]["status"] == "not applicable"
    assert main(["check", str(profile), "--json"]) == 1
    captured = capsys.readouterr()
    checked = json.loads(captured.out)["products"]
    for name in ("outline.csv", "gcode", "polydyne.csv"):
        assert checked[name] == result["products"][name]
        assert f"no {name}: " in err
        assert f"no {name}: " in captured.err
    assert "stl" not in checked
    assert "polydyne.csv" in told
    # The sound neighbour.
    profile.write_text(GOOD)
    assert main(["check", str(profile)]) == 0
    assert ran(profile, capsys)[0] == 0


def test_a_refusal_is_kept_and_comes_back_as_it_was() -> None:
    data = GOOD.replace("diameter = 12", "diameter = 24").replace("until = 180", "until = 55")
    model = Model(parse(data))
    said = []
    for _ in range(2):
        with pytest.raises(DesignError) as caught:
            _ = model.solids
        said.append(str(caught.value))
    assert said[0] == said[1]
    assert "undercut" in said[0]


def test_a_mark_without_a_place_stands_at_the_edge() -> None:
    from camgeom.drawing.content import Axis, Chart, Mark, Panel, Series
    from camgeom.drawing.plots import chart_sheet

    x = np.linspace(0.0, 1.0, 5)
    for y in (0.5, np.inf):
        panel = Panel(Axis("y"), (Series("s", x, x),), marks=(Mark(0.0, float(y), "unbounded"),))
        drawn = chart_sheet(Chart("c", Axis("x"), (panel,)), 600.0).render("c")
        assert "inf" not in drawn.replace("info", "")
        assert "nan" not in drawn


@pytest.mark.slow
def test_every_fault_costs_its_product_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A short stretch of scripts/stability/faults.py; of the libraries the one that a disc's files need."""
    monkeypatch.setattr(faults, "LIBRARIES", ("scipy",))
    said: list[str] = []
    counts = faults.campaign(("write", "memory", "library"), ("disc",), 3, said.append)
    assert not said
    assert sum(counts.values()) >= 7


@pytest.mark.slow
@pytest.mark.parametrize("seed", [9, 20, 34, 85, 117])
def test_whole_profiles_at_random(seed: int) -> None:
    """A short stretch of scripts/run_campaign."""
    runs.begin()
    record = runs.run(seed, True, True, 0.0)
    assert record["class"] in ("0", "1", "2", "3", "refused", "killed"), record["why"]


def test_what_an_extra_makes_is_told_with_its_pip_line_and_the_rest_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from camgeom.report import painter

    monkeypatch.setattr(painter, "find_spec", lambda name: None)
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    profile = str(PROFILES / "disc_offset_roller.toml")
    assert main(["build", profile, "--formats", "stl,dxf,png", "--out", str(tmp_path)]) == 1
    told = capsys.readouterr()
    assert "pip install 'camgeom[dxf]'" in told.err + told.out
    assert "pip install 'camgeom[pictures]'" in told.err + told.out
    assert list(tmp_path.glob("*.stl"))
    assert not list(tmp_path.glob("*.dxf"))


def test_a_pyvista_mesh_without_pyvista_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    import camgeom

    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(camgeom.ExportError, match=r"pip install 'camgeom\[pictures\]'"):
        camgeom.read(PROFILES / "disc_offset_roller.toml").solid.to_pyvista()


def test_memory_that_runs_out_between_two_products_leaves_the_result(
    profile: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where it is an import that finds none: what was made stands, what was not says why."""

    def starved(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("camgeom.report.delivery._pictures", starved)
    found, result, _ = ran(profile, capsys, "--formats", "stl,png,mp4")
    products = {name: one["status"] for name, one in result["products"].items()}
    assert found == 3
    assert {products[name] for name in ("solid", "stl", "contact")} == {"made"}
    assert {products[name] for name in ("png", "mp4", "report")} == {"failed"}
    assert "out of memory" in result["products"]["report"]["reason"]
    assert (profile.parent / "o" / "manifest.json").exists()
