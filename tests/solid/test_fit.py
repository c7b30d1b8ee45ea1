"""Rollers in the finished mesh: neither do they cut into it, nor does it stand back from them, nor is it rougher than
it says."""

from __future__ import annotations

import re
from dataclasses import replace
from math import cos, radians, sqrt, tan

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.model import Model, read
from camgeom.profile import Profile, from_data, parse
from camgeom.profile.text import load
from camgeom.report.sections.record import solid_rows
from camgeom.solid import Solid
from camgeom.track.sliding import passing
from tests.places import PROFILES
from tests.reference import profiles
from tests.reference.planar_machines import disc, flat
from tests.reference.profiles import said

TURRETS = ["barrel_indexer", "conical_indexer", "fine_indexer", "tool_changer", "two_start"]


def model(name: str, *solids: Solid) -> Model:
    made = read(str(PROFILES / f"{name}.toml"))
    if solids:
        made.body.__dict__["solids"] = solids
    return made


def cut_by(name: str, gap: float, tolerance: float) -> Solid:
    """The body that rollers larger by `gap` mm leave."""
    (part,) = model(name).parts
    if hasattr(part, "track"):
        return replace(part, track=part.track.grown(gap)).solid(tolerance)
    return replace(part, tracks=tuple(track.grown(gap) for track in part.tracks)).solid(tolerance)


def told(made: Model, check: str):
    (finding,) = judge(made, [check]).findings
    return finding


@pytest.mark.parametrize("name", TURRETS)
def test_a_larger_roller_of_many_stops_cuts_in(name) -> None:
    """Flanks of many stops have vertices on seams alone: these too are on the surface, and have no slack."""
    made = model(name)
    solid = made.solid
    on_flank = solid.mesh.group_vertices("flank")
    assert np.mean(solid.cut_vertices[on_flank]) < 0.1
    touch, larger = (min(c.value for c in made.clearances_with(grow)) for grow in (0.0, 5e-3))
    assert larger == pytest.approx(touch - 5e-3, abs=1e-6)


@pytest.mark.parametrize("name", ["pin_insertion", "tool_changer", "milled_drum"])
def test_a_mesh_rougher_than_it_says_is_found(name) -> None:
    (part,) = model(name).parts
    rough = part.solid(0.5)
    assert told(model(name, rough), "interference").level == "pass"
    lying = told(model(name, replace(rough, chord_error=0.004)), "interference")
    assert lying.level == "fail"
    assert lying.value < -0.05
    assert "rougher" in lying.advice


@pytest.mark.parametrize("name", ["pin_insertion", "steep_shuttle", "tool_changer", "barrel_indexer"])
def test_a_flank_cut_too_deep_is_backlash(name) -> None:
    sound = model(name)
    finding = told(sound, "backlash")
    assert finding.level == "pass"
    assert finding.limit == sound.mechanism.running_clearance
    deep = model(name, cut_by(name, 0.05, sound.tolerance))
    finding = told(deep, "backlash")
    assert finding.level == "fail"
    assert finding.value == pytest.approx(sound.mechanism.running_clearance + 0.05, abs=sound.tolerance)
    assert told(deep, "interference").level == "pass"


@pytest.mark.parametrize(("share", "level"), [(0.999, "pass"), (1.002, "fail")])
def test_the_limit_of_backlash_has_two_sides(share, level) -> None:
    """Vertices are on the true surface: the chord error is no excuse for them."""
    made = model("steep_shuttle")
    limit = made.mechanism.running_clearance
    made.body.__dict__["solids"] = (cut_by("steep_shuttle", (share - 1.0) * limit, made.tolerance),)
    finding = told(made, "backlash")
    assert finding.value == pytest.approx(share * limit, rel=1e-6)
    assert finding.level == level


