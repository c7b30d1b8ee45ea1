"""Tolerances: all sensitivities of a drive after its flanks, many machines, the widest tolerances; time and memory.

Asked: every sensitivity of an eight-stop globoid within 50 ms after the flanks; a million machines with all errors
within 10 s on two cores and 2 GB.
"""

from __future__ import annotations

import resource
from time import perf_counter, process_time

from kit import ROOT, Row, Table, milli, run, short

from camgeom.model import Model, read
from camgeom.tolerance.sensitivity import Sensitivities
from camgeom.tolerance.study import ToleranceStudy

DRIVES = ("tool_changer", "fine_indexer", "parallel_index", "conjugate_rocker", "pin_insertion", "disc_flat_face")
REPEATS = 5
ASKED_MS, ASKED_S, ASKED_MB = 50.0, 10.0, 2000.0


def sensitivity_rows(quick: bool) -> list[Row]:
    """Contacts, then all errors, of several kinds of cam."""
    rows: list[Row] = []
    for name in DRIVES[:2] if quick else DRIVES:
        loaded = read(str(ROOT / "profiles" / f"{name}.toml")).tolerances.loaded
        walls, errors, worked = [], [], 0.0
        for _ in range(REPEATS):
            began = perf_counter()
            table = Sensitivities(loaded)
            table.seated.nominal  # noqa: B018
            table.hard  # noqa: B018
            walls.append(perf_counter() - began)
            began, before = perf_counter(), process_time()
            table.rows  # noqa: B018
            errors.append(perf_counter() - began)
            worked += (process_time() - before) / REPEATS
        rows.append({"drive": name, "angles": len(table.theta), "stations": int(table.seated.contacts.on.sum()),
                     "errors": len(table.rows), "flanks_ms": milli(min(walls)), "all_errors_ms": milli(min(errors)),
                     "processor_ms": milli(worked),
                     "asked_ms": ASKED_MS if name == "tool_changer" else None})  # fmt: skip
    return rows


def machine_rows(quick: bool) -> list[Row]:
    """The shipped tool changer, 18 errors, all stops."""
    model = Model(read(str(ROOT / "profiles" / "tool_changer.toml")).profile)
    study: ToleranceStudy = model.tolerances
    machines = study.machines(study.spreads)
    machines.positions  # noqa: B018
    rows: list[Row] = []
    for count in (10_000, 100_000) if quick else (10_000, 100_000, 1_000_000):
        began, worked = perf_counter(), process_time()
        drawn = machines.drawn(count)
        resting = process_time() - worked
        drawn.motion, drawn.pressure  # noqa: B018
        rows.append({"machines": count, "numbers_each": len(machines.columns), "places": len(machines.positions),
                     "time_s": short(perf_counter() - began, 3), "processor_s": short(process_time() - worked, 3),
                     "dwells_s": short(resting, 3),
                     "peak_memory_mb": short(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3, 3),
                     "asked_s": ASKED_S if count == 1_000_000 else None,
                     "asked_mb": ASKED_MB if count == 1_000_000 else None})  # fmt: skip
    return rows


def tables(quick: bool) -> list[Table]:
    """Sensitivities, and machines."""
    return [
        Table("tolerance_errors", "All errors one by one, after the flanks", sensitivity_rows(quick)),
        Table("tolerance_machines", "Machines with all errors at once, two workers", machine_rows(quick),
              "processor_s: of all threads; time_s follows it by the cores that are free. dwells_s: of these without "
              "moves and pressure, which are drawn where they are asked."),
    ]  # fmt: skip


if __name__ == "__main__":
    run(tables, __doc__)
