"""S3: the design specification of globoidal cams; its scan is damaged, many operators of its equations are lost.

It prints no example: the equations are tried on the drive of the shipped tool changer. "As it stands" is what can be
read; the corrected form is what the exact geometry gives.
"""

from __future__ import annotations

from functools import cache, partial
from itertools import product
from math import atan, atan2, cos, hypot, pi, radians, sin, sqrt

import numpy as np

from camgeom.mechanics.bearing import rated_hours, required_rating
from camgeom.mechanics.grades import MATERIALS, speed_class
from camgeom.mechanics.hertz import allowable_load, line_pressure
from camgeom.mechanics.material import CAST_IRON, STEEL, pair_compliance
from camgeom.motion import LAWS
from camgeom.track.flank import Flank
from camgeom.track.follower import TurretFollower
from camgeom.track.turret import least_held
from camgeom.validation.entry import Answer, Entry, Reading, Source
from camgeom.validation.machine import machine

NAME = "tool_changer"
CENTRE, PITCH, ROLLER, LENGTH, GLOBOID, WIDTH = 180.0, 82.0, 16.0, 24.0, 72.0, 82.0
INDEX, MOVING = radians(45.0), radians(140.0)
MIDDLE, ASIDE = -pi, -pi - 0.35
"""cam angles, rad, at which a roller stands on the line of centres in the middle of the index, and before it"""


def _flank(theta: float, side: float = 1.0) -> Flank:
    """The flank at the pitch radius of the roller."""
    track = machine(NAME).tracks[0]
    return Flank(track, np.array([theta]), np.array([track.meridian.parameter(PITCH)]), side)


def _motion(theta: float) -> tuple[float, float]:
    """Turret angle from the line of centres, rad, and its slope over the cam angle, as sizes."""
    flank = _flank(theta)
    u = flank.pose.u[0][:, 0]
    tau = float(np.arctan2(abs(u[2]), hypot(u[0], u[1])))
    program = machine(NAME).mechanism.program
    return tau, abs(float(program.jet(np.array([theta % (2.0 * pi)]), 1)[1][0]))


def _contact(theta: float) -> tuple[float, float, float]:
    """tau, and tan and cos of the contact angle psi by (15), its sign left out."""
    tau, slope = _motion(theta)
    tangent = slope * PITCH / (CENTRE - PITCH * cos(tau))
    return tau, tangent, cos(atan(tangent))


def _tan_axis(theta: float) -> float:
    return float(np.tan(_flank(theta).pressure_angle("axis"))[0, 0])


def _largest_angle() -> Answer:
    """tan of the pressure angle at the pitch radius in the middle of the index, and (17)."""
    ratio = PITCH / CENTRE
    printed = INDEX / MOVING * ratio / (1.0 - ratio) * LAWS["modified-sine"].claims.vm
    return Answer(_tan_axis(MIDDLE), (), printed)


def _pressure_angle() -> Answer:
    """Cosine of the pressure angle at the contact point: (16) as it stands, and with its root."""
    _, _, psi = _contact(ASIDE)
    below = PITCH**2 + (ROLLER * psi) ** 2
    ours = float(np.cos(_flank(ASIDE).pressure_angle())[0, 0])
    return Answer(ours, (Reading("root over the denominator", PITCH * psi / sqrt(below)),), PITCH * psi / below)


