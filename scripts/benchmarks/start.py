"""Cold starts: what each command costs as a whole process, and the work that `--explain` says was not done.

Every figure is the shortest of several whole processes, beside an interpreter that does nothing and one that only
imports numpy, in one run; and how many of camgeom's own modules a profile of each kind enters.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile

from kit import ROOT, Row, Table, best, run, short

PROFILE = str(ROOT / "profiles" / "pin_insertion.toml")


def process(*arguments: str) -> str:
    """Run Python with these arguments; what it printed."""
    done = subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise SystemExit(f"{' '.join(arguments)}: {done.stderr}")
    return done.stdout + done.stderr


def modules(*arguments: str) -> int:
    """How many modules such a process imports."""
    return process("-X", "importtime", *arguments).count("import time:") - 1


def own_modules(code: str) -> int:
    """How many modules of camgeom a process has entered after this code."""
    count = "print(sum(name.partition('.')[0] == 'camgeom' for name in sys.modules))"
    return int(process("-c", f"import sys\n{code}\n{count}").split()[-1])


def entered() -> list[Row]:
    """The modules of camgeom that reading and checking a drum, a disc and a globoid enter."""
    rows: list[Row] = []
    for kind, name in (("drum", "pin_insertion"), ("disc", "disc_offset_roller"), ("globoid", "conical_indexer")):
        profile = str(ROOT / "profiles" / f"{name}.toml")
        rows.append({
            "profile": f"{kind}, {name}",
            "read": own_modules(f"import camgeom\ncamgeom.read({profile!r})"),
            "check": own_modules(f"from camgeom.cli import main\nmain(['check', {profile!r}])"),
        })
    return rows


def tables(quick: bool) -> list[Table]:
    """Whole processes, and what was skipped."""
    runs = 3 if quick else 7
    with tempfile.TemporaryDirectory() as out:
        build = ("-m", "camgeom", "build", PROFILE, "--out", out, "--formats")
        commands: dict[str, tuple[str, ...]] = {
            "python, nothing": ("-c", "pass"),
            "python, import numpy": ("-c", "import numpy"),
            "import camgeom": ("-c", "import camgeom"),
            "camgeom laws": ("-m", "camgeom", "laws"),
            "camgeom schema": ("-m", "camgeom", "schema"),
            "camgeom check, pin cam": ("-m", "camgeom", "check", PROFILE),
            "camgeom solve, pin cam": ("-m", "camgeom", "solve", PROFILE),
            "camgeom build (3MF, STL), pin cam": (*build, "3mf,stl"),
            "camgeom build (STEP), pin cam": (*build, "step"),
            "camgeom report, pin cam": ("-m", "camgeom", "report", PROFILE, "--out", out),
        }
        rows: list[Row] = []
        for name, command in commands.items():
            seconds, _ = best(lambda c=command: process(*c), runs)
            rows.append({"process": name, "time_s": short(seconds, 3), "modules": modules(*command)})
        numpy_only = rows[1]["time_s"]
        for row in rows:
            row["times_import_numpy"] = short(row["time_s"] / numpy_only, 3)
        skipped: list[Row] = []
        for command in ("laws", "check", "solve", "build"):
            arguments = ["-m", "camgeom", command] + ([] if command == "laws" else [PROFILE, "--explain"])
            told = process(*arguments, *(["--out", out, "--formats", "stl"] if command == "build" else []))
            lines = [line.strip() for line in told.splitlines()]
            said = [line for line in lines if line.startswith(("skipped", "not asked", "imported"))]
            skipped.append({"command": command, "it says": "; ".join(" ".join(line.split()) for line in said) or "-"})
    return [
        Table("start", "Whole processes", rows),
        Table("start_modules", "Modules of camgeom entered", entered()),
        Table("start_skipped", "Work not done", skipped),
    ]


if __name__ == "__main__":
    run(tables, __doc__)
