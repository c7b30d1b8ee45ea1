"""Materials by name: what a grade fills in, what may stand beside it, and what that lets the contact bear."""

from __future__ import annotations

import json

import pytest
from pydantic import ValidationError

import camgeom
from camgeom.checks import judge
from camgeom.cli import main
from camgeom.errors import ProfileError
from camgeom.mechanics.grades import grades
from camgeom.mechanics.hardness import hardness_bound
from camgeom.mechanics.material import Material
from tests.places import PROFILES

PIN = (PROFILES / "pin_insertion.toml").read_text(encoding="utf-8")


def made(**keys: object) -> Material:
    return Material.model_validate(keys)


def test_a_grade_gives_what_is_not_stated() -> None:
    steel = made(grade="20Cr")
    assert (steel.hardness, steel.case_depth_mm, steel.elastic_modulus, steel.poisson) == (58.0, 0.8, 206000.0, 0.3)
    assert steel.contact_limit == hardness_bound(58.0) == 1000.0
    assert steel.name == "20Cr, carburised and hardened, 58 to 63 HRC"
    assert made(grade="HT250").contact_limit == 600.0
    assert made(grade="QT600-3").elastic_modulus == 127000.0


@pytest.mark.parametrize(("hardness", "limit"), [(59.94, 1000.0), (60.12, 2450.0)])
def test_a_stated_hardness_decides_what_it_bears(hardness: float, limit: float) -> None:
    assert made(grade="20Cr", hardness=hardness).contact_limit == limit


@pytest.mark.parametrize(("hardness", "sound"), [(62.9, True), (63.1, False), (58.0, True), (57.9, False)])
def test_a_hardness_that_the_treatment_does_not_give_is_refused(hardness: float, sound: bool) -> None:
    if sound:
        assert made(grade="20Cr", hardness=hardness).hardness == hardness
    else:
        with pytest.raises(ValidationError, match="58 to 63"):
            made(grade="20Cr", hardness=hardness)


def test_without_a_printed_hardness_it_has_to_be_given() -> None:
    with pytest.raises(ValidationError, match="prints no hardness of 38CrMnAl"):
        made(grade="38CrMnAl")
    assert made(grade="38CrMnAl", hardness=62.0).contact_limit == 2450.0
    assert made(grade="38CrMnAl", contact_limit=900.0).contact_limit == 900.0


def test_a_stated_limit_is_kept_and_held_to_the_hardness() -> None:
    """1000 MPa are what 58 HRC bear: 999 pass the check, 1002 fail it."""
    for limit, level in ((999.0, "pass"), (1002.0, "fail")):
        text = PIN[: PIN.index("[material.cam]")] + (
            f'[material.cam]\ngrade = "20Cr"\ncontact_limit = {limit}\n[limits]\ncontact_pressure_mpa = {limit}\n'
        )
        (finding,) = [one for one in judge(camgeom.read(text), ["hardness"]).findings if one.where.startswith("cam")]
        assert (finding.level, finding.limit) == (level, 1000.0)


def test_an_unknown_grade_has_the_nearest_name() -> None:
    with pytest.raises(ProfileError, match="did you mean 'GCr15'"):
        camgeom.read(PIN[: PIN.index("[material.cam]")] + '[material.cam]\ngrade = "GC15"\n')


def test_every_grade_has_a_place_and_is_sound() -> None:
    assert len(grades()) >= 17
    assert {"cam", "roller"} == {body for one in grades().values() for body in one.of}
    for name, one in grades().items():
        keys = {} if one.limit is not None else {"hardness": 60.0}
        assert made(grade=name, **keys).grade == name
        assert one.place


def test_the_command_lists_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["materials", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["materials"]}
    assert rows["GCr15"]["contact_limit"] == 2450.0
    assert rows["5CrW2Si"]["contact_limit"] is None
    assert main(["materials"]) == 0
    assert "by hardness" in capsys.readouterr().out