def _induced() -> Answer:
    """Relative curvature across the contact line, 1/mm, of cam and roller: by (18) with the chain (19) to (32).

    Vectors in the frame of the cam, unit cam speed; the normal points out of the roller.
    """
    flank, program = _flank(ASIDE), machine(NAME).mechanism.program
    point, normal = flank.x[:, 0, 0], flank.n[:, 0, 0]
    (place, passing), (along, turning) = flank.pose.a[:2, :, 0], flank.pose.u[:2, :, 0]
    upright = np.array([0.0, 0.0, 1.0])
    cam = -float(np.cross(place, passing)[2]) / CENTRE**2 * upright
    axis = np.cross(upright, place) / CENTRE
    _, slope, bend = program.jet(np.array([ASIDE % (2.0 * pi)]), 2)[:, 0]
    speed = float(np.cross(along, turning + np.cross(cam, along)) @ axis)
    turret, gaining = speed * axis, speed * bend / slope * axis
    arm, apart, round_ = point - place, turret - cam, np.cross(normal, along)
    carried = np.cross(turret, arm)
    sliding, turned = carried - np.cross(cam, point), np.cross(apart, normal)
    first, mu1, mu2 = -1.0 / ROLLER, float(sliding @ round_), float(sliding @ along)
    a1, a2 = first * mu1 + float(turned @ round_), float(turned @ along)
    a3 = float(np.cross(turret, normal) @ sliding + normal @ (np.cross(apart, carried) + np.cross(gaining, arm)))
    below = a3 + a1 * mu1 + a2 * mu2
    one, two, mixed = first - a1**2 / below, -(a2**2) / below, -a1 * a2 / below
    most = 0.5 * (one + two + hypot(one - two, 2.0 * mixed))
    sigma, across = 0.5 * atan2(2.0 * mixed, one - two), atan2(a2, a1)
    of_cam = most * cos(across - sigma) ** 2 + (one + two - most) * sin(across - sigma) ** 2
    return Answer(float(flank.k_rel[0, 0]), (), abs(first * cos(across) ** 2 - of_cam))


def _profile() -> Answer:
    """Distance of the contact point from the cam axis, mm: (14) as it stands, and with cos(theta) in x.

    Hands and flanks change signs of tau and psi: the nearest of the four is taken, of both.
    """
    tau, tangent, _ = _contact(ASIDE)
    ours = float(np.hypot(*_flank(ASIDE).x[:2, 0, 0]))
    turned = 0.7

    def radius(with_cos: bool, a: float, b: float) -> float:
        c, s, psi = cos(turned), sin(turned), atan(tangent) + (pi if b < 0.0 else 0.0)
        second = ROLLER * sin(a * tau) * cos(psi)
        x = PITCH * cos(tau) * c - second * (c if with_cos else 1.0) - CENTRE * c - ROLLER * s * sin(psi)
        z = -PITCH * cos(tau) * s + second * s + CENTRE * s - ROLLER * c * sin(psi)
        return hypot(x, z)

    def best(with_cos: bool) -> float:
        tried = (radius(with_cos, a, b) for a, b in product((1.0, -1.0), repeat=2))
        return min(tried, key=lambda value: abs(value - ours))

    return Answer(ours, (Reading("r0 sin(tau) cos(phi) cos(theta) in x", best(True)),), best(False))


def _seat() -> Answer:
    """Distance of the rollers' inner ends from the turret axis, mm."""
    low = min(machine(NAME).tracks[0].contact)
    damaged = PITCH - 0.5 * LENGTH**2 * ROLLER**2
    return Answer(float(low), (Reading("rf - B0/2", PITCH - 0.5 * LENGTH),), damaged)


def _outer() -> Answer:
    """Radius, mm, of the turret over its rollers' ends."""
    ours = hypot(max(machine(NAME).tracks[0].contact), ROLLER)
    corrected = sqrt((PITCH + 0.5 * LENGTH) ** 2 + ROLLER**2)
    return Answer(ours, (Reading("root of (rf + B0/2)^2 + r0^2", corrected),), PITCH - 0.5 * LENGTH**2 * ROLLER**2)


def _outside() -> Answer:
    """Largest diameter of the cam, mm."""
    vertices = machine(NAME).solid.mesh.vertices
    ours = 2.0 * float(np.hypot(vertices[:, 0], vertices[:, 1]).max())
    exact = 2.0 * (CENTRE - sqrt(GLOBOID**2 - 0.25 * WIDTH**2))
    printed = 2.0 * CENTRE - GLOBOID * cos(INDEX) - 2.0 * ROLLER * sin(INDEX)
    whole = 2.0 * (CENTRE - GLOBOID * cos(0.5 * INDEX) - ROLLER * sin(0.5 * INDEX))
    readings = (Reading("2 (C - root of R_CH^2 - (b/2)^2)", exact),
                Reading("half angles in a bracket doubled", whole, slip=False))
    return Answer(ours, readings, printed)


@cache
def _least_width() -> float:
    """Least width of the cam, mm, at which a roller drives at every cam angle, by bisection."""
    low, high = 30.0, 100.0
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        mechanism = machine(NAME, ("cam.width", middle)).mechanism
        assert mechanism.turret is not None, "it is an indexer"
        held = least_held(mechanism.turret.bearing, mechanism.within)
        low, high = (low, middle) if all(least.value >= 1.0 for least in held) else (middle, high)
    return high


