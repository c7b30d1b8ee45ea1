"""Contours of discs: simulated from the files, with arcs in and out that do not cut, hollows and corners judged."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.errors import DesignError, ProfileError
from camgeom.machining.contour import ContourPath
from camgeom.machining.outcome import Outcome
from camgeom.machining.plate import PlatePath
from camgeom.model import Model
from camgeom.profile import parse
from tests.oracle.cutter_simulation import disc_profile, fed, forward_rotary_c, read_apt, read_gcode, swept
from tests.places import PROFILES
from tests.reference.milled_cams import model, written
from tests.reference.profiles import built, data_of, said

STEPS = ((90, 18.0), (150, None), (270, 0.0), (360, None))

DISC = """
[cam]
kind = "disc"
base_radius = 30
width = 12
[follower]
kind = "translating"
[roller]
diameter = 20
length = 12
[[motion]]
until = 90
to = 18
law = "cycloidal"
[[motion]]
until = 150
[[motion]]
until = 270
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""
HOLLOW = DISC.replace("base_radius = 30", "base_radius = 60").replace("to = 18", "to = 22").replace(
    "until = 90\n", "until = 34\n"
)
GROOVE = DISC.replace('kind = "disc"', 'kind = "disc"\nform = "groove"\ndiameter = 160\ngroove_depth = 8').replace(
    "length = 12", "length = 8"
)


def profile_points(count: int = 120) -> np.ndarray:
    phi = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, count)
    return np.column_stack([disc_profile(phi, 30.0, 10.0, STEPS), np.full(count, 6.0)])


@pytest.mark.parametrize(("diameter", "start"), [(1.0, 0.0), (12.0, 200.0), (20.0, 0.0), (150.0, 200.0)])
def test_any_tool_gives_the_profile_back_and_its_arcs_cut_nothing(
    tmp_path: Path, diameter: float, start: float
) -> None:
    made = model(DISC, kind="flat", diameter=diameter, start_angle=start, overrun=1.0)
    cutter, _, passes = read_apt(written(made, tmp_path, "apt"))
    tip, axis = fed(passes[0])
    assert np.all(tip[:, 2] == -1.0)
    left = swept(profile_points(), tip, axis, cutter)
    assert np.abs(left).max() < 1e-3
    # Arcs: everything before and after the cut keeps the tool off the profile.
    assert swept(profile_points(), tip[:20], axis[:20], cutter).min() > -1e-4
    assert np.linalg.norm(tip[0, :2] - tip[-1, :2]) > 0.5 * diameter


def test_gcode_turns_the_disc_at_a_constant_surface_speed(tmp_path: Path) -> None:
    made = model(DISC, kind="flat", diameter=12.0, feed=240.0, lead=0.0)
    blocks = read_gcode(written(made, tmp_path, "gcode"))
    cut = [b for b in blocks if b["G"] == "G1"]
    assert all(b["mode"] == "G93" for b in cut)
    # X and C alone carry the tool round the cam.
    assert all(b["Y"] == 0.0 for b in cut)
    tip = forward_rotary_c(cut)
    fine = np.linspace(0.0, 2.0 * np.pi, 40001)
    profile = disc_profile(fine, 30.0, 10.0, STEPS)
    length = np.linalg.norm(np.diff(profile, axis=0), axis=1).sum()
    minutes = sum(1.0 / b["F"] for b in cut[1:])
    assert minutes * 240.0 == pytest.approx(length, rel=1e-3)
    # Block by block: the contact is the profile's point nearest to the tool's centre.
    touch = np.array([np.argmin(np.hypot(*(profile - p[:2]).T)) for p in tip])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])[touch]
    step = np.abs(np.diff(arc))
    step = np.minimum(step, length - step)
    speed = step * np.array([b["F"] for b in cut[1:]])
    large = step > 0.1
    assert np.abs(speed[large] / 240.0 - 1.0).max() < 0.03
    gap = np.abs(np.hypot(*(profile[touch] - tip[:, :2]).T) - 6.0)
    assert gap.max() < 1e-3


def test_plain_machine_and_minutes_feed(tmp_path: Path) -> None:
    made = model(DISC, kind="flat", diameter=12.0, machine="plain", feed_mode="per-minute", feed=100.0)
    text = written(made, tmp_path, "gcode")
    blocks = read_gcode(text)
    assert "G93" not in text.read_text()
    assert all("C" not in b for b in blocks)
    cut = np.array([[b["X"], b["Y"], b["Z"]] for b in blocks if b["G"] == "G1"])
    axis = np.tile([0.0, 0.0, 1.0], (len(cut), 1))
    tool = [12.0, 0.0, 6.0, 0.0, 0.0, 0.0, 12.0]
    assert np.abs(swept(profile_points(), cut, axis, tool)).max() < 1e-3


