"""Histories as tables, CSV and Parquet: one turn over time and cam angle, and the run of a follower in its clearance.

`.history` has a row each quarter of a degree: lift to jerk, forces along the motion, the force and the pressure of
every roller, torques, and what [dynamics] finds, periodic and from rest. `.impact` has every point that the solver of
[impact] gives, over all its turns.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.errors import ExportError, not_installed
from camgeom.export import writer
from camgeom.export.files import write_csv, write_whole
from camgeom.maths import TURN, Floats

if TYPE_CHECKING:
    from camgeom.dynamics.impact.run import ImpactRun
    from camgeom.dynamics.linear.response import Response
    from camgeom.mechanics.contact import Contact
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.model import Model

STEP = 0.25
"""deg of cam angle between rows"""
Columns = dict[str, Floats]


def turn_history(model: Model) -> Columns:
    """One turn by columns (n,), units in their names; what the profile gives no speed, load or solver for is left out.

    Where a derivative of the motion jumps the row has the value after the jump. The pressure of a roller is that of its
    hardest slice; a turret's rollers are numbered by their places beside the cam, one index apart, and their values lie
    on straight lines between the samples of the duty. With [[duty]] the turn is that of the (first) follower's hardest
    state. All followers of the cam are there, over the cam's angle; the columns of further ones begin with
    `follower_2.` and so on.
    """
    first, model = model.number == 0, model.hardest_state
    angle = np.arange(0.0, 360.0 + 0.5 * STEP, STEP)
    theta, operation = np.radians(angle), model.profile.operation
    columns = {} if operation is None else {"time_s": theta / (operation.speed * pi / 30.0)}
    columns |= {"cam_angle_deg": angle, **_follower(model, theta)}
    for one in model.at_once[1:] if first else ():
        found = _follower(one, (theta - one.angle) % TURN)
        columns |= {f"follower_{one.number + 1}.{key}": value for key, value in found.items()}
    if first and model.camshaft is not None:
        columns["all_followers_torque_n_m"] = 1e-3 * model.camshaft.at(theta)
    return columns


def _follower(model: Model, theta: Floats) -> Columns:
    """Motion, loads and vibration of one follower at its own cam angles (n,), rad."""
    rotating, operation = model.profile.rotating, model.profile.operation
    word, unit, scale = ("position", "deg", degrees(1.0)) if rotating else ("lift", "mm", 1.0)
    omega, time = (1.0, "rad") if operation is None else (operation.speed * pi / 30.0, "s")
    jet = model.setup.program.jet(theta, 3)
    columns = {f"{word}_{unit}": scale * jet[0]}
    for order, name in ((1, "velocity"), (2, "acceleration"), (3, "jerk")):
        columns[f"{name}_{unit}_per_{time}{'' if order == 1 else order}"] = scale * omega**order * jet[order]
    return columns if operation is None else columns | dict(_loads(model, theta)) | dict(_vibration(model, theta))


def _loads(model: Model, theta: Floats) -> Iterator[tuple[str, Floats]]:
    """Forces along the motion, and what presses the cam."""
    torque, unit = (("torque", "n_m") if model.profile.rotating else ("force", "n"))
    factor = 1e-3 if model.profile.rotating else 1.0
    bearing = model.drive or model.carrier
    if bearing is None:
        return
    force, panels = bearing.force, bearing.force.panels
    yield f"follower_{torque}_{unit}", factor * panels.at(force.force, theta)
    yield f"inertia_{torque}_{unit}", factor * panels.at(force.inertia, theta)
    if (drive := model.slide_drive) is not None:
        yield "travel_mm", drive.carriage.travel(theta)
        yield "travel_force_n", panels.at(drive.groove, theta)
        if drive.mass is not None:
            yield "drive_force_n", panels.at(drive.force, theta)
    elif model.shaft is not None:
        yield "camshaft_torque_n_m", 1e-3 * model.shaft.at(theta)
    if model.turret_duty is not None:
        yield from _turret(model.turret_duty, theta)
    for duty in model.duties:
        name, own = duty.track.name.replace(" ", "_"), duty.force.panels
        yield f"{name}_force_n", np.abs(own.at(duty.normal, theta))
        yield f"{name}_pressure_mpa", _pressure(duty.slices, theta)
        yield f"{name}_quoted_pressure_mpa", _pressure(duty.contact, theta)
    if not model.duties and model.drive is not None:
        for name, normal in model.drive.normals.items():
            yield f"{name.replace(' ', '_')}_force_n", panels.at(normal, theta)
        for name, found in model.drive.contacts.items():
            yield f"{name.replace(' ', '_')}_pressure_mpa", _pressure(found, theta)


def _pressure(contact: Contact, theta: Floats) -> Floats:
    """Largest pressure, MPa, (k,), of a contact or of all its slices; its square is smooth on both walls."""
    square = np.maximum(contact.panels.at(contact.behind, theta), contact.panels.at(contact.ahead, theta))
    return np.asarray(np.sqrt(np.maximum(square, 0.0)).reshape(-1, len(theta)).max(axis=0))


def _turret(duty: TurretDuty, theta: Floats) -> Iterator[tuple[str, Floats]]:
    pressure = duty.pressure.max(axis=2)
    for number in range(duty.roller_load.shape[1]):
        yield f"roller_{number + 1}_force_n", np.interp(theta, duty.theta, duty.roller_load[:, number])
        yield f"roller_{number + 1}_pressure_mpa", np.interp(theta, duty.theta, pressure[:, number])


def _vibration(model: Model, theta: Floats) -> Iterator[tuple[str, Floats]]:
    """What [dynamics] finds: every output of the periodic state and of the first turn from rest."""
    if model.indexing is not None:
        yield from _outputs("periodic", model.indexing.steady, theta, rotating=True)
        yield from _outputs("from_rest", model.indexing.start, theta, rotating=True)
    if model.elastic_follower is not None:
        yield from _outputs("periodic", model.elastic_follower.steady, theta, model.profile.rotating)
    if (drive := model.dynamic_slide_drive) is not None and drive.mass is not None:
        yield "periodic.drive_force_n", drive.duty.force.panels.at(drive.force, theta)


SUFFIX = {
    "rad": "rad", "rad/s": "rad_s", "rad/s2": "rad_s2", "N m": "n_m", "N": "n", "m": "m", "m/s": "m_s", "m/s2": "m_s2",
}  # fmt: skip
"""ends of columns by the unit that an output's meaning begins with"""
ROTATING = {"n": "n_m", "m": "rad", "m_s": "rad_s", "m_s2": "rad_s2"}
"""the same of a rocker, whose outputs are worded as a slide's"""


