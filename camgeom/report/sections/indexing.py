"""Dynamics of an indexing drive: natural frequencies over the turn, Campbell diagram, response, sweep over speeds."""

from __future__ import annotations

from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import (
    CAM_ANGLE,
    Axis,
    Band,
    Block,
    Cell,
    Chart,
    Column,
    Limit,
    Mark,
    Panel,
    Series,
    Table,
    Text,
    quantities,
)
from camgeom.drawing.sheet import number
from camgeom.errors import ProfileError
from camgeom.maths import Floats
from camgeom.report.sections.motion import at_speed, mark, one_turn

if TYPE_CHECKING:
    from camgeom.dynamics.indexing.modes import Mode, Modes
    from camgeom.dynamics.indexing.study import IndexingStudy
    from camgeom.dynamics.indexing.system import DriveResponse

ORDERS = (1, 2, 3, 4, 6, 8, 12, 16, 24)
"""harmonics of the turn drawn in the Campbell diagram"""
HIGH = 3.0
"""modes up to this many times the lowest share one diagram; the others stand in the table"""
RAD = 30.0 / pi


def indexing(study: IndexingStudy) -> tuple[Block, ...]:
    """All about an indexing drive at its working speed; the sweep where one was asked for."""
    found, response, speed = study.modes, study.steady, study.speed * RAD
    blocks: list[Block] = [*frequencies(found), torsion(found), campbell_chart(found, speed), over_turn(response)]
    blocks.append(from_rest(study))
    left = in_dwell(study)
    blocks += [left] if left is not None else []
    if study.sweep_speeds is not None and study.sweep.answered.any():
        blocks.append(over_speeds(study, speed))
    return (*blocks, modes_table(found, speed), figures(study), balance(study), peaks(response))


def _low(found: Modes) -> list[Mode]:
    """Modes that oscillate, up to `HIGH` times the lowest of them."""
    kept = [mode for mode in found.modes if mode.oscillates]
    lowest = min(float(mode.frequency_hz().min()) for mode in kept)
    return [mode for mode in kept if float(mode.frequency_hz().min()) <= HIGH * lowest]


def frequencies(found: Modes) -> tuple[Chart, ...]:
    """Lateral frequencies over the cam angle among the lowest modes, those that agree all round on one line; none
    where there are none. The torsional ones have panels of their own."""
    angle = np.degrees(found.theta)
    together: list[tuple[list[str], Floats]] = []
    for mode in _low(found):
        hertz = mode.frequency_hz()
        same = next((names for names, line in together if np.allclose(line, hertz, rtol=1e-3)), None)
        if same is None:
            together.append(([mode.label], hertz))
        else:
            same.append(mode.label)
    together.sort(key=lambda item: float(item[1].min()))
    series, marks = [], []
    torsional = {mode.label for mode in found.torsional()}
    for k, (names, hertz) in enumerate(together, start=1):
        if torsional >= set(names):
            continue
        series.append(Series(f"f{_below(k)} {', '.join(dict.fromkeys(names))}", angle, hertz))
        low, high = float(hertz.min()), float(hertz.max())
        flat = high - low < 1e-3 * high
        i = len(angle) * k // (len(together) + 1) if flat else int(hertz.argmin() if k == 1 else hertz.argmax())
        marks.append(Mark(float(angle[i]), float(hertz[i]), f"{number(float(hertz[i]))} Hz"))
    if not series:
        return ()
    panel = Panel(Axis("Natural frequency", "Hz"), tuple(series), marks=tuple(marks), height=1.3)
    return (Chart("Lateral frequencies of the drive held at each cam angle", CAM_ANGLE, (panel,)),)


def torsion(found: Modes) -> Chart:
    """The three torsional modes over the cam angle, each on a scale of its own: they hang on the slope of the motion.
    """
    angle = np.degrees(found.theta)
    panels = tuple(
        _torsional(k, angle, mode.frequency_hz())
        for k, mode in enumerate(found.torsional(), 1)
        if mode.oscillates
    )
    return Chart("Torsional frequencies of the drive held at each cam angle", CAM_ANGLE, panels)


def _torsional(k: int, angle: Floats, hertz: Floats) -> Panel:
    least = int(hertz.argmin())
    marks = (Mark(float(angle[least]), float(hertz[least]), f"{number(float(hertz[least]))} Hz"),)
    return Panel(Axis(f"Torsional frequency {k}", "Hz"), (Series("frequency", angle, hertz),), marks=marks)


def _below(k: int) -> str:
    return str(k).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))


