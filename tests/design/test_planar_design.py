"""Design helpers: smallest radii hit their limits exactly, tool paths, balance, outlines as data."""

from __future__ import annotations

import csv
import json
import re
from math import degrees, hypot, pi, radians
from pathlib import Path

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.cli import main
from camgeom.design.planar import (
    PlanarLimits,
    balance,
    best_offset,
    margins,
    smallest_base_radius,
    smallest_prime_radius,
    with_key,
)
from camgeom.errors import DesignError, ExportError
from camgeom.export import write
from camgeom.model import Model
from camgeom.profile import read as read_profile
from camgeom.track.outline import OutlineIntegrals, ParallelOutline
from tests.places import PROFILES
from tests.reference.machines import pin_cam, pin_setup
from tests.reference.planar_machines import HARMONIC, disc, flat, smallest_flat_base


@pytest.mark.parametrize("offset", [-8.0, 0.0, 8.0])
@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_smallest_prime_radius_meets_the_limit(offset: float, direction: str) -> None:
    program = disc().setup.program
    sense = 1.0 if direction == "ccw" else -1.0
    prime = smallest_prime_radius(program, radians(25.0), offset, sense)
    cam = f'base_radius = {prime - 10.0}\ndirection = "{direction}"'
    model = disc(cam, f'kind = "translating"\noffset = {offset}')
    assert degrees(model.planar.pressure_angle.value) == pytest.approx(25.0, abs=1e-9)
    solved = smallest_base_radius(model.profile, PlanarLimits(25.0, None), 5.0, 300.0)
    assert solved == pytest.approx(prime - 10.0, rel=1e-9)


def test_offset_makes_the_cam_smaller_where_the_return_may_be_steeper() -> None:
    program = disc().setup.program
    best = best_offset(program, radians(25.0), back=radians(45.0))
    assert best < 0.0
    smallest = smallest_prime_radius(program, radians(25.0), best, back=radians(45.0))
    for other in (best - 0.5, best + 0.5, 0.0):
        assert smallest_prime_radius(program, radians(25.0), other, back=radians(45.0)) > smallest


def test_harmonic_cam_is_as_small_as_the_closed_form() -> None:
    """Prime radius of the stroke for asin(1/3): the textbook cam turned round."""
    program = disc("base_radius = 40.8", motion=HARMONIC).setup.program
    assert smallest_prime_radius(program, np.arcsin(1.0 / 3.0)) == pytest.approx(50.8, rel=1e-9)


def test_smallest_flat_base_just_keeps_the_radius() -> None:
    base = smallest_flat_base(flat().setup.program, 5.0)
    assert flat(cam=f"base_radius = {base}").planar.face_radius.value == pytest.approx(5.0, abs=1e-9)
    assert smallest_base_radius(flat().profile, PlanarLimits(None, 5.0)) == pytest.approx(base, rel=1e-9)


def test_contact_stress_and_curvature_set_the_size() -> None:
    model = flat(rest="[operation]\nspeed = 100\nspring_preload = 900")
    radius = smallest_base_radius(model.profile, PlanarLimits(None, 0.0, 300.0))
    at = flat(cam=f"base_radius = {radius}", rest="[operation]\nspeed = 100\nspring_preload = 900")
    assert at.drive.peak_pressure.value == pytest.approx(300.0, rel=1e-6)
    roller = disc(motion=[(60, 20, "cycloidal"), (360, 0, "cycloidal")])
    radius = smallest_base_radius(roller.profile, PlanarLimits(None, 4.0))
    sharp = disc(f"base_radius = {radius}", motion=[(60, 20, "cycloidal"), (360, 0, "cycloidal")])
    assert sharp.planar.radii[0].value == pytest.approx(4.0, rel=1e-7)


def test_no_radius_is_refused_with_the_limit_that_fails() -> None:
    with pytest.raises(DesignError, match="pressure angle fails"):
        smallest_base_radius(disc().profile, PlanarLimits(1.0), 5.0, 50.0)


def test_tool_paths_are_parallel_to_the_profile() -> None:
    model = disc("", 'kind = "translating"\noffset = 7')
    phi = np.linspace(0.0, 2.0 * pi, 361)
    profile, pitch = model.planar.outlines["profile"], model.planar.outlines["pitch curve"].curve(phi)
    same = ParallelOutline(profile, 10.0).curve(phi)
    assert same.points == pytest.approx(pitch.points, abs=1e-12)
    assert same.curvature == pytest.approx(pitch.curvature, rel=1e-10)
    wheel = ParallelOutline(profile, 150.0)
    back = ParallelOutline(wheel, -150.0).curve(phi)
    assert back.points == pytest.approx(profile.curve(phi).points, abs=1e-12)
    one, two = (OutlineIntegrals(curve).properties for curve in (profile, wheel))
    assert two.perimeter == pytest.approx(one.perimeter + 2.0 * pi * 150.0, rel=1e-12)


