"""What mills narrower than half a groove leave of it between their passes: seen from the middle of the groove."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.export import write
from camgeom.model import Model
from camgeom.profile import parse
from tests.places import PROFILES

PHI = np.linspace(0.0, 2.0 * np.pi, 181)


def milled(name: str, **keys: str | float) -> Model:
    """A shipped profile with another [cutter]."""
    text = (PROFILES / f"{name}.toml").read_text()
    before, _, after = text.partition("[cutter]\n")
    rest = after[after.index("\n[") :] if "\n[" in after else ""
    table = "".join(f"{key} = {value!r}\n" for key, value in ({"kind": "flat"} | keys).items())
    return Model(parse(before + rest + "\n[cutter]\n" + table.replace("'", '"')))


def seen_from_the_middle(made: Model, one: Model) -> float:
    """Width about the roller's way at the tool's end that no tool's end passes, mm."""
    (track,), machining = one.cutters, made.machined.machining
    own = [path for path in machining.paths if len(made.grooves) == 1 or path.below == (one.number > 0)]
    tips = np.concatenate([path.at(np.linspace(*path.knots()[[0, -1]], 20_001)).tip for path in own], axis=1)
    pose = track.pose(PHI, 0)
    middle = pose.a[0] + track.tip * pose.u[0]
    nearest = [np.sqrt(((tips - x[:, None]) ** 2).sum(axis=0)).min() for x in middle.T]
    return 2.0 * (float(max(nearest)) - machining.tool.radius)


CASES = [
    ("linear_groove", 6.0, {}),
    ("milled_drum", 5.0, {"corner_radius": 0.5}),
    ("bell_lifter", 6.0, {}),
    ("both_faces_disc", 5.0, {"corner_radius": 0.8}),
    ("conical_groove", 5.0, {"half_angle": 8.0}),
]


@pytest.mark.parametrize(("name", "diameter", "keys"), CASES, ids=[case[0] for case in CASES])
def test_narrow_mills_leave_the_middle_of_a_groove(name: str, diameter: float, keys: dict[str, float],
                                                   tmp_path: Path) -> None:  # fmt: skip
    made = milled(name, diameter=diameter, **keys)
    told = made.machined.data()["standing_mm"]
    assert told == pytest.approx(max(seen_from_the_middle(made, one) for one in made.grooves), abs=2e-3)
    (finding,) = (f for f in judge(made).findings if "standing" in f.where)
    assert (finding.check, finding.level, finding.value) == ("stock-left", "warn", told)
    write(made, tmp_path / "cam.gcode")
    assert f"ROUGH THE GROOVE OUT FIRST: BETWEEN THE PASSES {told:.6g} MM" in (tmp_path / "cam.gcode").read_text()
    # The other side: a mill that is wider by what the advice says leaves nothing.
    wider = milled(name, diameter=diameter + 0.5 * told + 2e-6, **keys)
    assert "standing_mm" not in wider.machined.data()
    assert not [f for f in judge(wider, ["stock-left"]).findings if "standing" in f.where]
    narrower = milled(name, diameter=diameter + 0.5 * told - 1e-3, **keys)
    assert narrower.machined.data()["standing_mm"] == pytest.approx(2e-3, rel=1e-3)


def test_wheels_grind_what_is_milled_and_profiles_have_no_other_wall() -> None:
    assert "standing_mm" not in milled("milled_drum", kind="wheel", diameter=5.0).machined.data()
    assert "standing_mm" not in milled("linear_edge", diameter=1.0).machined.data()
