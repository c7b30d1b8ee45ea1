"""Edges of plates: the roller stands on them wherever it goes, placed from the keys alone, by no envelope."""

from __future__ import annotations

from math import cos, degrees, hypot, pi, radians, sin

import numpy as np
import pytest

from camgeom.checks import findings
from camgeom.errors import DesignError, ProfileError
from camgeom.export.step.check import check_solid
from camgeom.export.step.solids import VOLUME, edge_solid
from camgeom.machining.job import machining_of
from camgeom.machining.spec import CutterSpec
from camgeom.model import Model
from camgeom.profile import from_data, parse
from camgeom.report.result import compute
from camgeom.solid.pocket import EdgePlate
from camgeom.track.outline import OutlineIntegrals

STROKE, RISE, FIRST, WIDE, RADIUS = 100.0, 20.0, 15.0, 70.0, 9.0
BASE = """
name = "edge"
[cam]
kind = "linear"
form = "edge"
stroke = 100
length = {length}
thickness = 12
start = {start}
edge = {edge}
{cam}
[follower]
{follower}
[roller]
diameter = {diameter}
length = 9
[[motion]]
until = {first}
[[motion]]
until = {last}
to = {rise}
law = "{law}"
[[motion]]
until = 100
[operation]
speed = {speed}
friction = 12
spring_preload = {preload}
{operation}
[limits]
{limits}
[output]
tolerance = 0.01
{more}
"""
GIVEN = {"length": 150, "start": 25, "edge": 32, "cam": "moving_mass = 5", "diameter": 18, "first": 15, "last": 85,
         "follower": 'kind = "translating"\nmass = 3', "rise": 20, "law": "cycloidal", "speed": 60, "preload": 90,
         "operation": "", "limits": "", "more": ""}  # fmt: skip


def plate(**keys: object) -> Model:
    return Model(parse(BASE.format(**GIVEN | keys)))


def lift(x: np.ndarray, first: float = FIRST, wide: float = WIDE, rise: float = RISE) -> np.ndarray:
    u = np.clip((x - first) / wide, 0.0, 1.0)
    return rise * (u - np.sin(2.0 * pi * u) / (2.0 * pi))