def _outputs(what: str, response: Response[Any], theta: Floats, rotating: bool) -> Iterator[tuple[str, Floats]]:
    begin = float(response.theta[-1]) - TURN
    for name, meaning in response.system.outputs.items():
        unit = SUFFIX[max((u for u in SUFFIX if meaning.replace(",", " ").startswith(f"{u} ")), key=len)]
        unit = ROTATING.get(unit, unit) if rotating else unit
        # The last moment of the turn belongs to it: a stretch ends before the next begins.
        yield f"{what}.{name}_{unit}", np.asarray(response.at(begin + theta * (1.0 - 1e-12), name)[0])


def impact_history(run: ImpactRun, rotating: bool) -> Columns:
    """The run by columns (n,) over time, all turns, units in their names; both sides of every event have a row."""
    trace = run.trace.flat()
    unit = "rad" if rotating else "m"
    columns = {
        "time_s": trace.time,
        "cam_angle_deg": np.degrees(trace.angle),
        f"deviation_{unit}": trace.deviation,
        f"position_{unit}": trace.position,
        f"velocity_{unit}_s": trace.speed,
        f"acceleration_{unit}_s2": trace.acceleration,
        "camshaft_torque_n_m": trace.cam_torque,
        "driving_side": trace.state.astype(float),
    }
    for k, side in enumerate(("main", "return")):
        columns |= {
            f"{side}_force_n": trace.force[:, k],
            f"{side}_penetration_m": trace.penetration[:, k],
            f"{side}_sliding_m_s": trace.sliding[:, k],
            f"{side}_pressure_mpa": 1e-6 * trace.pressure[:, k],
        }
    return columns


def _no_impact(model: Model) -> str:
    return "" if model.profile.impact_spec is not None else "the profile has no [impact]"


def _impacts(path: Path, model: Model) -> Columns:
    """`impact_history` of every follower; of several one below the other, over the cam's angle, with its number.

    A column that only another follower has (mm of a slide, rad of a rocker) is NaN.
    """
    if reason := _no_impact(model):
        raise ExportError(f"{path}: {reason}")
    tables = []
    for one in model.bindings:
        assert one.impact is not None
        table = impact_history(one.impact, one.profile.rotating)
        if len(model.bindings) > 1:
            table["time_s"] = table["time_s"] + one.angle / one.impact.problem.speed
            table["cam_angle_deg"] = table["cam_angle_deg"] + degrees(one.angle)
            table = {"follower": np.full(len(table["time_s"]), one.number + 1.0), **table}
        tables.append(table)
    heads = dict.fromkeys(head for table in tables for head in table)
    empty = [np.full(len(table["time_s"]), np.nan) for table in tables]
    return {head: np.concatenate([table.get(head, none) for table, none in zip(tables, empty)]) for head in heads}


@writer(".history.csv", "one turn over time and cam angle: motion, forces, pressures, torques, vibration; CSV", "model",
        body=False)  # fmt: skip
def write_history_csv(path: Path, model: Model) -> int:
    """Write `turn_history`; returns the bytes written. Raises what the model's facts raise, ExportError for the file.
    """
    return _csv(path, turn_history(model))


@writer(".history.parquet", "the same; Parquet (needs pyarrow)", "model", body=False)
def write_history_parquet(path: Path, model: Model) -> int:
    """Write `turn_history`; returns the bytes written. Raises as above, ExportError where pyarrow is absent."""
    return _parquet(path, turn_history(model))


@writer(".impact.csv", "the follower in its clearance, over all turns of [impact]; CSV", "model",
        "profiles with [impact]", _no_impact, body=False)  # fmt: skip
def write_impact_csv(path: Path, model: Model) -> int:
    """Write `impact_history` of every follower; returns the bytes written. Raises as above."""
    return _csv(path, _impacts(path, model))


@writer(".impact.parquet", "the same; Parquet (needs pyarrow)", "model", "profiles with [impact]", _no_impact,
        body=False)  # fmt: skip
def write_impact_parquet(path: Path, model: Model) -> int:
    """Write `impact_history` of every follower; returns the bytes written. Raises as above."""
    return _parquet(path, _impacts(path, model))


def _csv(path: Path, columns: Columns) -> int:
    return write_csv(path, list(columns), [("", np.column_stack(list(columns.values())))])


def _parquet(path: Path, columns: Columns) -> int:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise not_installed("Parquet", "pyarrow", "parquet") from None
    rows = {head: pyarrow.array(values, from_pandas=True) for head, values in columns.items()}  # NaN: no value
    whole = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(pyarrow.table(rows), whole)
    return write_whole(path, whole.getvalue().to_pybytes())
