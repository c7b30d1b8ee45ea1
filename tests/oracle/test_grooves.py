"""Several grooves on one drum: the body by the oracle, each follower as on its own drum, one body in every export."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from camgeom.checks import findings
from camgeom.checks import judge as judged
from camgeom.errors import DesignError, ProfileError
from camgeom.export.points import flank_points
from camgeom.model import Model, read
from camgeom.profile import from_data, parse
from camgeom.report.result import compute
from camgeom.report.sections import report
from camgeom.solid.drum import WALL_SAMPLES
from camgeom.track.flank import Flank
from tests.places import ROOT
from tests.profile.cases import MOVES, frozen
from tests.reference.profiles import built, changed, model

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from judging import judge

Data = dict[str, Any]
TEXT = f"""
name = "two grooves"
[cam]
kind = "cylindrical"
form = "groove"
diameter = 120
length = 150
start = 30
groove_depth = 10
bore = 40
[follower]
kind = "translating"
mass = 1.5
[roller]
diameter = 20
length = 9
[[motion]]{MOVES}
[operation]
speed = 200
friction = 20
[output]
tolerance = 0.05
[[track]]
angle = 90
cam = {{ start = 85, groove_depth = 8 }}
follower = {{ mass = 0.8 }}
roller = {{ diameter = 16, length = 7 }}
[[track.motion]]
until = 100
[[track.motion]]
until = 260
to = 25
law = "3-4-5"
[[track.motion]]
until = 360
to = 0
law = "cycloidal"
"""


def data_of(**keys: Any) -> Data:
    return changed(tomllib.loads(TEXT), **keys)


def model_of(**keys: Any) -> Model:
    return built(data_of(**keys))


def alone(track: int) -> Model:
    """A drum with one of the two grooves."""
    data = data_of()
    (table,) = data.pop("track")
    if track:
        for name in ("cam", "follower"):
            data[name] |= table[name]
        data |= {"roller": table["roller"], "motion": table["motion"]}
    return built(data)


@pytest.fixture(scope="module")
def both() -> Model:
    return model_of()


@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_the_body_lies_where_the_oracle_says(direction: str) -> None:
    record = judge(data_of(cam__direction=direction))
    assert record["outcome"] == "good", record
    assert 0.3 < record["error"] <= 1.0 + 1e-6


def test_each_follower_has_the_figures_of_its_own_drum(both: Model) -> None:
    for number, lone in enumerate((alone(0), alone(1))):
        one = both.bindings[number]
        assert one.duty.peak_pressure == lone.duty.peak_pressure
        assert one.flanks[0].margin == lone.flanks[0].margin
        assert one.lives == lone.lives
        assert min(c.value for c in one.clearances) > -1e-6
    first, second = (alone(k).shaft for k in (0, 1))
    theta = np.linspace(0.1, 6.2, 40)
    wanted = [shaft.panels.at(shaft.torque, (theta - angle) % (2.0 * np.pi))
              for shaft, angle in ((first, 0.0), (second, 0.5 * np.pi))]  # fmt: skip
    assert both.camshaft.at(theta) == pytest.approx(sum(wanted), abs=1e-6 * both.camshaft.peak_torque.value)


@pytest.mark.parametrize(("first", "second"), [(2000.0, 5.0), (5.0, 2000.0)])
def test_the_cam_lives_as_long_as_the_track_that_lives_least(first: float, second: float) -> None:
    data = data_of(operation__friction=first)
    data["track"][0]["operation"] = {"friction": second}
    found = built(data)
    lives = [one.lives["cam"] for one in found.bindings]
    assert (lives[1] < lives[0]) is (second > first)
    assert compute(found, ["contact"]).data["together"]["cam_life_h"] == min(lives)


def test_forces_of_its_own_stay_in_every_state() -> None:
    """Those of a state stand for those of [operation], which a follower with forces of its own does not have."""
    def force(newton: int) -> list[Data]:
        return [{"from": 30, "until": 140, "expression": str(newton)}]

    duty = [{"share": 0.5}, {"share": 0.5, "force": force(400)}]
    tracks = data_of(operation__force=force(200), duty=duty)
    tracks["track"][0]["operation"] = {"force": force(900)}
    drum = data_of(operation__force=force(200), duty=duty, track=None)
    for data in (tracks, drum | {"station": [{"angle": 180, "force": force(900)}]}):
        first, second = built(data).bindings
        assert first.states[1].duty.peak_force.value > first.states[0].duty.peak_force.value + 150.0
        assert second.states[1].duty.peak_force == second.states[0].duty.peak_force
    without = tracks | {"track": [tracks["track"][0] | {"operation": {"friction": 5}}]}
    easy, hard = built(without).bindings[1].states
    assert hard.duty.peak_force.value > easy.duty.peak_force.value + 150.0


def test_volumes_that_are_cut_add(both: Model) -> None:
    volumes = [model.mass[0].volume for model in (alone(0), alone(1), both)]
    drum = np.pi * (60.0**2 - 20.0**2) * 150.0
    # The chord error of all faces is a layer of its own.
    assert volumes[0] + volumes[1] - drum == pytest.approx(volumes[2], abs=0.5 * both.tolerance * both.solid.mesh.area)
    assert both.solid.sound
    assert both.solid.mesh.genus == 1


def test_what_is_left_between_grooves_is_a_wall() -> None:
    walls = [wall for wall in model_of().walls if "groove 1 to groove 2" in wall.name]
    assert [wall.thickness for wall in walls] == pytest.approx([13.8], abs=0.5)
    for start, level in ((walls[0], "pass"), (None, "fail")):
        keys = {} if start else {"limits": {"min_wall_mm": walls[0].thickness + 0.02}}
        (found,) = [f for f in findings(model_of(**keys), ["wall"]) if "groove 1 to" in f.where]
        assert found.level == level
    data = data_of()
    data["track"][0]["cam"]["start"] = 60
    with pytest.raises(DesignError, match="run into each other"):
        _ = built(data).solids


def test_a_land_is_judged_where_it_is_thinnest_down_to_the_floor() -> None:
    """Both motions are steep at one angle: the grooves lean by more near the axis, and the land is thinner there."""
    law = "cycloidal"
    steep = [{"until": 110, "to": 30, "law": law}, {"until": 250}, {"until": 360, "to": 0, "law": law}]
    keys = {"cam__diameter": 100, "cam__length": 120, "cam__start": 25, "cam__bore": 20, "motion": steep}
    track = [{"cam": {"start": 51, "groove_depth": 10}, "follower": {"mass": 0.8}, "motion": steep,
              "roller": {"diameter": 16, "length": 9}}]  # fmt: skip
    both_steep = model_of(**keys, track=track)
    lower, upper = (one.tracks[0] for one in both_steep.bindings)
    phi = np.linspace(0.0, 2.0 * np.pi, 4001)
    told = {wall.name: wall.thickness for wall in both_steep.walls}["groove 1 to groove 2"]

    def edge(track: Any, delta: float, top: bool) -> np.ndarray:
        each = [Flank(track, phi, np.array([delta]), side).x[:, :, 0] for side in (1.0, -1.0)]
        return max(each, key=lambda x: float(x[2].mean()) if top else -float(x[2].mean()))

    def apart(delta: float) -> float:
        flat = [np.stack([delta * np.arctan2(x[1], x[0]), x[2]], axis=1)
                for x in (edge(lower, delta, True), edge(upper, delta, False))]  # fmt: skip
        return float(cKDTree(flat[0]).query(flat[1])[0].min())

    outside, floor = apart(50.0), apart(40.0)
    assert floor < 0.8 * outside
    assert told == pytest.approx(floor, rel=0.03)

    # Straight from flank to flank, of points of both as close to each other on each as to add 1e-5 mm at most.
    (at,) = (wall.cam_angle for wall in both_steep.walls if wall.name == "groove 1 to groove 2")
    assert at is not None
    phi = at + np.linspace(-0.4, 0.4, 4001)
    flanks = [np.concatenate([edge(one, delta, top) for delta in (40.0, 40.05, 40.2)], axis=1)
              for one, top in ((lower, True), (upper, False))]  # fmt: skip
    assert told == pytest.approx(float(cKDTree(flanks[0].T).query(flanks[1].T)[0].min()), abs=2e-5)
    for share, level in ((0.99, "pass"), (1.01, "fail")):
        judged = model_of(**keys, track=track, limits={"min_wall_mm": share * told})
        (found,) = [f for f in findings(judged, ["wall"]) if "groove 1 to" in f.where]
        assert found.level == level


def test_walls_to_the_ends_are_those_at_the_ends_of_the_stroke() -> None:
    """Where the roller is only for a moment, at no whole degree."""
    motion = [{"until": 133.77, "to": 20, "law": "cycloidal"}, {"until": 360, "to": 0, "law": "cycloidal"}]
    data = data_of(motion=motion)
    del data["track"]
    cam, tool = data["cam"], 0.5 * data["roller"]["diameter"] + data["cam"].get("running_clearance", 0.0)
    told = {wall.name: wall.thickness for wall in built(data).walls}
    assert told["groove to upper end"] == pytest.approx(cam["length"] - cam["start"] - 20.0 - tool, abs=1e-9)
    assert told["groove to lower end"] == pytest.approx(cam["start"] - tool, abs=1e-9)


def test_passes_of_one_groove_are_nearest_at_its_floor() -> None:
    """Steep passes of a groove 1 mm deep are as far apart as on the outside; a deep one's floor has less arc."""

    def told(depth: float) -> float:
        keys = {"cam__groove_depth": depth, "roller__length": depth - 0.5}
        (wall,) = [wall for wall in model("pin_insertion", **keys).walls if "between passes" in wall.name]
        return wall.thickness

    shallow, deep = told(1.0), told(13.0)
    arc = shallow + 22.0
    assert shallow == pytest.approx(51.0, abs=0.5)
    # The middles of both passes keep their angle, and the roller its size: across steep passes, whose lean grows.
    assert 0.75 * (arc * 54.0 / 67.0 - 22.0) < deep < arc * 54.0 / 67.0 - 22.0


