"""The geometry of the contact pairs against distances found without their equations."""

import cmath
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from camgeom.cams.conjugate import Conjugate
from camgeom.dynamics.impact.laws import PowerLaw
from camgeom.dynamics.impact.lift import Lift, MotionArc
from camgeom.dynamics.impact.pair import GrooveWall, Pair, Roller, groove_pair, planar_pair
from camgeom.dynamics.impact.problem import ImpactProblem
from camgeom.dynamics.impact.run import solve
from camgeom.errors import DesignError, NotConverged, ProfileError
from camgeom.maths import TURN
from camgeom.model import Model
from camgeom.model.impact import impact_pair
from camgeom.motion import Program, Segment
from camgeom.profile import parse
from camgeom.track import Slide, Straight, Swing, Track
from camgeom.track.follower import CylinderRoller, Setup, TranslatingFollower
from tests.places import PLATE, PROFILES
from tests.reference.impact_reference import LOWEST, b1_pair, b1_problem, frame_pair, pressure_angle, rise_return_lift


def slide_program(stroke: float = 30.0, law: str = "cycloidal") -> Program:
    """Rise 140, dwell 40, return 140, dwell 40 degrees: a motion of constant width."""
    stops = [Segment(math.radians(140), stroke, law), Segment(math.radians(180))]
    back = [Segment(math.radians(320), 0.0, law), Segment(TURN)]
    return Program.from_segments(stops + back)


def slide_lift(stroke: float = 30.0, law: str = "cycloidal") -> Lift:
    """The same motion for the solver."""
    return Lift.from_program(slide_program(stroke, law), 1e-3)


def slide_pair(
    program: Program, base: float, back: float, roller: float, clearance: float, offset: float = 0.0
) -> Pair:
    """A slide between two discs: base radii, roller radius and offset in mm, clearance in m."""
    cam = Conjugate(kind="conjugate", base_radius=base, return_radius=back, width=10.0)
    setup = Setup(TranslatingFollower(offset=offset), CylinderRoller(diameter=2.0 * roller, length=10.0), program)
    return planar_pair(program, cam.mechanism(setup).touches, clearance, "chord")


def profile_pair(name: str, extra: str = "") -> Pair:
    """The pair of a profile with 1 mm of play; a frame's as no part, with faces as wide as they have to be."""
    text = (PROFILES / f"{name}.toml").read_text().partition("[impact]")[0]
    text = "".join(line for line in text.splitlines(True) if line.partition(" =")[0] not in ("face_width", *PLATE))
    model = Model(parse(f"{text}\n{extra}\n[impact]\nclearance = 1\n"))
    return impact_pair(model.profile, model.mechanism)


PAIRS: dict[str, Callable[[], Pair]] = {
    "rocker": lambda: b1_pair(1e-3),
    "rocker-right": lambda: b1_pair(1e-3, side="right"),
    "rocker-normal": lambda: b1_pair(1e-3, kind="normal"),
    "rocker-unequal": lambda: b1_pair(1e-3, return_arm=80.0, rocker_angle=math.degrees(1.9)),
    "slide": lambda: slide_pair(slide_program(), 50.0, 70.0, 15.0, 1e-3, offset=10.0),
    "slide-normal": lambda: replace(PAIRS["slide"](), kind="normal"),
    "yoke": lambda: profile_pair("constant_width_press", "[roller]\ndiameter = 20\nlength = 12\n"),
    "face-groove": lambda: profile_pair("disc_face_groove"),
    "frame": lambda: frame_pair(slide_lift(), 0.04, 1e-3),
    "table": lambda: table_pair(b1_pair(1e-3)),
    "groove": lambda: groove_pair(groove_track(True), 1e-3, 0.0, 180),
}


def table_pair(pair: Pair, count: int = 360) -> Pair:
    """The same mechanism as tables of its exact geometry."""
    angle = np.arange(count) * TURN / count
    walls = []
    for side in (pair.main, pair.back):
        _, lever, _, _, sliding, bend = (tuple(map(float, row)) for row in side.many(pair.lift, angle, np.zeros(count)))
        walls.append(GrooveWall(side.push, tuple(side.push * h for h in lever), bend, sliding))
    return replace(pair, main=walls[0], back=walls[1])


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
        scale = np.abs(many).max(axis=1)
        for i, (a, e) in enumerate(zip(angle.tolist(), eta.tolist(), strict=True)):
            k = pair.lift.arc_at(a)
            x = a - pair.lift.starts[k]
            one = touch(k, x, *jets.at(k, x), e)
            assert np.all(np.abs(one - many[:, i]) <= 1e-10 + 1e-5 * scale)
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
        assert np.all(np.sign(lever) == side.push)


