"""The geometry of the contact pairs against distances found without their equations."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from camgeom.dynamics.impact.flank import groove_pair
from camgeom.dynamics.impact.frame import FramePair
from camgeom.dynamics.impact.laws import PowerLaw
from camgeom.dynamics.impact.lift import TURN, Arc, Lift
from camgeom.dynamics.impact.pair import TablePair
from camgeom.dynamics.impact.pairs import GroovePair, RockerPair, SlidePair
from camgeom.dynamics.impact.problem import ImpactProblem
from camgeom.dynamics.impact.roller import CurveSide, DevelopedCurve
from camgeom.dynamics.impact.run import solve
from camgeom.dynamics.impact.side import Pair
from camgeom.errors import NotConverged, ProfileError
from camgeom.motion import Program, Segment
from camgeom.track import Slide, Straight, Swing, Track
from tests.reference.impact_reference import b1_pair, rise_return_lift


def slide_lift(stroke: float = 0.03, law: str = "cycloidal") -> Lift:
    """Rise 140, dwell 40, return 140, dwell 40 degrees: a motion of constant width."""
    stops = [Segment(math.radians(140), stroke, law), Segment(math.radians(180))]
    back = [Segment(math.radians(320), 0.0, law), Segment(TURN)]
    return Lift.from_program(Program.from_segments(stops + back), 1.0)


PAIRS: dict[str, Callable[[], Pair]] = {
    "rocker": lambda: b1_pair(1e-3),
    "rocker-normal": lambda: b1_pair(1e-3, clearance_kind="normal"),
    "rocker-unequal": lambda: b1_pair(1e-3, arm_return=0.08, arm_angle=1.9),
    "slide": lambda: SlidePair(slide_lift(), 0.05, 0.07, 0.015, 1e-3, offset=0.01),
    "groove": lambda: GroovePair(slide_lift(), 0.067, 0.011, 1e-3),
    "frame": lambda: FramePair(slide_lift(), 0.04, 1e-3),
    "table": lambda: table_pair(b1_pair(1e-3)),
}


def table_pair(pair: RockerPair, count: int = 360) -> TablePair:
    """The same mechanism as tables of its exact geometry."""
    angle = np.arange(count) * TURN / count
    main, back = (side.many(pair.lift, angle, np.zeros(count)) for side in pair.sides)
    rows = [tuple(map(float, row)) for row in (main[1], -back[1], main[5], back[5], main[4])]
    return TablePair(pair.lift, rows[0], rows[1], pair.clearance, rows[2], rows[3], rows[4])


@pytest.mark.parametrize("name", PAIRS)
def test_quick_and_array_evaluation_agree(name: str) -> None:
    pair = PAIRS[name]()
    rng = np.random.default_rng(5)
    angle = rng.uniform(0.0, TURN, 200)
    eta = rng.uniform(-2.0, 2.0, 200) * pair.play
    jets = pair.lift.compiled()
    for side in pair.sides:
        touch = side.compiled(jets)
        many = np.array(side.many(pair.lift, angle, eta))
        for i, (a, e) in enumerate(zip(angle.tolist(), eta.tolist(), strict=True)):
            k = pair.lift.arc_at(a)
            x = a - pair.lift.starts[k]
            one = touch(k, x, *jets.at(k, x), e)
            assert one == pytest.approx(many[:, i].tolist(), rel=1e-4, abs=1e-10)
            assert one[0] == pytest.approx(float(many[0, i]), abs=1e-15)


@pytest.mark.parametrize("name", PAIRS)
def test_levers_and_drags_are_the_derivatives_of_the_penetration(name: str) -> None:
    """d delta = g dphi - h dq: by central differences along both coordinates."""
    pair = PAIRS[name]()
    angle = np.linspace(0.02, TURN - 0.02, 41)
    eta = np.full_like(angle, 0.3 * pair.play)
    step = 1e-6
    for side in pair.sides:
        _, lever, drag, _, _, _ = side.many(pair.lift, angle, eta)
        ahead, behind = (side.many(pair.lift, angle, eta + s * step)[0] for s in (1, -1))
        assert (ahead - behind) / (2 * step) == pytest.approx(-lever, abs=1e-7)
        rate = pair.lift.many(angle, 1)[1]
        ahead, behind = (side.many(pair.lift, angle + s * step, eta)[0] for s in (1, -1))
        assert (ahead - behind) / (2 * step) == pytest.approx(drag - lever * rate, abs=1e-7)
        assert np.all(np.sign(lever) == side.sense)


@pytest.mark.parametrize("name", ["rocker", "rocker-normal", "rocker-unequal", "slide", "groove"])
def test_penetration_is_the_distance_to_the_true_profile(name: str) -> None:
    """Roller radius less the distance of its centre from densely sampled pitch curve points."""
    pair = PAIRS[name]()
    for side in pair.sides:
        assert isinstance(side, CurveSide)
        for angle, share in ((0.4, -0.2), (1.0, 0.5), (1.9, 1.2), (4.0, 0.1)):
            eta = share * pair.play
            e = np.linspace(-0.05, 0.05, 100_001)
            jet = pair.lift.many(angle + e, 2)
            curve, curve1, _ = side.curve.point(e, (jet[0], jet[1], jet[2]), np.exp)
            here = pair.lift.many(angle, 0)[0]
            centre = side.arm.pose(here + eta, np.exp)[0]
            profile = curve - side.radius * 1j * side.outward * curve1 / np.abs(curve1)
            distance = np.abs(centre - profile)
            near = int(np.argmin(distance))
            # The sampled minimum is too large by the square of half a step along the curve over the radius.
            found = side.radius - distance[near] - side.gap
            delta = float(side.many(pair.lift, np.array([angle]), np.array([eta]))[0][0])
            assert delta == pytest.approx(found, abs=2e-12)


def test_clearance_as_chord_and_as_normal_gap() -> None:
    chord, normal = b1_pair(1e-4), b1_pair(1e-4, clearance_kind="normal")
    for pair in (chord, normal):
        angle = np.linspace(0.0, TURN, 361)
        gap = -pair.sides[1].many(pair.lift, angle, np.zeros(361))[0]
        if pair is chord:
            assert 1e3 * gap.min() == pytest.approx(0.0843, abs=6e-4)
            assert 1e3 * gap.max() == pytest.approx(0.1, abs=1e-6)
            assert "chord" in pair.clearance_text
        else:
            assert gap == pytest.approx(1e-4, abs=1e-16)
            assert "normal" in pair.clearance_text
    assert chord.play == pytest.approx(1.111111168267040e-3, rel=1e-14)
    assert b1_pair(1e-5).play == pytest.approx(1.111111111682671e-4, rel=1e-14)
    assert b1_pair(1e-3).play == pytest.approx(1.111116826782631e-2, rel=1e-14)


def test_reference_mechanism_b1() -> None:
    pair = b1_pair(1e-7)
    assert pair.lowest == pytest.approx(0.724780463366959, abs=1e-14)
    assert math.degrees(pair.angle_between) == pytest.approx(107.053723248926, abs=1e-11)
    assert math.degrees(pair.pressure_angle()) == pytest.approx(33.0, abs=0.05)
    main, back = pair.sides
    angle = np.linspace(0.0, TURN, 20001)
    convex, hollow = [], []
    for side in (main, back):
        bend = side.many(pair.lift, angle, np.zeros_like(angle))[5]
        convex.append(1.0 / bend.max() + pair.roller_radius)
        hollow.append(-1.0 / bend.min())
    assert convex == pytest.approx([0.1029, 0.1029], abs=2e-5)
    assert hollow[0] - pair.roller_radius == pytest.approx(hollow[1] - pair.roller_radius, rel=1e-3)
    assert min(hollow) == pytest.approx(3.66, abs=0.03)


@pytest.mark.parametrize(
    ("changes", "degrees"),
    [
        ({"base_radius": 0.120}, 41.6),
        ({"base_radius": 0.140}, 25.4),
        ({"base_radius": 0.145}, 21.7),
        ({"base_radius": 0.0795, "arm_main": 0.15, "arm_return": 0.15}, 42.5),
        ({"base_radius": 0.0795, "center_distance": 0.16}, 38.1),
    ],
)
def test_geometries_that_would_fit(changes: dict[str, float], degrees: float) -> None:
    assert math.degrees(b1_pair(1e-4, **changes).pressure_angle()) == pytest.approx(degrees, abs=0.06)


def test_the_printed_geometry_is_refused_with_the_ranges_that_fit() -> None:
    with pytest.raises(ProfileError) as refused:
        b1_pair(1e-4, base_radius=0.0795)
    text = str(refused.value)
    for part in ("cannot be assembled", "1.090102", "95..275 mm", "arm 105.5..", "center_distance 9.5..189.5 mm"):
        assert part in text
    b1_pair(1e-4, base_radius=0.0951 + 0.02)
    with pytest.raises(ProfileError, match="cannot be assembled"):
        b1_pair(1e-4, base_radius=0.0949)
    with pytest.raises(ProfileError, match="line of centres"):
        b1_pair(1e-4, base_radius=0.27)


def test_undercut_is_refused_on_both_sides_of_the_limit() -> None:
    def pair(roller: float) -> SlidePair:
        return SlidePair(lift, 0.05 - roller, 0.15 - roller, roller, 1e-4)

    lift = rise_return_lift("cycloidal", 60, 60, swing=0.03)

    with pytest.raises(ProfileError, match="undercut") as refused:
        pair(0.045)
    limit = float(str(refused.value).split("allowed: < ")[1].split(" m")[0])
    pair(0.998 * limit)
    with pytest.raises(ProfileError, match="undercut"):
        pair(1.002 * limit)


def test_frame_needs_constant_width_and_a_convex_cam() -> None:
    with pytest.raises(ProfileError, match="constant width"):
        FramePair(rise_return_lift("3-4-5", swing=0.02), 0.04, 1e-5)
    lift = slide_lift(0.03)
    angle = np.linspace(0.0, TURN, 7201)
    s0, _, s2 = lift.many(angle, 2)
    least = -float((s0 + s2).min())
    FramePair(lift, 1.002 * least, 1e-5)
    with pytest.raises(ProfileError, match="convex"):
        FramePair(lift, 0.998 * least, 1e-5)


def test_an_acceleration_jump_in_the_profile_is_bracketed_and_a_lost_roller_is_told() -> None:
    lift = slide_lift(0.03, "simple-harmonic")
    pair = SlidePair(lift, 0.05, 0.07, 0.015, 1e-3)
    jets, side = lift.compiled(), pair.sides[0]
    touch = side.compiled(jets)
    for x in (1e-9, 1e-5, 1e-3):
        delta = touch(0, x, *jets.at(0, x), -2e-3)[0]
        before = jets.spans[-1] - x
        other = touch(len(jets.spans) - 1, before, *jets.at(len(jets.spans) - 1, before), -2e-3)[0]
        assert delta == pytest.approx(other, abs=2e-3 * x + 1e-12)
    with pytest.raises(NotConverged, match="no nearest point"):
        touch(0, 0.5, *jets.at(0, 0.5), -0.065)


def test_tables_reproduce_the_mechanism_at_small_clearance() -> None:
    pair = b1_pair(1e-5)
    law = PowerLaw(6.4e9)
    exact = solve(ImpactProblem(pair, 0.14, 20 * math.pi, law), end_angle=math.radians(70))
    tables = TablePair(pair.lift, *_rows(pair))
    rough = solve(ImpactProblem(tables, 0.14, 20 * math.pi, law), end_angle=math.radians(70))
    assert rough.energy.relative_residual < 1e-8
    assert rough.peak("acceleration").value == pytest.approx(exact.peak("acceleration").value, rel=5e-3)


def _rows(pair: RockerPair) -> tuple[tuple[float, ...], ...]:
    table = table_pair(pair)
    clearance = (pair.clearance,)
    return table.lever_main, table.lever_return, *clearance, table.curvature_main, table.curvature_return, table.sliding  # type: ignore[return-value]


def test_a_groove_roller_changes_walls() -> None:
    pair = GroovePair(slide_lift(0.037), 0.067, 0.011, 2e-5)
    run = solve(ImpactProblem(pair, 2.25, 20 * math.pi, PowerLaw(2e9, 10 / 9)), end_angle=math.radians(150))
    assert run.energy.relative_residual < 1e-8
    first = run.conversions[0]
    assert 70.0 < math.degrees(first.angle) < 80.0, "soon after the acceleration changes sign at 70 degrees"
    assert isinstance(pair.sides[0].curve, DevelopedCurve)


def groove_track(swinging: bool) -> Track:
    """A cylinder roller of 22 mm in a groove at 67 mm radius; sliding, or swinging on an arm of 150 mm."""
    stroke = 0.2 if swinging else 37.0
    stops = [Segment(math.radians(140), stroke, "cycloidal"), Segment(math.radians(180))]
    program = Program.from_segments([*stops, Segment(math.radians(320), 0.0, "cycloidal"), Segment(TURN)])
    joint = Swing((-1.0, 0.0, 0.0), (0.0, 150.0, 40.0)) if swinging else Slide((0.0, 0.0, 1.0))
    return Track(Straight(11.0, 0.0), joint, (67.0, 0.0, 20.0), (1.0, 0.0, 0.0), -6.0, (-6.0, 6.0), program)


def test_flanks_of_a_groove_as_tables_meet_the_developed_groove() -> None:
    track = groove_track(False)
    tables = groove_pair(track, 2e-5, 0.0, 360)
    developed = GroovePair(Lift.from_program(track.program, 1e-3), 0.067, 0.011, 2e-5)
    angle = np.linspace(0.1, 6.2, 50)
    for exact, plane in zip(tables.sides, developed.sides, strict=True):
        a, b = (side.many(tables.lift, angle, np.zeros(50)) for side in (exact, plane))
        assert a[1] == pytest.approx(b[1], abs=1e-6)
        assert a[2] == pytest.approx(b[2], abs=1e-6)
        assert a[5] == pytest.approx(b[5], abs=1.5), "the developed curvature misses the twist of the surface"
    law = PowerLaw(2e9, 10 / 9)
    runs = [
        solve(ImpactProblem(pair, 2.25, 20 * math.pi, law), end_angle=math.radians(150)) for pair in (tables, developed)
    ]
    assert all(run.energy.relative_residual < 1e-7 for run in runs)
    first = [math.degrees(run.conversions[0].angle) for run in runs]
    assert first[0] == pytest.approx(first[1], abs=0.2)


def test_flanks_of_a_swinging_groove_give_levers_per_radian() -> None:
    pair = groove_pair(groove_track(True), 2e-5, 0.0, 180)
    lever = pair.sides[0].many(pair.lift, np.array([0.0]), np.zeros(1))[1][0]
    assert lever == pytest.approx(0.150 * 0.9912, rel=2e-2)
    with pytest.raises(ProfileError, match="two flanks"):
        groove_pair(replace(groove_track(True), sides=(1.0,)), 2e-5, 0.0)


def test_lift_refuses_what_does_not_close() -> None:
    with pytest.raises(ProfileError, match="close after one turn"):
        Lift((Arc(0.0, TURN, 0.0, (0.0, 0.01)),))
    with pytest.raises(ProfileError, match="velocity jumps at 70 degrees"):
        rise_return_lift("constant-velocity")
    with pytest.raises(ProfileError, match="follow each other"):
        Lift((Arc(0.0, 1.0, 0.0, (0.0,)),))
