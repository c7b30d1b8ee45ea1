"""S4: Figs. 5 to 7, the torsional frequencies over the turn and the load plate's acceleration over turn and speed."""

from __future__ import annotations

from math import pi

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Chart, Limit, Mark, Panel, Series
from camgeom.drawing.sheet import number
from camgeom.dynamics.indexing.drive import squared_frequencies
from camgeom.dynamics.indexing.system import DriveResponse
from camgeom.maths import Floats
from camgeom.validation.figures import SourceFigure
from camgeom.validation.indexing import LAW_NAMES, LOWEST, RPM, drive_study, torsion

SPEEDS = (200.0, 655.64, 1639.10)
"""r/min, a low one that is not printed and the bounds of the classes"""
PRINTED = ((200.0, 38.9), (655.64, 427.5), (1639.10, 2852.4), (3000.0, 11255.4))
"""r/min, of which the first and the last are not printed, and the peaks of the text, rad/s²"""
SWEPT = np.linspace(200.0, 3000.0, 57)
"""r/min"""
TURN = np.linspace(0.0, 2.0 * pi, 1441)
ACCELERATION = "Load acceleration"


def frequencies() -> tuple[Block, ...]:
    """Fig. 5, the three torsional modes; dashed as they come without K12 tau'^2, which is missing in (25)."""
    study = drive_study()
    modes = study.modes.torsional()
    theta, angle = study.modes.theta, np.degrees(study.modes.theta)
    slope = np.asarray(study.motion.jet(theta, 1)[1])
    without = np.array([_without(float(one)) for one in slope])
    panels = []
    for k, mode in enumerate(modes):
        lines = (Series("exact", angle, mode.frequency_hz()), Series("without K12 τ'²", angle, without[:, k]))
        marks = (Mark(180.0, LOWEST, f"printed {LOWEST} Hz"),) if k == 0 else ()
        panels.append(Panel(Axis(f"Torsional frequency {k + 1}", "Hz"), lines, marks=marks))
    return (Chart("Fig. 5: torsional frequencies of the drive held at each cam angle", CAM_ANGLE, tuple(panels)),)


def _without(slope: float) -> Floats:
    mass, stiffness = torsion(slope)
    stiffness[0, 0] -= drive_study().drive.contact_stiffness * slope**2
    return np.asarray(np.sqrt(squared_frequencies(mass, stiffness)) / (2.0 * pi))


def _turned(response: DriveResponse) -> Floats:
    """Load acceleration over the last turn of a response, rad/s²."""
    last = float(response.theta[-1])
    return np.asarray(response.at(last - 2.0 * pi + TURN * (1.0 - 1e-12), "load_acceleration")[0])


def accelerations() -> tuple[Block, ...]:
    """Fig. 6: a panel a speed, with every law; and the speeds overlaid, over the rigid peak's square of the speed."""
    angle = np.degrees(TURN)
    panels = tuple(
        Panel(Axis(f"{ACCELERATION}, {number(rpm)} r/min", "rad/s²"),
              tuple(Series(law, angle, _turned(drive_study(law, rpm).steady)) for law in LAW_NAMES))
        for rpm in SPEEDS
    )  # fmt: skip
    speeds = tuple(
        Series(f"{number(rpm)} r/min", angle, _turned(drive_study(rpm=rpm).steady) / (rpm * RPM) ** 2)
        for rpm in (*SPEEDS, PRINTED[-1][0])
    )
    rest = tuple(
        Series(f"{number(rpm)} r/min", angle, _turned(drive_study(rpm=rpm).start) / (rpm * RPM) ** 2)
        for rpm in (*SPEEDS, PRINTED[-1][0])
    )
    scaled = Axis(f"{ACCELERATION} over ω², periodic", "rad/rad²")
    begun = Axis(f"{ACCELERATION} over ω², first turn from rest", "rad/rad²")
    return (
        Chart("Fig. 6: acceleration of the load plate at three speeds, four laws", CAM_ANGLE, panels),
        Chart("The same of the modified trapezoid, speeds overlaid", CAM_ANGLE,
              (Panel(scaled, speeds, height=1.2), Panel(begun, rest, height=1.2))),
    )  # fmt: skip


def peaks() -> tuple[Block, ...]:
    """Fig. 7: peaks over the speed, with the printed ones and the bound that no motion goes below."""
    from camgeom.validation.indexing import INDEX, MOTION

    lines = []
    for law in LAW_NAMES:
        sweep = drive_study(law).over(SWEPT * RPM)
        lines.append(Series(law, SWEPT, sweep.peaks["load_acceleration"].magnitude))
    bound = 4.0 * INDEX * (SWEPT * RPM / MOTION) ** 2
    rpm, value = np.array(PRINTED).T
    lines += [Series("no motion below", SWEPT, bound), Series("printed", rpm, value, dots=True)]
    limits = tuple(Limit(speed, f"{number(speed)} r/min", vertical=True) for speed in SPEEDS[1:])
    panel = Panel(Axis("Peak load acceleration", "rad/s²", zero=True), tuple(lines), limits=limits, height=1.3)
    return (Chart("Fig. 7: peaks of the load plate's acceleration over the speed", Axis("Cam speed", "r/min"),
                  (panel,)),)  # fmt: skip


FIGURES = (SourceFigure("Fig. 5", frequencies), SourceFigure("Fig. 6", accelerations), SourceFigure("Fig. 7", peaks))
