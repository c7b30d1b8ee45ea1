"""The validation of the sources: its rule on both sides, its page, its command."""

from __future__ import annotations

import json
import subprocess
import sys
from math import nan
from pathlib import Path

import pytest

from camgeom.cli import main
from camgeom.validation import SOURCES, Answer, Entry, JudgedEntry, Reading, validate
from camgeom.validation.entry import judge, last_digit
from camgeom.validation.machine import machine
from camgeom.validation.page import markdown
from tests.places import ROOT

PAGE = ROOT / "docs" / "validation.md"


def _judged(printed: str, answer: Answer, **changes: object) -> JudgedEntry:
    return judge("S0", Entry("item", "place", "says", printed, "1", lambda: answer, **changes))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("printed", "half"), [("1168", 0.5), ("27.0", 0.05), ("0.449", 0.0005), ("1.2329e6", 50.0), ("120.341", 0.0005)]
)
def test_half_a_unit_of_the_last_printed_digit(printed: str, half: float) -> None:
    assert last_digit(printed) == pytest.approx(half, rel=1e-12)
    value = float(printed)
    assert _judged(printed, Answer(value + 0.999 * half)).verdict == "confirmed"
    assert _judged(printed, Answer(value - 1.002 * half)).verdict == "not reproducible"


def test_a_misprint_needs_a_reading_that_explains_it() -> None:
    near, far = Reading("with '+'", 10.04), Reading("with '-'", 10.06)
    row = _judged("10.0", Answer(12.0, (far, near)))
    assert row.verdict == "misprint"
    assert "'+'" in row.reason
    assert "'-'" not in row.reason
    row = _judged("10.0", Answer(12.0, (far,)))
    assert row.verdict == "not reproducible"
    assert "Tried: with '-' 10.06" in row.reason
    assert _judged("10.0", Answer(10.01, (near,))).verdict == "confirmed"


def test_an_equation_is_held_to_the_exact_computation() -> None:
    corrected = Reading("with the half width", 2.0)
    assert _judged("", Answer(2.0, printed=2.0 * (1.0 + 0.999e-6))).verdict == "confirmed"
    assert _judged("", Answer(2.0, printed=2.0 * (1.0 + 1.002e-6))).verdict == "not reproducible"
    assert _judged("", Answer(2.0, (corrected,), printed=4.0)).verdict == "misprint"
    assert _judged("", Answer(2.0, (Reading("another", 2.1),), printed=4.0)).verdict == "not reproducible"


def test_a_bound_holds_or_not() -> None:
    assert _judged("1", Answer(1.002), comparison=">").verdict == "confirmed"
    assert _judged("1", Answer(0.999), comparison=">").verdict == "not reproducible"
    assert _judged("1", Answer(0.999), comparison="<").verdict == "confirmed"


def test_no_value_that_is_none() -> None:
    for answer in (Answer(nan), Answer(1.0), Answer(1.0, (Reading("x", nan),), 1.0)):
        with pytest.raises(ValueError, match="no finite value"):
            _judged("", answer)


def test_items_have_names_of_their_own() -> None:
    for source in SOURCES:
        names = [entry.item for entry in source.entries]
        assert len(set(names)) == len(names), source.short


@pytest.fixture(scope="module")
def quick() -> list[JudgedEntry]:
    return validate(slow=False)


def test_what_takes_no_time_stands_in_the_page_as_it_comes_out(quick: list[JudgedEntry]) -> None:
    text = PAGE.read_text(encoding="utf-8")
    for line in markdown(SOURCES, quick).splitlines():
        if line.startswith("| ") and not line.startswith("| item"):
            assert line in text, "run `python scripts/validation_page.py`"