def slopes(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative of the lift by the travel."""
    u = np.clip((x - FIRST) / WIDE, 0.0, 1.0)
    return RISE / WIDE * (1.0 - np.cos(2.0 * pi * u)), 2.0 * pi * RISE / WIDE**2 * np.sin(2.0 * pi * u)


def levels(model: Model, name: str) -> list[str]:
    return [one.level for one in findings(model, [name])]


def distances(body: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Least distance of each centre (n, 2) from a closed polygon (m, 2)."""
    way = np.roll(body, -1, axis=0) - body
    found = np.empty(len(centres))
    for k, centre in enumerate(centres):
        share = np.clip(((centre - body) * way).sum(axis=1) / (way * way).sum(axis=1), 0.0, 1.0)
        found[k] = np.hypot(*(body + share[:, None] * way - centre).T).min()
    return found


def test_200_random_edges_hold_the_roller_wherever_it_goes() -> None:
    """No design passes whose body the roller cuts into or leaves; placed from travel, lift and slide alone."""
    dice, judged, refused = np.random.default_rng(20), 0, 0
    for _ in range(200):
        first = dice.uniform(5.0, 45.0)
        last, rise = dice.uniform(first + 8.0, 95.0), dice.uniform(-1.0, 1.0) * 10.0 ** dice.uniform(0.0, 1.6)
        radius, lean = dice.uniform(2.0, 14.0), dice.choice([0.0, dice.uniform(-35.0, 35.0)])
        arm = dice.uniform(1.5, 4.0) * abs(rise) + 20.0 if not lean and dice.random() < 0.4 else 0.0
        keys: dict[str, object] = {"first": first, "last": last, "rise": rise, "diameter": 2.0 * radius}
        start, edge, length, to = dice.uniform(5.0, 60.0), dice.uniform(10.0, 80.0), dice.uniform(130.0, 220.0), rise
        keys |= {"start": start, "edge": edge, "length": length}
        x = np.linspace(0.0, STROKE, 301)
        way, rest = float(dice.choice([-1.0, 1.0])), radians(dice.uniform(-30.0, 10.0))
        if arm:
            to = float(np.degrees(rise / arm))
            side, angle = "left" if way > 0.0 else "right", np.degrees(rest)
            keys["follower"] = f'kind = "swinging"\narm = {arm}\nstart_angle = {angle}\nside = "{side}"\ninertia = 0.01'
            keys["rise"] = to
            turn = rest + np.radians(lift(x, first, last - first, to))
            place = np.stack([start + x + way * arm * (np.cos(turn) - cos(rest)),
                              edge + arm * (np.sin(turn) - sin(rest))], axis=1)  # fmt: skip
        else:
            keys["cam"] = f"inclination = {lean}"
            s = lift(x, first, last - first, rise)
            place = np.stack([start + x + s * sin(radians(lean)), edge + s * cos(radians(lean))], axis=1)
        try:
            model = plate(**keys)
            mesh = model.solid.mesh
        except (ProfileError, DesignError):
            refused += 1
            continue
        if "fail" in levels(model, "undercut") + levels(model, "interference") + levels(model, "relative-curvature"):
            refused += 1
            continue
        judged += 1
        (part,) = model.parts
        near = distances(part.outline.curve(np.linspace(0.0, 2.0 * pi, 6001)[:-1]).points.T, place)
        assert near.min() > radius - 0.01, keys
        assert near.max() < radius + 0.01, keys
        assert mesh.vertices[:, 1].min() == 0.0
        assert mesh.vertices[:, 0].min() == pytest.approx(0.0)
        assert mesh.vertices[:, 0].max() == pytest.approx(length)
    assert judged > 60
    assert refused > 20


def test_body_step_and_dxf_have_the_area_under_the_parallel_of_the_path() -> None:
    model = plate()
    x = np.linspace(0.0, STROKE, 400_001)
    s = lift(x)
    slope, _ = slopes(x)
    # The area under a parallel at r is that under the path less r times its length; in all the path does not turn.
    under = np.trapezoid(32.0 + s, x) - RADIUS * np.trapezoid(np.hypot(1.0, slope), x)
    volume = 12.0 * (under + 25.0 * (32.0 - RADIUS) + 25.0 * (52.0 - RADIUS))
    assert check_solid(edge_solid(model.parts[0])).volume == pytest.approx(volume, rel=1e-8)
    assert model.solid.sound
    assert model.solid.mesh.volume == pytest.approx(volume, rel=1e-4)
    assert model.mechanism.box == pytest.approx((150.0, 52.0 - RADIUS, 12.0))
    assert set(model.solid.mesh.groups) == {"flank", "rim", "end"}
    for name in ("interference", "backlash", "watertight", "chord-error"):
        assert levels(model, name) == ["pass"]


def test_the_ends_go_on_along_the_tangents() -> None:
    """A motion that ends on a slope: corners on the straight line beyond the last contact."""
    made = plate().with_({"motion[2].to": 34.0, "motion[2].law": "constant-velocity"})
    slope = 14.0 / 15.0
    corners = made.parts[0].outline.corners
    along = hypot(1.0, slope)
    end = np.array([125.0 + RADIUS * slope / along, 32.0 + 34.0 - RADIUS / along])
    assert corners[:, 3] == pytest.approx(end)
    assert corners[:, 2] == pytest.approx([150.0, end[1] + slope * (150.0 - end[0])])


def test_the_wall_has_two_sides() -> None:
    for factor, level in ((0.999, "pass"), (1.002, "fail")):
        found = findings(plate(limits=f"min_wall_mm = {factor * (32.0 - RADIUS)}"), ["wall"])
        (foot,) = (one for one in found if "foot" in one.where)
        assert (foot.level == "fail") is (level == "fail")


def test_the_follower_lifts_off_where_spring_and_weight_do_not_hold_it() -> None:
    """Spring, inertia and friction: the preload that just does has two sides."""
    theta = np.linspace(0.0, 2.0 * pi, 400_001)
    x, dx, ddx = (0.5 * STROKE * one for one in (1.0 - np.cos(theta), np.sin(theta), np.cos(theta)))
    slope, bend = slopes(x)
    least = (3e-3 * (2.0 * pi) ** 2 * (bend * dx * dx + slope * ddx) + 12.0 * np.sign(slope * dx)).min()
    for factor, level in ((1.001, "pass"), (0.998, "fail")):
        assert levels(plate(preload=-least * factor), "contact-kept") == [level]


@pytest.mark.parametrize("thick", [9.0, 12.0, 80.0])
def test_a_plate_may_be_much_thicker_than_its_roller_is_long(thick: float) -> None:
    made = plate().with_({"cam.thickness": thick})
    for name in ("backlash", "interference"):
        assert levels(made, name) == ["pass"]


def test_an_undercut_edge_makes_no_body() -> None:
    made = plate(first=15, last=30)
    assert levels(made, "undercut") == ["fail"]
    with pytest.raises(DesignError, match="undercut"):
        _ = made.solid


@pytest.mark.parametrize(("key", "last", "way"), [("start", 50.0, -1.0), ("edge", RADIUS, 1.0)])
def test_an_edge_that_leaves_the_plate_is_refused_and_one_just_within_is_not(key: str, last: float, way: float) -> None:
    plate(**{key: last + way * 1e-3})
    with pytest.raises(ProfileError, match=f"cam.{key}"):
        plate(**{key: last - way * 1e-3})


def test_every_state_tells_the_force_of_its_drive_where_the_plate_has_a_mass() -> None:
    """`contact` tells of the state that is pressed hardest, which another may exceed; the check asks all."""
    states = '[[duty]]\nspeed = 40\nshare = 0.5\n[[duty]]\nshare = 0.5\n'
    model = plate(more=states)
    found = compute(model, ("contact", "fatigue")).data
    forces = [state.slide_drive.peak.value for state in model.states if state.slide_drive is not None]
    assert [one["peak_drive_force_n"] for one in found["fatigue"]["states"]] == pytest.approx(forces)
    assert forces[0] != pytest.approx(forces[1], rel=1e-3)
    (judged,) = findings(plate(more=states, limits="drive_force_n = 150"), ["drive-force"])
    assert judged.value == pytest.approx(max(forces))
    light = compute(plate(more=states, cam=""), ("fatigue",)).data
    assert all("peak_drive_force_n" not in one for one in light["fatigue"]["states"])


def pivoted(way: float, rest: float, arm: float, limit: float | None = None, **keys: object) -> Model:
    side = "left" if way > 0.0 else "right"
    follower = f'kind = "swinging"\narm = {arm}\nstart_angle = {rest}\nside = "{side}"\ninertia = 0.01'
    limits = "" if limit is None else f"clearance_mm = {limit}"
    return plate(follower=follower, cam="", rise=degrees(RISE / arm), limits=limits, **keys)


def to_the_body(way: float, rest: float, arm: float, start: float = 25.0, edge: float = 32.0) -> float:
    """Least signed distance of the pivot from the plate below the roller, wherever it stands, over the travel."""
    x, first = np.linspace(0.0, STROKE, 1001), radians(rest)
    turn = first + lift(x, rise=RISE / arm)
    centre = start + x + way * arm * (np.cos(turn) - cos(first)), edge + arm * (np.sin(turn) - sin(first))
    along = np.linspace(0.0, 150.0, 1501)
    # It dwells at both ends of the stroke, so that the edge goes on level.
    high = np.where(along < start, edge, centre[1][-1]) - RADIUS
    on = (along >= start) & (along <= centre[0][-1])
    off = along[on, None] - centre[0]
    under = np.where(np.abs(off) < RADIUS, centre[1] - np.sqrt(np.maximum(RADIUS**2 - off**2, 0.0)), np.inf)
    high[on] = under.min(axis=1)
    body = np.concatenate([np.stack([along, high], axis=1), [[150.0, 0.0], [0.0, 0.0]]])
    pivot = np.stack([start - way * arm * cos(first) + x, np.full_like(x, edge - arm * sin(first))], axis=1)
    within = (pivot[:, 0] > 0.0) & (pivot[:, 0] < 150.0) & (pivot[:, 1] < np.interp(pivot[:, 0], along, high))
    away = distances(body, pivot)
    return float(np.where(within, -away, away).min())


@pytest.mark.parametrize(("way", "rest", "arm"), [
    (-1.0, 0.0, 60.0), (1.0, 20.0, 45.0), (1.0, -3.0, 60.0), (-1.0, -14.0, 70.0), (-1.0, -9.0, 140.0),
])  # fmt: skip
def test_a_pivot_is_as_far_from_its_plate_as_it_stands_from_the_material(way: float, rest: float, arm: float) -> None:
    wanted = to_the_body(way, rest, arm)
    (found,) = findings(pivoted(way, rest, arm), ["pivot"])
    assert found.value == pytest.approx(wanted, abs=1e-4)
    assert found.level == ("pass" if wanted > 0.0 else "warn")
    if wanted > 0.0:
        for share, level in ((0.999, "pass"), (1.002, "warn")):
            assert levels(pivoted(way, rest, arm, share * wanted), "pivot") == [level]


def test_a_pivot_under_the_level_end_of_an_edge_is_as_deep_as_that_is_high() -> None:
    """The arm lies along the travel and rises by 20 deg: the edge ends 60 sin 20 deg - 9 mm above its pivot."""
    (found,) = findings(pivoted(-1.0, 0.0, 60.0).with_({"motion[1].to": 20.0}), ["pivot"])
    assert found.value == pytest.approx(RADIUS - 60.0 * sin(radians(20.0)), abs=1e-6)
    assert (found.level, found.limit) == ("warn", 0.0)


def test_an_arm_over_the_groove_of_a_plate_and_a_slide_have_no_pivot_to_judge() -> None:
    assert levels(plate(), "pivot") == []
    text = BASE.format(**GIVEN | {"rise": 15, "cam": "width = 80\ngroove_depth = 10", "follower":
                       'kind = "swinging"\narm = 60\nside = "right"'}).replace('"edge"', '"groove"')  # fmt: skip
    assert levels(Model(parse(text.replace("spring_preload = 90", ""))), "pivot") == []


def test_a_place_beyond_the_plate_is_told_bounds_that_it_may_not_have() -> None:
    with pytest.raises(ProfileError, match="above 0 and below 50 mm, so that the roller stays"):
        plate(start=50.0)


@pytest.mark.parametrize(("tool", "reach"), [({"kind": "roller"}, RADIUS), ({"kind": "flat", "diameter": 12.0}, 6.0)])
@pytest.mark.parametrize("milling", ["climb", "conventional"])
def test_the_tool_goes_round_the_plate_and_never_into_it(tool: dict[str, object], reach: float, milling: str) -> None:
    model = plate()
    made = machining_of("plate", CutterSpec(**tool, overrun=1.0, milling=milling), [model.mechanism], model.parts)
    (cut,) = made.passes("machine")
    tips = np.concatenate([move.positions.tip for move in cut.moves if move.kind == "cut"], axis=1)
    body = model.parts[0].outline.curve(np.linspace(0.0, 2.0 * pi, 6001)[:-1]).points.T
    away = distances(body, tips[:2, :: max(1, tips.shape[1] // 300)].T)
    assert away == pytest.approx(np.full(away.shape, reach), abs=3e-3)
    assert tips[2] == pytest.approx(np.full(tips.shape[1], -1.0))


def test_a_tool_too_large_for_the_hollow_is_refused() -> None:
    model = plate()
    slope, bend = slopes(np.linspace(0.0, STROKE, 400_001))
    hollow = 1.0 / (bend / np.hypot(1.0, slope) ** 3).max() + RADIUS
    machining_of("plate", CutterSpec(kind="flat", diameter=1.998 * hollow), [model.mechanism], model.parts)
    with pytest.raises(DesignError, match="does not go into the hollow"):
        machining_of("plate", CutterSpec(kind="flat", diameter=2.004 * hollow), [model.mechanism], model.parts)


@pytest.mark.parametrize(("keys", "key", "says"), [
    ({"cam": "width = 60"}, "cam.width", "form = 'groove'"),
    ({"cam": "groove_depth = 6"}, "cam.groove_depth", "form = 'groove'"),
    ({"cam": "running_clearance = 0.02"}, "cam.running_clearance", "form = 'groove'"),
    ({"limits": "play_mm = 0.1"}, "limits.play_mm", "no play"),
    ({"limits": "clearance_mm = 0.1"}, "limits.clearance_mm", "touches its own cam"),  # an arm has a pivot: below
    ({"more": "[tolerance]\nrunning_clearance = 0.01"}, "tolerance.running_clearance", "has none"),
    ({"more": "[tolerance]\nside_shift = 0.01\nbacklash_limit = 20"}, "tolerance.backlash_limit", ""),
    ({"more": "[impact]\nrestitution = 0.5"}, "impact", ""),
    ({"more": '[cutter]\nkind = "flat"\ndiameter = 10\nstart_angle = 20'}, "cutter.start_angle", "none on a plate"),
])  # fmt: skip
def test_what_an_edge_does_not_have_is_refused_by_name(keys: dict[str, object], key: str, says: str) -> None:
    with pytest.raises(ProfileError) as refused:
        plate(**keys)
    problem = next(one for one in refused.value.problems if one.key == key)
    assert says in f"{problem.message} {problem.allowed} {problem.hint}"


@pytest.mark.parametrize("missing", ["groove_depth", "width"])
def test_a_groove_needs_its_depth_and_the_plates_width(missing: str) -> None:
    keys = {"groove_depth": 10, "width": 80}
    text = BASE.format(**GIVEN).replace('"edge"', '"groove"').replace("spring_preload = 90", "")
    whole = "\n".join(f"{key} = {value}" for key, value in keys.items())
    parse(text.replace("moving_mass = 5", whole))
    left = "\n".join(f"{key} = {value}" for key, value in keys.items() if key != missing)
    with pytest.raises(ProfileError, match=f"cam.{missing}"):
        parse(text.replace("moving_mass = 5", left))


def test_tolerances_of_an_edge_know_no_groove_ends() -> None:
    made = plate(more="[tolerance]\ndwell_limit = 60\nsamples = 1000\ncenter_distance = 0.02\nside_shift = 0.05")
    names = {one.check: one.level for one in findings(made)}
    assert names["dwell-tolerance"] == "pass"
    assert "groove-end-tolerance" not in names


def test_the_step_file_of_a_narrow_plate_keeps_its_volume(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fitted within 1e-5 mm an edge 111 mm long and 1.6 mm high in the mean would be 2.5e-7 of its volume off."""
    data = {
        "cam": {"kind": "linear", "form": "edge", "stroke": 100.0, "start": 3.943, "length": 111.209, "edge": 3.814,
                "thickness": 8.333, "inclination": 2.703, "drive_out": 98.03},
        "follower": {"kind": "translating"}, "roller": {"diameter": 5.037, "length": 2.617},
        "motion": ({"until": 15.64}, {"to": 0.539, "law": "power-polynomial", "until": 90.269}, {"until": 100.0}),
    }  # fmt: skip
    (part,) = Model(from_data(data, "")).parts
    assert isinstance(part, EdgePlate)
    true = OutlineIntegrals(part.outline, 64).properties.area * part.top
    assert check_solid(edge_solid(part)).volume == pytest.approx(true, rel=VOLUME)
    monkeypatch.setattr("camgeom.export.step.solids.VOLUME", np.inf)
    assert check_solid(edge_solid(part)).volume != pytest.approx(true, rel=VOLUME)
