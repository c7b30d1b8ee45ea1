"""The verdict campaign: sound designs that must raise no alarm, and the same with one fault that must be told.

    scripts/verdict_campaign --count 200 --seed 0 --jobs 2      200 sound designs and 200 faults, from seed 0 on
    scripts/verdict_campaign --fault 17                         one fault, printed whole (also: --sound 17)

Designs and faults come from `verdict_designs` and `verdict_faults`, which know nothing of the product. Here the
product is asked, and only here: what does its verdict say? Exit status 1 where a sound design fails or warns without
an explanation, or where a fault is not told by a check (or refusal) of its class.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import time
import traceback
from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from verdict_designs import FIRST_SEED, Data, furnished, kind_of, kinds_of, sound  # noqa: E402
from verdict_faults import FAULTS, PENDING, count_of, fault_of, injected, swinging_torque  # noqa: E402

BUGS = (
    ArithmeticError, AssertionError, AttributeError, LookupError, NameError, RuntimeError, TypeError, ValueError
)
"""what a mistake in the product's code raises; what the machine does, or who stops it, ends the campaign"""
EXPLAINED: dict[str, str] = {}
"""warnings that a sound design may raise, by check, each with its reason"""


@dataclass(frozen=True)
class Record:
    """What was said of one design.

    outcome  "told", "pending" or "MISS"; of a sound design "quiet", "explained" or "ALARM"
    by       checks or refused keys that spoke
    """

    seed: int
    group: str
    kind: str
    outcome: str
    by: tuple[str, ...] = ()
    said: str = ""
    seconds: float = 0.0


def frozen(value: Any) -> Any:
    """Lists as tuples, as the reader of profiles gives them."""
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return tuple(frozen(item) for item in value) if isinstance(value, list | tuple) else value


def model_of(data: Data, tolerance: float | None = None) -> Any:
    """The product's model of plain tables."""
    from camgeom.model import Model
    from camgeom.profile import from_data

    return Model(from_data(frozen(data), ""), tolerance)


def design_of(seed: int) -> Data:
    """The sound design of a seed; from FIRST_SEED on with further limits and solvers."""
    return sound(seed) if seed < FIRST_SEED else furnished(seed)


def run_sound(seed: int) -> Record:
    """The record of a sound design."""
    from camgeom.checks import judge
    from camgeom.errors import CamgeomError

    began = time.perf_counter()
    kind, design = kind_of(seed), design_of(seed)
    try:
        verdict = judge(model_of(design))
        loud = [f for f in verdict.findings if f.level != "pass"]
        lost = [f"{name} lost: {why.reason}" for name, why in verdict.lost]
        by = tuple(sorted({f"{f.check} ({f.level})" for f in loud} | {name for name, _ in verdict.lost}))
        told = [f"{f.check} {f.level} {f.value} {f.comparison} {f.limit} {f.where} {f.advice}" for f in loud]
        said = "; ".join(told + lost)
        alarms = [f for f in loud if f.level == "fail" or f.check not in EXPLAINED]
        outcome = "ALARM" if alarms or lost else "explained" if loud else "quiet"
    except CamgeomError as error:
        outcome, by, said = "ALARM", (type(error).__name__,), str(error)
    except BUGS:
        outcome, by, said = "ALARM", ("traceback",), traceback.format_exc(limit=-3)
    if outcome == "ALARM" and by != ("traceback",) and kind in PENDING.get("sound", ()):
        outcome = "pending"
    return Record(seed, "sound", kind, outcome, by, said[:600], time.perf_counter() - began)


def of_fault(seed: int) -> tuple[str, str, Data, Data]:
    """Class, kind, sound and faulty design of a seed."""
    name = fault_of(seed)
    turn = seed // count_of(seed)
    # Classes step through their kinds from different places, so that few seeds meet many pairs.
    every = kinds_of(seed)
    kinds = [kind for kind in FAULTS[name].kinds if kind in every]
    kind = kinds[(turn + 7 * list(FAULTS).index(name)) % len(kinds)]
    data = sound(every.index(kind) + len(every) * turn, kind)
    return name, kind, data, injected(name, data, kind, seed)