def _width_of_12() -> float:
    return 2.0 * PITCH * sin(0.5 * INDEX) + ROLLER / cos(0.5 * INDEX)


def _estimate_of_6() -> Answer:
    """rf less r0 / sin(tau_h / 4), mm, of the tool changer; (6) allows 1 to 5 mm."""
    return Answer(PITCH - ROLLER / sin(0.25 * INDEX))


def _ratio_limit() -> Answer:
    """rf / C at which the pressure angle at the pitch radius is that of the tool changer, and (9)."""
    tangent = _tan_axis(MIDDLE)
    printed = 1.0 / (1.0 + INDEX * LAWS["modified-sine"].claims.vm / (MOVING * tangent))
    return Answer(PITCH / CENTRE, (), printed)


def _allowed_load() -> Answer:
    """Load, N, at which a line of 24 mm, radii 16 and 60 mm, reaches 1000 MPa; and (35), its product restored."""
    curvature, pair = 1.0 / ROLLER + 1.0 / 60.0, float(pair_compliance(STEEL, STEEL))
    load = float(allowable_load(1000.0, curvature, LENGTH, pair))
    reached = float(line_pressure(load / LENGTH, curvature, pair))
    return Answer(load * (1000.0 / reached) ** 2, (), pi * LENGTH / curvature * 1000.0**2 * pair)


def _bearing_load() -> Answer:
    """Load over rating of a roller that lives 20000 h at 500 r/min; (37) as it stands, and turned over."""
    speed, turns = 500.0 * pi / 30.0, 60.0 * 20000.0 * 500.0 / 1e6
    load = 1.0 / float(required_rating(1.0, 20000.0, speed))
    lived = float(rated_hours(1.0, load, speed))
    return Answer(load * (lived / 20000.0) ** 0.3, (Reading("10^6 above 60 L n, times the rating C", turns**-0.3),),
                  turns**0.3)


def _class_bound(low: float, high: float) -> Answer:
    """Track speed, m/s, between two at which the class changes, by bisection."""
    first = speed_class(low)
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if speed_class(middle) == first else (low, middle)
    return Answer(high)


def _least_stops() -> Answer:
    bounds = TurretFollower.model_fields["stops"].metadata
    return Answer(float(next(one.ge for one in bounds if hasattr(one, "ge"))))


def _claims(key: str, one: str, other: str) -> Answer:
    return Answer(getattr(LAWS[one].claims, key) / getattr(LAWS[other].claims, key))


def _moving() -> Answer:
    """Motion angle of the cam, rad, of 140 over 220 of the time; (3) and (4)."""
    program = machine(NAME).mechanism.program
    moved = sum(span.end - span.start for span, piece in zip(program.spans, program.segments) if piece.to is not None)
    share = 140.0 / 220.0
    return Answer(float(moved), (), share / (1.0 + share) * 2.0 * pi)


_SCAN = "Operators of the equation are lost in the scan."

