"""S4: the elastic indexing drive with eleven degrees of freedom, its frequencies and the response of its load plate.

Damping, motion law and speeds are not printed; the drive of the shipped profile has the chosen ones. Where the paper
writes a dot for a derivative over the cam angle, ours is tau'.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from math import pi, radians, sqrt

import numpy as np

from camgeom.dynamics.indexing.drive import (
    TORSION,
    IndexingDrive,
    Term,
    assemble,
    contact_dyad,
    definiteness,
    squared_frequencies,
)
from camgeom.dynamics.indexing.modes import speed_classes
from camgeom.dynamics.indexing.study import IndexingStudy
from camgeom.dynamics.indexing.system import TorsionSystem
from camgeom.dynamics.linear.maps import step_maps
from camgeom.dynamics.linear.method import wilson
from camgeom.maths import Floats
from camgeom.mechanics.hertz import line_half_width
from camgeom.mechanics.material import STEEL, pair_compliance
from camgeom.mechanics.stiffness import Estimate
from camgeom.motion import LAWS
from camgeom.validation.entry import Answer, Entry, Reading, Source
from camgeom.validation.machine import machine

NAME = "globoidal_drive"
LAW_NAMES = ("modified-trapezoid", "modified-sine", "3-4-5", "cycloidal")
INDEX, MOTION = radians(45.0), radians(300.0)
LOWEST = 163.91
"""Hz, the printed first frequency"""
RPM = pi / 30.0


@cache
def drive_study(law: str = LAW_NAMES[0], rpm: float = 655.64) -> IndexingStudy:
    study = machine(NAME, ("motion.1.law", law), ("operation.speed", rpm)).indexing
    assert study is not None
    return study


def _drive() -> IndexingDrive:
    return drive_study().drive


def _steepest(law: str = LAW_NAMES[0]) -> float:
    """Largest slope tau' of the motion, rad/rad."""
    return LAWS[law].claims.vm * INDEX / MOTION


def torsion(slope: float) -> tuple[Floats, Floats]:
    """Mass and stiffness (3, 3) of the torsion at a slope, SI."""
    d = _drive()
    mass = d.matrix(d.inertia_terms(), TORSION)
    contact = np.array([-slope, 1.0, 0.0])
    return mass, d.matrix(d.spring_terms(), TORSION) + d.contact_stiffness * np.outer(contact, contact)


def _hertz(mass: Floats, stiffness: Floats) -> float:
    """Lowest natural frequency, Hz, of a stiffness that need not be symmetric."""
    squared = np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real
    return sqrt(float(squared.min())) / (2.0 * pi)


def _without_square(slope: float) -> float:
    """Lowest frequency, Hz, with K12 tau'^2 left out of the cam's stiffness but the coupling kept on both sides."""
    mass, stiffness = torsion(slope)
    stiffness[0, 0] -= _drive().contact_stiffness * slope**2
    return sqrt(float(squared_frequencies(mass, stiffness)[0])) / (2.0 * pi)


def _as_printed(slope: float) -> float:
    """Lowest frequency, Hz, of the stiffness as (25) prints it: triangular."""
    mass, stiffness = torsion(slope)
    stiffness[0, 0] -= _drive().contact_stiffness * slope**2
    stiffness[1, 0] = 0.0
    return _hertz(mass, stiffness)


def _first_frequency() -> Answer:
    readings = [Reading(f"exact, {law}", drive_study(law).modes.lowest_hz()[0]) for law in LAW_NAMES[1:]]
    readings += [Reading(f"K12 tau'^2 left out, {law}", _without_square(_steepest(law))) for law in LAW_NAMES]
    readings.append(Reading("(25) as printed", _as_printed(_steepest())))
    return Answer(drive_study().modes.lowest_hz()[0], tuple(readings))


def _stiffness_of_25() -> Answer:
    mass, stiffness = torsion(_steepest())
    corrected = Reading("K12 tau'^2 q1 in its first row, -K12 tau' q1 in its second", _hertz(mass, stiffness))
    return Answer(drive_study().modes.lowest_hz()[0], (corrected,), _as_printed(_steepest()))


