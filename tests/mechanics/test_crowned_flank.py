"""How a flank meets a crowned roller is a key: cut by the cylinder of its crest, or by the crown itself."""

from __future__ import annotations

import re

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.errors import ProfileError
from camgeom.mechanics.hertz import line_pressure
from camgeom.model import Model
from camgeom.profile import Profile, parse
from camgeom.report.result import compute
from camgeom.track import Arc, Straight
from camgeom.track.clearance import roller_distance
from camgeom.track.flank import Flank
from tests.places import PROFILES

LENGTH, CROWN = 8.0, 120.0


def drum(flank: str = "", crown: float = CROWN, form: str = "groove") -> Profile:
    key = f'\nflank = "{flank}"' if flank else ""
    rib = '\nform = "rib"\nrib_thickness = 14' if form == "rib" else ""
    return parse(f"""
name = "drum"
[cam]
kind = "cylindrical"
diameter = 100
length = 130
start = 45
groove_depth = 10{rib}
[follower]
kind = "translating"
mass = 2
[roller]
shape = "crowned"
diameter = 18
length = {LENGTH}
crown_radius = {crown}{key}
[[motion]]
until = 110
to = 38
law = "modified-sine"
[[motion]]
until = 180
[[motion]]
until = 300
to = 0
law = "modified-sine"
[[motion]]
until = 360
[operation]
speed = 200
friction = 300
[output]
tolerance = 0.01
""")


@pytest.mark.parametrize("form", ["groove", "rib"])
def test_the_flank_is_that_of_the_tool_the_key_names(form) -> None:
    """Straight: as a cylindrical roller of the crest's diameter leaves it. Conforming: its section is hollow."""
    straight, conforming = Model(drum("straight", form=form)), Model(drum("conforming", form=form))
    assert np.array_equal(Model(drum(form=form)).solid.mesh.vertices, straight.solid.mesh.vertices)
    plain = straight.profile.model_dump()["roller"] | {"shape": "cylinder"}
    cylinder = Model(replace_roller(straight.profile, plain))
    assert np.array_equal(cylinder.solid.mesh.vertices, straight.solid.mesh.vertices)
    drop = (0.5 * LENGTH) ** 2 / (2.0 * CROWN)
    for made in (straight, conforming):
        assert abs(made.clearances[0].value) < 1e-9
        assert isinstance(made.tracks[0].meridian, Arc)
        cut = made.flanks[0].cutter.meridian
        assert isinstance(cut, Straight if made is straight else Arc)
        assert {f.level for f in judge(made, ["interference", "backlash", "watertight"]).findings} == {"pass"}
        assert compute(made, ("flank",)).data["flank"]["crown"] == made.mechanism.crown
    # The body of the one, declared to be the other's: too deep beside the crest, or too tight, by the crown's drop.
    for own, other, check in ((conforming, straight, "backlash"), (straight, conforming, "interference")):
        wrong = Model(own.profile)
        wrong.body.__dict__["solids"] = other.solids
        told = judge(wrong, [check]).findings
        assert {f.level for f in told} == {"fail"}
        assert all(0.8 * drop < abs(f.value) < 4.0 * drop for f in told)


def replace_roller(profile: Profile, roller: dict) -> Profile:
    from camgeom.track.follower import CylinderRoller

    keys = {k: v for k, v in roller.items() if k in CylinderRoller.model_fields}
    return profile.model_copy(update={"roller": CylinderRoller(**keys)})


@pytest.mark.parametrize("crown", [40.0, 120.0, 2000.0])
def test_relative_curvatures_are_those_of_the_gap(crown) -> None:
    """Of the distance of the straight flank's points from the crowned roller, by differences, where the slope twists
    the line of contact."""
    model = Model(drum("straight", crown))
    duty = model.duty
    alignment = duty.pressing.alignment
    at = np.unravel_index(int(np.argmin(np.where(np.abs(duty.normal) > 0.0, alignment, 1.0))), duty.normal.shape)
    phi, behind = float(duty.force.panels.theta[at]), duty.normal[at] >= 0.0
    assert alignment[at] < 0.995
    track, real = duty.track, model.tracks[0]
    at_crest = np.array([phi]), np.array([duty.station])
    (side,) = (s for s in track.sides if (Flank(track, *at_crest, s).lever()[0, 0] < 0.0) == behind)
    step = 2e-3
    own = Flank(track, np.array([phi]), np.array([duty.station]), side)
    x_phi, x_t = (x[:, 0, 0] for x in own.tangents)
    e1 = x_t / np.linalg.norm(x_t)
    e2 = x_phi - (x_phi @ e1) * e1
    e2 /= np.linalg.norm(e2)
    frame = np.linalg.inv(np.array([[x_phi @ e1, x_t @ e1], [x_phi @ e2, x_t @ e2]]))

    def gap(a: float, b: float) -> float:
        """At a, b mm along e1 and e2 on the tangent plane."""
        d_phi, d_t = frame @ [a, b]
        x = Flank(track, np.array([phi + d_phi]), np.array([duty.station + d_t]), side).x[:, :, 0]
        return float(roller_distance(real, x, np.array([phi]))[0])

    h = step * 60.0
    zero = gap(0.0, 0.0)
    assert abs(zero) < 1e-12
    first = (gap(h, 0) + gap(-h, 0) - 2 * zero) / h**2
    second = (gap(0, h) + gap(0, -h) - 2 * zero) / h**2
    mixed = (gap(h, h) + gap(-h, -h) - gap(h, -h) - gap(-h, h)) / (4 * h**2)
    low, high = np.linalg.eigvalsh([[first, mixed], [mixed, second]])
    across, along = duty.crowned.principal
    assert sorted((across[at], along[at])) == pytest.approx([low, high], rel=3e-4)