SOURCE = Source(
    "S3",
    "globoidal-design",
    "Design specification for globoidal cam mechanisms",
    "T/WLJC 15-2018",
    (
        Entry("(1)", "Equation (1)", "index angle of eight stops", "", "rad",
              lambda: Answer(machine(NAME).mechanism.program.peak(0).value, (), 2.0 * pi / 8.0)),
        Entry("(3) (4)", "Equations (2) to (4)", "motion angle of the cam from the ratio of motion and dwell", "",
              "rad", _moving),
        Entry("(6) least", "Equation (6)", "rf less r0/sin(tau_h/4); 1 to 5 mm", "-5", "mm", _estimate_of_6,
              comparison=">"),
        Entry("(6) most", "Equation (6)", "rf less r0/sin(tau_h/4); 1 to 5 mm", "5", "mm", _estimate_of_6,
              comparison="<"),
        Entry("(7)", "Equation (7)", "radius of the turret's seat", "", "mm", _seat, _SCAN),
        Entry("(8)", "Equation (8)", "radius of the turret over its rollers", "", "mm", _outer, _SCAN),
        Entry("(9)", "Equation (9)", "rf/C of a pressure angle", "", "1", _ratio_limit),
        Entry("(11)", "Equation (11)", "outside diameter of the cam", "", "mm", _outside,
              f"{_SCAN} It depends on the width, which (11) has not.", slow=True),
        Entry("(12)", "Equation (12)", "least width that keeps a roller engaged, below that of (12)", "", "mm",
              lambda: Answer(_least_width(), (), _width_of_12()), "With a plus between its terms, which is lost.",
              "<"),
        Entry("(13)", "Equation (13)", "depth that clears the roller's engaged length, below 1.25 r0", "20", "mm",
              lambda: Answer(LENGTH), "The depth has to follow the roller's length B0, not its radius r0: 1.1 to 1.25 "
              "of 24 mm would do.", "<"),
        Entry("(14)", "Equation (14)", "distance of the flank from the cam axis", "", "mm", _profile, _SCAN),
        Entry("(15)", "Equation (15)", "tangent of the contact angle", "", "1",
              lambda: Answer(_tan_axis(ASIDE), (), _contact(ASIDE)[1]), "But for its sign."),
        Entry("(16)", "Equation (16)", "cosine of the pressure angle", "", "1", _pressure_angle, _SCAN),
        Entry("(17)", "Equation (17)", "tangent of the largest pressure angle, at the pitch radius", "", "1",
              _largest_angle, "Along the roller and on its surface it is larger: 32.7 degrees in this drive."),
        Entry("pressure angle", "Section 5.2", "allowed pressure angle", "50", "deg",
              lambda: Answer(TurretFollower.pressure_angle_limit)),
        Entry("(18)-(32)", "Equations (18) to (32)", "relative curvature across the contact line", "", "1/mm", _induced,
              f"{_SCAN[:-1]}; restored, they hold."),
        Entry("(33)", "Equation (33)", "least relative curvature of the tool changer", "0", "1/mm",
              lambda: Answer(min(one.relative_curvature.value for one in machine(NAME).flanks)), comparison=">"),
        Entry("(35) (36)", "Equations (35), (36)", "load at a contact limit of 1000 MPa", "", "N", _allowed_load,
              "The scan has no operators; the product is restored."),
        Entry("(37)", "Equation (37)", "load over rating of a roller for 20000 h at 500 r/min", "", "1", _bearing_load,
              "The fraction stands upside down and the rating is lost."),
        Entry("E steel", "Section 8.1", "elastic modulus of hardened steel", "206", "GPa",
              lambda: Answer(1e-3 * STEEL.elastic_modulus)),
        Entry("E iron", "Section 8.1", "elastic modulus of cast iron", "127", "GPa",
              lambda: Answer(1e-3 * CAST_IRON.elastic_modulus)),
        Entry("nu steel", "Section 8.1", "Poisson number of steel", "0.3", "1", lambda: Answer(STEEL.poisson)),
        *(
            Entry(f"class {name}", "Section 9.1", f"pressure up to which the load is {name}", printed, "MPa",
                  partial(lambda k: Answer(MATERIALS[k].pressure), k))
            for k, (name, printed) in enumerate((("light", "600"), ("medium", "1000"), ("heavy", "1300")))
        ),
        Entry("speed low", "Section 9.1", "track speed up to which it is low", "0.5", "m/s",
              partial(_class_bound, 0.1, 0.9), within=1e-6),
        Entry("speed medium", "Section 9.1", "track speed up to which it is medium", "1", "m/s",
              partial(_class_bound, 0.6, 2.0), within=1e-6),
        Entry("stops least", "Section 3.2", "fewest stops", "1", "1", _least_stops,
              "Of a cam with several starts: one roller alone could not be driven.", within=0.0),
        Entry("stops most", "Section 3.2", "stops beyond which a preload jams", "24", "1",
              lambda: Answer(float(TurretFollower.usual_stops[1]))),
        Entry("law slow", "Section 7.4, 2)", "peak velocity, modified constant velocity over modified sine", "1", "1",
              partial(_claims, "vm", "modified-constant-velocity", "modified-sine"), comparison="<"),
        Entry("law gentle", "Section 7.4, 7)", "peak acceleration, modified trapezoid over modified sine", "1", "1",
              partial(_claims, "am", "modified-trapezoid", "modified-sine"), comparison="<"),
        Entry("law jerk", "Section 7.4, 3)", "peak jerk, modified trapezoid over modified sine", "1", "1",
              partial(_claims, "jm", "modified-trapezoid", "modified-sine"), comparison="<"),
    ),
)  # fmt: skip