def _critical() -> Answer:
    return Answer(drive_study().classes.first_critical_rpm)


def _class_bound(which: int, lowest: float) -> Answer:
    classes = speed_classes(lowest)
    return Answer((classes.first_critical_rpm, classes.low_rpm, classes.medium_rpm)[which])


def _peak(law: str, rpm: float) -> float:
    """Largest acceleration of the load plate in the steady state, rad/s²."""
    return float(drive_study(law, rpm).steady.peak("load_acceleration").magnitude[0])


def _plate(rpm: float) -> Answer:
    readings = tuple(Reading(f"with {law}", _peak(law, rpm)) for law in LAW_NAMES[1:])
    return Answer(_peak(LAW_NAMES[0], rpm), readings)


def _growth() -> Answer:
    def ratio(law: str) -> float:
        return _peak(law, 1639.10) / _peak(law, 655.64)

    readings = (*(Reading(f"with {law}", ratio(law)) for law in LAW_NAMES[1:]), Reading("square of the speeds", 6.25))
    return Answer(ratio(LAW_NAMES[0]), readings)


def _least_possible(rpm: float) -> Answer:
    """Peak acceleration below which no rest-to-rest motion of 45 degrees in 300 can stay, rad/s²."""
    return Answer(4.0 * INDEX * (rpm * RPM / MOTION) ** 2)


def _lateral() -> Answer:
    """Smallest eigenvalue of the output shaft's bending block, scaled to a unit diagonal."""
    block = ("x2", "x3")
    found = next(item for item in drive_study().modes.indefinite if item.block == block)
    d = _drive()
    mass = d.matrix(d.inertia_terms(), block)

    def scaled(first: float, second: float, cross: float) -> float:
        wrong = definiteness(block, mass, np.array([[first, cross], [cross, second]]))
        return 1.0 - abs(cross) / sqrt(first * second) if wrong is None else wrong.scaled_eigenvalue

    k22, k33, k23 = d.turret_bending, d.load_bending, d.cross_bending
    readings = (Reading("K33 = 6.3888e8", scaled(k22, 10 * k33, k23)), Reading("K23 = 8.4679e7", scaled(k22, k33,
                                                                                                       k23 / 10)))
    return Answer(found.scaled_eigenvalue, readings)


def _lowest_three() -> Answer:
    """The third torsional frequency against the lowest of the others, Hz."""
    modes = drive_study().modes
    others = [mode.frequency_hz().min() for mode in modes.modes if mode.block != TORSION and mode.oscillates]
    return Answer(float(modes.torsional()[2].frequency_hz().max()), (), float(min(others)))


def _wilson_bound() -> Answer:
    """Least theta with which Wilson's method lets no mode grow in steps far longer than its period, by bisection."""
    undamped = replace(_drive(), input_damping=0.0, output_damping=0.0, contact_damping=0.0)
    dwell, step = np.array([radians(335.0)]), np.array([0.1])
    system = TorsionSystem(undamped, drive_study().motion, np.array([1e-4]))

    def grows(theta: float) -> bool:
        maps = step_maps(wilson(theta), system, dwell, step)[0, 0, :, :-1]
        return bool(np.abs(np.linalg.eigvals(maps)).max() > 1.0 + 1e-9)

    low, high = 1.3, 1.45
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if grows(middle) else (low, middle)
    return Answer(high)


def _contact() -> Answer:
    """Mean stiffness of cam against turret, N m/rad, of the profile's own flanks under its own torque."""
    duty = machine(NAME).turret_duty
    assert duty is not None
    kinds: tuple[tuple[Estimate, str], ...] = (
        ("secant", "half-space, load over approach"), ("chord", "arcs within the contact width, as (1) to (3)")
    )
    readings = tuple(Reading(what, float(np.mean(duty.stiffness_table(kind)))) for kind, what in kinds)
    return Answer(float(np.mean(duty.stiffness_table("half-space"))), readings)


STATE = {name: 0.3 + 0.1 * k for k, name in enumerate(
    ("theta1", "theta2", "theta3", "x1", "y1", "z1", "x2", "y2", "x3", "y3", "z23"))}
"""a displacement or speed of every coordinate, for energies"""


