"""S5: conjugate cams with clearance, the rocker of a beating-up mechanism and its impacts.

The printed geometry cannot be assembled. What can be is the mechanism of the shipped profile, with a base radius of
130 mm and rise and return of 70 degrees; so are the conclusions judged. Peaks are of the first turn, for beyond it a
motion with 1 mm of clearance cannot be reproduced by any solver.
"""

from __future__ import annotations

from functools import cache, partial
from math import degrees, exp, log, pi, radians, sqrt

import numpy as np

from camgeom.dynamics.impact.laws import ImpactDamping, LiuCylinder, PrintedStiffness, exact_factor, hybrid_factor
from camgeom.dynamics.impact.pair import Pair, Roller
from camgeom.dynamics.impact.run import ImpactRun, Quantity
from camgeom.errors import ProfileError
from camgeom.mechanics.material import pair_compliance
from camgeom.validation.entry import Answer, Entry, Reading, Source
from camgeom.validation.fixed_step import FixedRun, solve_fixed
from camgeom.validation.machine import machine

NAME = "conjugate_rocker"
SWING, RISE = radians(24.0), radians(70.0)
ROLLER, BASE, LENGTH, ARM = 0.020, 0.130, 0.020, 0.090
SOFT = (("impact.law", "power"), ("impact.stiffness", 6.4e9 / 10.0**4.5), ("impact.exponent", 1.5))
CONTACTS: dict[str, tuple[tuple[str, float | str], ...]] = {
    "line contact (Hertz)": (),
    "(9) as printed, n = 1": (("impact.law", "printed"), ("impact.exponent", 1.0)),
    "(9) as printed, n = 1.5": (("impact.law", "printed"), ("impact.exponent", 1.5)),
    "K = 6.4e9 N/m^1.5": SOFT,
}
LINE, *OTHERS = CONTACTS


@cache
def impact_run(contact: str = LINE, clearance: float = 0.1, law: str = "3-4-5") -> ImpactRun:
    """The first turns of the mechanism; clearance in mm."""
    laws = (("motion.0.law", law), ("motion.1.law", law))
    run = machine(NAME, ("follower.clearance", clearance), *laws, *CONTACTS[contact]).impact
    assert run is not None
    return run


def peak(contact: str, clearance: float, law: str = "3-4-5", quantity: Quantity = "acceleration") -> float:
    """Largest magnitude of a quantity in the first turn, SI."""
    run = impact_run(contact, clearance, law)
    return run.peak(quantity, 0.0, run.problem.period).value


@cache
def fixed() -> FixedRun:
    """Rise and return of the first turn, clearance 0.1 mm, by the paper's method: Runge-Kutta, steps of 1e-5 s."""
    problem = impact_run().problem
    return solve_fixed(problem, (problem.pair.clearance,), end_angle=2.0 * RISE)


def _fixed_peak() -> Answer:
    """Peak acceleration by events over rise and return, 1; printed: by the paper's method, over ours."""
    run = impact_run()
    until = 2.0 * RISE / run.problem.speed
    return Answer(1.0, (), float(fixed().peaks()[0]) / run.peak("acceleration", 0.0, until).value)


def _pair() -> tuple[Pair, Roller]:
    pair = impact_run().problem.pair
    main = pair.sides[0]
    assert isinstance(main, Roller)
    return pair, main


def _modulus() -> float:
    """Contact modulus, Pa."""
    material = machine(NAME).profile.material
    return 1e6 / float(pair_compliance(material.cam, material.roller))


def _least_base(*changes: tuple[str, float]) -> Answer:
    """Least base radius, mm, of which a cam is accepted, by bisection."""
    low, high = 1.0, 200.0
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        try:
            machine(NAME, ("cam.base_radius", middle), *changes)
        except ProfileError:
            low = middle
        else:
            high = middle
    return Answer(high)


def _gyration() -> Answer:
    return Answer(sqrt(0.140 / 0.0686), (Reading("mass 6.86 kg for 0.0686", sqrt(0.140 / 6.86)),))