def test_a_crown_on_a_straight_flank_is_pressed_harder() -> None:
    straight, conforming = Model(drum()), Model(drum("conforming"))
    peaks = [float(model.duty.peak_pressure.value) for model in (straight, conforming)]
    assert peaks[0] > 1.5 * peaks[1]
    assert straight.duty.lives["roller"] < 0.2 * conforming.duty.lives["roller"]
    shown = compute(straight, ("flank", "contact")).data["contact"]
    assert shown["peak_pressure_mpa"] == pytest.approx(peaks[0])
    assert shown["line_pressure_mpa"] < peaks[0]
    assert "ellipse_half_length_mm" not in compute(conforming, ("flank", "contact")).data["contact"]


def test_a_flat_crown_joins_the_line() -> None:
    """Without a crown both flanks are one, and the pressure is that of the line on the length that touches."""
    straight, conforming = (Model(drum(flank, crown=1e5)) for flank in ("straight", "conforming"))
    assert (straight.duty.level, conforming.duty.level) == ("finite", "line")
    # Its sharp ends bear more than the middle, and have no largest pressure; the line knows of no ends.
    assert straight.duty.peak_pressure is None
    patch = straight.duty.finite.hardest[1]
    middle = float(np.interp(patch.centre, patch.y, patch.line_load))
    line = float(line_pressure(middle, patch.bodies.curvature, patch.bodies.compliance))
    assert patch.at(patch.centre) == pytest.approx(line, rel=1e-2)
    assert line == pytest.approx(conforming.duty.pressing.as_line.peak().pressure, rel=8e-2)


CROWNED = 'shape = "crowned"\ncrown_radius = 300\n'


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [("disc_offset_roller", "straight", "conforming"), ("conjugate_rocker", "straight", "conforming"),
     ("disc_face_groove", "straight", "conforming"), ("parallel_index", "straight", "conforming")],
)  # fmt: skip
def test_what_is_not_built_is_refused_by_name(name, good, bad) -> None:
    text = (PROFILES / f"{name}.toml").read_text()
    text = re.sub(r"(?m)^(shape|crown_radius|half_angle) = .*\n", "", text)

    def crowned(flank: str) -> str:
        return text.replace("[roller]\n", f'[roller]\n{CROWNED}flank = "{flank}"\n')

    assert Model(parse(crowned(good))).mechanism.crown == good
    with pytest.raises(ProfileError, match=r"roller\.flank"):
        parse(crowned(bad))
    # One default for all kinds.
    assert Model(parse(text.replace("[roller]\n", f"[roller]\n{CROWNED}"))).mechanism.crown == "straight"


@pytest.mark.parametrize("name", ["tool_changer", "barrel_indexer"])
def test_a_turrets_flank_is_the_cylinders_or_the_crowns(name: str) -> None:
    text = re.sub(r"(?m)^(shape|crown_radius|half_angle) = .*\n", "", (PROFILES / f"{name}.toml").read_text())
    straight, conforming = (
        Model(parse(text.replace("[roller]\n", f'[roller]\n{CROWNED}flank = "{flank}"\n')))
        for flank in ("straight", "conforming")
    )
    plain = Model(parse(text))
    assert [track.meridian for track in straight.tracks] == [track.meridian for track in plain.tracks]
    assert isinstance(conforming.tracks[0].meridian, Arc)
    assert straight.turret_duty is not None
    assert conforming.turret_duty is not None
    assert (straight.turret_duty.level, conforming.turret_duty.level) == ("finite", "line")


def test_other_rollers_have_no_such_key() -> None:
    with pytest.raises(ProfileError, match="flank"):
        parse(starter("cylindrical").replace("[roller]\n", '[roller]\nflank = "straight"\n'))
