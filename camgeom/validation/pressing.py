"""S2: the constant-width cam of a pressing mechanism, its profile in polar form and its simulated motion.

The paper's polar angle runs the other way round than our cam turns: y is mirrored.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from math import pi, radians

import numpy as np

from camgeom.maths import Floats
from camgeom.validation.entry import Answer, Entry, Reading, Source
from camgeom.validation.machine import machine

NAME = "constant_width_press"
BASE, STROKE, RISE = 40.0, 30.0, radians(140.0)
WIDTH = 2.0 * BASE + STROKE
PHI = np.linspace(0.0, RISE, 281)[1:-1]
"""cam angles of the rise, rad"""
Form = Callable[[], Floats]


def _jet(phi: Floats = PHI) -> Floats:
    return machine(NAME).mechanism.program.jet(phi, 2)


def _points(phi: Floats) -> Floats:
    """Points (2, n) of the cam's profile at cam angles, in the paper's axes, mm."""
    (outline,) = machine(NAME).mechanism.outlines.values()
    return np.asarray(outline.curve(phi).points * np.array([[1.0], [-1.0]]))


def _polar(phi: Floats) -> Floats:
    """Polar angle, rad, from 0 to one turn."""
    x, y = _points(phi)
    return np.asarray(np.mod(np.arctan2(y, x), 2.0 * pi))


def _compared(ours: Form, printed: Form, corrected: tuple[tuple[str, Form], ...] = ()) -> Answer:
    """Both forms where they differ most; a corrected form is as good as its largest deviation anywhere."""
    exact, given = ours(), printed()
    at = int(np.argmax(np.abs(given - exact)))
    readings = (Reading(what, float(exact[at] + np.abs(form() - exact).max())) for what, form in corrected)
    return Answer(float(exact[at]), tuple(readings), float(given[at]))


def _rise_angle(sign: float) -> Floats:
    """Polar angle of the rise by (5), with a sign before the second term of the denominator."""
    s, slope, _ = _jet()
    top = (BASE + s) * np.sin(PHI) + slope * np.sin(pi / 2 - PHI)
    below = (BASE + s) * np.cos(PHI) + sign * slope * np.cos(pi / 2 - PHI)
    return np.asarray(np.mod(np.arctan2(top, below), 2.0 * pi))


def _rise_radius() -> Floats:
    s, slope, _ = _jet()
    angle = _polar(PHI) - PHI
    return np.asarray((BASE + s) * np.cos(angle) + slope * np.cos(pi / 2 - angle))


def _return_angle(sign: float) -> Floats:
    """Polar angle of the return by (11), with the printed sign of the arc tangent or the other, from pi to 2 pi."""
    x, y = _points(PHI)
    slope = (y - WIDTH * np.sin(PHI)) / (x - WIDTH * np.cos(PHI))
    return np.asarray(pi + np.mod(sign * np.arctan(slope), pi))


def _return_radius() -> Floats:
    x, y = _points(PHI)
    away = _polar(PHI + pi)
    return np.asarray(np.hypot(x, y) * np.cos(away - np.arctan2(y, x)) + WIDTH * np.cos(PHI + pi - away))


def _return_lift() -> Floats:
    """Lift of the return by (15), from the profile's own polar radius and angle."""
    return np.asarray(np.hypot(*_points(PHI + pi)) * np.cos(pi + PHI - _polar(PHI + pi)) - BASE)


def _harmonic(order: int) -> Floats:
    """(14) as printed."""
    x = pi / RISE * PHI
    form = (1.0 - np.cos(x), pi / RISE * np.sin(x), (pi / RISE) ** 2 * np.cos(x))[order]
    return 0.5 * STROKE * form


def _radius_at(angle: float) -> Answer:
    return Answer(float(np.hypot(*_points(np.array([radians(angle)])))[0]))


@cache
def _simulated(clearance: float) -> tuple[float, float]:
    """Largest speed, mm/s, and acceleration, m/s², of the second turn with the published contact; play in mm."""
    run = machine(NAME, ("follower.clearance", clearance)).impact
    assert run is not None
    trace, period = run.trace.flat(), run.problem.period
    speed = 1e3 * float(np.abs(trace.speed[trace.time >= period]).max())
    return speed, run.peak("acceleration", period).value


def _peak(order: int) -> float:
    """Peak velocity, mm/s, or acceleration, m/s², of the motion without play."""
    value = abs(machine(NAME).mechanism.program.peak(order).value) * (2.0 * pi) ** order
    return value if order == 1 else 1e-3 * value