@pytest.mark.parametrize("name", ["disc_flat_face", "constant_width_press", "disc_offset_roller", "conjugate_rocker"])
def test_a_rough_mesh_of_a_convex_cam_stands_back(name) -> None:
    """Between the vertices of a convex profile facets are inside it: no follower cuts in, all stand off."""
    rough = tuple(part.solid(0.2) for part in model(name).parts)
    assert {f.level for f in judge(model(name, *rough), ["interference", "backlash"]).findings} == {"pass"}
    lying = judge(model(name, *(replace(solid, chord_error=0.004) for solid in rough)), ["backlash"]).findings
    assert {f.level for f in lying} == {"fail"}
    assert all(0.05 < f.value < 0.2 and "rougher" in f.advice for f in lying)


SPRUNG = "[operation]\nspeed = 100\nspring_preload = 50"
KNIFE = disc("", 'kind = "translating"\nface = "knife"', "", rest=SPRUNG).profile
SLIDING = {
    "flat": read(str(PROFILES / "disc_flat_face.toml")).profile,
    "frame": read(str(PROFILES / "constant_width_press.toml")).profile,
    "arm": flat("swinging", "center_distance = 100", "face_offset = 6", [(160, 8, "3-4-5"), (360, 0, "3-4-5")]).profile,
    "knife": KNIFE,
}


def scaled(profile: Profile, by: float) -> Model:
    """The model with a body whose radii are larger (smaller) by a share, as its follower does not know."""
    made = Model(profile)
    (solid,) = made.solids
    vertices = solid.mesh.vertices * [1.0 + by, 1.0 + by, 1.0]
    made.body.__dict__["solids"] = (replace(solid, mesh=replace(solid.mesh, vertices=vertices)),)
    return made


@pytest.mark.parametrize("face", SLIDING)
def test_faces_and_edges_are_measured_against_the_finished_mesh(face) -> None:
    sound = Model(SLIDING[face])
    assert {f.level for f in judge(sound, ["interference", "backlash"]).findings} == {"pass"}
    least, largest = np.ptp(sound.solid.mesh.vertices[:, :2], axis=0).min() / 2, np.ptp(sound.solid.mesh.vertices) / 2
    for by, check, sign in ((1e-4, "interference", -1.0), (-1e-4, "backlash", 1.0)):
        wrong = scaled(SLIDING[face], by)
        told_ = judge(wrong, [check]).findings
        assert {f.level for f in told_} == {"fail"}
        worst = max(sign * f.value for f in told_)
        assert 0.5e-4 * least < worst < 2.1e-4 * largest
    other = "backlash" if check == "interference" else "interference"
    assert {f.level for f in judge(scaled(SLIDING[face], -1e-4), [other]).findings} == {"pass"}


@pytest.mark.parametrize("face", SLIDING)
def test_the_least_distance_of_what_slides_is_the_least_of_many(face) -> None:
    """Against a million plain samples of the follower's line (edge) in the machine frame."""
    made = Model(SLIDING[face])
    rng = np.random.default_rng(3)
    ring = made.solid.mesh.vertices[rng.integers(0, len(made.solid.mesh.vertices), 5)] * [0.97, 0.97, 1.0]
    for slider in made.mechanism.sliders:
        when, distance = passing(slider, ring)
        phi = np.linspace(0.0, 2.0 * np.pi, 200_001)
        for x, at, value in zip(ring, when, distance):
            sampled = slider.jet(x[:2, None], phi)[0]
            least = sampled.min() if face != "knife" else np.sqrt(2.0 * sampled.min())
            assert value == pytest.approx(least, abs=1e-6)
            assert slider.distance(x[:2, None], np.array([at]))[0] == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize("name", ["conjugate_rocker", "disc_face_groove", "disc_offset_roller", "fine_indexer"])
def test_other_shipped_bodies_have_the_backlash_they_ask_for(name) -> None:
    made = model(name)
    for finding in judge(made, ["backlash"]).findings:
        assert finding.level == "pass"
        assert finding.value >= made.mechanism.running_clearance - 1e-9