def _energy(terms: tuple[Term, ...], names: str) -> float:
    """Energy 1/2 x K x of the terms that hang on the named coordinates alone, at `STATE`."""
    kept = names.split()
    own = [term for term in terms if all(name in kept for name, _ in (*term.g, *term.h))]
    x = np.array([STATE[name] for name in kept])
    return 0.5 * float(x @ assemble(own, kept) @ x)


def _energies(which: str) -> Answer:
    """An energy of (6) to (16) as printed, by the drive's own terms, and corrected."""
    d, s = _drive(), STATE
    moving, springs = d.inertia_terms(), d.spring_terms()
    both = d.turret_mass + d.load_mass
    cam = d.cam_inertia * s["theta1"] ** 2 + d.cam_mass * (s["y1"] ** 2 + s["z1"] ** 2)
    if which == "(6)":
        ours = _energy(moving, "theta1 x1 y1 z1")
        return Answer(ours, (Reading("x1'^2 for x1'^3", 0.5 * (cam + d.cam_mass * s["x1"] ** 2)),),
                      0.5 * (cam + d.cam_mass * s["x1"] ** 3))
    if which == "(7)":
        rest = d.turret_inertia * s["theta2"] ** 2 + d.turret_mass * (s["x2"] ** 2 + s["y2"] ** 2)
        return Answer(_energy(moving, "theta2 x2 y2 z23"), (), 0.5 * (rest + both * s["z23"] ** 2))
    if which == "(8)":
        rest = d.load_inertia * s["theta3"] ** 2 + d.load_mass * (s["x3"] ** 2 + s["y3"] ** 2)
        return Answer(_energy(moving, "theta3 x3 y3"), (), 0.5 * rest)
    if which == "(9)":
        rest = d.cam_bending_x * s["x1"] ** 2 + d.cam_axial_y * s["y1"] ** 2 + d.cam_bending_z * s["z1"] ** 2
        return Answer(_energy(springs, "theta1 x1 y1 z1"), (), 0.5 * (d.input_stiffness * s["theta1"] ** 2 + rest))
    if which == "(10)":
        return Answer(_energy(springs, "z23"), (Reading("Kz23 for K23", 0.5 * d.output_axial * s["z23"] ** 2),),
                      0.5 * d.cross_bending * s["z23"] ** 2)
    if which == "(11)":
        return Answer(_energy(springs, "theta2 theta3"), (),
                      0.5 * d.output_stiffness * (s["theta3"] - s["theta2"]) ** 2)

    def bent(one: float, two: float, cross: float) -> float:
        return 0.5 * d.load_bending * two**2 + cross * one * two + 0.5 * d.turret_bending * one**2

    if which == "(12)":
        return Answer(_energy(springs, "x2 x3"), (), bent(s["x2"], s["x3"], d.cross_bending))
    if which == "(13)":
        # K21 and K12 of the bending are nowhere defined; K12 is the contact's.
        wrong = (0.5 * d.load_bending * s["y1"] ** 2 + d.contact_stiffness * s["y1"] * s["y2"]
                 + 0.5 * d.turret_bending * s["y2"] ** 2)
        right = bent(s["y2"], s["y3"], d.cross_bending)
        return Answer(_energy(springs, "y2 y3"), (Reading("y3 for y1 and K23 for K21, K12", right),), wrong)
    raise ValueError(which)


def _losses_of_16() -> Answer:
    """(16) with a friction of the turret that differs from the contact's damping."""
    d, s = replace(_drive(), turret_friction=0.7), STATE
    slip = 0.5 * d.output_damping * (s["theta3"] - s["theta2"]) ** 2
    ours = _energy(d.damping_terms(), "theta2 theta3 z23")
    return Answer(ours, (Reading("Cf2 for C12", slip + 0.5 * d.turret_friction * s["theta2"] ** 2),),
                  slip + 0.5 * d.contact_damping * s["theta2"] ** 2)