COSTLY = "so that it swings less often in a turn"


def run_fault(seed: int) -> Record:
    """The record of a fault."""
    from camgeom.checks import checks

    began = time.perf_counter()
    name, kind, data, faulty = of_fault(seed)
    fault = FAULTS[name]
    try:
        told, by, said = asked(name, data, faulty)
    except BUGS:
        told, by, said = False, ("traceback",), traceback.format_exc(limit=-3)
    outcome = "told" if told else "MISS"
    missing = fault.checks and not set(fault.checks) & set(checks())
    # What ends in a traceback is never excused: no check that is still to come would mend it.
    if not told and by != ("traceback",) and (missing or kind in PENDING.get(name, ())):
        outcome = "pending"
    return Record(seed, name, kind, outcome, by, said[:600], time.perf_counter() - began)


def asked(name: str, data: Data, faulty: Data) -> tuple[bool, tuple[str, ...], str]:
    """Whether the right check (or refusal) spoke of a fault; who did, and what was said."""
    from camgeom.checks import judge
    from camgeom.errors import CamgeomError, ProfileError

    fault = FAULTS[name]
    notes = {key: faulty.pop(key) for key in ("named", "between") if key in faulty}
    words = (notes["named"],) if "named" in notes else fault.refusal
    try:
        if "between" in notes:
            faulty["dynamics"], limit = swinging(faulty, notes["between"])
            faulty.setdefault("limits", {})["contact_pressure_mpa"] = limit
        model = model_of(faulty)
        if fault.body:
            model.body.__dict__["solids"] = spoilt(fault.body, data, model)
        verdict = judge(model, fault.checks or ("continuity",))
    except ProfileError as error:
        keys = [word for word in words if word in str(error)]
        return bool(keys), tuple(f"refused: {key}" for key in keys) or ("refused",), str(error)
    except CamgeomError as error:
        return False, (type(error).__name__,), str(error)
    levels = ("fail", "warn") if fault.warns else ("fail",)
    right = [f for f in verdict.findings if f.check in fault.checks and f.level in levels]
    if right:
        return True, tuple(sorted({f.check for f in right})), right[0].advice
    # What costs more than is spent is refused with its price: the verdict does not pass, and says why.
    costly = [n for n in verdict.not_judged if n.check in fault.checks and COSTLY in n.reason]
    if costly:
        return True, tuple(f"refused for its cost: {n.check}" for n in costly), costly[0].reason
    heard = [f"{f.check}: {f.value} {f.comparison} {f.limit} {f.level}" for f in verdict.findings]
    heard += [f"{n.check} not judged: {n.reason}" for n in verdict.not_judged]
    return False, (), "; ".join(heard)


def swinging(data: Data, drives: list[Data]) -> tuple[Data, float]:
    """The first drive that presses its rollers 12 % harder than the rigid turret, and the pressure half way, MPa.

    At every cam angle the pressure goes with the root of the torque: the rigid turret says which rollers share it, one
    mass on a spring (`swinging_torque`) how large it is. A torque may peak where two rollers bear and the rigid one
    where one does, so that half as much again of it hardly shows: such a drive has not this fault.
    """
    rigid = model_of({k: v for k, v in data.items() if k != "dynamics"}).carrier
    pressure, torque = rigid.pressure.max(axis=(1, 2)), rigid.turret_torque
    for drive in drives:
        swung = swinging_torque(data | {"dynamics": drive}, rigid.theta)
        alike = (swung * torque > 0.0) & (np.abs(torque) > 0.05 * np.abs(torque).max())
        harder = float((pressure * np.sqrt(np.divide(swung, torque, out=np.zeros_like(torque), where=alike))).max())
        if harder > 1.12 * pressure.max():
            return drive, float(np.sqrt(harder * pressure.max()))
    raise AssertionError("no drive of the six presses harder: throw more")


