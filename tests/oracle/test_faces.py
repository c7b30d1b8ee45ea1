"""Several tracks on one disc: the body by the oracle, walls by the rollers' ways alone, one body in every export."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import camgeom
from camgeom.checks import findings
from camgeom.checks import judge as judged
from camgeom.errors import DesignError, ProfileError
from camgeom.export.points import flank_points
from camgeom.export.step.bodies import model_bodies
from camgeom.export.step.brep import Brep
from camgeom.export.step.check import check_solid
from camgeom.inspection import inspect
from camgeom.inspection.points import MeasuredPoints
from camgeom.machining.contour import ContourPath
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.report.sections import report
from camgeom.solid.prism import GroovedPlate
from tests.oracle.cams import disc_walls
from tests.oracle.cutter_simulation import dense, fed_passes, read_gcode, swept
from tests.places import ROOT
from tests.profile.cases import MOVES, frozen
from tests.reference.profiles import built, changed

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from designs import design
from judging import _judges, judge

Data = dict[str, Any]
BOTH = f"""
[cam]
kind = "disc"
form = "groove"
diameter = 200
base_radius = 40
width = 40
groove_depth = 12
bore = 30
[follower]
kind = "translating"
mass = 1.5
[roller]
diameter = 20
length = 11
[operation]
speed = 200
friction = 20
[output]
tolerance = 0.05
[[motion]]{MOVES}
[[track]]
angle = 90
cam = {{ face = "lower", groove_depth = 10, base_radius = 45, running_clearance = 0.02, root_radius = 0.8 }}
follower = {{ mass = 0.8 }}
roller = {{ diameter = 16, length = 9 }}
{MOVES.replace('[[motion]]', '[[track.motion]]').replace('until = 150', '[[track.motion]]' + chr(10) + 'until = 120')}
"""
RIM = {"base_radius": 88.0, "form": "external"}


def data_of(**keys: Any) -> Data:
    return changed(tomllib.loads(BOTH), **keys)


def mixed(*grooves: str, **keys: Any) -> Data:
    """A disc whose rim is a profile, with a groove in each face that is named."""
    data = data_of(**keys)
    first = {key: data["cam"].pop(key) for key in ("form", "diameter", "base_radius", "groove_depth")}
    (lower,) = data["track"]
    upper = {"cam": {"form": "groove", "rim": "profile", "base_radius": first["base_radius"], "groove_depth": 12.0},
             "roller": data["roller"], "motion": data["motion"]}  # fmt: skip
    lower["cam"] |= {"form": "groove", "rim": "profile"}
    data["cam"] |= RIM
    data["roller"] = {"diameter": 30.0, "length": 20.0}
    data["motion"] = [{"until": 200.0, "to": 12.0, "law": "3-4-5"}, {"until": 360.0, "to": 0.0, "law": "3-4-5"}]
    data["operation"]["spring_preload"] = 500.0
    for track in (upper, lower):
        track["operation"] = {"spring_preload": 0.0}
    data["track"] = [{"upper": upper, "lower": lower}[name] for name in grooves]
    return data


def model_of(**keys: Any) -> Model:
    return built(data_of(**keys))


@pytest.fixture(scope="module")
def both() -> Model:
    return model_of()


@pytest.fixture(scope="module")
def three() -> Model:
    return built(mixed("upper", "lower"))


@pytest.mark.parametrize("direction", ["ccw", "cw"])
@pytest.mark.parametrize("data", [data_of(), mixed("upper"), mixed("upper", "lower")], ids=["both", "rim", "all"])
def test_the_body_lies_where_the_oracle_says(data: Data, direction: str) -> None:
    record = judge({**data, "cam": {**data["cam"], "direction": direction}})
    assert record["outcome"] == "good", record
    assert 0.3 < record["error"] <= 1.0 + 1e-6


def test_each_follower_has_the_figures_of_its_own_plate(both: Model) -> None:
    data = data_of()
    (table,) = data.pop("track")
    first = built(data)
    for name in ("cam", "follower"):
        data[name] = {**data[name], **table[name]}
    data["cam"]["face"], data["roller"], data["motion"] = "upper", table["roller"], table["motion"]
    second = built(data)
    for one, lone in zip(both.bindings, (first, second)):
        assert one.duty.peak_pressure.value == pytest.approx(lone.duty.peak_pressure.value, rel=1e-12)
        assert one.flanks[0].margin.value == lone.flanks[0].margin.value
        assert one.lives == pytest.approx(lone.lives)
        assert min(c.value for c in one.clearances) > -1e-6
    plate = np.pi * (100.0**2 - 15.0**2) * 40.0
    cut = [model.mass[0].volume for model in (first, second, both)]
    assert cut[0] + cut[1] - plate == pytest.approx(cut[2], abs=0.5 * both.tolerance * both.solid.mesh.area)


def test_the_web_is_judged_from_floor_to_floor() -> None:
    """Grooves at one radius leave the width less both depths; each floor is 20 and 22 mm from the other face."""
    for limit, level in ((9.99, "pass"), (10.02, "fail")):
        found = findings(model_of(cam__width=32.0, limits={"min_wall_mm": limit}), ["wall"])
        assert [f.where for f in found if f.level == level][-1:] == ["groove 1 to groove 2, floor to floor"]
        assert sum(f.level == "fail" for f in found) == (level == "fail")
    thin = model_of(cam__width=21.9)
    with pytest.raises(DesignError, match="groove 1 to groove 2, floor to floor: nothing is left"):
        _ = thin.solids
    assert [f.where for f in findings(thin, ["wall"]) if f.level == "fail"] == ["groove 1 to groove 2, floor to floor"]
    assert "fail" in {f.level for f in findings(thin, ["watertight"])}


def test_grooves_beside_each_other_may_be_deeper_than_half_the_plate() -> None:
    """One round the other: what is left is the wall between their flanks, in any direction, and never negative."""
    deep = {"face": "lower", "groove_depth": 24.0, "base_radius": 86.0}
    data = data_of(cam__diameter=300.0, cam__groove_depth=24.0)
    data["track"][0]["cam"] = deep
    model = built(data)
    wanted, off = disc_walls(data, [lambda phi, p=one.setup.program: p.jet(phi, 0)[0] for one in model.grooves])
    told = {wall.name: wall.thickness for wall in model.walls}
    beside = told["groove 1 to groove 2, edge to edge"]
    assert 0.0 < beside == pytest.approx(wanted["groove 1 to groove 2, edge to edge"], abs=off)
    assert model.solid.sound
    assert {"groove 1, under the floor", "groove 2, under the floor"} <= set(told)


def test_the_rim_s_own_profile_decides_how_thick_the_wall_is(three: Model) -> None:
    data = mixed("upper", "lower")
    wanted, off = disc_walls(data, [lambda phi, p=one.setup.program: p.jet(phi, 0)[0] for one in three.grooves])
    told = {wall.name: wall.thickness for wall in three.walls}
    for name in ("groove 2, outer flank to rim", "groove 3, outer flank to rim"):
        assert told[name] == pytest.approx(wanted[name], abs=off)
        # Neither the base circle nor the profile's largest radius tells it.
        assert abs(told[name] - (88.0 - 85.0)) > 0.5
    worst = told["groove 2, outer flank to rim"]
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        judged_ = built({**data, "limits": {"min_wall_mm": share * worst}})
        (found,) = [f for f in findings(judged_, ["wall"]) if f.where == "groove 2, outer flank to rim"]
        assert found.level == level


def test_what_is_cut_too_deep_is_told_of_each_track() -> None:
    """A track with more room than the first one is no backlash; the same flank of a roller that is smaller is."""
    for clearances in ((0.0, 0.05), (0.05, 0.0)):
        data = data_of(cam__running_clearance=clearances[0])
        data["track"][0]["cam"]["running_clearance"] = clearances[1]
        (found,) = findings(built(data), ["backlash"])
        assert (found.level, found.value) == ("pass", pytest.approx(clearances[0], abs=1e-9))


def test_rollers_one_behind_the_other_are_as_far_apart_as_their_ends() -> None:
    """Both followers at one place with one motion: between the flat ends stand the web and both floor gaps."""
    data = data_of()
    (track,) = data["track"]
    track |= {"angle": 0.0, "motion": data["motion"]}
    track["cam"]["base_radius"] = 42.0
    assert built(data).apart.value == pytest.approx(40.0 - 11.0 - 9.0)
    data["track"][0]["roller"]["length"] = 10.0
    assert built(data).apart.value == pytest.approx(40.0 - 11.0 - 10.0)


@pytest.mark.parametrize("name", ["both", "three"])
def test_step_has_one_solid_of_the_mesh_s_volume(name: str, request: pytest.FixtureRequest) -> None:
    model = request.getfixturevalue(name)
    body = model_bodies(model)
    assert isinstance(body, Brep)
    found = check_solid(body)
    assert (found.problems, found.genus) == ((), 1)
    layer = 0.5 * model.tolerance * model.solid.mesh.area
    assert found.volume == pytest.approx(model.solid.mesh.volume, abs=layer)


def test_every_reader_has_all_tracks(three: Model, tmp_path: Path) -> None:
    assert set(flank_points(three)["track"].tolist()) == {0.0, 1.0, 2.0}
    camgeom.write(three, tmp_path / "cam.outline.csv")
    camgeom.write(three, tmp_path / "cam.dxf")
    curves = {line.split(",")[0] for line in (tmp_path / "cam.outline.csv").read_text().splitlines()[1:]}
    assert curves == {"track 1 profile", "track 1 pitch curve", *(f"track {k} {word}" for k in (2, 3)
                      for word in ("profile", "outer flank", "pitch curve"))}  # fmt: skip
    page = report(three, only=["design", "flank"])
    assert [chapter.key for chapter in page.sections] == ["design", "flank", "flank-2", "flank-3"]
    assert isinstance(three.parts[0], GroovedPlate)
    assert len(three.parts) == 1


TOOL = {"kind": "flat", "diameter": 12.0, "corner_radius": 0.8, "spindle": 2000.0, "feed": 300.0}


def test_the_lower_face_is_cut_with_the_part_turned_over(tmp_path: Path) -> None:
    """The program's coordinates, turned back into the cam: X, Y, Z of the tool's end beside the lower groove's way."""
    data = data_of(cutter=TOOL)
    data["track"][0]["cam"].pop("root_radius")
    model = built(data)
    camgeom.write(model, tmp_path / "cam.gcode")
    text = (tmp_path / "cam.gcode").read_text()
    upper, lower = text.split("M0\nG55\n")
    assert "G54" in upper
    assert upper.rstrip().endswith("(TURN THE PART OVER)")
    assert "G54" not in lower
    blocks = np.array([[float(v) for v in found] for found in
                       re.findall(r"G1 X(\S+) Y(\S+) Z(\S+) C(\S+) F", lower)])  # fmt: skip
    x, y, z, c = blocks.T
    turned = (x + 1j * y) * np.exp(-1j * np.radians(c))
    tip = np.stack([turned.real, -turned.imag, 40.0 - z], axis=1)
    cut = tip[np.abs(tip[:, 2] - 10.0) < 1e-3]
    assert len(cut) > 0.9 * len(tip)
    (track,) = model.bindings[1].tracks
    centres = track.pose(np.linspace(0.0, 2.0 * np.pi, 20001), 0).a[0][:2].T
    away = np.array([np.hypot(*(centres - p[:2]).T).min() for p in cut[:: len(cut) // 60]])
    # The tool of 12 mm stands 2.02 mm off the way of the 16 mm roller with its clearance, but on the arcs in and out.
    assert np.quantile(np.abs(away - 2.02), 0.75) < 5e-4


def test_rollers_of_two_sizes_are_followed_by_two_tools(tmp_path: Path) -> None:
    model = model_of(cutter={"kind": "roller"})
    for ext in ("gcode", "apt"):
        camgeom.write(model, tmp_path / f"cam.{ext}")
    assert re.findall(r"T(\d) M6", (tmp_path / "cam.gcode").read_text()) == ["1", "2"]
    apt = (tmp_path / "cam.apt").read_text()
    assert re.findall(r"CUTTER/([\d.]+)", apt) == ["20.000000", "16.040000"]
    assert apt.index("STOP") < apt.index("LOADTL/2")


def test_what_contradicts_itself_on_one_disc_is_refused(three: Model) -> None:
    del three
    for change, word in (
        ({"face": "upper"}, r"track\[0\]\.cam\.face: cannot be built .*one groove a face, and cam has this one"),
        ({"rim": "profile"}, r"track\[0\]\.cam\.rim: .*without a track of form = 'external'"),
        ({"width": 30.0}, r"track\[0\]\.cam\.width: is the body's"),
    ):
        data = data_of()
        data["track"][0]["cam"] |= change
        with pytest.raises(ProfileError, match=word):
            from_data(frozen(data), "")
    lone = {key: value for key, value in data_of(cam__face="lower").items() if key != "track"}
    with pytest.raises(ProfileError, match=r"cam\.face: .*turned over"):
        from_data(frozen(lone), "")
    lone["cam"] = {key: value for key, value in lone["cam"].items() if key not in ("face", "diameter")}
    for cam in ({}, {"rim": "profile"}):
        with pytest.raises(ProfileError, match=r"cam\.(diameter: is missing|rim: cannot be built)"):
            from_data(frozen({**lone, "cam": lone["cam"] | cam}), "")
    two = mixed("upper")
    two["track"].append({"cam": RIM})
    with pytest.raises(ProfileError, match=r"track\[1\]\.cam\.form: .*discs side by side are not built"):
        from_data(frozen(two), "")


def test_what_is_not_solved_of_several_tracks_is_told() -> None:
    """A body without a bore is held by nothing."""
    data = data_of(operation={"speed": 200.0, "friction": 200.0}, material={"cam": {"bending_limit": 400.0}})
    data["cam"].pop("bore")
    model = built(data)
    said = judged(model, ["root-stress"])
    assert not said.findings
    assert {word.check for word in said.not_judged} == {"root-stress"}


def test_what_a_track_has_no_use_for_is_not_taken_over() -> None:
    """Impacts are those of the groove: what holds the other follower on its profile has none. Said of it, refused."""
    data = mixed("upper")
    (groove,) = data.pop("track")
    rim = {key: data.pop(key) for key in ("roller", "motion", "operation")}
    profile = {"cam": RIM, **rim, "operation": {"spring_preload": 500.0}}
    body = {key: data["cam"][key] for key in ("kind", "width", "bore")}
    data |= {"cam": body | groove["cam"] | {"running_clearance": 0.02}, "roller": groove["roller"],
             "motion": groove["motion"],
             "operation": {"speed": 60.0, "friction": 20.0}, "impact": {}, "limits": {"play_mm": 0.2},
             "track": [profile]}  # fmt: skip
    model = built(data)
    assert [one.profile.impact is None for one in model.bindings] == [False, True]
    profile["cam"] = {**RIM, "groove_depth": 4.0}
    with pytest.raises(ProfileError, match=r"track\[0\]\.cam\.groove_depth: means nothing here"):
        from_data(frozen(data), "")


def test_measured_points_find_the_flanks_of_both_faces(both: Model) -> None:
    """Points of both grooves, moved and turned, go back to their own flanks; without heights nobody knows the face."""
    cloud = flank_points(both)
    some = np.arange(0, len(cloud["points"]), 97)
    turn, x = np.radians(0.4), cloud["points"][some].T
    moved = np.stack([np.cos(turn) * x[0] - np.sin(turn) * x[1], np.sin(turn) * x[0] + np.cos(turn) * x[1], x[2]])
    found = inspect(both, MeasuredPoints(moved, False, None))
    assert set(found.names) == {f"{face} {which} flank" for face in ("upper", "lower") for which in ("inner", "outer")}
    assert found.angle == pytest.approx(-turn, abs=1e-7)
    assert float(np.abs(found.deviation[found.kept]).max()) < 1e-6
    assert found.kept.mean() > 0.9
    flat = np.concatenate([x[:2], np.zeros((1, x.shape[1]))])
    with pytest.raises(ProfileError, match="points: need heights on a disc with several tracks"):
        inspect(both, MeasuredPoints(flat, True, None))


def cones(data: Data, *leans: float) -> Data:
    """The same with rollers of these half angles, the first one's first; 0: as it is."""
    for table, lean in zip((data, *data["track"]), leans):
        if lean:
            table["roller"] = {**table["roller"], "shape": "cone", "half_angle": lean}
            table["cam"].pop("root_radius", None)
    return data


LEANING = {
    "first": cones(data_of(), 6.0),
    "second": cones(data_of(), 0.0, -5.0),
    "both": cones(data_of(), 6.0, 5.0),
    "rim": cones(mixed("upper"), 7.0),
    "all": cones(mixed("upper", "lower"), -6.0, 5.0, -4.0),
}


@pytest.mark.parametrize("direction", ["ccw", "cw"])
@pytest.mark.parametrize("case", LEANING)
def test_a_body_with_walls_that_lean_lies_where_the_oracle_says(case: str, direction: str) -> None:
    data = LEANING[case]
    record = judge({**data, "cam": {**data["cam"], "direction": direction}})
    assert record["outcome"] == "good", record
    assert 0.3 < record["error"] <= 1.0 + 1e-6


@pytest.mark.parametrize("case", LEANING)
def test_its_step_file_is_one_sound_body(case: str) -> None:
    data = LEANING[case]
    one = built(data)
    solid = model_bodies(one)
    assert isinstance(solid, Brep)
    verdict = check_solid(solid, 1e-5)
    assert verdict.problems == ()
    volumes = [built(data | {"output": {"tolerance": size}}).solid.mesh.volume for size in (2e-3, 5e-4)]
    assert verdict.volume == pytest.approx(volumes[1] + (volumes[1] - volumes[0]) / 3.0, rel=1e-6)


def test_random_discs_of_several_tracks_and_cones() -> None:
    outcomes = {seed: judge(design(seed), seed) for seed in range(220_000, 220_012)}
    bad = {seed: one for seed, one in outcomes.items() if one["outcome"] in ("FAILURE", "stopped")}
    assert not bad
    assert any("error" in one for one in outcomes.values())


@pytest.mark.parametrize(("share", "sound"), [(0.999, True), (1.001, False)])
def test_a_leaning_wall_is_judged_where_it_is_thinnest(share: float, sound: bool) -> None:
    """The upper groove's wall to the rim: at the mouth the cone is thicker by what it leans over half its length."""
    lean = np.tan(np.radians(6.0))
    # Both are widest at the upper face: the roller's middle is 5.5 mm below it, the profile's rim as high.
    data = cones(data_of(), 6.0)
    plain = {wall.name: wall.thickness for wall in built(data_of()).walls}["groove 1, outer flank to rim"]
    least = plain - 5.5 * lean
    found = next(one for one in findings(built(data | {"limits": {"min_wall_mm": share * least}}), ["wall"])
                 if "groove 1, outer" in one.where)  # fmt: skip
    assert found.value == pytest.approx(least, abs=1e-9)
    assert found.passed is sound


def test_grooves_beside_each_other_leave_the_way_between_their_walls() -> None:
    """A narrow groove within a wide one: from the foot of the one to the wall of the other, by hand."""
    data = cones(data_of(cam__base_radius=30.0, cam__groove_depth=22.0), 0.0, 8.0)
    data["track"][0]["cam"] |= {"base_radius": 78.0, "groove_depth": 25.0, "running_clearance": 0.0}
    data["cam"] |= {"diameter": 280.0, "bore": 20.0}
    walls = {wall.name: wall.thickness for wall in built(data).walls}
    # Rises differ in time, so that the nearest are a dwell at the top beside one at rest: by their middles alone.
    programs = [one.setup.program for one in built(data).grooves]
    wanted, off = disc_walls(data, [lambda phi, one=one: one.jet(phi, 0)[0] for one in programs])
    name = "groove 1 to groove 2, edge to edge"
    assert wanted[name] == pytest.approx(walls[name], abs=off)
    straight = cones(data_of(cam__base_radius=30.0, cam__groove_depth=22.0))
    straight["track"][0]["cam"] |= {"base_radius": 78.0, "groove_depth": 25.0, "running_clearance": 0.0}
    straight["track"][0]["cam"].pop("root_radius")
    straight["cam"] |= {"diameter": 280.0, "bore": 20.0}
    assert {wall.name: wall.thickness for wall in built(straight).walls}[name] != pytest.approx(walls[name], abs=0.1)


@pytest.mark.parametrize("keys", [{}, {"kind": "flat", "diameter": 9.0, "axis": "fitted"}])
def test_every_wall_of_both_faces_is_cut_from_its_own_side(tmp_path: Path, keys: Data) -> None:
    data = cones(data_of(cam__running_clearance=0.02), 0.0, 5.0)
    model = built({**data, "cutter": keys})
    file = tmp_path / "cam.gcode"
    camgeom.write(model, file)
    text = file.read_text()
    within = float(re.search(r"PATH WITHIN ([0-9.E-]+)", text)[1])
    upper, lower = text.split("M0\nG55\n")
    file.write_text(upper[: upper.rindex("G53")])
    above = fed_passes(read_gcode(file))
    file.write_text("G43 H1\n" + lower)
    below = fed_passes(read_gcode(file))
    mesh, (oracle,) = model.solid.mesh, _judges(model, data)
    points = mesh.vertices[mesh.group_vertices("flank")]
    assert np.abs(oracle.least(points[::20])).max() < 1e-6
    rng = np.random.default_rng(1)
    for blocks, face, tool in ((above, points[points[:, 2] > 20.0], 0), (below, points[points[:, 2] < 20.0], -1)):
        some = face[rng.permutation(len(face))[:40]]
        if tool:
            some = some * [1.0, -1.0, -1.0] + [0.0, 0.0, 40.0]
        numbers = [*model.machining.tools[tool].apt(30.0)]
        off = np.min([swept(some, *dense(one, "C", upright=True), numbers) for one in blocks], axis=0)
        assert np.abs(off).max() < within + 1e-4
    assert ("TILTS" in text) == bool(keys)


def test_what_leaning_walls_do_not_have_is_told() -> None:
    with pytest.raises(ProfileError, match=r"cutter\.axis.*roller, for a disc"):
        built(data_of(cutter={"kind": "flat", "diameter": 9.0, "axis": "fitted"}))
    with pytest.raises(ProfileError, match=r"cutter\.half_angle.*allowed: 0$"):
        built({**cones(data_of(), 0.0, 5.0), "cutter": {"kind": "flat", "diameter": 9.0, "half_angle": 5.0}})
    data = cones(data_of(operation={"speed": 200.0, "friction": 200.0}, material={"cam": {"bending_limit": 400.0}}),
                 0.0, 5.0)  # fmt: skip
    said = judged(built(data), ["root-stress"])
    assert not said.findings
    assert any("lean" in word.reason for word in said.not_judged)


def test_rows_of_a_ball_on_several_tracks_have_blocks_of_their_own() -> None:
    data = {**cones(data_of(), 6.0, 5.0), "cutter": {"kind": "ball", "diameter": 5.0, "scallop": 0.2, "neck": 1.5}}
    machining = built(data).machining
    assert len(machining.rows) == 4
    for path in machining.paths:
        assert path.track is machining.rows[path.group].paths[0].track
    passes = list(machining.passes())
    assert len(passes) == len(machining.paths)
    assert max(one.chord_error for one in passes) <= machining.spec.tolerance
    assert [one.below for one in passes] == sorted(one.below for one in passes)


@pytest.mark.parametrize("data", [data_of(), mixed("upper")], ids=["grooves", "rim"])
def test_an_overrun_is_refused_where_there_are_grooves_alone(data: Data) -> None:
    made = built(data | {"cutter": {"kind": "flat", "diameter": 8.0, "overrun": 1.0}})
    if "rim" in data["track"][0]["cam"]:
        assert min(path.low for path in made.machining.paths if isinstance(path, ContourPath)) == -1.0
    else:
        with pytest.raises(ProfileError, match=r"cutter.overrun.*lower face"):
            _ = made.machining