def _losses_of_15() -> Answer:
    """(15) with a friction of the cam and damping of its bending, the input at rest."""
    d, s = replace(_drive(), cam_friction=0.7, cam_damping_x=11.0, cam_damping_y=13.0, cam_damping_z=17.0), STATE
    printed = (d.input_damping + d.cam_friction) * s["theta1"] ** 2 + d.cam_damping_x * s["x1"] ** 2
    printed += d.cam_damping_y * s["y1"] ** 2 + d.cam_damping_z * s["z1"] ** 2
    return Answer(_energy(d.damping_terms(), "theta1 x1 y1 z1"), (), 0.5 * printed)


def _losses_of_17() -> Answer:
    """(17) at the steepest place of the motion."""
    d, names, slope = _drive(), TORSION, _steepest()
    x = np.array([STATE[name] for name in names])
    ours = 0.5 * d.contact_damping * float(x @ contact_dyad(np.array([slope]), names)[0] @ x)
    return Answer(ours, (), 0.5 * d.contact_damping * (STATE["theta2"] - slope * STATE["theta1"]) ** 2)


def _chain() -> Answer:
    """Turret speed, rad/s, at mid-stroke and 1000 r/min: (19) prints d tau / d theta for it."""
    study = drive_study(rpm=1000.0)
    slope = float(study.motion.jet(np.array([pi]), 1)[1][0])
    turned = study.steady.system.rates(np.array([[pi]]))[0][0, 0] * slope
    return Answer(float(turned), (Reading("tau'(theta1) times the cam's speed", slope * 1000.0 * RPM),), slope)


def _half_width() -> Answer:
    """Half-width, mm, of a line contact: load 2000 N over 24 mm, radii 16 and 60 mm, steel."""
    load, length, curvature = 2000.0, 24.0, 1.0 / 16.0 + 1.0 / 60.0
    pair = float(pair_compliance(STEEL, STEEL))

    def width(force: float) -> float:
        return sqrt(4.0 * force * pair / (pi * length * curvature))

    ours = float(line_half_width(load / length, curvature, pair))
    return Answer(ours, (Reading("P the whole load, not that per length", width(load)),), width(load / length))


_SPEEDS = "Speeds, law and damping of the figure are not printed in the text."
_BOUND = (
    "4 delta/theta_m^2 omega^2 bounds every motion from rest to rest: 45 degrees in 300 cannot be done with the "
    "printed peak at this speed."
)
_FIRST = (
    "The least frequency has the largest slope of the law. K12 tau'^2 is missing in (25); without it, the modified "
    "trapezoid comes within 1.1 %, and no reading closer without tuning."
)

