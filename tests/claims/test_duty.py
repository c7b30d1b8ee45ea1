"""Operating states: damage adds by Miner's rule, peaks are judged in the hardest, every key acts or is refused."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import camgeom
from camgeom.checks import judge
from camgeom.errors import NotConverged, ProfileError
from camgeom.mechanics.life import summed_life
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute
from camgeom.report.sections.film import lasting
from tests.places import PROFILES

PIN = (PROFILES / "pin_insertion.toml").read_text()


def pin(duty: str = "", **changed: str) -> Model:
    """The pin cam with operating states; changed: texts of the profile by what they replace."""
    text = PIN
    for old, new in changed.items():
        assert old in text, old
        text = text.replace(old, new, 1)
    return Model(parse(f"{text}\n{duty}"))


TWO = """
[[duty]]
name = "normal"
share = 0.75

[[duty]]
name = "fast"
speed = 750
load_factor = 1.5
share = 0.25
"""


def refused(duty: str, text: str = PIN) -> str:
    with pytest.raises(ProfileError) as caught:
        parse(f"{text}\n{duty}")
    return str(caught.value)


def test_two_states_by_hand():
    whole = pin(TWO)
    slow, fast = pin(), Model(parse(PIN.replace("speed = 600", "speed = 750").replace("79.55 *", "119.325 *")))
    for body in ("roller", "cam"):
        by_hand = 1.0 / (0.75 / slow.lives[body] + 0.25 / fast.lives[body])
        assert whole.lives[body] == pytest.approx(by_hand, rel=1e-9)
    assert slow.lives["roller"] == pytest.approx(23064.0594, rel=1e-6)
    data = compute(whole, ("contact", "fatigue")).data
    assert data["contact"]["state"] == "fast"
    assert data["contact"]["peak_slice_pressure_mpa"] == pytest.approx(fast.duty.peak_pressure.value, rel=1e-9)
    assert data["fatigue"]["roller_slice_life_h"] == pytest.approx(whole.lives["roller"])
    shares = [state["roller_damage_share"] for state in data["fatigue"]["states"]]
    assert sum(shares) == pytest.approx(1.0)
    assert shares[1] == pytest.approx(0.25 * whole.lives["roller"] / fast.lives["roller"])


def test_life_is_judged_on_the_sum_and_pressure_on_the_hardest_state():
    life, peak = pin(TWO).lives["roller"], pin(TWO).hardest_state.duty.peak_pressure.value
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        said = judge(pin(TWO, **{"life_h = 10000": f"life_h = {share * life!r}"}), ["life"]).findings
        assert [one.level for one in said if one.where == "roller"] == [level]
        said = judge(pin(TWO, **{"life_h = 10000": f"contact_pressure_mpa = {peak / share!r}"}),
                     ["contact-pressure"]).findings  # fmt: skip
        assert [one.level for one in said] == [level]
        assert "state 'fast'" in said[0].where


def test_hours_are_shares_and_starts_come_on_top():
    hours = TWO.replace("share = 0.75", "hours = 6000").replace("share = 0.25", "hours = 2000")
    assert pin(hours).lives == pytest.approx(pin(TWO).lives)
    more = '[[duty]]\nname = "start"\nspeed = 750\nload_factor = 1.5\nstarts = 90\nturns = 25\n'
    fast = pin(TWO).states[1].lives["roller"]
    # 90 starts of 25 turns at 750 r/min are three minutes in an hour.
    expected = 1.0 / (1.0 / pin(TWO).lives["roller"] + 0.05 / fast)
    assert pin(TWO + more).lives["roller"] == pytest.approx(expected, rel=1e-9)
    assert pin(TWO + more.replace("turns = 25\n", "")).lives["roller"] > expected


def test_a_history_is_counted_into_states(tmp_path: Path):
    # Maxima of the cycles: 2 (five whole cycles of 1 to 2, and half a one), 1.
    values = [0.0, *([2.0, 1.0] * 5), 2.0, 0.0]
    one = pin(f"[[duty]]\nshare = 1\nhistory = {values}\n")
    factors = [state.state.load_factor for state in one.states if state.state]
    assert factors == pytest.approx([2.0])
    assert one.lives["roller"] == pytest.approx(pin("[[duty]]\nshare = 1\nload_factor = 2\n").lives["roller"])
    (tmp_path / "loads.csv").write_text("factor\n" + "\n".join(map(str, [1.0, 3.0, 1.0, 1.5, 1.0, 3.0])))
    (tmp_path / "pin.toml").write_text(PIN + '\n[[duty]]\nshare = 1\nhistory_file = "loads.csv"\n')
    two = camgeom.read(str(tmp_path / "pin.toml"))
    found = {round(s.state.load_factor, 9): s.state.weight for s in two.states if s.state}
    # 1-3, 3-1 and 1-3 half each, 1-1.5 whole.
    assert found == pytest.approx({3.0: 0.6, 1.5: 0.4})
    single = [Model(s.state.profile, state=s.state, body=s.body).lives["roller"] for s in two.states if s.state]
    expected = 1.0 / sum(weight / life for weight, life in zip(found.values(), single, strict=True))
    assert two.lives["roller"] == pytest.approx(expected)


def test_a_state_has_its_own_forces():
    own = '[[duty]]\nshare = 1\n[[duty.force]]\nexpression = "400"\nfrom = 250\nuntil = 280\n'
    other = PIN.replace("from = 255.30999351    # deg, 4.456 rad", "from = 250")
    start = other.index('expression = "79')
    end = other.index("\n", start)
    same = Model(parse(other[:start] + 'expression = "400"' + other[end:]))
    bare = PIN[: PIN.index("[[operation.force]]")] + PIN[PIN.index("[material.cam]") :]
    assert Model(parse(f"{bare}\n{own}")).lives == pytest.approx(same.lives)


def test_without_duty_nothing_changes():
    model = pin()
    assert model.states == (model,)
    assert model.hardest_state is model
    assert model.lives == model.duty.lives
    assert "state" not in compute(model, ("contact",)).data["contact"]
    once = pin("[[duty]]\nshare = 1\n")
    assert once.lives == pytest.approx(model.lives)
    assert [f.value for f in judge(once).findings] == [f.value for f in judge(model).findings]


def test_states_survive_pickling():
    model = pin(TWO)
    life = model.lives["roller"]
    again = pickle.loads(pickle.dumps(model))
    assert again.bindings == (again,)
    assert again.lives["roller"] == life
    assert again.states[1].state.name == "fast"


@pytest.mark.parametrize(
    ("duty", "words"),
    [
        ("[[duty]]\nshare = 0.5\n[[duty]]\nshare = 0.4", "add up to 1"),
        ("[[duty]]\nshare = 0.5\n[[duty]]\nhours = 40", "mixes share and hours"),
        ("[[duty]]\nstarts = 3", "starts alone"),
        ("[[duty]]\nspeed = 40", "needs one of share"),
        ("[[duty]]\nshare = 1\nturns = 4", "`turns`"),
        ("[[duty]]\nshare = 1\nhistory = [1, 1]", "never changes"),
        ("[[duty]]\nshare = 1\nhistory = [1, 2]\nload_factor = 2", "`load_factor` beside"),
        ('[[duty]]\nshare = 1\nhistory_file = "loads.csv"', "read from a file"),
        ("[[duty]]\nshare = 1\nspeeed = 3", "did you mean 'speed'"),
        ("[duty]\nshare = 1", "double brackets"),
        ('[[duty]]\nshare = 1\n[[duty.force]]\nexpression = "1/0"', "duty[0].force[0].expression"),
    ],
)
def test_what_a_duty_cannot_mean_is_refused(duty: str, words: str):
    assert words in refused(duty)


def test_a_factor_of_no_force_and_a_duty_without_operation_are_refused():
    start, end = PIN.index("[[operation.force]]"), PIN.index("[material.cam]")
    bare = PIN[:start] + PIN[end:]
    assert "duty[0].load_factor" in refused("[[duty]]\nshare = 1\nload_factor = 2", bare)
    start = PIN.index("[operation]")
    assert "give [operation]" in refused("[[duty]]\nshare = 1", PIN[:start] + PIN[end:])


def test_what_every_state_states_anew_is_asked_of_nothing_else():
    """Forces, speeds and temperatures of [operation] and [lubricant] changed no figure beside those of every state."""
    force = '[[duty.force]]\nexpression = "20"\n'
    assert "operation.force: means nothing here" in refused(f"[[duty]]\nshare = 1\n{force}")
    pin(f"[[duty]]\nshare = 0.5\n{force}[[duty]]\nshare = 0.5\n")
    one, two = "[[duty]]\nshare = 0.5\nspeed = 500\n", "[[duty]]\nshare = 0.5\n"
    with pytest.raises(ProfileError, match=r"every state of \[\[duty\]\] has a speed of its own"):
        camgeom.study(pin(one + one), {"operation.speed": [300.0, 600.0]})
    assert len(camgeom.study(pin(one + two), {"operation.speed": [300.0, 600.0]}, only=["motion"])["verdict"]) == 2


@pytest.mark.parametrize("key", ["speed", "temperature"])
def test_what_no_state_runs_at_is_refused(key: str):
    """A speed of [operation] beside states that all have their own: any number passed and changed nothing."""
    oil = "[lubricant]\nviscosity_40 = 100\nviscosity_100 = 11\ntemperature = 60\n"
    said = {"speed": ("operation.speed", 600), "temperature": ("lubricant.temperature", 60)}[key]
    one, other = (f"[[duty]]\nshare = 0.5\n{key} = {value}\n" for value in (said[1] - 10, said[1] + 10))
    same = f"[[duty]]\nshare = 0.5\n{key} = {said[1]}\n"
    assert f"{said[0]}: is that of no state (found {said[1]:g}" in refused(oil + one + other)
    for second in (same, "[[duty]]\nshare = 0.5\n"):
        pin(oil + one + second)


def test_a_state_without_life_ends_all():
    assert summed_life([(0.5, 100.0), (0.5, 0.0)]) == 0.0
    assert summed_life([(0.5, float("inf")), (0.5, 100.0)]) == pytest.approx(200.0)
    assert summed_life([(1.0, float("inf"))]) == float("inf")


def test_the_page_shows_damage_by_state_and_life_by_part_and_cause():
    from camgeom.drawing.content import Chart, Table
    from camgeom.report.sections import report

    oil = (
        "[lubricant]\nviscosity_40 = 100\nviscosity_100 = 11\ntemperature = 60\npressure_viscosity = 20\n"
    )
    text = PIN.replace("[material.cam]", "[material.cam]\nroughness_um = 0.2\nwear_rate = 1e-8")
    text = text.replace("[material.roller]", "[material.roller]\nroughness_um = 0.2")
    page = report(Model(parse(f"{text}\n{oil}{TWO}")), ["fatigue", "contact"])
    blocks = [block for chapter in page.sections for block in chapter.blocks]
    tables = {block.caption: block for block in blocks if isinstance(block, Table)}
    shares = tables["Operating states, and their shares of the damage of each body"]
    assert [row[0] for row in shares.rows] == ["normal", "fast"]
    assert sum(float(row[4]) for row in shares.rows) == pytest.approx(100.0)
    causes = {(row[0], row[1]) for row in tables["Life by part and cause"].rows}
    assert causes == {("Roller", "contact fatigue"), ("Cam", "contact fatigue"), ("Cam", "sliding wear")}
    assert any(isinstance(block, Chart) and "Oil film" in block.caption for block in blocks)


def test_vibration_is_solved_in_every_state():
    text = (PROFILES / "tool_changer.toml").read_text()
    speeds = [s for s in text.splitlines() if s.startswith("speed")]
    assert speeds
    made = Model(parse(text + "\n[[duty]]\nshare = 0.8\n[[duty]]\nname = 'fast'\nspeed = 350\nshare = 0.2\n"))
    alone = Model(parse(text.replace(speeds[0], "speed = 350", 1)))
    slow = Model(parse(text))
    (found,) = judge(made, ["dynamic-pressure"]).findings
    assert found.value == pytest.approx(alone.dynamic_duty.peak_pressure.value, rel=1e-9)
    assert "state 'fast'" in found.where
    for body, life in made.dynamic_lives.items():
        assert life == pytest.approx(1.0 / (0.8 / slow.dynamic_lives[body] + 0.2 / alone.dynamic_lives[body]))


def test_head_colours_and_history_are_of_the_hardest_state_and_lives_of_all():
    from camgeom.export.history import turn_history
    from camgeom.report.sections.judgement import key_figures
    from camgeom.report.sections.mechanism import fields

    whole = pin(TWO)
    fast, slow = whole.hardest_state, pin()
    figures = {one.label: one.value for one in key_figures(whole, ("contact", "fatigue"))}
    assert figures["Peak contact force"] == pytest.approx(fast.duty.peak_force.value)
    assert figures["Peak contact force"] > 1.2 * slow.duty.peak_force.value
    assert figures["Roller life"] == pytest.approx(whole.lives["roller"])
    rows, calm = turn_history(whole), turn_history(slow)
    force = next(name for name in rows if name.endswith("_force_n") and not name.startswith(("follower", "inertia")))
    assert calm[force].max() < rows[force].max() == pytest.approx(fast.duty.peak_force.value, rel=1e-3)
    assert rows["time_s"][-1] == pytest.approx(60.0 / 750.0)
    mesh = whole.solid.mesh
    ratio = np.nanmax(fields(whole, mesh)["pressure"]) / np.nanmax(fields(slow, mesh)["pressure"])
    assert ratio == pytest.approx(fast.duty.peak_pressure.value / slow.duty.peak_pressure.value, rel=0.02)
    said = judge(whole, ["load"]).findings
    assert [(one.value, one.where) for one in said] == [
        (pytest.approx(fast.duty.peak_force.value), "state 'fast': largest contact force")
    ]


@pytest.mark.parametrize("name", ["feeder_runout", "pin_insertion", "conjugate_rocker", "parallel_index",
                                  "linear_groove", "disc_flat_face", "globoidal_drive", "both_faces_disc"])  # fmt: skip
def test_the_picture_has_the_hardest_place_at_the_figure_of_the_check(name: str) -> None:
    """Where a groove runs out the hardest place is narrower than any mesh: 666 MPa in the check, 485 painted."""
    from camgeom.report.sections.bodies import cam_meshes
    from camgeom.report.sections.mechanism import fields

    model = Model(parse((PROFILES / f"{name}.toml").read_text()))
    painted = [np.nanmax(fields(model, mesh)["pressure"]) for _, mesh in cam_meshes(model)]
    checked = max(one.carrier.peak_pressure.value for one in model.bindings)
    assert max(painted) == pytest.approx(checked, rel=1e-9)


@pytest.mark.parametrize(("mass", "harder"), [(0.9, 0), (30.0, 1)])
def test_the_picture_shows_the_hardest_of_several_followers(mass: float, harder: int) -> None:
    from camgeom.report.sections.bodies import cam_meshes
    from camgeom.report.sections.mechanism import fields

    text = (PROFILES / "disc_offset_roller.toml").read_text()
    model = Model(parse(text + f"\n[[station]]\nangle = 120.0\nmass = {mass}\nspring_preload = 80.0\n"))
    each = [one.duty.peak_pressure.value for one in model.bindings]
    assert np.argmax(each) == harder
    ((_, mesh),) = cam_meshes(model)
    field = fields(model, mesh)["pressure"]
    assert np.nanmax(field) == pytest.approx(max(each), rel=1e-9)
    assert np.sum(field > 0.98 * max(each)) > 1


def test_a_drive_that_cannot_be_solved_takes_no_rigid_life_along():
    """At 0.3 r/min an exact contact asks for 54 s and 3 GB: refused with the figures, and the other lives are told."""
    text = (PROFILES / "tool_changer.toml").read_text().partition("[tolerance]")[0]
    drive = 'kind = "indexing"\ninput_stiffness = 2e4\noutput_stiffness = 3e5\ncam_inertia = 0.01\nexact_contact = true'
    table = re.search(r"(?m)^\[dynamics\][^\n]*\n(?:(?!\[).*\n?)*", text)
    text = text.replace(table[0], "") if table else text
    model = Model(parse(re.sub(r"(?m)^speed = .*$", "speed = 0.3", text) + f"\n[dynamics]\n{drive}\n"))
    with pytest.raises(NotConverged, match="GB, more than the"):
        _ = model.dynamic_duties
    (table, *_) = lasting(model, {})
    rows = {(row[0], row[1]): (row[2], row[3]) for row in table.rows}
    assert ("Roller", "contact fatigue") in rows
    life, why = rows["All", "the same with vibration"]
    assert life == "-"
    assert "GB, more than the" in why


@pytest.mark.parametrize("name", ["conjugate_rocker", "disc_offset_roller", "end_face_lifter"])
@pytest.mark.parametrize("states", ["", "[[duty]]\nshare = 0.5\n[[duty]]\nshare = 0.5\nspeed = 300\n"])
def test_a_follower_beside_another_one_tells_what_it_does_alone(name: str, states: str):
    """Shares of the cam's damage added up to a half beside a second one, and a pair's cam life was that of both."""
    text = (PROFILES / f"{name}.toml").read_text() + states

    def told(more: str) -> dict:
        return compute(Model(parse(text + more)), ("contact", "fatigue")).data

    alone, both = told(""), told("[[station]]\nangle = 150\n")
    for one in (both, both["followers"][0]):
        for key in ("roller_slice_life_h", "cam_life_h", "cam_slice_life_h"):
            assert one["fatigue"].get(key) == alone["fatigue"].get(key), key
        for body in ("roller", "cam") if states else ():
            shares = [state[f"{body}_damage_share"] for state in one["fatigue"]["states"]]
            assert sum(shares) == pytest.approx(1.0, rel=1e-12)
    assert 2.0 * both["together"]["cam_life_h"] == pytest.approx(alone["fatigue"]["cam_slice_life_h"], rel=1e-12)