def campbell_chart(found: Modes, speed_rpm: float) -> Chart:
    """Bands of natural frequency over all cam angles, and the harmonics of the turn that excite them."""
    from camgeom.dynamics.indexing.modes import campbell

    low = _low(found)
    top = 1.15 * max(float(mode.frequency_hz().max()) for mode in low)
    reach = 2.0 * speed_rpm
    speeds = np.array([0.0, reach])
    data = campbell(found, speeds, max(ORDERS))
    lines = []
    for order in ORDERS:
        line = data.lines_hz[order - 1]
        share = min(1.0, top / float(line[-1]))  # a line ends where it leaves the diagram
        lines.append(Series(f"{order}×", speeds * share, line * share, 4))
    bands = []
    for k, mode in enumerate(low, start=1):
        hertz = mode.frequency_hz()
        lowest, highest = float(hertz.min()), float(hertz.max())
        name, style = f"f{_below(k)}", (k - 1) % 4
        if highest - lowest < 0.004 * top:  # too narrow for a band
            lines.append(Series(name, speeds, np.full(2, 0.5 * (lowest + highest)), style))
        else:
            bands.append(Band(name, speeds, np.full(2, lowest), np.full(2, highest), style))
    at = at_speed(speed_rpm)
    panel = Panel(Axis("Frequency", "Hz", 0.0, top), tuple(lines), tuple(bands), at, direct=True, height=1.4)
    caption = "Campbell diagram: bands of natural frequency over the turn, and harmonics of the cam speed"
    return Chart(caption, Axis("Cam speed", "r/min", 0.0, reach), (panel,))


def over_turn(response: DriveResponse) -> Chart:
    """Load acceleration against the rigid motion, load deviation, contact and input torque over one turn."""
    theta, angle = one_turn(response)
    acceleration = response.at(theta, "load_acceleration")[0]
    omega = float(response.speed[0])
    rigid = omega**2 * np.asarray(response.system.motion.jet(theta, 2)[2])
    i = int(np.abs(acceleration).argmax())
    panels = [
        Panel(
            Axis("Load acceleration", "rad/s²"),
            (Series("with vibration", angle, acceleration), Series("rigid", angle, rigid)),
            marks=(mark(float(angle[i]), float(acceleration[i])),),
        )
    ]
    rows = (
        ("load_deviation", Axis("Load deviation", "mrad"), 1e3),
        ("contact_torque", Axis("Contact torque", "N m"), 1.0),
        ("input_torque", Axis("Input torque", "N m"), 1.0),
    )
    for name, axis, factor in rows:
        panels.append(Panel(axis, (Series(axis.label, angle, factor * response.at(theta, name)[0]),)))
    caption = f"Periodic response over one turn at {number(omega * RAD)} r/min"
    return Chart(caption, CAM_ANGLE, tuple(panels))


def from_rest(study: IndexingStudy) -> Chart:
    """Load acceleration and the torques of both shafts in the first turn from rest, with the periodic ones."""
    panels = []
    for name, axis in (
        ("load_acceleration", Axis("Load acceleration", "rad/s²")),
        ("output_torque", Axis("Output torque", "N m")),
        ("input_torque", Axis("Input torque", "N m")),
    ):
        lines = []
        for words, response in (("first turn from rest", study.start), ("periodic", study.steady)):
            theta, angle = one_turn(response)
            lines.append(Series(words, angle, response.at(theta, name)[0]))
        panels.append(Panel(axis, tuple(lines)))
    return Chart(f"The first turn from rest at {number(study.speed * RAD)} r/min", CAM_ANGLE, tuple(panels))


def balance(study: IndexingStudy) -> Text:
    """How far the mean powers balance, and why they need not."""
    energy = study.energy
    error = f"{number(float(energy.error[0]))} of the largest of them"
    linear, varying = (number(float(power[0])) for power in (energy.linearisation, energy.varying))
    told = []
    if not study.exact:
        told.append(
            f"The linearised contact adds {linear} W: its torque also turns a cam that is wound up, T tau'' omega q1, "
            "and stores no energy of its own. With dynamics.exact_contact = true that power is zero."
        )
    if study.drive.contact_table:
        told.append(
            f"The contact's stiffness varies over the cam angle, which adds {varying} W: half its rate times the "
            "square of its stretch."
        )
    why = "with what the contact's model adds." if told else "the contact is exact, and of one stiffness."
    return Text((f"The mean powers of a turn balance to {error}{', ' if told else ': '}{why}", *told))


def in_dwell(study: IndexingStudy) -> Chart | None:
    """Deviation of the load in its hardest dwell against the band it has to settle in; None without a dwell."""
    try:
        left = study.residual
    except ProfileError:
        return None
    response = study.steady
    offset = float(response.solution.theta[-1] - response.solution.grid.theta[-1])
    theta = offset + np.linspace(left.begin_rad, left.end_rad, 1201)[:-1]
    time = 1e3 * (theta - theta[0]) / study.speed
    deviation = 1e3 * response.at(theta, "load_deviation")[0]
    top = float(np.abs(deviation).max())
    band = 1e3 * study.band
    limits = (Limit(band, f"band ±{number(band)} mrad"), Limit(-band, "")) if 0.02 * top < band < 3.0 * top else ()
    panel = Panel(Axis("Load deviation", "mrad"), (Series("deviation", time, deviation),), limits=limits)
    return Chart("The load in its hardest dwell", Axis("Time from the start of the dwell", "ms"), (panel,))