def _with_contact(order: int) -> Answer:
    readings = tuple(Reading(f"simulated, play {c:g} mm", _simulated(c)[order - 1]) for c in (0.001, 0.005, 0.02))
    return Answer(_peak(order), readings)


def _dwell_share() -> Answer:
    """Share of the turn, %, over which the frame is held down."""
    middles = 2.0 * pi * (np.arange(3600) + 0.5) / 3600
    return Answer(100.0 * float(np.mean(_jet(middles)[0] > STROKE - 1e-9)))


SOURCE = Source(
    "S2",
    "pressing",
    "Constant-width cam of a multi-position pressing mechanism",
    "Light Industry Machinery 2014, doi 10.3969/j.issn.1005-2895.2014.02.011",
    (
        Entry("(1)-(4)", "Equations (1) to (4)", "polar angle of the rise, its parts put into (1)", "", "rad",
              partial(_compared, lambda: _polar(PHI), partial(_rise_angle, -1.0))),
        Entry("(5) angle", "Equation (5)", "polar angle of the rise", "", "rad",
              partial(_compared, lambda: _polar(PHI), partial(_rise_angle, 1.0),
                      (("minus before ds/dphi cos(pi/2 - phi) in the denominator", partial(_rise_angle, -1.0)),)),
              "(1) subtracts K1K2 = ds/dphi cos(pi/2 - phi), (5) adds it."),
        Entry("(5) radius", "Equation (5)", "polar radius of the rise", "", "mm",
              partial(_compared, lambda: np.hypot(*_points(PHI)), _rise_radius)),
        Entry("(6) (11) angle", "Equations (6), (11)", "polar angle of the return", "", "rad",
              partial(_compared, lambda: _polar(PHI + pi), partial(_return_angle, -1.0),
                      (("theta_B = pi + arctan(...), no minus", partial(_return_angle, 1.0)),)),
              "B lies beyond the origin: both of its coordinates change sign, their quotient does not."),
        Entry("(7)-(11) radius", "Equations (7) to (11)", "polar radius of the return", "", "mm",
              partial(_compared, lambda: np.hypot(*_points(PHI + pi)), _return_radius)),
        Entry("(12)", "Equation (12)", "radius of the upper dwell, Rb + h", "70", "mm", partial(_radius_at, 160.0),
              "Stroke and base radius are not printed; 30 and 40 mm are used.", within=1e-9),
        Entry("(13)", "Equation (13)", "radius of the lower dwell, Rb", "40", "mm", partial(_radius_at, 340.0),
              within=1e-9),
        *(
            Entry(f"(14) {name}", "Equation (14)", f"{what} of the rise over the cam angle", "", unit,
                  partial(_compared, partial(lambda k: _jet()[k], k), partial(_harmonic, k)))
            for k, (name, what, unit) in enumerate(
                (("s", "lift", "mm"), ("ds", "first derivative", "mm"), ("dds", "second derivative", "mm")))
        ),
        Entry("(15)", "Equation (15)", "lift of the return from the profile", "", "mm",
              partial(_compared, lambda: _jet(PHI + pi)[0], _return_lift)),
        Entry("speed", "Section 3", "speed of the frame while it presses, simulated with contact", "120.341", "mm/s",
              partial(_with_contact, 1), "The stroke is not printed. The motion's own peak for 30 mm is 0.7 % higher, "
              "with contact 0.7 to 1.4 %; 29.79 mm would give the printed one.", slow=True),
        Entry("speed-least", "Section 1", "peak speed within the standard's 50 to 150 mm/s, lower bound", "50",
              "mm/s", lambda: Answer(_peak(1)), comparison=">"),
        Entry("speed-most", "Section 1", "peak speed within the standard's 50 to 150 mm/s, upper bound", "150",
              "mm/s", lambda: Answer(_peak(1)), comparison="<"),
        Entry("on-time", "Section 3", "time on contact, share of the cycle", "11", "%", _dwell_share,
              "The upper dwell, 40 of 360 degrees."),
        Entry("acceleration", "Section 3", "acceleration at the ends of the rise, simulated with contact", "1.251",
              "m/s2", partial(_with_contact, 2), "The jump of the motion's acceleration is 0.979 for 30 mm; what the "
              "contact adds depends on mass, play and the depth over which the damping ramps in, none of them printed.",
              slow=True),
    ),
)  # fmt: skip