@pytest.mark.parametrize(
    ("name", "changes"),
    [("tool_changer", {"relief": 0.05, "relief_angle": 4.0}), ("barrel_indexer", {"relief": 0.05, "relief_angle": 4.0}),
     ("tool_changer", {"preload": 0.01}), ("fine_indexer", {"preload": 0.05})],
)  # fmt: skip
def test_relief_and_preload_open_flanks_by_no_more_than_they_allow(name, changes) -> None:
    lines = "\n".join(f"{key} = {value}" for key, value in changes.items())
    text = re.sub(r"(?m)^preload = .*$", "", (PROFILES / f"{name}.toml").read_text())
    made = Model(parse(text.replace("[cam]\n", f"[cam]\n{lines}\n")))
    finding = told(made, "backlash")
    assert finding.level == "pass"
    assert 0.2 * finding.limit < finding.value


def test_a_preload_alone_is_no_backlash() -> None:
    """The starter with a preload: what the closer turret opens on the far flanks is asked for, and no more."""
    made = Model(parse(starter("globoidal").replace("[cam]\n", "[cam]\npreload = 0.01\n")))
    assert made.mechanism.running_clearance == 0.0
    finding = told(made, "backlash")
    assert finding.level == "pass"
    assert finding.value > 0.005
    rows = [row for row in solid_rows(made) if "mesh" in str(row[0])]
    assert rows
    assert all(row[-1] for row in rows)
    deep = made.mechanism.allowed_backlash + 0.001
    (part,) = made.parts
    tracks = tuple(track.grown(deep) for track in part.tracks)
    worse = Model(made.profile)
    worse.body.__dict__["solids"] = (replace(part, tracks=tracks).solid(made.tolerance),)
    assert told(worse, "backlash").level == "fail"


END = {"drum": "cylindrical", "rib": "cylindrical", "face groove": "disc_face_groove", "barrel": "cylindrical-index"}


@pytest.mark.parametrize(("gap", "level"), [(1.0, "pass"), (1e-3, "pass"), (0.0, "fail")])
@pytest.mark.parametrize("kind", END)
def test_a_roller_that_stands_on_the_floor_of_its_groove_fails(kind: str, gap: float, level: str) -> None:
    text = (PROFILES / f"{END[kind]}.toml").read_text() if "_" in END[kind] else starter(END[kind])
    data = load(text, kind)[0]
    if kind == "barrel":
        data["cam"] = data["cam"] | {"tip_clearance": gap}
    else:
        data["roller"] = data["roller"] | {"length": data["cam"]["groove_depth"] - gap}
    if kind == "rib":
        data["cam"] = data["cam"] | {"form": "rib", "rib_thickness": 12.0}
    check = "turret-gap" if kind == "barrel" else "floor-gap"
    found = [f for f in judge(Model(from_data(data, kind)), [check]).findings if "rollers" not in f.where]
    assert [f.level for f in found] == [level]
    assert found[0].value == pytest.approx(gap, abs=1e-9)


CONE = {"roller__shape": "cone", "cutter": None}
CROWN = {"roller__shape": "crowned", "roller__crown_radius": 500.0}


@pytest.mark.parametrize(("name", "keys", "thicker"), [
    ("conical_groove", CONE | {"roller__half_angle": -8.0}, lambda length: length * tan(radians(8.0))),
    ("pin_insertion", CONE | {"roller__half_angle": -6.0}, lambda length: length * tan(radians(6.0))),
    ("conical_guide", CONE | {"roller__half_angle": -6.0}, lambda length: length * tan(radians(6.0))),
    ("pin_insertion", CROWN | {"roller__flank": "conforming"}, lambda length: 500.0 - sqrt(500.0**2 - length**2 / 4.0)),
])  # fmt: skip
def test_a_roller_thicker_than_the_mouth_of_its_closed_groove_is_told(name, keys, thicker) -> None:
    for more, level in ((-1e-3, "warn"), (1e-3, "pass")):
        length = profiles.model(name, **keys).profile.roller.length
        clearance = (thicker(length) + more) * cos(radians(keys.get("roller__half_angle", 0.0)))
        (found,) = said(profiles.model(name, **keys, cam__running_clearance=clearance), "mouth")
        assert (found.level, found.value) == (level, pytest.approx(more, abs=2e-5))
    assert not said(profiles.model(name), "mouth")