ROLLERS = ["rocker", "rocker-right", "rocker-normal", "rocker-unequal", "slide", "yoke", "face-groove"]


@pytest.mark.parametrize("name", ROLLERS)
def test_penetration_is_the_distance_to_the_true_profile(name: str) -> None:
    """Roller radius less the distance of its centre from densely sampled pitch curve points."""
    pair = PAIRS[name]()
    for side in pair.sides:
        assert isinstance(side, Roller)
        for angle, share in ((0.4, -0.2), (1.0, 0.5), (1.9, 1.2), (4.0, 0.1)):
            eta = share * pair.play
            e = np.linspace(-0.05, 0.05, 100_001)
            curve, curve1, _ = side.pitch(np.exp, e, *pair.lift.many(angle + e, 2))
            here = pair.lift.many(angle, 0)[0]
            centre = side.pose(np.exp, here + eta)[0]
            profile = curve - side.radius * 1j * side.outward * curve1 / np.abs(curve1)
            distance = np.abs(centre - profile)
            near = int(np.argmin(distance))
            # The sampled minimum is too large by the square of half a step along the curve over the radius.
            found = side.radius - distance[near] - side.gap
            delta = float(side.many(pair.lift, np.array([angle]), np.array([eta]))[0][0])
            assert delta == pytest.approx(found, abs=2e-12)


def test_clearance_as_chord_and_as_normal_gap() -> None:
    chord, normal = b1_pair(1e-4), b1_pair(1e-4, kind="normal")
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
    assert pytest.approx(0.724780463366959, abs=1e-14) == LOWEST
    main, back = pair.sides
    assert isinstance(main, Roller)
    assert isinstance(back, Roller)
    assert cmath.phase(-main.arm) == pytest.approx(-LOWEST, abs=1e-14)
    assert math.degrees(cmath.phase(back.arm / main.arm)) == pytest.approx(107.053723248926, abs=1e-11)
    assert math.degrees(pressure_angle(pair)) == pytest.approx(33.0, abs=0.05)
    angle = np.linspace(0.0, TURN, 20001)
    convex, hollow = [], []
    for side in (main, back):
        bend = side.many(pair.lift, angle, np.zeros_like(angle))[5]
        convex.append(1.0 / bend.max() + side.radius)
        hollow.append(-1.0 / bend.min())
    assert convex == pytest.approx([0.1029, 0.1029], abs=2e-5)
    assert hollow[0] - main.radius == pytest.approx(hollow[1] - main.radius, rel=1e-3)
    assert min(hollow) == pytest.approx(3.66, abs=0.03)


@pytest.mark.parametrize(
    ("changes", "degrees"),
    [
        ({"base_radius": 120.0}, 41.6),
        ({"base_radius": 140.0}, 25.4),
        ({"base_radius": 145.0}, 21.7),
        ({"base_radius": 79.5, "arm": 150.0}, 42.5),
        ({"base_radius": 79.5, "center_distance": 160.0}, 38.1),
    ],
)
def test_geometries_that_would_fit(changes: dict[str, float], degrees: float) -> None:
    assert math.degrees(pressure_angle(b1_pair(1e-4, **changes))) == pytest.approx(degrees, abs=0.06)


def test_undercut_is_refused_on_both_sides_of_the_limit() -> None:
    moves = [Segment(math.radians(60), 30.0, "cycloidal"), Segment(math.radians(120), 0.0, "cycloidal"), Segment(TURN)]
    program = Program.from_segments(moves)

    def pair(roller: float) -> Pair:
        return slide_pair(program, 50.0 - roller, 150.0 - roller, roller, 1e-4)

    with pytest.raises(DesignError, match="undercut") as refused:
        pair(45.0)
    limit = 1e3 * float(str(refused.value).split("radius < ")[1].split(" m")[0])
    pair(0.998 * limit)
    with pytest.raises(DesignError, match="undercut"):
        pair(1.002 * limit)


def test_a_frame_needs_a_convex_cam() -> None:
    lift = slide_lift()
    angle = np.linspace(0.0, TURN, 7201)
    s0, _, s2 = lift.many(angle, 2)
    least = -float((s0 + s2).min())
    frame_pair(lift, 1.002 * least, 1e-5)
    with pytest.raises(DesignError, match="convex"):
        frame_pair(lift, 0.998 * least, 1e-5)