def _penetration() -> Answer:
    """Penetration, m, of the main roller turned 1e-7 rad into its cam at the steepest place of the rise."""
    pair, main = _pair()
    angle, eta = 0.5 * RISE, -1e-7
    q = float(pair.lift.many(angle, 0)[0, 0])
    delta, lever, *_ = main.many(pair.lift, np.array([angle]), np.array([eta]))
    offset = complex(main.pose(np.exp, q + eta)[0] - main.pose(np.exp, q)[0])
    slant = abs(float(lever[0])) / abs(main.arm)
    readings = (Reading("squares of ex and ey", abs(offset)),
                Reading("squares, and the part along the common normal, |e| cos(alpha)", abs(offset) * slant))
    return Answer(float(delta[0]), readings, sqrt(abs(offset.real + offset.imag)))


def _approach() -> Answer:
    """Speed of approach along the normal, m/s, on touching at the steepest place of the rise, play closing at 0.5
    rad/s."""
    pair, main = _pair()
    angle, closing, omega = 0.5 * RISE, -0.5, 20.0 * pi
    s0, s1, s2 = (float(v[0]) for v in pair.lift.many(angle, 2))
    step = 1e-6
    before, after = (
        float(main.many(pair.lift, np.array([angle + k * omega * step]), np.array([k * closing * step]))[0][0])
        for k in (-1, 1)
    )
    centre, slope = main.pose(np.exp, s0)
    _, along, _ = main.pitch(np.exp, 0.0, s0, s1, s2)
    normal = 1j * along / abs(along)
    normal = normal if (np.conj(normal) * centre).real > 0.0 else -normal
    roller = slope * (s1 * omega + closing)
    cam = 1j * omega * (centre - ROLLER * normal)
    difference = float((np.conj(normal) * (cam - roller)).real)
    total = float((np.conj(normal) * (cam + roller)).real)
    return Answer((after - before) / (2.0 * step), (Reading("velocities subtracted", difference),), total)


def _tangent() -> Answer:
    """Stiffness, N/m, of the cylinder joint of sum S = Rb + R at 0.1 mm of penetration; (9) is per nothing."""
    modulus, total, depth = _modulus(), BASE + ROLLER, 1e-4
    law, h = LiuCylinder(modulus, LENGTH, total), 1e-9
    ours = (law.force(depth + h, 0.0) - law.force(depth - h, 0.0)) / (2.0 * h)
    inside = 2.0 * depth * (3.0 * total + 2.0 * depth) ** 2
    corrected = 0.125 * pi * modulus * LENGTH * sqrt(inside / (total + depth) ** 3)
    printed = PrintedStiffness(modulus, total, 1.0).force(depth, 0.0) / depth
    return Answer(ours, (Reading("cube of (Rb + R + delta) and the contact length L", corrected),), printed)


def _exponent() -> Answer:
    """Exponent of the force over the penetration that (8) gives with (9) and n = 1.5."""

    def slope(power: float) -> float:
        law = PrintedStiffness(_modulus(), BASE + ROLLER, power)
        return log(law.force(1.01e-6, 0.0) / law.force(1e-6, 0.0)) / log(1.01)

    return Answer(slope(1.5), (Reading("n = 1, for K grows with the root of the penetration already", slope(1.0)),))


def _restitution() -> Answer:
    """Restitution that the damping (11) makes of a coefficient of 0.9, by bisection."""
    wanted, low, high = hybrid_factor(0.9), 0.5, 0.999
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if exact_factor(middle) > wanted else (low, middle)
    return Answer(high)


def _triangle() -> tuple[float, float, float, float, float]:
    """Distances, m, of the roller's centre on its cam and beside it from the cam axis, their own, and the cosines of
    the angles at the axis and at the first centre; play 0.1 mm, at the steepest place."""
    pair, main = _pair()
    q = float(pair.lift.many(0.5 * RISE, 0)[0, 0])
    one, two = (complex(main.pose(np.exp, q + eta)[0]) for eta in (0.0, pair.play))
    apart = two - one
    at_axis = (one.conjugate() * two).real / abs(one) / abs(two)
    at_centre = -(one.conjugate() * apart).real / abs(one) / abs(apart)
    return abs(one), abs(two), abs(apart), at_axis, at_centre


def _angle_of_24() -> Answer:
    first, second, apart, at_axis, _ = _triangle()
    top = first**2 + second**2 - apart**2
    return Answer(at_axis, (Reading("2 l1 l11 below the line", top / (2.0 * first * second)),),
                  top / (2.0 * ARM * second))