def test_groove_is_made_in_one_pass_or_two(tmp_path: Path) -> None:
    for keys, passes in (({}, 1), ({"kind": "flat", "diameter": 20.0}, 1), ({"kind": "flat", "diameter": 14.0}, 2)):
        made = model(GROOVE, **keys)
        cutter, _, found = read_apt(written(made, tmp_path, "apt"))
        assert len(found) == passes
        inner = np.min([swept(profile_points(), *fed(blocks), cutter) for blocks in found], axis=0)
        assert np.abs(inner).max() < 1e-3
    with pytest.raises(DesignError, match=r"does not go into the groove; at most 20 mm"):
        model(GROOVE, kind="flat", diameter=20.1).machining  # noqa: B018


def test_hollow_refuses_a_large_wheel_and_says_the_largest() -> None:
    fits = model(HOLLOW, kind="wheel", diameter=10.0).machined.data()["largest_tool_diameter_mm"]
    assert 15.0 < fits < 1000.0
    assert model(HOLLOW, kind="wheel", diameter=0.999 * fits).machining.paths
    with pytest.raises(DesignError, match="at most"):
        model(HOLLOW, kind="wheel", diameter=1.002 * fits).machining  # noqa: B018


@pytest.mark.parametrize("stock", [0.0, 0.2])
def test_largest_tool_of_a_groove_goes_between_its_walls(stock: float) -> None:
    most = model(GROOVE, kind="flat", diameter=14.0, allowance=stock).machined.data()["largest_tool_diameter_mm"]
    assert most == pytest.approx(20.0 - 2.0 * stock, rel=1e-12)
    assert model(GROOVE, kind="flat", diameter=0.999 * most, allowance=stock).machining.paths
    with pytest.raises(DesignError, match="does not go into the groove"):
        model(GROOVE, kind="flat", diameter=1.002 * most, allowance=stock).machining  # noqa: B018


@pytest.mark.parametrize("cone", [False, True])
def test_largest_tool_of_a_plate_goes_into_the_narrower_of_two_grooves(cone: bool) -> None:
    text = (PROFILES / "both_faces_disc.toml").read_text()
    if cone:
        text = text.replace("root_radius = 0.8\nbore", "bore").replace(
            'shape = "cylinder"\ndiameter = 22', 'shape = "cone"\nhalf_angle = 2\ndiameter = 22'
        ).replace('kind = "flat"\ndiameter = 16\ncorner_radius = 0.8', 'kind = "roller"')  # fmt: skip
    assert Model(parse(text)).machined.data()["largest_tool_diameter_mm"] == pytest.approx(19.02, rel=1e-12)


def test_arc_that_cuts_is_refused() -> None:
    with pytest.raises(DesignError, match=r"cutter\.lead .* cuts into the profile"):
        model(HOLLOW, kind="flat", diameter=5.0, lead=90.0, start_angle=8.0).machining  # noqa: B018


def test_a_ball_is_no_tool_for_a_disc() -> None:
    with pytest.raises(ProfileError, match=r"cutter\.kind"):
        model(DISC, kind="ball", diameter=8.0)


def stirred(made: Model, part: int) -> np.ndarray:
    """Points of a disc's outline, between the knots of its motion, (100, 3)."""
    outline = made.parts[part].outer.outline
    points = outline.curve(np.random.default_rng(4).uniform(0.0, 2.0 * np.pi, 100)).points
    height = 0.5 * (made.parts[part].z0 + made.parts[part].z1)
    return np.column_stack([points.T, np.full(100, height)])


@pytest.mark.parametrize(("name", "start"), [("conjugate_rocker", 0.0), ("parallel_index", 77.0)])
def test_rotary_axis_never_goes_round_in_the_cut(tmp_path: Path, name: str, start: float) -> None:
    """Discs whose follower stands on the far side, and plates with corners: between blocks the tool stays outside."""
    keys = f'[cutter]\nkind = "flat"\ndiameter = 12\nstart_angle = {start}\n'
    made = Model(parse((PROFILES / f"{name}.toml").read_text() + keys))
    passes: list[list[dict]] = []
    for block in read_gcode(written(made, tmp_path, "gcode")):
        if block["G"] == "G0" and (not passes or passes[-1][-1]["G"] == "G1"):
            passes.append([])
        passes[-1].append(block)
    passes = [[b for b in blocks if b["G"] == "G1"] for blocks in passes]
    passes = [blocks for blocks in passes if blocks]
    assert len(passes) == 2
    for number, blocks in enumerate(passes):
        table = np.array([[b[w] for w in "XYZC"] for b in blocks])
        assert np.abs(np.diff(table[:, 3])).max() < 45.0
        parts = np.maximum(2, np.ceil(np.abs(np.diff(table[:, 3])) / 0.25)).astype(int)
        at = np.concatenate([i + np.arange(n) / n for i, n in enumerate(parts)] + [[len(parts)]])
        fine = np.stack([np.interp(at, np.arange(len(table)), column) for column in table.T], axis=1)
        tip = forward_rotary_c([dict(zip("XYZC", row)) for row in fine])
        axis = np.tile([0.0, 0.0, 1.0], (len(tip), 1))
        left = swept(stirred(made, number), tip, axis, [12.0, 0.0, 6.0, 0.0, 0.0, 0.0, 50.0])
        assert np.abs(left).max() < 1e-3