def test_a_rocker_and_its_mirror_image_move_alike() -> None:
    """The cam that turns clockwise with the rocker on the other side: the same mechanism seen from behind."""
    for side, other in (("left", "right"), ("right", "left")):
        pair, mirrored = b1_pair(1e-4, side=side), b1_pair(1e-4, side=other, direction="cw")
        assert pair.sides == mirrored.sides
    runs = [
        solve(replace(b1_problem(1e-4), pair=b1_pair(1e-4, side=side)), end_angle=math.radians(140))
        for side in ("left", "right")
    ]
    assert runs[0].conversions[0].angle != pytest.approx(runs[1].conversions[0].angle, rel=1e-6)
    assert runs[1].energy.relative_residual < 1e-7


def test_an_acceleration_jump_in_the_profile_is_bracketed_and_a_lost_roller_is_told() -> None:
    pair = slide_pair(slide_program(30.0, "simple-harmonic"), 50.0, 70.0, 15.0, 1e-3)
    jets, side = pair.lift.compiled(), pair.sides[0]
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
    rough = solve(ImpactProblem(table_pair(pair), 0.14, 20 * math.pi, law), end_angle=math.radians(70))
    assert rough.energy.relative_residual < 1e-8
    assert rough.peak("acceleration").value == pytest.approx(exact.peak("acceleration").value, rel=5e-3)


def test_a_groove_roller_changes_walls() -> None:
    pair = groove_pair(groove_track(False), 2e-5, 0.0, 360)
    run = solve(ImpactProblem(pair, 2.25, 20 * math.pi, PowerLaw(2e9, 10 / 9)), end_angle=math.radians(150))
    assert run.energy.relative_residual < 1e-7
    first = run.conversions[0]
    assert 70.0 < math.degrees(first.angle) < 80.0, "soon after the acceleration changes sign at 70 degrees"


def groove_track(swinging: bool) -> Track:
    """A cylinder roller of 22 mm in a groove at 67 mm radius; sliding, or swinging on an arm of 150 mm."""
    stroke = 0.2 if swinging else 37.0
    stops = [Segment(math.radians(140), stroke, "cycloidal"), Segment(math.radians(180))]
    program = Program.from_segments([*stops, Segment(math.radians(320), 0.0, "cycloidal"), Segment(TURN)])
    joint = Swing((-1.0, 0.0, 0.0), (0.0, 150.0, 40.0)) if swinging else Slide((0.0, 0.0, 1.0))
    return Track(Straight(11.0, 0.0), joint, (67.0, 0.0, 20.0), (1.0, 0.0, 0.0), -6.0, (-6.0, 6.0), program)


def test_flanks_of_a_groove_as_tables_meet_the_developed_groove() -> None:
    """Unrolled at the pitch radius the walls lie beside y = s(phi), x = radius phi: levers are cosines of its slope."""
    tables = groove_pair(groove_track(False), 2e-5, 0.0, 360)
    angle = np.linspace(0.1, 6.2, 50)
    _, s1, s2 = tables.lift.many(angle, 2)
    cosine = 1.0 / np.hypot(1.0, s1 / 0.067)
    bend = s2 / 0.067**2 * cosine**3
    for side in tables.sides:
        _, lever, drag, _, _, curvature = side.many(tables.lift, angle, np.full(50, 2e-5 if side.push < 0 else 0.0))
        assert lever == pytest.approx(side.push * cosine, abs=1e-6)
        assert drag == pytest.approx(side.push * cosine * s1, abs=1e-5)
        walls = -side.push * bend / (1.0 + side.push * bend * 0.011)
        assert curvature == pytest.approx(walls, abs=1.5), "the developed curvature misses the twist of the surface"


def test_flanks_of_a_swinging_groove_give_levers_per_radian() -> None:
    pair = groove_pair(groove_track(True), 2e-5, 0.0, 180)
    lever = pair.sides[0].many(pair.lift, np.array([0.0]), np.zeros(1))[1][0]
    assert lever == pytest.approx(0.150 * 0.9912, rel=2e-2)
    with pytest.raises(ProfileError, match="two flanks"):
        groove_pair(replace(groove_track(True), sides=(1.0,)), 2e-5, 0.0)


def test_lift_refuses_what_does_not_close() -> None:
    with pytest.raises(DesignError, match="close after one turn"):
        Lift((MotionArc(0.0, TURN, 0.0, (0.0, 0.01)),))
    with pytest.raises(DesignError, match="velocity jumps at 70 degrees"):
        rise_return_lift("constant-velocity")
    with pytest.raises(ProfileError, match="follow each other"):
        Lift((MotionArc(0.0, 1.0, 0.0, (0.0,)),))