def figures(study: IndexingStudy) -> Table:
    """Critical speed and class, what is left in the dwell, and mean powers."""
    rows: list[tuple[Cell, ...]] = [
        ("First critical speed", study.classes.first_critical_rpm, "r/min"),
        ("Low speeds reach up to", study.classes.low_rpm, "r/min"),
        ("Medium speeds reach up to", study.classes.medium_rpm, "r/min"),
        ("Class of the working speed", study.classes.of(study.speed * RAD), ""),
        ("Mean input power", float(study.energy.input[0]), "W"),
        ("Mean power lost in damping and viscous friction", float(study.energy.dissipated[0]), "W"),
        ("Mean power taken by friction and applied torques", 0.0 - float(study.energy.external[0]), "W"),
        ("Mean power that the linearised contact adds", float(study.energy.linearisation[0]), "W"),
        ("Mean power that the contact's varying stiffness adds", float(study.energy.varying[0]), "W"),
    ]
    try:
        left = study.residual
    except ProfileError:
        left = None
    if left is not None:
        settled = study.settling_time
        rows += [
            ("Largest load deviation in the dwell", 1e3 * float(left.deviation[0]), "mrad"),
            ("Largest load acceleration in the dwell", float(left.acceleration[0]), "rad/s²"),
            (
                f"Settles within {number(1e3 * study.band)} mrad after",
                "not within the dwell" if settled is None else 1e3 * settled,
                "" if settled is None else "ms",
            ),
        ]
    if study.rigid is not None:
        for words, one in (("with the cam's body", study), ("on a rigid cam body", study.rigid)):
            highest = float(one.steady.peak("load_acceleration").magnitude[0])
            rows += [
                (f"First natural frequency, {words}", one.modes.lowest_hz()[0], "Hz"),
                (f"Mean contact stiffness, {words}", one.drive.contact_stiffness, "N m/rad"),
                (f"Peak load acceleration, {words}", highest, "rad/s²"),
            ]
    return quantities(f"The drive at {number(study.speed * RAD)} r/min", rows)


def over_speeds(study: IndexingStudy, speed_rpm: float) -> Chart:
    """Peak load acceleration and its ratio to the rigid peak over the cam speed."""
    from camgeom.dynamics.indexing.response import amplification

    sweep = study.sweep
    kept, load = sweep.answered, sweep.peaks["load_acceleration"]
    x = sweep.speed[kept] * RAD
    at = at_speed(speed_rpm)
    peak = load.magnitude[kept]
    ratio = amplification(load, study.motion, sweep.speed)[kept]
    i = int(ratio.argmax())
    top = Mark(float(x[i]), float(ratio[i]), f"{number(float(ratio[i]))} at {number(float(x[i]))} r/min")
    panels = (
        Panel(Axis("Peak load acceleration", "rad/s²", zero=True), (Series("peak", x, peak),), limits=at),
        Panel(Axis("Ratio to the rigid peak"), (Series("ratio", x, ratio),), marks=(top,)),
    )
    return Chart("Response over the cam speed", Axis("Cam speed", "r/min"), panels)


def modes_table(found: Modes, speed_rpm: float) -> Table:
    """Every mode with its range of frequency and the harmonic of the turn that comes nearest to it."""
    rows: list[tuple[Cell, ...]] = []
    for mode in found.modes:
        if not mode.oscillates:
            rows.append((mode.label, "diverges: the stiffness is not definite", None, None, None))
            continue
        hertz = mode.frequency_hz()
        low, high = float(hertz.min()), float(hertz.max())
        order = max(1, round(60.0 * low / speed_rpm))
        rows.append((mode.label, "oscillates", low, high, order))
    columns = (
        Column("Block"),
        Column("Kind"),
        Column("Lowest", "Hz"),
        Column("Highest", "Hz"),
        Column("Nearest harmonic"),
    )
    return Table(f"Natural modes; harmonics of {number(speed_rpm)} r/min", columns, tuple(rows))


def peaks(response: DriveResponse) -> Table:
    """Extremes of the outputs and what the drive does in the dwell."""
    from camgeom.dynamics.indexing.response import amplification
    from camgeom.dynamics.indexing.system import OUTPUTS

    rows: list[tuple[Cell, ...]] = []
    for name, meaning in OUTPUTS.items():
        found = response.peak(name)
        high, low = (
            (float(found.maximum[0]), float(found.maximum_at[0])),
            (float(found.minimum[0]), float(found.minimum_at[0])),
        )
        unit = meaning.split(",")[0].split(" of ")[0].split(" in ")[0].split(" between ")[0].replace("rad/s2", "rad/s²")
        rows.append((name.replace("_", " "), unit, high[0], degrees(high[1]) % 360.0, low[0], degrees(low[1]) % 360.0))
    ratio = float(amplification(response.peak("load_acceleration"), response.system.motion, response.speed)[0])
    rows.append(("peak load acceleration over rigid", "1", ratio, None, None, None))
    columns = (
        Column("Output"), Column("Unit"), Column("Largest"), Column("at", "°"), Column("Smallest"), Column("at", "°"),
    )  # fmt: skip
    return Table("Extremes of the periodic response", columns, tuple(rows))