def off_outline(made: Model, places: np.ndarray) -> float:
    """Least distance of straight ways between places (n, 2) from the outline of the solid's upper face, mm: of ten
    thousand points on its edges."""
    mesh = made.solid.mesh
    faces = mesh.faces[np.all(np.abs(mesh.vertices[mesh.faces][:, :, 2] - mesh.vertices[:, 2].max()) < 1e-9, axis=1)]
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    ends = mesh.vertices[edges[count == 1]][:, :, :2]
    share = np.linspace(0.0, 1.0, 1 + 10_000 // len(ends))[:, None, None]
    points = (ends[:, 0] + share * (ends[:, 1] - ends[:, 0])).reshape(-1, 2)
    pieces = np.maximum(1, np.ceil(np.linalg.norm(np.diff(places, axis=0), axis=1) / 0.2)).astype(int)
    ways = [a + np.linspace(0.0, 1.0, n + 1)[:, None] * (b - a) for a, b, n in zip(places, places[1:], pieces)]
    return min(float(np.linalg.norm(points - at, axis=1).min()) for at in np.concatenate(ways))


@pytest.mark.parametrize(
    "changed",
    [{}, {"kind": "roller", "diameter": None}, {"diameter": 40}, {"diameter": 4, "milling": "conventional"},
     {"kind": "wheel", "diameter": 60}, {"allowance": 0.2}],
)  # fmt: skip
def test_round_a_plate_every_corner_stays(tmp_path: Path, changed: dict[str, Any]) -> None:
    """The corner at which the path begins was cut off by 0.29 of the tool's radius, and `gouge` passed with 0."""
    made = built(data_of("linear_edge", **{f"cutter__{key}": value for key, value in changed.items()}))
    path = written(made, tmp_path, "gcode")
    at = {"X": 0.0, "Y": 0.0}
    places = []
    for line in path.read_text().splitlines():
        if line.startswith("G1 X"):
            at |= {word[0]: float(word[1:]) for word in line.split()[1:3]}
            places.append((at["X"], at["Y"]))
    radius = made.machined.machining.tool.radius + changed.get("allowance", 0.0)
    assert len(places) > 100
    assert -0.006 < off_outline(made, np.array(places)) - radius < 0.006
    (told,) = said(made, "gouge")
    assert told.value is not None
    assert told.value <= 0.000501


@pytest.mark.parametrize(("share", "level"), [(1.001, "pass"), (0.999, "fail")])
def test_a_cut_into_a_profile_is_judged(share: float, level: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a path that is nearer to it than the tool's radius, and of its chords, beyond that."""
    found = nearer(built(data_of("linear_edge"))).into_profile
    assert found is not None
    assert found.deep == pytest.approx(0.0505, abs=5e-5)
    made = built(data_of("linear_edge", cutter__gouge_limit=share * found.deep))
    outcome = nearer(made)
    monkeypatch.setitem(vars(made), "machined", outcome)
    (told,) = said(made, "gouge")
    assert (told.level, told.value) == (level, found.deep)
    with nullcontext() if level == "pass" else pytest.raises(DesignError, match="into the profile"):
        outcome.refuse_gouges()


def nearer(made: Model) -> Outcome:
    """Of a path round a plate that is 0.05 mm too near to it."""
    machining = made.machined.machining
    (path,) = machining.paths
    assert isinstance(path, PlatePath)
    assert isinstance(path.along, ContourPath)
    return Outcome(replace(machining, paths=(replace(path, along=replace(path.along, reach=path.along.reach - 0.05)),)))


STEEP = """
[cam]
kind = "disc"
base_radius = 320
width = 12
bore = 60
[follower]
kind = "translating"
[roller]
diameter = 20
length = 10
[[motion]]
until = 14
to = 36
law = "cycloidal"
[[motion]]
until = 180
[[motion]]
until = 194
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""


def chords_against(made: Model) -> tuple[float, float]:
    """How deep the straight ways of the cutter data of a disc cut into its outline, and how much they leave, mm: of its
    points half a micron's sag apart."""
    (path,) = made.machined.machining.paths
    (run,) = made.machined.machining.passes("cam")
    places = np.concatenate([one.positions.tip[:2] for one in run.moves if one.kind != "rapid"], axis=1).T
    knots = path.outline.knots()
    phi = np.concatenate([np.linspace(a, b, 3000) for a, b in zip(knots, knots[1:])])
    points = path.outline.curve(phi).points.T
    off = np.full(len(points), np.inf)
    for a, b in zip(places, places[1:]):
        share = np.clip((points - a) @ (b - a) / max((b - a) @ (b - a), 1e-300), 0.0, 1.0)
        off = np.minimum(off, np.linalg.norm(points - a - share[:, None] * (b - a), axis=1))
    radius = made.machined.machining.tool.radius
    return radius - off.min(), off.max() - radius


def test_a_large_disc_has_no_gouge_but_its_chords() -> None:
    """Sags of a polygon of 1440 sides were told as a gouge of 0.00304 mm in its hollows."""
    made = model(STEEP, kind="flat", diameter=40.0, gouge_limit=0.001)
    deep, left = chords_against(made)
    (cut,), (rest,) = said(made, "gouge"), said(made, "stock-left")
    assert (cut.level, rest.level) == ("pass", "pass")
    assert cut.value == pytest.approx(deep, abs=2e-6)
    assert rest.value == pytest.approx(left, abs=2e-6)
    assert made.machining.paths


@pytest.mark.parametrize("tolerance", [0.02, 0.2])
@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.999, "fail")])
def test_chords_of_a_path_are_judged_as_they_cut(tolerance: float, share: float, level: str) -> None:
    """What the path's chord error is was taken off: with cutter.tolerance = 0.2 a cut of 0.13 mm was told as 0."""
    keys: dict[str, Any] = {"kind": "flat", "diameter": 40.0, "tolerance": tolerance, "machine": "plain"}
    deep = chords_against(model(STEEP, **keys))[0]
    assert 0.5 * tolerance < deep <= 1.001 * tolerance
    made = model(STEEP, **keys, gouge_limit=share * deep)
    (told,) = said(made, "gouge")
    assert (told.level, told.value) == (level, pytest.approx(deep, rel=1e-4))
    if level == "fail":
        assert told.advice == "use a smaller cutter.tolerance"
        with pytest.raises(DesignError, match=r"into the profile .* use a smaller cutter\.tolerance"):
            made.machining  # noqa: B018
    stood_off = said(model(STEEP, **keys, allowance=1.1 * tolerance, gouge_limit=0.0), "gouge")[0]
    assert (stood_off.level, stood_off.value) == ("pass", 0.0)