def _distance_of_26() -> Answer:
    first, second, apart, _, at_centre = _triangle()
    square = first**2 + apart**2 - 2.0 * apart * first * at_centre
    return Answer(second, (Reading("its square root", sqrt(square)),), square)


def _conversions(low: float, high: float) -> Answer:
    """Drive conversions between two cam angles, deg, of the second turn, clearance 0.1 mm."""
    run = impact_run()
    places = [degrees(run.problem.speed * hit.time) - 360.0 for hit in run.conversions]
    return Answer(float(sum(low < place < high for place in places)))


def _growth(small: float, large: float) -> Answer:
    ratios = {contact: peak(contact, large) / peak(contact, small) for contact in CONTACTS}
    return Answer(ratios[LINE], tuple(Reading(contact, ratios[contact], slip=False) for contact in OTHERS))


def _trapezoid(quantity: Quantity) -> Answer:
    """Peak with the modified trapezoid over that with the polynomial, clearance 0.01 mm."""
    ratios = {
        contact: peak(contact, 0.01, "modified-trapezoid", quantity) / peak(contact, 0.01, "3-4-5", quantity)
        for contact in CONTACTS
    }
    return Answer(ratios[LINE], tuple(Reading(contact, ratios[contact], slip=False) for contact in OTHERS))


def _amplification() -> Answer:
    """Amplification of the ideal peak by the play of 0.01 mm: modified trapezoid over polynomial."""
    law = "modified-trapezoid"

    def ratio(contact: str) -> float:
        runs = {name: impact_run(contact, 0.01, name) for name in (law, "3-4-5")}
        one, other = (peak(contact, 0.01, name) / run.machine.lift.peaks[2] for name, run in runs.items())
        return one / other

    return Answer(ratio(LINE), tuple(Reading(contact, ratio(contact), slip=False) for contact in OTHERS))


def _speed_change() -> Answer:
    run = impact_run()
    trace = run.trace.flat()
    first = trace.time <= run.problem.period
    return Answer(float(np.abs(trace.speed[first]).max()) / (run.machine.lift.peaks[1] * run.problem.speed))


def _deviation() -> Answer:
    """Largest deviation from the ideal motion over the swing, 1."""
    run = impact_run()
    trace = run.trace.flat()
    return Answer(float(np.abs(trace.deviation[trace.time <= run.problem.period]).max()) / SWING)


def _gap() -> Answer:
    """Least gap along the normal, mm, that a chord of 0.1 mm leaves at either roller while it rises or returns."""
    pair, _ = _pair()
    angles = np.linspace(0.0, 2.0 * RISE, 2801)
    gaps = (-side.many(pair.lift, angles, np.full(angles.shape, at))[0] for side, at in zip(pair.sides, (pair.play, 0)))
    return Answer(1e3 * min(float(gap.min()) for gap in gaps))


_STIFF = (
    "Only a contact as stiff as a line comes near; free flight after the drive conversion makes the force grow as "
    "c^0.8 (6.3 per decade) at most for n = 1.5, as c^(2/3) (4.6) for n = 1."
)