def test_balance_agrees_with_the_mesh() -> None:
    model = disc("bore = 20\nkeyway_width = 6\nkeyway_depth = 2.8", rest="[output]\ntolerance = 0.0002")
    found, mesh = balance(model.parts[0], 7850.0), model.mass[0]
    assert found.mass == pytest.approx(mesh.mass, rel=1e-5)
    assert found.centroid == pytest.approx(mesh.centroid[:2], rel=1e-5)
    about = mesh.inertia[2][2] + mesh.mass * hypot(*mesh.centroid[:2]) ** 2 * 1e-6
    assert found.inertia == pytest.approx(about, rel=3e-5)
    weight = 1e-3 * found.unbalance / 25.0
    at = 25.0 * np.array([np.cos(found.correction), np.sin(found.correction)])
    assert found.mass * np.array(found.centroid) + weight * at == pytest.approx(0.0, abs=1e-12)


def test_outlines_are_written_as_data(tmp_path) -> None:
    model = disc()
    write(model, tmp_path / "cam.outline.csv")
    with (tmp_path / "cam.outline.csv").open() as file:
        table = list(csv.DictReader(file))
    assert {row["curve"] for row in table} == {"profile", "pitch curve"}
    row = table[1000]
    at = model.planar.outlines["profile"].curve(np.radians([float(row["cam_angle_deg"])]))
    assert [float(row["x_mm"]), float(row["y_mm"])] == pytest.approx(at.points[:, 0], abs=1e-12)
    assert float(row["curvature_per_mm"]) == pytest.approx(at.curvature[0], rel=1e-9)


def test_other_cams_have_no_outlines(tmp_path) -> None:
    assert pin_cam().mechanism(pin_setup()).touches == ()
    with pytest.raises(ExportError, match="only planar"):
        write(Model(read_profile(PROFILES / "pin_insertion.toml")), tmp_path / "x.outline.csv")


@pytest.mark.parametrize("name", ["disc_offset_roller", "disc_flat_face"])
def test_design_disc_writes_the_smallest_cam_that_passes(name, tmp_path, capsys) -> None:
    """The written radius keeps the limit, which stands beside it, a hundredth below it does not, and the rest stands.
    """
    old, new = PROFILES / f"{name}.toml", tmp_path / "new.toml"
    limits = ["--pressure-angle", "25"] if name == "disc_offset_roller" else ["--convex-radius", "12"]
    assert main(["design", "disc", str(new), "--profile", str(old), *limits]) == 0
    assert "decides" in capsys.readouterr().out
    changed = [(a, b) for a, b in zip(old.read_text().splitlines(), new.read_text().splitlines()) if a != b]
    asked = ["pressure_angle_deg = 25"] if name == "disc_offset_roller" else []
    assert changed[0][1].lstrip().startswith("base_radius = ")
    assert [line for _, line in changed[1:]] == asked
    profile = read_profile(new)
    wanted = PlanarLimits(25.0, 0.0) if name == "disc_offset_roller" else PlanarLimits(None, 12.0)
    base = profile.cam.base_radius
    assert min(margins(profile, base, wanted).values()) >= 0.0
    assert min(margins(profile, base - 0.011, wanted).values()) < 0.0


def test_a_crowned_rollers_pressure_is_the_one_that_checks_read(tmp_path, capsys) -> None:
    """Its line contact had made a cam of 25 mm, which the ellipse presses with 783 MPa where 700 were asked for."""
    old, new = PROFILES / "disc_offset_roller.toml", tmp_path / "new.toml"
    assert main(["design", "disc", str(new), "--profile", str(old), "--contact-pressure", "700"]) == 0
    assert "contact pressure decides" in capsys.readouterr().out
    profile = read_profile(new)
    assert profile.limits.contact_pressure_mpa == 700.0
    base = profile.cam.base_radius
    levels = [
        judge(Model(profile.with_({"cam.base_radius": radius})), ["contact-pressure"]).level
        for radius in (base, base - 0.5)
    ]
    assert levels == ["pass", "fail"]


def test_a_track_without_a_radius_of_its_own_is_asked_at_the_same_one() -> None:
    profile = read_profile(PROFILES / "both_faces_disc.toml").with_({"track[0].cam.base_radius": None})
    angles = [margins(profile, radius, PlanarLimits(30.0)) for radius in (45.0, 60.0)]
    assert angles[0]["pressure angle of track 2"] < angles[1]["pressure angle of track 2"]
    second = profile.with_({"track[0].cam.base_radius": 50})
    own = [margins(second, radius, PlanarLimits(30.0)) for radius in (45.0, 60.0)]
    assert own[0]["pressure angle of track 2"] == own[1]["pressure angle of track 2"]