SOURCE = Source(
    "S4",
    "indexing-drive",
    "Globoidal indexing drive with eleven degrees of freedom",
    "Light Industry Machinery 2022, doi 10.3969/j.issn.1005-2895.2022.03.006",
    (
        Entry("(4)", "Equation (4)", "half-width of the contact of cam and roller", "", "mm", _half_width,
              "P is defined as force per length, and (4) divides by the length once more; b is the half-width."),
        *(
            Entry(item, f"Equation {item}", says, "", "J", partial(_energies, item), reason)
            for item, says, reason in (
                ("(6)", "kinetic energy of the cam", ""), ("(7)", "kinetic energy of the turret", ""),
                ("(8)", "kinetic energy of the load plate", ""), ("(9)", "potential energy of the input shaft", ""),
                ("(10)", "potential energy of the output shaft along its axis",
                 "K23 is the coupling of the bending."),
                ("(11)", "potential energy of the output shaft in torsion", ""),
                ("(12)", "bending energy of the output shaft along x", ""),
                ("(13)", "bending energy of the output shaft along y", "(12) has them right."),
            )
        ),
        Entry("(15)", "Equation (15)", "losses of the input shaft", "", "W", _losses_of_15),
        Entry("(16)", "Equation (16)", "losses of the output shaft", "", "W", _losses_of_16,
              "The turret's own friction is Cf2 in (25); C12 is the contact's, which (17) has."),
        Entry("(17)", "Equation (17)", "losses of the contact", "", "W", _losses_of_17,
              "With d tau/d t of the turning cam, tau' theta1'."),
        Entry("(19)", "Equation (19)", "turret speed at mid-stroke, 1000 r/min", "", "rad/s", _chain,
              "Dot and prime are both printed as a dot; (25) holds for d tau/d theta."),
        Entry("(25)", "Equation (25)", "first frequency at mid-stroke of the printed equations", "", "Hz",
              _stiffness_of_25, "As printed the stiffness is triangular, its frequencies are the same at every cam "
              "angle, and Fig. 5 could not be. The signs of J1 theta.. and of Cf2 (printed C12), and Cth3 for Cth2, "
              "are wrong as well."),
        Entry("K12", "Section 3", "contact stiffness; of the drive in the profile, under its own torque",
              "1.2329e6", "N m/rad", _contact, "Load, radii and lengths are not printed, nor the roller's "
              "place on the turret that makes N m/rad of N/m: the printed value is taken as it stands."),
        Entry("frequency", "Fig. 5", "lowest natural frequency", "163.91", "Hz", _first_frequency, _FIRST),
        Entry("n1", "Section 3.1", "first critical speed of 163.91 Hz", "9834.60", "r/min",
              partial(_class_bound, 0, LOWEST)),
        Entry("n2", "Section 3.1", "bound of low and medium speed, n1/15", "655.64", "r/min",
              partial(_class_bound, 1, LOWEST)),
        Entry("n3", "Section 3.1", "bound of medium and high speed, n1/6", "1639.10", "r/min",
              partial(_class_bound, 2, LOWEST), "The line of n2 is lost: n1/6 stands below lambda = 15."),
        Entry("n1 of the drive", "Section 3.1", "first critical speed of the drive", "9834.60", "r/min", _critical,
              "Follows the lowest frequency, 245.69 Hz."),
        Entry("torsion first", "Section 3.1", "third torsional frequency below all others", "", "Hz", _lowest_three,
              "The eight others begin at 652.8 Hz, bending of the input shaft.", "<"),
        Entry("lateral", "Section 3", "least eigenvalue of the output shaft's bending stiffness, scaled", "0", "1",
              _lateral, "K22 K33 < K23^2: no shaft has such a stiffness; one bending mode diverges with 5061.7 1/s. "
              "K33 > 2.4463e8 or |K23| < 4.3275e8 N/m would do.", ">"),
        Entry("plate-low", "Section 3.2", "load plate's peak acceleration at the lowest speed, 200 r/min", "38.9",
              "rad/s2", partial(_plate, 200.0), _SPEEDS),
        Entry("plate-655", "Section 3.2", "load plate's peak acceleration at 655.64 r/min", "427.5", "rad/s2",
              partial(_plate, 655.64), _SPEEDS),
        Entry("plate-1639", "Section 3.2", "load plate's peak acceleration at 1639.10 r/min", "2852.4", "rad/s2",
              partial(_plate, 1639.10), _SPEEDS),
        Entry("plate-high", "Section 3.2", "load plate's peak acceleration at the highest speed, 3000 r/min", "11255.4",
              "rad/s2", partial(_plate, 3000.0), _SPEEDS),
        Entry("plate-655 possible", "Section 3.2", "peak that no motion of 45 in 300 degrees undercuts, 655.64 r/min",
              "427.5", "rad/s2", partial(_least_possible, 655.64), _BOUND, "<"),
        Entry("plate-1639 possible", "Section 3.2", "peak that no motion of 45 in 300 degrees undercuts, 1639.10 r/min",
              "2852.4", "rad/s2", partial(_least_possible, 1639.10), _BOUND, "<"),
        Entry("growth", "Section 3.2", "peak at 1639.10 over that at 655.64 r/min", "6.672", "1", _growth,
              "Mostly the square of the speed. The four printed peaks lie on one curve, as if a factor of 0.50 to 0.65 "
              "were missing in all."),
        Entry("rising", "Section 4", "the peak rises with the speed: 3000 over 200 r/min", "1", "1",
              lambda: Answer(_peak(LAW_NAMES[0], 3000.0) / _peak(LAW_NAMES[0], 200.0)), comparison=">"),
        Entry("wilson", "Section 3", "theta from which Wilson's method is stable at any step", "1.37", "1",
              _wilson_bound, "(1 + sqrt 3)/2 = 1.3660."),
    ),
)  # fmt: skip