SOURCE = Source(
    "S5",
    "conjugate-clearance",
    "Clearance and impact of conjugate cams",
    "Journal of Tiangong University 2025, doi 10.3969/j.issn.1671-024x.2025.05.013",
    (
        Entry("geometry", "Table 1", "least base radius, mm, of the printed centre distance, arm and roller", "79.5",
              "mm", _least_base, "The roller's centre cannot come nearer the cam axis than 205 - 90 = 115 mm; "
              "79.5 + 20 = 99.5. (Table 1 prints 7.950 m.) It would do with an arm above 105.5 or a "
              "centre distance below 189.5 mm.", "<"),
        Entry("gyration", "Table 1", "radius of gyration of the follower, below the centre distance", "0.205", "m",
              _gyration, "0.0686 kg cannot have 0.140 kg m2 within the machine.", "<"),
        Entry("clearance", "Section 2.1.1", "gap along the common normal of a clearance of 0.1 mm", "0.1", "mm", _gap,
              "The clearance is defined as a chord between two roller centres; the gap is its part along the normal.",
              within=1e-4),
        Entry("(5)", "Equation (5)", "penetration of the roller, turned 1e-7 rad into the cam", "", "m", _penetration,
              "|e| is the chord; it overstates the penetration by 1/cos(alpha), 19 % in this mechanism."),
        Entry("(7)", "Equation (7)", "speed of approach along the normal", "", "m/s", _approach,
              "A relative velocity is a difference."),
        Entry("(8) n", "Equations (8), (9)", "exponent of the elastic force over the penetration", "1.5", "1",
              _exponent, within=0.01),
        Entry("(9)", "Equation (9)", "contact stiffness at 0.1 mm", "", "N/m", _tangent,
              "The unit of the printed one is Pa m. It is the tangent of a conformal cylinder joint; between cam and "
              "roller the sum of radii in it is wrong as well, a line contact by Hertz is right."),
        Entry("(10)", "Equation (10), Table 2", "contact modulus", "", "Pa",
              lambda: Answer(_modulus(), (), 1.0 / (2.0 * (1.0 - 0.28**2) / 207e9))),
        Entry("(11)", "Equation (11)", "damping factor of a restitution of 0.9", "", "1",
              lambda: Answer(ImpactDamping(0.9).factor, (), 0.75 * (1.0 - 0.9**2) * exp(2.0 * (1.0 - 0.9)))),
        Entry("restitution", "Table 2", "restitution that (11) makes", "0.9", "1", _restitution,
              "0.8959; the factor that makes 0.9 exactly is `exact_restitution`."),
        Entry("(24)", "Equation (24)", "cosine of the angle theta_11 at the cam axis", "", "1", _angle_of_24,
              "'l' is nowhere defined; it is read as the arm here."),
        Entry("(26)", "Equation (26)", "distance l_31 of the roller's centre", "", "m", _distance_of_26),
        Entry("conversions rise", "Section 3.1", "drive conversions in the rise", "1", "1",
              partial(_conversions, 5.0, 69.5), "Another contact takes up the play as the rise begins, at 2 degrees."),
        Entry("conversions return", "Section 3.1", "drive conversions in the return", "1", "1",
              partial(_conversions, 75.0, 139.5)),
        Entry("fixed step", "Fig. 10", "peak acceleration by Runge-Kutta in steps of 1e-5 s over that by events", "",
              "1", _fixed_peak, "The approach speed is latched up to a step late, so the method is of order 1 whatever "
              "its formula: good enough here.", within=5e-3, slow=True),
        Entry("displacement", "Fig. 11", "deviation from the ideal motion over the swing: 'not evident'", "0.01", "1",
              _deviation, comparison="<"),
        Entry("velocity", "Fig. 11", "peak speed over that without clearance: 'not evident'", "1", "1", _speed_change,
              within=0.05),
        Entry("growth-0.1", "Section 3.2", "peak acceleration, 0.1 over 0.01 mm clearance, 'about 2 times'", "2", "1",
              partial(_growth, 0.01, 0.1), _STIFF, slow=True),
        Entry("growth-1", "Section 3.2", "peak acceleration, 1 over 0.1 mm clearance, '6 times'", "6", "1",
              partial(_growth, 0.1, 1.0), f"{_STIFF} At 1 mm the motion is not periodic: the peak of a single turn "
              "scatters by 20 %, so that no such figure is a result: over six turns the mean "
              "of the last five is some 4 times, (9) with n = 1 some 5, and the largest 4.5 and 5.7.", slow=True),
        Entry("trapezoid acceleration", "Section 3.3", "peak acceleration, modified trapezoid over polynomial, 0.01 mm",
              "1", "1", partial(_trapezoid, "acceleration"), "With a line contact the impact of so small a play stays "
              "below the rigid peak, and that of the trapezoid is 15 % lower; a softer contact makes the statement "
              "true.", ">", slow=True),
        Entry("trapezoid force", "Section 3.3", "peak force of the main cam, modified trapezoid over polynomial", "1",
              "1", partial(_trapezoid, "force_main"), "As the acceleration.", ">", slow=True),
        Entry("trapezoid amplification", "Section 3.3", "peak over ideal peak, modified trapezoid over polynomial", "1",
              "1", _amplification, "What the paper means holds: the trapezoid's jerk at mid-stroke is 2.05 times as "
              "large.", ">", slow=True),
    ),
)  # fmt: skip
