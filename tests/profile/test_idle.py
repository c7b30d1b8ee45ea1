"""Keys that mean nothing for a cam, its follower, roller, tool or solver are refused by name, all at once."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import pytest

from camgeom.cams import kinds, starter
from camgeom.checks import judge
from camgeom.dynamics.impact.spec import ImpactSpec
from camgeom.dynamics.spec import DynamicsSpec
from camgeom.errors import DesignError, ProfileError
from camgeom.model import Model
from camgeom.profile import Profile, from_data, parse, read
from camgeom.profile.errors import keys_of
from camgeom.profile.own_track import TWO_UNITS
from camgeom.profile.sections import Limits, Operation
from camgeom.profile.text import load
from camgeom.tolerance.spec import ToleranceSpec
from tests.places import PROFILES
from tests.profile.cases import CASES, frozen, made, put
from tests.reference.profiles import built


def refusals(case: str, changes: dict[str, Any]) -> dict[str, str]:
    """What is refused of a changed case: the text of every problem by key."""
    data = made(case)
    for key, value in changes.items():
        put(data, key, value)
    try:
        from_data(frozen(data), "part.toml")
    except ProfileError as error:
        return {problem.key: str(problem) for problem in error.problems if str(error).startswith("part.toml: ")}
    return {}


@pytest.mark.parametrize(
    ("case", "key", "value", "word"),
    [
        ("drum, groove", "follower.offset", 5.0, "a drum's translating follower has none"),
        ("drum, groove", "follower.face", "flat", "carries a roller"),
        ("drum, groove", "follower.face_width", 20.0, "carries a roller"),
        ("drum, groove", "follower.clearance", 0.02, "cam.running_clearance"),
        ("drum, groove", "cam.rib_thickness", 12.0, "form = 'rib'"),
        ("drum, groove", "impact.clearance", 0.02, ""),
        ("drum, rib", "impact.clearance", 0.02, "both ways"),
        ("drum, arm", "follower.side", "right", "to neither side"),
        ("drum, arm", "follower.mass", 2.0, "unknown key"),
        ("disc, roller", "cam.groove_depth", 5.0, "form = 'groove'"),
        ("disc, roller", "cam.diameter", 120.0, "form = 'groove'"),
        ("disc, roller", "cam.running_clearance", 0.01, "form = 'groove'"),
        ("disc, groove", "cam.running_clearance", 0.01, ""),
        ("disc, roller", "cam.center_distance", 120.0, "swinging follower"),
        ("disc, roller", "follower.face_radius", 50.0, "face = 'curved'"),
        ("disc, curved face", "follower.face_radius", 50.0, ""),
        ("disc, roller", "follower.face_width", 50.0, "face = 'flat'"),
        ("disc, flat face", "follower.face_width", 50.0, ""),
        ("disc, roller", "follower.clearance", 0.02, "discs of a pair"),
        ("pair, slide", "follower.clearance", 0.02, ""),
        ("disc, roller", "impact.clearance", 0.02, "both ways"),
        ("disc, flat face", "roller", {"diameter": 20.0, "length": 10.0}, "flat face touches"),
        ("disc, flat face", "limits.undercut_margin", 0.1, "face-curvature"),
        ("disc, flat face", "limits.warn_pressure_angle_deg", 20.0, "always 0"),
        ("frame", "limits.warn_pressure_angle_deg", 20.0, "always 0"),
        ("disc, roller", "limits.warn_pressure_angle_deg", 20.0, ""),
        ("disc, roller", "limits.warn_pressure_angle_deg", 30.0, ""),
        ("disc, roller", "limits.warn_pressure_angle_deg", 31.0, "the limit fails before it warns"),
        ("disc, flat face", "operation.guide_friction", 0.3, "no side thrust"),
        ("frame", "operation.guide_friction", 0.3, "no side thrust"),
        ("disc, roller", "operation.guide_friction", 0.3, ""),
        ("disc, flat face", "limits.clearance_mm", 0.1, "may not touch"),
        ("frame", "limits.clearance_mm", 0.1, "may not touch"),
        ("pair, slide", "limits.clearance_mm", 0.1, ""),
        ("disc, flat face", "limits.life_h", 1e9, ""),
        ("disc, roller", "limits.life_h", 1e9, ""),
        ("disc, roller", "limits.min_wall_mm", 3.0, ""),
        ("disc, knife", "limits.contact_pressure_mpa", 500.0, "knife edge"),
        ("disc, arm with roller", "follower.start_angle", 4.0, "a drum's follower"),
        ("disc, arm with roller", "follower.pivot_distance", 90.0, "a drum's follower"),
        ("drum, arm", "follower.start_angle", -19.0, ""),
        ("pair, slide", "cam.rocker_angle", 90.0, "rocker"),
        ("pair, rocker", "cam.return_radius", 60.0, "slide"),
        ("pair, rocker", "output.undercut_solid", True, "only a drum's groove"),
        ("pair, rocker", "output.fewest_triangles", True, "only drums"),
        ("pair, rocker", "output.fewest_triangles", False, ""),
        ("drum, arm", "output.fewest_triangles", True, ""),
        ("globoid", "output.fewest_triangles", True, ""),
        ("yoke", "follower.face_width", 80.0, "rollers touch"),
        ("frame", "follower.face_width", 95.0, ""),
        ("globoid", "cam.relief_angle", 4.0, "relief"),
        ("barrel", "operation.load_mass", 4.0, "a rotating one takes load_inertia"),
        ("disc, roller", "operation.load_inertia", 4.0, "a translating one takes load_mass"),
        ("disc, roller", "roller.static_rating", 9000.0, "dynamic_rating"),
        ("globoid", "dynamics", {"kind": "follower", "linkage_stiffness": 9.0}, "kind = 'indexing'"),
        ("disc, elastic", "dynamics.sweep_points", 50, "no sweep"),
        ("disc, elastic", "dynamics.tappet_damping", 5.0, "rigid"),
        ("disc, elastic", "dynamics.wilson_theta", 1.5, "method = 'wilson'"),
        ("pair, impact", "impact.damping_depth", 0.2, "`damping`"),
        ("pair, impact", "impact.exponent", 1.5, "law = 'power'"),
        ("drum, impact", "impact", {"clearance": 0.05, "stick_speed": 0.0005}, "static_friction"),
        ("drum, mill", "cutter.scallop", 0.1, "ball"),
        ("drum, ball", "cutter.scallop", 0.1, ""),
        ("drum, mill", "cutter.contact", "side", "wheel"),
        ("drum, mill", "cutter.overrun", 1.0, "disc"),
        ("disc, mill", "cutter.overrun", 1.0, ""),
    ],
)
def test_a_key_that_means_nothing_is_refused_by_name(case: str, key: str, value: object, word: str) -> None:
    """An empty word: the same key where it means something passes."""
    found = refusals(case, {key: value})
    if not word:
        assert found == {}
        return
    (name,) = (refused for refused in found if key.startswith(refused) or refused.startswith(key))
    assert word in found[name]


def test_all_at_once_with_key_and_value() -> None:
    found = refusals("drum, groove", {"follower.offset": 5.0, "cam.rib_thickness": 9.0, "operation.load_inertia": 2.0})
    assert list(found) == ["cam.rib_thickness", "follower.offset", "operation.load_inertia"]
    assert "found 5.0" in found["follower.offset"]


def test_a_key_at_its_default_says_nothing_wrong() -> None:
    assert refusals("drum, groove", {"follower.offset": 0.0, "follower.face": "roller"}) == {}
    assert refusals("disc, roller", {"cam.running_clearance": 0.0, "output.undercut_solid": False}) == {}


@pytest.mark.parametrize("case", ["disc, roller", "frame", "pair, slide"])
def test_a_disc_without_a_hole_still_has_its_thickness_to_limit(case: str) -> None:
    whole = {"cam.bore": None, "cam.keyway_width": None, "cam.keyway_depth": None}
    whole |= {"cam.mark_diameter": None, "cam.mark_radius": None}
    assert refusals(case, {**whole, "limits.min_wall_mm": 3.0}) == {}


@pytest.mark.parametrize("bore", [0.0, 20.0])
def test_a_keyway_needs_a_bore(bore: float) -> None:
    found = refusals("disc, roller", {"cam.bore": bore})
    assert (set(found) == {"cam.keyway_width", "cam.keyway_depth"}) is (bore == 0.0)


def test_two_ways_to_choose_the_points_of_a_table() -> None:
    found = refusals("disc, roller", {"output.table_points": 100, "output.table_tolerance": 0.01})
    assert set(found) == {"output.table_points"}
    assert refusals("disc, roller", {"output.table_points": 100}) == {}


ROWS = [[0, 0], [10, 0.5], [20, 2], [30, 4], [40, 6], [50, 8], [60, 9.5], [70, 10]]


def test_a_table_needs_its_data() -> None:
    data = made("disc, roller")
    data["motion"][0]["law"] = "table"
    with pytest.raises(ProfileError, match=r"motion\[0\]\.file: is missing: law = 'table' is made of data"):
        from_data(frozen(data), "")
    data["motion"][0] |= {"rows": ROWS, "to": 10.0}
    assert from_data(frozen(data), "").motion[0].law == "table"


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('law = "cycloidal"', 'law = "cycloidal"\nshare = 0.4', "motion[0].share: unknown key"),
        ('law = "cycloidal"', 'law = "cycloidal"\nvelocity = 0.4', "motion[0].velocity: only where two joining laws"),
        ('law = "cycloidal"', 'law = "spline"\nshare = 0.4', "motion[0].share: unknown key"),
    ],
)
def test_parameters_that_a_law_does_not_use(old: str, new: str, word: str) -> None:
    text = CASES["disc, roller"][0]
    with pytest.raises(ProfileError) as caught:
        parse(text.replace(old, new, 1))
    assert word in str(caught.value)


@pytest.mark.parametrize("file", sorted(PROFILES.glob("*.toml")), ids=lambda file: file.stem)
def test_shipped_profiles_give_no_idle_key(file: Any) -> None:
    assert read(file)


@pytest.mark.parametrize("kind", kinds())
def test_starters_give_no_idle_key(kind: str) -> None:
    assert parse(starter(kind))
    assert tomllib.loads(starter(kind))["cam"]["kind"] == kind


@pytest.mark.parametrize(("limit", "warn", "told"), [(0.1, 0.05, True), (0.1, 0.1, False), (0.1, 0.0, False)])
def test_a_warning_below_the_undercut_limit_is_refused(limit: float, warn: float, told: bool) -> None:
    found = refusals("disc, roller", {"limits.undercut_margin": limit, "limits.warn_undercut_margin": warn})
    assert ("limits.warn_undercut_margin" in found) == told


TABLE = [[0, 0], [90, 3000], [360, 0]]


@pytest.mark.parametrize(
    ("force", "word"),
    [
        ({"table": TABLE}, ""),
        ({"table": TABLE, "interpolation": "smooth"}, ""),
        ({"table": TABLE, "from": 40.0}, "from its first to its last row"),
        ({"table": TABLE, "until": 60.0}, "from its first to its last row"),
        ({"expression": "100", "from": 40.0, "until": 60.0}, ""),
        ({"expression": "100", "interpolation": "smooth"}, "an expression has no rows"),
    ],
)
def test_a_force_is_a_table_or_an_expression_with_its_own_keys(force: dict[str, Any], word: str) -> None:
    found = refusals("disc, roller", {"operation.force": [force]})
    assert (word in " ".join(found.values())) if word else not found


def test_a_rate_is_told_as_it_is_written() -> None:
    text = (PROFILES / "disc_flat_face.toml").read_text().replace('law = "', 'velocity = 0.3\nlaw = "', 1)
    with pytest.raises(ProfileError, match=r"motion\[0\].velocity: .*\(found 0.3\)"):
        parse(text)


def test_the_face_of_an_arm_ends_with_the_arm() -> None:
    levels = {}
    for arm in (40.0, 900.0):
        data = made("disc, arm with flat face")
        put(data, "follower.arm", arm)
        data["follower"].pop("face_width", None)
        found = judge(built(data), ["face-width"]).findings
        levels[arm] = [(finding.level, finding.value) for finding in found]
    assert levels == {40.0: [("fail", 40.0)], 900.0: [("pass", 900.0)]}


@pytest.mark.parametrize(("name", "cutter", "reason"), [
    ("milled_drum", 'kind = "roller"', "fills its groove"),
    ("milled_drum", 'kind = "flat"\ndiameter = 20.0', "fills its groove"),
    ("milled_drum", 'kind = "flat"\ndiameter = 19.0\nallowance = 0.5', "fills its groove"),
    ("milled_drum", 'kind = "flat"\ndiameter = 19.9', ""),
    ("disc_face_groove", 'kind = "roller"', "fills its groove"),
    ("linear_groove", 'kind = "roller"', "fills its groove"),
    ("both_faces_disc", 'kind = "roller"', "fills its groove"),
    ("disc_offset_roller", 'kind = "roller"', ""),
    ("end_face_lifter", 'kind = "wheel"\ncontact = "side"\nwidth = 3.0\ndiameter = 200.0', "either way alike"),
    ("end_face_lifter", 'kind = "ball"\ndiameter = 6.0', ""),
])  # fmt: skip
def test_which_way_a_tool_mills_is_refused_where_it_goes_but_one(name: str, cutter: str, reason: str) -> None:
    """A tool that fills its groove climbs along one wall whichever way it goes; the key changed no block."""
    text = re.sub(r"(?ms)^\[cutter\].*?(?=^\[|\Z)", "", (PROFILES / f"{name}.toml").read_text())
    text = text.replace('"cutter.csv", ', "").replace('"gcode", ', "").replace('"apt", ', "")
    parse(f'{text}\n[cutter]\n{cutter}\nmilling = "climb"\n')
    asked = f'{text}\n[cutter]\n{cutter}\nmilling = "conventional"\n'
    if reason:
        with pytest.raises(ProfileError, match=f"cutter.milling: means nothing here.*{reason}"):
            parse(asked)
    else:
        parse(asked)


@pytest.mark.parametrize(
    ("kind", "tables", "told"),
    [
        ("constant_width_press", "\n[[track]]\n", "track: means nothing here"),
        ("pin_insertion", "\n[track]\n", r"track: needs an array of tables \[\[track\]\]"),
        ("pin_insertion", "\n[[track]]\n" * 40, "track: too many tracks"),
        ("feeder_runout", "\n[[track]]\n", "cam.run_out: cannot be built"),
        ("rib", "\n[[track]]\ncam.start = 75\n", "cam.form: cannot be built"),
    ],
)
def test_a_refusal_of_tracks_names_its_file(kind: str, tables: str, told: str) -> None:
    rib = (PROFILES / "pin_insertion.toml").read_text().replace('form = "groove"', 'form = "rib"\nrib_thickness = 9')
    text = (rib if kind == "rib" else (PROFILES / f"{kind}.toml").read_text()) + tables
    with pytest.raises(ProfileError, match=f"^my.toml: {told}"):
        parse(text, "my.toml")


def test_of_flanks_that_cannot_be_made_the_way_round_is_not_asked() -> None:
    """Plates whose motion jumps have no walls: their profile is read, and whoever asks for the walls is told."""
    text = (PROFILES / "parallel_index.toml").read_text(encoding="utf-8")
    cutter = '[cutter]\nkind = "flat"\ndiameter = 6\nmilling = "conventional"\n'
    assert parse(text + cutter).cutter_spec is not None
    jumping = parse(text.replace("modified-sine", "constant-velocity") + cutter)
    with pytest.raises(DesignError, match="velocity jumps"):
        _ = Model(jumping).solids


@pytest.mark.parametrize(("gap", "told"), [(1000.0, False), (1001.0, True)])
def test_a_roller_has_no_more_than_a_metre_of_room_in_its_groove(gap: float, told: bool) -> None:
    """100 m of it took the body of an undercut drum three minutes."""
    found = refusals("drum, groove", {"cam.running_clearance": gap})
    assert ("cam.running_clearance" in found) is told


@pytest.mark.parametrize("file", sorted(PROFILES.glob("*.toml")), ids=lambda file: file.stem)
def test_a_taper_lies_on_the_flank_of_a_cone_of_its_angle_alone(file: Any) -> None:
    data, _, _ = load(file.read_text(encoding="utf-8"), file.stem)
    cutter = {"kind": "flat", "diameter": 2.0, "half_angle": 7.3}
    with pytest.raises(ProfileError, match=r"cutter\.half_angle|cutter: |cutter\.kind"):
        from_data({**data, "cutter": cutter}, "")


def _drum_of_a_slide_and_an_arm(**tables: Any) -> Profile:
    """Two grooves of a drum, one with a slide, one with an arm, and tables more; `own` is the second's [operation]."""
    data, _, _ = load((PROFILES / "two_groove_drum.toml").read_text(encoding="utf-8"), "two_groove_drum")
    keep = {key: data[key] for key in ("name", "cam", "follower", "roller", "motion")}
    (track,) = data["track"]
    arm = {"angle": track["angle"], "cam": track["cam"],
           "follower": {"kind": "swinging", "arm": 100.0, "inertia": 0.01},
           "motion": ({"until": 150.0, "to": 10.0, "law": "cycloidal"}, {"until": 320.0, "to": 0.0, "law": "cycloidal"},
                      {"until": 360.0}), "operation": tables.pop("own", {})}  # fmt: skip
    return from_data(keep | {"operation": {"speed": 60.0}, "track": (arm,)} | tables, "")