@pytest.mark.slow
def test_the_page_is_current() -> None:
    done = subprocess.run(
        [sys.executable, "scripts/validation_page.py", "--check"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"run `python scripts/validation_page.py` {done.stderr}"


def test_the_audit_of_the_sources_is_whole() -> None:
    """Every item of the validation stands in the audit, every row of it has an item or a reason and a command."""
    lines = (ROOT / "docs" / "sources.tsv").read_text(encoding="utf-8").splitlines()[1:]
    rows = [line.split("\t") for line in lines]
    assert all(len(row) == 5 and row[0] and row[1] and row[2] and row[4].strip("! ") for row in rows)
    named = {(row[0], item.strip()) for row in rows if not row[4].startswith("!") for item in row[4].split(", ")}
    assert named == {(source.short, entry.item) for source in SOURCES for entry in source.entries}
    shown = {word for row in rows for word in row[3].split() if word.startswith("profiles/")}
    assert all((ROOT / name).is_file() for name in shown)
    assert len(rows) >= 120


def test_the_papers_trends_and_figures_of_the_groove_cam(quick: list[JudgedEntry]) -> None:
    """Computed independently for this project beforehand, theory of the groove cam's fatigue."""
    rows = {row.item: row for row in quick if row.source == "S1"}
    tried = {reading.what[:12]: reading.value for reading in rows["peak-pressure"].tried}
    assert rows["peak-pressure"].computed == pytest.approx(1004.677, abs=1e-3)
    assert tried == pytest.approx(
        {"(11) as prin": 989.908, "(11) with '+": 1178.359, "flat wall, 1": 1072.765, "true wall of": 998.895}, abs=1e-3
    )
    assert rows["trend-length"].verdict == "confirmed"
    assert rows["trend-roller"].tried[1].value == pytest.approx(15.12, abs=0.01)
    assert rows["trend-speed"].tried[1].value == pytest.approx(0.448, abs=5e-4)
    assert rows["undercut-50"].computed < 0.0


def test_the_drive_of_eleven_degrees_of_freedom(quick: list[JudgedEntry]) -> None:
    """Computed independently for this project beforehand, theory of the indexing dynamics, A.3, A.4 and A.6."""
    rows = {row.item: row for row in quick if row.source == "S4"}
    tried = {reading.what: reading.value for reading in rows["frequency"].tried}
    assert rows["frequency"].computed == pytest.approx(245.686461, abs=1e-6)
    assert tried["K12 tau'^2 left out, modified-trapezoid"] == pytest.approx(165.688011, abs=1e-6)
    assert tried["K12 tau'^2 left out, modified-sine"] == pytest.approx(190.1325, abs=1e-6)
    assert rows["(25)"].printed == pytest.approx(265.555936, abs=1e-6)
    assert rows["plate-655"].computed == pytest.approx(684.268976343, abs=1e-6)
    assert rows["plate-1639"].computed == pytest.approx(4288.597293768, abs=1e-5)
    assert rows["plate-high"].computed == pytest.approx(18625.694665559, abs=1e-4)
    assert rows["lateral"].verdict == "misprint"
    assert rows["plate-655 possible"].computed == pytest.approx(540.2, abs=0.1)


def test_the_conjugate_cams_equations(quick: list[JudgedEntry]) -> None:
    """Computed independently for this project beforehand, theory of the conjugate clearance, B.1 and B.2."""
    rows = {row.item: row for row in quick if row.source == "S5"}
    assert rows["geometry"].computed == pytest.approx(95.0, abs=1e-3)
    assert rows["clearance"].computed == pytest.approx(0.08382, abs=1e-5)
    assert rows["restitution"].computed == pytest.approx(0.895918, abs=1e-6)
    assert rows["(9)"].printed == pytest.approx(72474.94789 / 1e-4, rel=1e-6)
    assert rows["(9)"].computed == pytest.approx(9656.888460 / 1e-4, rel=1e-6)
    for item in ("(5)", "(7)", "(8) n", "(9)", "(24)", "(26)"):
        assert rows[item].verdict == "misprint", item


def test_the_design_specifications_restored_chain_and_the_losses(quick: list[JudgedEntry]) -> None:
    """(18) to (32) of S3 and (15), (17) of S4, by the printed terms, against the product's own flank and matrices."""
    rows = {(row.source, row.item): row for row in quick}
    for key in (("S3", "(18)-(32)"), ("S3", "stops least"), ("S4", "(15)"), ("S4", "(17)")):
        assert rows[key].verdict == "confirmed", key
    assert rows["S3", "(18)-(32)"].printed == pytest.approx(rows["S3", "(18)-(32)"].computed, rel=1e-10)


@pytest.mark.slow
def test_the_growth_over_turns_of_stable_running() -> None:
    """Mean peak of the turns 2 to 6, theory B.3: 2.39 and 3.7 (a motion that is not periodic: within a third)."""
    means = []
    for clearance in (0.01, 0.1, 1.0):
        run = machine("conjugate_rocker", ("follower.clearance", clearance), ("impact.turns", 6)).impact
        assert run is not None
        turns = [run.problem.period * k for k in range(1, 7)]
        means.append(sum(run.peak("acceleration", *span).value for span in zip(turns, turns[1:])) / 5.0)
    assert means[0] == pytest.approx(6444.0, rel=1e-3)
    assert means[1] / means[0] == pytest.approx(2.39, abs=0.01)
    assert 3.2 < means[2] / means[1] < 4.8


@pytest.mark.parametrize("name", sorted(path.stem for path in (ROOT / "camgeom" / "validation").glob("*.toml")))
def test_a_machine_of_a_source_is_that_of_its_shipped_profile(name: str) -> None:
    """One set of printed data: what the validation and the profile of the same name both give is the same."""
    from camgeom.profile import read

    shipped = read(str(ROOT / "profiles" / f"{name}.toml"))
    own = machine(name).profile
    assert own.motion == shipped.motion
    for section in ("cam", "follower", "roller", "operation", "material", "dynamics", "impact"):
        ours, theirs = getattr(own, section), getattr(shipped, section)
        for key in ours.model_fields_set if ours is not None else ():
            if section == "material":
                for field in getattr(ours, key).model_fields_set:
                    assert getattr(getattr(theirs, key), field) == getattr(getattr(ours, key), field), (key, field)
            else:
                assert getattr(theirs, key) == getattr(ours, key), (section, key)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", "s2", "--json", "--out", str(tmp_path)]) == 0
    data = json.loads(capsys.readouterr().out)
    keys = {"source", "item", "printed", "computed", "unit", "verdict", "reason"}
    assert data["rows"]
    assert all(keys <= set(row) for row in data["rows"])
    assert {row["verdict"] for row in data["rows"]} <= {"confirmed", "misprint", "not reproducible"}
    assert json.loads((tmp_path / "validation.json").read_text()) == data
    assert data["rows"][0]["item"] in (tmp_path / "validation.html").read_text()
    assert main(["validate", "pin-insertion"]) == 0
    assert "Tried: (11) as printed" in capsys.readouterr().out
    assert main(["validate", "pin-insertio"]) == 2
    assert "pin-insertion" in capsys.readouterr().err


def test_other_commands_do_not_import_it() -> None:
    code = "import sys; from camgeom.cli import main; main(['check', 'profiles/pin_insertion.toml']); " \
        "sys.exit('camgeom.validation' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, check=False)
    assert done.returncode == 0