@pytest.mark.parametrize(("name", "wall"), [("pin_insertion", "between passes"), ("two_groove_drum", "groove 1 to")])
def test_what_walls_leave_out_of_their_search_is_not_the_thinnest(
    name: str, wall: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pairs of points that cannot face each other, and stretches of a land too far from a near point."""

    def told() -> list[tuple[str, float, float | None]]:
        walls = read(ROOT / "profiles" / f"{name}.toml").walls
        return [(one.name, one.thickness, one.cam_angle) for one in walls]

    quick, every = told(), np.arange(WALL_SAMPLES)
    assert any(wall in name for name, _, _ in quick)
    monkeypatch.setattr("camgeom.solid.drum._opposed", lambda normal: (every, every))
    monkeypatch.setattr("camgeom.solid.grooves.STRIDE", 1)
    assert told() == quick


def test_a_follower_without_a_rating_beside_one_that_has_is_told() -> None:
    rated = {"diameter": 20, "length": 9, "dynamic_rating": 8000.0, "static_rating": 9000.0}
    one = judged(model_of(roller=rated), ["bearing"])
    told = [word.reason for word in one.not_judged if "dynamic" in word.reason]
    assert [text.partition(":")[0] for text in told] == ["follower 2"]
    own = data_of()["track"]
    own[0]["roller"] |= {"dynamic_rating": 5000.0, "static_rating": 6000.0}
    assert not [w for w in judged(model_of(roller=rated, track=own), ["bearing"]).not_judged if "dynamic" in w.reason]
    assert not judged(model_of(), ["bearing"]).not_judged


def test_every_reader_has_both(both: Model) -> None:
    cloud = flank_points(both)
    assert set(cloud["track"].tolist()) == {0.0, 1.0}
    data = compute(both, ["flank", "contact", "motion"]).data
    (second,) = data["followers"]
    assert (second["track"], second["angle_deg"]) == (2, 90.0)
    assert second["flank"]["undercut_margin"] == alone(1).flanks[0].margin.value
    assert data["together"]["peak_torque_n_m"] > data["contact"]["peak_torque_n_m"]
    assert {path.track.program for path in both.machining.paths} == {one.setup.program for one in both.grooves}
    page = report(both, only=["flank", "contact"])
    assert [chapter.key for chapter in page.sections] == ["flank", "flank-2", "contact", "contact-2"]


def test_what_a_track_cannot_say_is_refused(tmp_path: Path) -> None:
    for change, word in (
        ({"cam": {"diameter": 90.0}}, r"track\[0\]\.cam\.diameter: is the body's"),
        ({"operation": {"speed": 90.0}}, r"track\[0\]\.operation\.speed: is the cam's"),
        ({"angle": 400.0}, r"track\[0\]\.angle: out of range"),
        ({"speed": 1.0}, r"track\[0\]\.speed: unknown key"),
        ({"roller": {"diameter": -1.0, "length": 5.0}}, r"track\[0\]\.roller\.diameter"),
        ({"motion": [{"until": 200.0, "to": 5.0, "law": "cycloidal"}]}, r"track\[0\]\.motion"),
    ):
        with pytest.raises(ProfileError, match=word):
            model_of(track=[{"cam": {"start": 85.0}, **change}])
    tool = {"kind": "flat", "diameter": 17.0, "length": 30.0}
    with pytest.raises(ProfileError, match=r"(?<!\.)cutter\.diameter: .*groove, of track\[0\] .*at most 16 mm"):
        model_of(cutter=tool, track=[{"cam": {"start": 85.0}, "roller": {"diameter": 16.0, "length": 9.0}}])
    with pytest.raises(ProfileError, match=r"track: means nothing here.*grooved drums and discs"):
        parse('[cam]\nkind = "end-face"\ndiameter = 100\ninner_diameter = 80\nheight = 30\nweb = 8\n[roller]\n'
              'diameter = 20\nlength = 9\n[[motion]]\nuntil = 360\n[[track]]\nangle = 3\n')  # fmt: skip
    with pytest.raises(ProfileError, match=r"cam\.form: .*groove, of several tracks"):
        model_of(cam__form="rib", cam__rib_thickness=10.0, track=[{"cam": {"start": 100.0}}])


def test_a_study_finds_a_track_s_own_keys() -> None:
    model = model_of()
    other = model.with_({"track[0].cam.start": 90.0})
    assert other.walls != model.walls
    assert from_data(frozen(tomllib.loads(other.toml())), "") == other.profile
    assert model.profile.digest() != other.profile.digest()


def test_key_figures_say_whose_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    """Text and head of the report; of one follower by the plain names."""
    from camgeom.cli import main
    from camgeom.report.sections.judgement import key_figures

    drum = str(ROOT / "profiles" / "two_groove_drum.toml")
    assert main(["solve", drum]) == 0
    told = capsys.readouterr().out
    assert "peak contact pressure, follower 1 " in told
    assert "peak velocity, follower 2 " in told
    figures = key_figures(Model(parse(Path(drum).read_text())), ("motion", "contact"))
    shown = {figure.label: figure.value for figure in figures}
    assert (shown["Stroke, follower 1"], shown["Stroke, follower 2"]) == (46.0, 18.0)
    assert shown["Peak contact pressure, follower 2"] < shown["Peak contact pressure, follower 1"]
    pin = Model(parse((ROOT / "profiles" / "pin_insertion.toml").read_text()))
    assert [figure.label for figure in key_figures(pin, ("motion",))] == ["Stroke", "Peak acceleration"]