def test_a_lift_in_another_unit_is_not_taken_over() -> None:
    data, _, _ = load((PROFILES / "both_faces_disc.toml").read_text(encoding="utf-8"), "both_faces_disc")
    (track,) = data["track"]
    bare = {key: value for key, value in track.items() if key != "motion"}
    with pytest.raises(ProfileError, match=r"track\[0\]\.motion: is missing.*turns.*slides"):
        from_data({**data, "track": (bare,)}, "")


@pytest.mark.parametrize("key", ["friction", "spring_rate", "spring_preload", "force"])
def test_a_load_in_another_unit_is_not_taken_over(key: str) -> None:
    value: Any = ({"expression": "20"},) if key == "force" else 20.0
    load_of_slide = {"speed": 60.0, key: value}
    with pytest.raises(ProfileError, match=rf"track\[0\]\.operation\.{key}: is missing.*slides.*turns"):
        _drum_of_a_slide_and_an_arm(operation=load_of_slide)
    own = _drum_of_a_slide_and_an_arm(operation=load_of_slide, own={key: () if key == "force" else 0.0}).tracks[0].whole
    assert own.operation is not None
    assert not getattr(own.operation, key)
    _drum_of_a_slide_and_an_arm(operation={"speed": 60.0} | ({} if key == "force" else {key: 0.0}))


