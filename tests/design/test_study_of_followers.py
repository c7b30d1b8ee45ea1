"""Studies and searches of cams with several followers: no figure of one stands for all, and none without its number."""

from __future__ import annotations

import csv
import json
from functools import partial
from pathlib import Path

import pytest

from camgeom.checks import light_checks
from camgeom.cli import main
from camgeom.design.batch import offered
from camgeom.design.requirement import figure_name, limits_of
from camgeom.design.study import Row
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.measured import STUDIED, measure, of_followers, product_of
from camgeom.report.result import compute
from tests.places import PROFILES
from tests.reference.rising_disc import rising_disc

FACES = PROFILES / "both_faces_disc.toml"
STATIONS = rising_disc() + ("[operation]\nspeed = 120\nspring_preload = 400\n[[station]]\nangle = 100\n"
                            "spring_preload = 900\n[[station]]\nangle = 250\n")  # fmt: skip
measured = partial(measure, products=STUDIED, checks=light_checks())


@pytest.fixture(scope="module")
def faces() -> Model:
    return Model(parse(FACES.read_text()))


@pytest.fixture(scope="module")
def stations() -> Model:
    return Model(parse(STATIONS))


def test_every_figure_of_a_track_has_the_number_of_its_follower(faces: Model) -> None:
    figures, _, _ = measured(faces)
    data = compute(faces, ("motion", "flank", "contact", "fatigue")).data
    assert not [name for name in figures if name.startswith(("motion.", "flank.", "contact.", "fatigue."))]
    for number, own in enumerate((data, *data["followers"]), start=1):
        for section, key in (("contact", "peak_pressure_mpa"), ("flank", "max_pressure_angle_deg"),
                             ("contact", "peak_torque_n_m")):  # fmt: skip
            assert figures[f"followers.{number}.{section}.{key}"] == own[section][key]
    assert any(name.startswith("checks.contact-pressure follower 1") for name in figures)
    assert any(name.startswith("checks.contact-pressure follower 2") for name in figures)
    assert any(name == "blank.volume_mm3" for name in figures)


def test_what_all_do_together_is_the_machine_s(faces: Model, stations: Model) -> None:
    for model in (faces, stations):
        figures, _, _ = measured(model)
        peaks = [one.carrier.peak_pressure.value for one in model.bindings]
        assert figures["together.peak_pressure_mpa"] == max(peaks)
        assert figures["together.hardest_follower"] == peaks.index(max(peaks)) + 1
        assert figures["together.peak_torque_n_m"] == pytest.approx(1e-3 * model.camshaft.peak_torque.value, rel=1e-12)
        lives = [hours for one in model.bindings for hours in one.lives.values()]
        assert (figures["together.least_life_h"] or float("inf")) == min(lives)


def test_followers_on_one_track_have_its_geometry_in_common(stations: Model) -> None:
    figures, _, _ = measured(stations)
    assert "flank.max_pressure_angle_deg" in figures
    assert not [name for name in figures if name.startswith(("contact.", "followers.1.flank."))]
    pressures = [figures[f"followers.{k}.contact.peak_pressure_mpa"] for k in (1, 2, 3)]
    assert pressures[1] > pressures[0] == pytest.approx(pressures[2])


def test_one_follower_s_figures_have_no_number() -> None:
    figures, _, _ = measured(Model(parse(STATIONS.partition("[[station]]")[0])))
    assert "contact.peak_pressure_mpa" in figures
    assert not [name for name in figures if name.startswith(("followers.", "together."))]


@pytest.mark.parametrize("case", ["faces", "stations"])
def test_an_aim_that_is_of_no_follower_is_refused(case: str, request: pytest.FixtureRequest) -> None:
    model = request.getfixturevalue(case)
    known = [*measured(model)[0], *offered(model.profile)]
    with pytest.raises(ProfileError, match=r"names several.*followers\.1\.contact\.peak_pressure_mpa, "
                       r"followers\.2\.contact\.peak_pressure_mpa, .*together\.peak_pressure_mpa"):  # fmt: skip
        figure_name("contact.peak_pressure_mpa", known, "--least")
    for name in ("followers.2.contact.peak_pressure_mpa", "together.peak_pressure_mpa", "blank.volume_mm3"):
        assert figure_name(name, known, "--least") == name