@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.999, "fail")])
def test_what_chords_leave_in_hollows_is_stock(share: float, level: str) -> None:
    keys: dict[str, Any] = {"kind": "flat", "diameter": 40.0, "tolerance": 0.01, "machine": "plain"}
    left = chords_against(model(STEEP, **keys))[1]
    (told,) = said(model(STEEP, **keys, gouge_limit=share * left), "stock-left")
    assert (told.level, told.value) == (level, pytest.approx(left, rel=1e-3))
    assert ("cutter.tolerance" in told.advice) == (level == "fail")
    ground = said(model(STEEP, **keys, allowance=0.2), "stock-left")
    assert [(one.level, one.value) for one in ground] == [("pass", 0.0)]


@pytest.mark.parametrize("name", ["both_faces_disc", "conical_pair"])
def test_the_gcode_of_a_part_turned_over_is_judged_as_it_lies(name: str) -> None:
    """The part as it lies was held against the part as it was: a gouge of 170 and of 240 mm."""
    data = data_of(name)
    cutter = {"kind": "flat", "diameter": 16.0} if name == "both_faces_disc" else {"kind": "roller"}
    data["cutter"] = {**data.get("cutter", cutter), "tolerance": 0.01, "gouge_limit": 0.0099}
    data["cutter"].pop("allowance", None)
    machining = built(data).machined.machining
    assert any(machining.machine.below(path.at(np.zeros(1))) for path in machining.paths)
    for path in machining.paths:
        for space in ("cam", "machine"):
            sag = machining.sag(path, space)
            assert min(sag.cut, sag.left) >= 0.0
            assert 0.003 < max(sag.cut, sag.left) <= 0.0101


def test_chords_of_the_gcode_count_where_those_of_the_path_keep_the_limit() -> None:
    """The rotary axis turns the disc along other chords, which cut deeper, or less deep."""
    keys: dict[str, Any] = {"kind": "flat", "diameter": 40.0}
    for tolerance in (0.05, 0.1, 0.2):
        machining = model(STEEP, **keys, tolerance=tolerance).machined.machining
        cam, turned = (machining.sag(machining.paths[0], space).cut for space in ("cam", "machine"))
        limit = 1.001 * cam
        (told,) = said(model(STEEP, **keys, tolerance=tolerance, gouge_limit=limit), "gouge")
        assert told.value == pytest.approx(max(cam, turned), rel=5e-4)
        assert told.level == ("pass" if turned <= limit else "fail")
