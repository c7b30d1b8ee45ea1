"""What the body gives way below its contacts, and what vibrates on it: with it and on a rigid body, both shown."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations
from math import pi
from typing import Any

import numpy as np
import pytest

from camgeom.body import compliance
from camgeom.body.compliance import Below, Own, below_turret, sunk
from camgeom.body.element import elasticity
from camgeom.body.plate import PlateSection
from camgeom.body.ring import even_planes, ring_of
from camgeom.body.sparse_solver import SparseElastic
from camgeom.body.tetra import EDGES, FACES, PointLoad, TetraMesh
from camgeom.errors import NotConverged, ProfileError
from camgeom.mechanics.hertz import line_flexibility
from camgeom.mechanics.material import Material
from camgeom.mechanics.turret_duty import COUNT
from camgeom.model import Model
from camgeom.model.vibration import indexing_of
from camgeom.profile import from_data, read_data
from camgeom.report.result import compute
from camgeom.report.sections.dynamics import dynamics
from tests.body.ribs import ribbed
from tests.places import PROFILES

STEEL = Material()
BAR, THICK = 40.0, 10.0


def tapped(name: str = "end_face_lifter", **dynamics: Any) -> Model:
    data = read_data(PROFILES / f"{name}.toml")
    table = {"kind": "follower", "linkage_stiffness": 20000.0, "linkage_damping": 60.0, **dynamics}
    return Model(from_data({**data, "dynamics": table}, name))


@pytest.fixture(scope="module")
def lifted() -> Iterator[Model]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compliance, "PLANES", 30)
        yield tapped(tappet_mass=0.2, tappet_contact="tangent", tappet_damping=10.0, body_compliance=True)


def bar(count: int = 8) -> TetraMesh:
    """A bar along x of cubes in six straight tetrahedra each, their middles in place; both end faces are named."""
    step = THICK / 2.0
    n = (count, 2, 2)
    grid = np.arange((2 * n[0] + 1) * (2 * n[1] + 1) * (2 * n[2] + 1)).reshape([2 * k + 1 for k in n])
    places = np.stack(np.meshgrid(*(np.arange(2.0 * k + 1.0) for k in n), indexing="ij"), axis=-1)
    nodes = 0.5 * step * places.reshape(-1, 3)
    cells = []
    for i, j, k in np.ndindex(*n):
        for order in permutations(range(3)):
            at = [np.array([2 * i, 2 * j, 2 * k])]
            for axis in order:
                at.append(at[-1] + 2 * np.eye(3, dtype=int)[axis])
            if np.linalg.det(np.array(at[1:]) - at[0]) < 0.0:
                at[1], at[2] = at[2], at[1]
            every = [*at, *((at[a] + at[b]) // 2 for a, b in EDGES)]
            cells.append([grid[tuple(one)] for one in every])
    elements = np.array(cells)
    faces = elements[:, np.array(FACES)]
    _, first, seen = np.unique(np.sort(faces[:, :, :3].reshape(-1, 3), axis=1), axis=0, return_index=True,
                               return_counts=True)  # fmt: skip
    outer = np.stack(np.divmod(first[seen == 1], 4), axis=1)
    x = nodes[faces[outer[:, 0], outer[:, 1]][:, :3]][:, :, 0]
    labels = np.where((x == 0.0).all(axis=1), 0, np.where((x == x.max()).all(axis=1), 1, 2))
    return TetraMesh(nodes, elements, outer, labels, ("bore", "far", "side"), 0.0)


def test_tetrahedra_stretch_as_a_bar_does_and_bend_as_a_beam() -> None:
    """Patch: nu = 0 and an even pull is linear, exact; the cantilever comes to Timoshenko within a per cent."""
    mesh = bar()
    far = mesh.outer_nodes[mesh.labels == 1]
    pull = np.zeros((len(mesh.nodes), 3, 2))
    for face in far:
        a, b, c = mesh.nodes[face[:3]]
        # Even pressure on a quadratic triangle works on the middles of its edges alone.
        pull[face[3:], 0, 0] += 0.5 * float(np.linalg.norm(np.cross(b - a, c - a))) / 3.0
        pull[face[3:], 2, 1] += 0.5 * float(np.linalg.norm(np.cross(b - a, c - a))) / 3.0
    moved = SparseElastic(mesh, elasticity(200000.0, 0.0)).solve(pull, 1e-12)
    assert np.abs(moved[:, 0, 0] - mesh.nodes[:, 0] / 200000.0).max() < 1e-12
    force, inertia = THICK**2, THICK**4 / 12.0
    beam = force * BAR**3 / (3.0 * 200000.0 * inertia) + force * BAR / (5.0 / 6.0 * 100000.0 * THICK**2)
    assert moved[mesh.sets["far"], 2, 1].mean() == pytest.approx(beam, rel=0.01)


def test_the_formula_of_a_line_holds_what_its_depth_holds() -> None:
    """Between two depths the line's formula moves what it gains from one to the other; a point's by Boussinesq."""
    one = np.ones(1)
    load = PointLoad(0.0, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), 100.0 * one, 50.0 * one)
    held = Own(STEEL, 30.0, False).moved(load, 12.0 * one)[0]
    deep, near = (float(line_flexibility(50.0, 0.1, STEEL, STEEL, 15.0, depth)) for depth in (30.0, 12.0))
    assert held == pytest.approx(50.0 * (deep - near), rel=1e-12)
    endless = Own(STEEL, 30.0, True).moved(load, 12.0 * one)[0]
    nu, modulus = STEEL.poisson, STEEL.elastic_modulus
    assert endless == pytest.approx(100.0 * (1 + nu) * (3 - 2 * nu) / (2 * pi * modulus * 12.0), rel=1e-12)


def test_what_lies_below_does_not_hang_on_the_depth_at_which_it_is_asked(lifted: Model) -> None:
    found = lifted.below
    assert isinstance(found, Below)
    part, duty = lifted.parts[0], lifted.duty
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compliance, "DEPTHS", 0.6 * compliance.DEPTHS)
        other = compliance.below_rollers(part, lifted.cutters, [duty], None, lambda: lifted.solid.mesh)
    assert other.value == pytest.approx(found.value, rel=0.05)


def test_the_compliance_stands_in_series_and_both_are_shown(lifted: Model) -> None:
    study = lifted.elastic_follower
    assert study is not None
    assert study.rigid is not None
    assert lifted.below is not None
    soft, angle = study.body
    duty = lifted.duty
    lever = duty.force.panels.at(duty.pressing.reference.lever, lifted.below.theta)
    assert soft == pytest.approx(float((lifted.below.value / lever**2).max()), rel=1e-12)
    whole, contact = study.train.contact_stiffness, study.rigid.train.contact_stiffness
    assert 1.0 / whole == pytest.approx(1.0 / contact + 1e-3 * soft, rel=1e-12)
    assert study.train.contact_damping == pytest.approx(10.0 * (whole / contact) ** 2, rel=1e-12)
    assert study.train.stiffness == study.rigid.train.stiffness
    data = compute(lifted, ("dynamics",)).data["dynamics"]
    assert data["frequencies_hz"][0] < 0.99 * data["rigid_body"]["frequencies_hz"][0]
    assert data["rigid_body"]["frequencies_hz"] == pytest.approx(
        compute(tapped(tappet_mass=0.2, tappet_contact="tangent", tappet_damping=10.0), ("dynamics",)).data["dynamics"]
        ["frequencies_hz"], rel=1e-12)  # fmt: skip
    assert data["body_stiffness_n_mm"] == pytest.approx(1.0 / soft)
    assert data["tappet_stiffness_n_mm"] == pytest.approx(1e-3 * contact), "the contact's own"
    assert data["body_softest_at_deg"] == pytest.approx(np.degrees(angle))
    shown = str(dynamics(lifted))
    assert "on a rigid cam body" in shown
    assert "below the contact" in shown


def test_a_linkage_yields_with_the_body_and_a_stiffer_body_stiffens_none() -> None:
    for value in (2e-6, -2e-6):
        model = tapped(body_compliance=True)
        vars(model)["below"] = Below(np.array([0.0, 1.0]), np.array([value, value - 3e-6]))
        study = model.elastic_follower
        assert study is not None
        assert study.rigid is not None
        lever = float(model.duty.force.panels.at(model.duty.pressing.reference.lever, np.zeros(1))[0])
        factor = 1.0 / (1.0 + 20000.0 * max(value, 0.0) / lever**2)
        assert study.train.stiffness == pytest.approx(2e7 * factor, rel=1e-9)
        assert study.train.damping == pytest.approx(60.0 * factor**2, rel=1e-9)
        assert study.rigid.train.stiffness == 2e7


def test_a_turret_keeps_the_share_of_its_contact_stiffness_that_the_body_leaves() -> None:
    data = read_data(PROFILES / "tool_changer.toml")
    model = Model(from_data({**data, "name": "tool changer"}))
    rigid = indexing_of(model)
    vars(model)["below"] = Below(np.array([0.0, pi]), np.array([0.8, 0.5]))
    soft = indexing_of(model)
    left = np.array(soft.drive.contact_table) / np.array(rigid.drive.contact_table)
    assert (left[0], left[COUNT // 2], left[COUNT // 4]) == pytest.approx((0.8, 0.5, 0.65))
    assert soft.drive.contact_damping == pytest.approx(40.0 * left.mean() ** 2)
    assert "the body below" in soft.sources["contact_stiffness"]
    shown = soft.summary()["rigid_body"]
    assert isinstance(shown, dict)
    assert shown["first_frequency_hz"] == pytest.approx(rigid.modes.lowest_hz()[0])
    assert soft.modes.lowest_hz()[0] < rigid.modes.lowest_hz()[0]


def test_the_plates_of_a_parallel_indexer_yield_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compliance, "PLANES", 24)
    model = Model(from_data(read_data(PROFILES / "parallel_index.toml")))
    assert model.turret_duty is not None
    left = below_turret(model.parts, model.turret_duty, lambda: model.solid.mesh).value
    assert np.all((left > 0.3) & (left < 1.0))


def test_a_rib_gives_way_under_both_its_rollers_and_a_thin_one_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compliance, "PLANES", 24)
    soft = []
    for thickness in (6.0, 4.0):
        model = Model(from_data(ribbed(thickness)))
        each = [compliance.below_rollers(model.parts[0], (), [one], None, lambda: model.solid.mesh)  # noqa: B023
                for one in model.duties]  # fmt: skip
        both = compliance.below_rollers(model.parts[0], (), model.duties, None, lambda: model.solid.mesh)  # noqa: B023
        assert np.array_equal(both.theta, np.unique(np.concatenate([one.theta for one in each])))
        assert both.value.max() == max(one.value.max() for one in each)
        soft.append(both.value.max())
    assert soft[1] > 1.3 * soft[0] > 0.0


@pytest.mark.parametrize(("name", "cam", "table", "word"), [
    ("end_face_lifter", {"bore": 0.0, "keyway_width": 0.0, "keyway_depth": 0.0}, {}, "cam.bore"),
    ("disc_flat_face", {}, {}, "no \\[roller\\]"),
    ("conjugate_rocker", {}, {}, "press in turn"),
    ("end_face_lifter", {}, {"tappet_mass": 0.2}, "tappet_contact"),
    ("tool_changer", {}, {"kind": "indexing", "estimate": "chord"}, "chord"),
    ("tool_changer", {}, {"kind": "indexing", "contact_stiffness": 1e6}, "contact_stiffness is given"),
])  # fmt: skip
def test_where_nothing_is_known_of_the_body_the_key_is_refused(
    name: str, cam: dict[str, Any], table: dict[str, Any], word: str
) -> None:
    data = read_data(PROFILES / f"{name}.toml")
    given = {"linkage_stiffness": 20000.0, "kind": "follower"} if table.get("kind") != "indexing" else data["dynamics"]
    with pytest.raises(ProfileError, match=word):
        from_data({**data, "cam": {**data["cam"], **cam}, "dynamics": {**given, "body_compliance": True, **table}})


def test_the_disc_is_deep_enough_to_be_asked_and_a_feather_edge_is_not() -> None:
    model = Model(from_data(read_data(PROFILES / "disc_offset_roller.toml")))
    (disc,) = model.parts
    ring = ring_of(PlateSection(disc), even_planes(24))  # type: ignore[arg-type]
    still = np.zeros((len(ring.nodes), 3, 1))
    inward = np.array([[-1.0, 0.0, 0.0]])
    x = np.array([[float(PlateSection(disc).radius(np.zeros(1))[0]), 0.0, 0.5 * (disc.z0 + disc.z1)]])  # type: ignore
    load = PointLoad(0.0, x, inward, np.ones(1), np.ones(1))
    deep = sunk(ring, "hexahedron20", still, load, Own(STEEL, 16.0, False))
    assert np.isfinite(deep).all()
    out = PointLoad(0.0, x + 40.0, inward, np.ones(1), np.ones(1))
    assert np.isinf(sunk(ring, "hexahedron20", still, out, Own(STEEL, 16.0, False))).all()


@pytest.mark.parametrize(
    ("states", "said"),
    [(8, "of 8 followers .* 48 s of one core beside 0.4 s of loads, 8.4 s of .*: at most 6 of"), (6, "")],
)
def test_the_body_is_not_solved_for_any_number_of_states(states: int, said: str, monkeypatch: Any) -> None:
    """64 of them took 148 s of a processor and 2.5 GB: the price is told before the first one."""
    data = read_data(PROFILES / "disc_offset_roller.toml")
    data = {key: value for key, value in data.items() if key not in ("cutter", "tolerance")}
    data["dynamics"] = {"kind": "follower", "linkage_stiffness": 8000, "linkage_damping": 40, "tappet_mass": 0.2,
                        "tappet_contact": "tangent", "body_compliance": True}  # fmt: skip
    shares = ({"name": f"s{i}", "share": 1.0 / states, **({"speed": 100.0 + i} if i else {})} for i in range(states))
    data["duty"] = tuple(shares)
    solved = []
    monkeypatch.setattr("camgeom.body.compliance.below_rollers", lambda *_: solved.append(1))
    model = Model(from_data(data))
    if said:
        with pytest.raises(NotConverged, match=said):
            assert model.states[0].below
    else:
        assert model.states[0].below is None
    assert len(solved) == (not said)