def test_the_limits_of_every_follower_bound_a_search(faces: Model) -> None:
    figures, verdict, _ = measured(faces)
    findings = compute(faces, ("checks",), light_checks()).data["checks"]
    bounds = {one.figure: one for one in limits_of(Row((), figures, verdict), findings, list(figures))}
    for number in (1, 2):
        assert f"followers.{number}.contact.peak_slice_pressure_mpa" in bounds
    assert bounds["together.peak_torque_n_m"].value == faces.profile.limits.torque_n_m


@pytest.mark.parametrize(("figure", "product"), [
    ("followers.2.contact.peak_pressure_mpa", "contact"), ("followers.1.dynamics.amplification", "dynamics"),
    ("together.peak_torque_n_m", "contact"), ("together.tolerance.yield", "tolerance"), ("solid.mass_kg", "solid"),
    ("followers", ""), ("followers.1", ""),
])  # fmt: skip
def test_a_figure_asks_for_its_product(figure: str, product: str) -> None:
    assert product_of(figure) == product
    assert of_followers(["a.b"], 1) == ["a.b"]


def test_a_search_for_one_of_several_followers_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pymoo", reason="no pymoo: scripts/test_extras installs it and runs these tests")
    path = tmp_path / "three.toml"
    path.write_text(STATIONS)
    asked = ["optimise", str(path), "--free", "cam.base_radius=34:44", "--points", "10", "--out", str(tmp_path)]
    assert main([*asked, "--least", "contact.peak_pressure_mpa"]) == 2
    assert "followers.2.contact.peak_pressure_mpa" in capsys.readouterr().err
    assert main([*asked, "--least", "together.peak_pressure_mpa"]) == 0
    assert "together.peak_pressure_mpa" in capsys.readouterr().out


def test_the_command_shows_every_follower(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "three.toml"
    path.write_text(STATIONS)
    vary, out = ["--vary", "operation.speed=100,140"], ["--out", str(tmp_path / "out")]
    assert main(["study", str(path), *vary, *out]) == 0
    header = capsys.readouterr().out.splitlines()[2].split()
    names = {f"followers.{k}.contact.peak_pressure_mpa" for k in (1, 2, 3)} | {"together.peak_pressure_mpa"}
    assert names < set(header)
    assert "contact.peak_pressure_mpa" not in header
    page = (tmp_path / "out" / "study.html").read_text()
    assert "Contact pressure, quoted place, follower 2" in page
    assert "Contact pressure, hardest follower" in page
    with (tmp_path / "out" / "study.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        assert float(row["together.peak_pressure_mpa"]) == float(row["followers.2.contact.peak_slice_pressure_mpa"])
    assert main(["study", str(path), *vary, *out, "--figures", "contact.peak_pressure_mpa"]) == 2
    assert "followers.3.contact.peak_pressure_mpa" in capsys.readouterr().err
    assert main(["study", str(path), *vary, *out, "--figures", "together.peak_pressure_mpa", "--json"]) == 0
    assert "together.peak_pressure_mpa" in json.loads(capsys.readouterr().out)["rows"][0]


@pytest.mark.parametrize(("share", "kept"), [(0.999, False), (1.002, True)])
def test_the_machine_s_pressure_is_what_the_limit_is_held_against(stations: Model, share: float, kept: bool) -> None:
    peak = measured(stations)[0]["together.peak_pressure_mpa"]
    figures, told, reason = measured(Model(parse(f"{STATIONS}[limits]\ncontact_pressure_mpa = {share * peak}\n")))
    assert (told != "fail") is ("contact-pressure" not in reason) is kept
    assert figures["followers.1.contact.peak_pressure_mpa"] < 0.9 * peak