def test_design_disc_chooses_the_offset_too(tmp_path, capsys) -> None:
    old = PROFILES / "disc_offset_roller.toml"
    plain, best = (tmp_path / f"{name}.toml" for name in ("plain", "best"))
    command = ["--profile", str(old), "--pressure-angle", "20"]
    assert main(["design", "disc", str(plain), *command]) == 0
    assert main(["design", "disc", str(best), *command, "--best-offset", "--json"]) == 0
    out = capsys.readouterr().out
    chosen = json.loads(out[out.index("{") :])["choices"]
    assert [one["what"] for one in chosen] == ["follower.offset", "cam.base_radius"]
    assert read_profile(best).cam.base_radius < read_profile(plain).cam.base_radius
    assert read_profile(best).follower.offset != read_profile(plain).follower.offset


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["disc", "--profile", str(PROFILES / "conjugate_rocker.toml")], "kind"),
        (["disc", "--profile", str(PROFILES / "disc_flat_face.toml"), "--best-offset"], "best-offset"),
        (["disc", "--pressure-angle", "steep"], "pressure-angle"),
        (["disc", "--pressure-angle", "0"], "--pressure-angle: is out of range"),
        (["disc", "--pressure-angle", "90"], "--pressure-angle: is out of range"),
        (["disc", "--convex-radius=-1"], "--convex-radius: is out of range"),
        (["disc", "a.toml", "b.toml"], "unrecognized arguments: b.toml"),
        (["sphere"], "unknown kind"),
        (["globoidal", "--motion-angle", "120"], "stops"),
    ],
)
def test_design_refuses_what_it_cannot_choose(words, reason, capsys) -> None:
    assert main(["design", *words]) == 2
    assert reason in capsys.readouterr().err


def test_a_key_is_replaced_or_added_and_comments_stay() -> None:
    text = "name = 'x'\n[cam]\nwidth = 20   # mm\n[follower]\nkind = 'y'\n"
    assert with_key(text, "cam", "width", 21.5).splitlines()[2] == "width = 21.5   # mm"
    assert "[follower]\noffset = 3\n" in with_key(text, "follower", "offset", 3.0)
    assert with_key(text, "limits", "life_h", 1e4).endswith("[limits]\nlife_h = 10000\n")


SWINGING = """
[cam]
kind = "disc"
base_radius = 40
width = 10
center_distance = 120
[follower]
kind = "swinging"
arm = 100
side = "left"
[roller]
diameter = 20
length = 10
[[motion]]
until = 120
to = 15
law = "cycloidal"
[[motion]]
until = 240
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""


@pytest.mark.parametrize("kind", ["conjugate", "disc"])
def test_rockers_and_arms_have_a_smallest_radius_inside_their_triangle(kind, tmp_path) -> None:
    """A radius keeps the limit, a hundredth below it does not; larger ones cannot all be built."""
    from camgeom.cams import starter
    from camgeom.profile import parse

    profile = parse(starter("conjugate") if kind == "conjugate" else SWINGING)
    wanted = PlanarLimits(30.0)
    radius = smallest_base_radius(profile, wanted)
    assert "what can be built" in margins(profile, 1000.0, wanted)
    assert min(margins(profile, radius + 0.001, wanted).values()) >= 0.0
    assert min(margins(profile, radius - 0.01, wanted).values()) < 0.0
    if kind == "conjugate":
        assert radius == pytest.approx(133.885, abs=0.01)
    with pytest.raises(DesignError, match=r"pressure angle fails by a share of .* which comes nearest"):
        smallest_base_radius(profile, PlanarLimits(4.0))


def test_a_frames_cam_is_as_large_as_its_bore_needs_and_that_is_said(tmp_path, capsys) -> None:
    path = tmp_path / "new.toml"
    assert main(["design", "constant-width", str(path)]) == 0
    out = capsys.readouterr().out
    assert "wall, profile to bore, decides" in out
    assert "findings pass" in out
    assert "FAILS" not in out
    assert f"wrote {path}" in out


def test_a_design_that_fails_a_check_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As `check` does of the profile that is written: the motion is the user's."""
    words = ["design", "disc", "--pressure-angle", "30"]
    for law, status in (("cycloidal", 0), ("simple-harmonic", 1)):
        given, made = tmp_path / "given.toml", tmp_path / f"{law}.toml"
        assert main([*words[:2], str(given)]) in (0, 1)
        capsys.readouterr()
        given.write_text(re.sub(r'law = "[^"]*"', f'law = "{law}"', given.read_text()))
        assert main([*words, "--profile", str(given), str(made)]) == status
        assert ("FAILS: continuity" in capsys.readouterr().out) == bool(status)
        assert main(["check", str(made), "--only", "checks", "--out", str(tmp_path / law)]) == status
        assert main([*words, "--profile", str(given), "--json"]) == status
        capsys.readouterr()


def test_a_drive_of_which_nothing_can_be_tried_says_why(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["design", "globoidal", "--stops", "24", "--motion-angle", "90", "--center-distance", "100"]
    assert main([*words, "--pressure-angle", "35"]) == 1
    assert "leave no room for a roller" in capsys.readouterr().err