def spoilt(how: str, data: Data, model: Any) -> tuple[Any, ...]:
    """The bodies as a workshop or a careless mesher would have made them."""
    if how == "made with":
        return tuple(model_of(data).solids)
    tolerance = data["output"]["tolerance"]
    if how == "coarse":
        coarse = model_of(data, min(30.0 * tolerance, 1.0)).solids
        return tuple(replace(solid, chord_error=0.97 * tolerance) for solid in coarse)
    axes = {"cylindrical": 2, "conical": 2, "cylindrical-index": 2, "globoidal": 2, "linear": 1}
    axis = axes.get(data["cam"]["kind"], 0)
    moved = []
    for solid in model.solids:
        vertices = solid.mesh.vertices.copy()
        vertices[:, axis] += 6.0 * tolerance
        moved.append(replace(solid, mesh=replace(solid.mesh, vertices=vertices)))
    return tuple(moved)


def table(records: list[Record]) -> str:
    """Counts by class and kind: judged by whom."""
    lines = []
    groups: dict[str, list[Record]] = defaultdict(list)
    for record in sorted(records, key=lambda r: r.seed):
        groups[record.group].append(record)
    heads = ("quiet", "explained", "ALARM", "told", "pending", "MISS")
    lines.append(f"{'class':<32}{'number':>7}" + "".join(f"{head:>10}" for head in heads) + "   by")
    for name in ("sound", *FAULTS):
        own = groups.get(name, [])
        if not own:
            continue
        counts, by = Counter(r.outcome for r in own), Counter(word for r in own for word in r.by)
        who = ", ".join(f"{word} {n}" for word, n in by.most_common(6))
        lines.append(f"{name:<32}{len(own):>7}" + "".join(f"{counts[head] or '':>10}" for head in heads) + f"   {who}")
    for outcome in ("ALARM", "MISS", "pending"):
        rows = Counter((r.group, r.kind) for r in records if r.outcome == outcome)
        seeds = {row: [r.seed for r in records if (r.group, r.kind) == row and r.outcome == outcome] for row in rows}
        lines += [f"{outcome:<8} {a} · {b}: {n}, seeds {seeds[a, b][:5]}" for (a, b), n in sorted(rows.items())]
    return "\n".join(lines)


def one(record: Record, data: Data) -> int:
    """Print a design and what was said of it."""
    print(json.dumps(data, indent=1))
    print(record)
    return int(record.outcome in ("ALARM", "MISS"))


def main() -> int:
    """Run the campaign."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100, help="sound designs, and as many faults")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sound", type=int, help="one sound design, printed whole")
    parser.add_argument("--fault", type=int, help="one fault, printed whole")
    parser.add_argument("--only", choices=("sound", "faults"))
    parser.add_argument("--out", type=Path, help="also write the records, one JSON object a line")
    args = parser.parse_args()
    if args.sound is not None:
        return one(run_sound(args.sound), design_of(args.sound))
    if args.fault is not None:
        return one(run_fault(args.fault), of_fault(args.fault)[3])
    seeds = range(args.seed, args.seed + args.count)
    records: list[Record] = []
    context = multiprocessing.get_context("forkserver")
    with context.Pool(args.jobs, maxtasksperchild=200) as pool:
        for judge, wanted in ((run_sound, "sound"), (run_fault, "faults")):
            if args.only in (None, wanted):
                for record in pool.imap_unordered(judge, seeds, chunksize=4):
                    records.append(record)
                    if record.outcome in ("ALARM", "MISS"):
                        where = f"{record.outcome} seed {record.seed}: {record.group} · {record.kind}"
                        print(f"{where} {record.by} {record.said[:200]}", flush=True)
    if args.out:
        args.out.write_text("".join(json.dumps(vars(record)) + "\n" for record in records), encoding="utf-8")
    print(table(records))
    return int(any(record.outcome in ("ALARM", "MISS") for record in records))


if __name__ == "__main__":
    sys.exit(main())