@pytest.mark.parametrize(
    ("table", "keys", "word"),
    [
        ("limits", {"velocity": 700.0}, r"limits\.velocity: has two units"),
        ("limits", {"torque_n_m": 700.0}, ""),
        ("dynamics", {"kind": "follower", "linkage_stiffness": 9000.0}, r"dynamics\.linkage_stiffness: has two units"),
        ("impact", {"clearance": 0.02, "inertia": 2.4}, r"impact\.inertia: "),
        ("tolerance", {"phase_arcmin": 1.0, "dwell_limit": 20.0}, r"tolerance\.dwell_limit: has two units"),
        ("tolerance", {"phase_arcmin": 1.0, "pressure_limit": 2000.0}, ""),
        ("duty", ({"hours": 1.0, "force": ({"expression": "9"},)},), r"track\[0\]\.operation\.force: is missing"),
    ],
)
def test_a_number_with_two_units_is_not_that_of_a_slide_and_an_arm(table: str, keys: Any, word: str) -> None:
    if not word:
        _drum_of_a_slide_and_an_arm(**{table: keys})
        return
    with pytest.raises(ProfileError, match=word):
        _drum_of_a_slide_and_an_arm(**{table: keys})


def test_which_keys_have_two_units() -> None:
    """They are told by their meanings: one whose text is written anew is still found, or this says so."""
    found = {name: {key for key, field in keys_of(model).items() if TWO_UNITS.match(field.description or "")}
             for name, model in (("operation", Operation), ("limits", Limits), ("dynamics", DynamicsSpec),
                                 ("tolerance", ToleranceSpec), ("impact", ImpactSpec))}  # fmt: skip
    assert found == {
        "operation": {"friction", "spring_rate", "spring_preload"},
        "limits": {"velocity", "least_velocity"},
        "dynamics": {"settling_band", "mass", "linkage_stiffness", "linkage_damping", "return_stiffness",
                     "return_damping", "preload", "tappet_mass", "tappet_stiffness", "tappet_damping"},
        "tolerance": {"dwell_limit", "motion_limit", "backlash_limit"},
        "impact": {"inertia"},
    }  # fmt: skip