@pytest.mark.parametrize("keys", [CONE | {"roller__half_angle": 6.0}, CROWN])
def test_what_narrows_towards_the_floor_or_runs_on_a_straight_flank_goes_in(keys) -> None:
    assert not said(profiles.model("pin_insertion", **keys), "mouth")


@pytest.mark.parametrize(("gap", "level"), [(1.0, "pass"), (0.01, "pass"), (0.0, "fail")])
def test_a_tip_clearance_of_nothing_fails_a_globoid(gap: float, level: str) -> None:
    data = load(starter("globoidal"), "")[0]
    data["cam"] = data["cam"] | {"tip_clearance": gap}
    (found,) = [f for f in judge(Model(from_data(data, "")), ["turret-gap"]).findings if f.where.endswith("floor")]
    assert found.level == level


@pytest.mark.parametrize(("by", "level"), [(0.0, "pass"), (1e-3, "fail")])
def test_the_rim_between_the_flanks_of_a_plate_is_no_backlash(by, level) -> None:
    """Plates for rollers larger by `by` mm stand back from those of the profile by as much."""
    made = model("parallel_index")
    roller = made.profile.roller.model_copy(update={"diameter": made.profile.roller.diameter + 2.0 * by})
    made.body.__dict__["solids"] = Model(made.profile.model_copy(update={"roller": roller})).solids
    found = judge(made, ["backlash"]).findings
    assert [f.level for f in found] == [level, level]
    assert [f.value for f in found] == pytest.approx([by, by], abs=2e-6)


def steep_cone(half_angle: float) -> Model:
    """A groove for a cone whose point is close to the groove's floor: there a passage lasts a quarter of a degree."""
    data = load((PROFILES / "pin_insertion.toml").read_text(), "steep cone")[0]
    data["cam"] |= {"diameter": 120, "length": 80, "start": 22, "groove_depth": 12, "bore": 35}
    data["cam"].pop("pitch_radius", None)
    data["roller"] = {"shape": "cone", "diameter": 19, "length": 11, "half_angle": half_angle}
    data["motion"] = (
        {"until": 120, "to": 30, "law": "modified-sine"}, {"until": 180},
        {"until": 320, "to": 0, "law": "cycloidal"}, {"until": 360},
    )  # fmt: skip
    data.pop("operation")
    data["limits"] = {"pressure_angle_deg": 70}
    return Model(from_data(data))


@pytest.mark.parametrize("half_angle", [45, 52, 55])
def test_a_groove_of_a_steep_cone_fits_down_to_its_point(half_angle) -> None:
    made = steep_cone(half_angle)
    assert {f.level for f in judge(made, ["interference", "backlash"]).findings} == {"pass"}


def test_one_vertex_beside_the_point_of_a_cone_is_found() -> None:
    """Moved along the cam's axis, into the lower wall of the dwell, and a roller that is larger everywhere."""
    made = steep_cone(55)
    (solid,) = made.solids
    assert min(c.value for c in made.clearances_with(5e-3)) == pytest.approx(-5e-3, abs=1e-6)
    vertices = solid.mesh.vertices.copy()
    flank = np.flatnonzero(solid.mesh.group_vertices("flank"))
    radius, z = np.hypot(*vertices[flank, :2].T), vertices[flank, 2]
    angle = np.degrees(np.arctan2(vertices[flank, 1], vertices[flank, 0])) % 360.0
    low = flank[(radius < 48.5) & (z < 22.0) & (z > 20.0) & (angle > 5.0) & (angle < 35.0)]
    vertices[low[len(low) // 2], 2] -= 0.02
    made.body.__dict__["solids"] = (replace(solid, mesh=replace(solid.mesh, vertices=vertices)),)
    finding = told(made, "backlash")
    assert finding.level == "fail"
    assert finding.value == pytest.approx(0.02 * np.cos(np.radians(55.0)), rel=0.01)
