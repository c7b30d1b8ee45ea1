"""Every option of `camgeom design`, for every kind: it changes the profile that is designed, or is refused by name."""

from __future__ import annotations

import argparse
import json
import tomllib
from math import degrees
from pathlib import Path

import pytest

from camgeom.cams import starter
from camgeom.cli import _add_design, main
from camgeom.cli.design import KINDS, OPTIONS
from camgeom.model import Model
from camgeom.profile import read
from tests.places import PROFILES

DRIVE = {"stops": "6", "ratio": "0.8", "center-distance": "180"}
OFFSET, FLAT = (["--profile", str(PROFILES / f"disc_{name}.toml")] for name in ("offset_roller", "flat_face"))
OTHER = {
    "stops": "8", "motion-angle": "150", "ratio": "1.1", "center-distance": "160", "envelope": "400", "speed": "90",
    "inertia": "0.5", "torque": "20", "life": "9000", "name": "another", "pressure-angle": "22", "convex-radius": "60",
    "contact-pressure": "250", "profile": str(PROFILES / "disc_flat_face.toml"), "best-offset": "", "law": "cycloidal",
    "accurate-dwell": "",
}  # fmt: skip
"""another value of every option, so sharp that it decides"""
OF_KIND = {
    ("globoidal", "pressure-angle"): "42", ("globoidal", "contact-pressure"): "500",
    ("disc", "pressure-angle"): "20", ("disc", "contact-pressure"): "230",
    ("conjugate", "pressure-angle"): "30", ("conjugate", "contact-pressure"): "350",
    ("conjugate", "convex-radius"): "115",
    ("conjugate", "profile"): str(PROFILES / "conjugate_rocker.toml"),
    ("end-face", "pressure-angle"): "25", ("end-face", "contact-pressure"): "210",
    ("end-face", "profile"): str(PROFILES / "end_face_lifter.toml"),
    ("constant-width", "contact-pressure"): "40", ("constant-width", "convex-radius"): "40",
    ("constant-width", "profile"): str(PROFILES / "constant_width_press.toml"),
}  # fmt: skip
"""the same where what decides differs"""
INSTEAD = {"motion-angle": "ratio", "envelope": "center-distance"}
"""options that take the place of another"""
BESIDE = {("disc", "best-offset"): OFFSET}
"""what an option needs beside it to mean something"""


_usual: dict[tuple[str, ...], str] = {}
"""what a kind is designed to without the option, kept for the next option"""


def options() -> list[str]:
    """All options but --json, as the parser has them."""
    parser = argparse.ArgumentParser(add_help=False)
    _add_design(parser)
    words = [action.option_strings[0].removeprefix("--") for action in parser._actions if action.option_strings]
    return [word for word in words if word != "json"]


def designed(kind: str, given: dict[str, str], more: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Exit status, and the profile as data or what refuses it."""
    words = [part for key, value in given.items() for part in (f"--{key}", value) if part]
    status = main(["design", kind, *words, *more, "--json"])
    shown = capsys.readouterr()
    return status, str(tomllib.loads(json.loads(shown.out)["profile"])) if status == 0 else shown.err


@pytest.mark.parametrize("option", options())
@pytest.mark.parametrize("kind", KINDS)
def test_every_option_acts_or_is_refused_by_name(
    kind: str, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    value = OF_KIND.get((kind, option), OTHER[option])
    base = DRIVE if kind == "globoidal" else {}
    given = {key: text for key, text in base.items() if key != INSTEAD.get(option)} | {option: value}
    more = BESIDE.get((kind, option), [])
    status, said = designed(kind, given, more, capsys)
    if option.replace("-", "_") not in OPTIONS[kind]:
        assert status == 2
        assert f"--{option}: nothing in the design of a {kind} cam hangs on it" in said
    elif status == 2:
        assert f"--{option}" in said
        assert (kind, option) in (("constant-width", "pressure-angle"), ("constant-width", "best-offset"),
                                  ("conjugate", "best-offset"))  # fmt: skip
    else:
        # The press of the paper stands still and starts with a jump of the acceleration.
        assert status == int((kind, option) == ("constant-width", "profile")), said
        key = (kind, *more)
        if key not in _usual:
            _usual[key] = designed(kind, base, more, capsys)[1]
        assert said != _usual[key]


def test_a_flat_face_has_no_pressure_angle_to_keep(capsys: pytest.CaptureFixture[str]) -> None:
    status, said = designed("disc", {"pressure-angle": "20"}, FLAT, capsys)
    assert status == 2
    assert "pushes square" in said
    assert designed("disc", {"pressure-angle": "20"}, OFFSET, capsys)[0] == 0


def test_the_contact_pressure_bounds_a_drive(capsys: pytest.CaptureFixture[str]) -> None:
    status, said = designed("globoidal", DRIVE | {"contact-pressure": "30"}, [], capsys)
    assert status == 1
    assert "turret-pressure" in said
    assert designed("globoidal", DRIVE | {"contact-pressure": "60"}, [], capsys)[0] == 0


def test_all_idle_options_are_told_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", "disc", "--stops", "6", "--speed", "60"]) == 2
    assert "--stops, --speed: nothing" in capsys.readouterr().err


@pytest.mark.parametrize("units", ["mm", "inch"])
def test_the_smallest_end_face_keeps_its_limit_and_a_smaller_one_does_not(
    units: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = []
    if units == "inch":
        text = starter("end-face").replace("my end-face cam\"", "in inches\"\nunits = \"inch\"")
        for key, value in (("diameter", 120), ("inner_diameter", 84), ("height", 40), ("web", 15), ("bore", 30),
                           ("diameter", 26), ("length", 14), ("to", 20)):  # fmt: skip
            text = text.replace(f"{key} = {value}", f"{key} = {value / 25.4:.12g}", 1)
        (tmp_path / "inch.toml").write_text(text.replace("tolerance = 0.005", "tolerance = 0.0002"), encoding="utf-8")
        given = ["--profile", str(tmp_path / "inch.toml")]
    assert main(["design", "end-face", str(tmp_path / "out.toml"), "--pressure-angle", "28", *given]) == 0
    assert "pressure angle decides" in capsys.readouterr().out
    profile = read(tmp_path / "out.toml")
    assert degrees(Model(profile).pressure_angle.value) <= 28.0
    wide = profile.cam.diameter - profile.cam.inner_diameter
    assert wide == pytest.approx(36.0, abs=1e-9)
    near = profile.cam.model_copy(update={"diameter": profile.cam.diameter - 0.05,
                                          "inner_diameter": profile.cam.inner_diameter - 0.05})  # fmt: skip
    assert degrees(Model(profile.model_copy(update={"cam": near})).pressure_angle.value) > 28.0


def test_an_end_face_that_no_ring_can_be_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    status, said = designed("end-face", {"pressure-angle": "0.5"}, [], capsys)
    assert status == 1
    assert "no middle radius of the ring" in said
    status, said = designed("end-face", {"profile": str(PROFILES / "disc_flat_face.toml")}, [], capsys)
    assert status == 2
    assert "is not the kind to design" in said
