"""The mutation check: one sign, factor, index or comparison changed at a time, and a related test must fail.

    scripts/mutate --each 8 --seed 1 [--modules flank,hertz]

Works on copies of the tree, never on the tree itself. Prints the survivors; exit status 1 where there are any.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

ROOT = Path(__file__).resolve().parents[2]
TESTS: dict[str, tuple[str, ...]] = {
    "track/flank": ("oracle/test_flank.py", "cli/test_stability.py"),
    "track/__init__": ("oracle/test_flank.py", "solid/test_relief.py", "oracle/test_disc.py"),
    "track/column": ("solid/test_solid_drum.py", "cli/test_stability.py"),
    "track/section": ("solid/test_solid_drum.py", "cli/test_stability.py"),
    "solid/drum": ("solid/test_solid_drum.py", "oracle/test_globoidal_solid.py"),
    "track/outline": ("oracle/test_disc.py", "oracle/test_planar.py", "oracle/test_constant_width.py"),
    "track/clearance": ("cli/test_stability.py", "solid/test_solid_drum.py", "oracle/test_globoidal_solid.py"),
    "track/survey": ("oracle/test_flank.py", "cli/test_stability.py"),
    "solid/cut": ("oracle/test_globoidal_solid.py", "oracle/test_indexing_cams.py"),
    "track/turret": ("oracle/test_globoidal.py", "oracle/test_indexing_cams.py", "oracle/test_globoidal_solid.py"),
    "mechanics/turret_duty": ("oracle/test_indexing_cams.py", "oracle/test_globoidal.py"),
    "mechanics/hertz": ("mechanics/test_hertz.py",),
    "mechanics/life": ("mechanics/test_fatigue.py",),
    "dynamics/linear/maps": ("dynamics/test_integrators.py", "dynamics/test_integrators_split.py"),
    "dynamics/linear/solve": ("dynamics/test_integrators.py",),
}
LIMIT = 100
"""s that the tests of one mutant may take; a mutant that hangs counts as killed"""
SWAPS: dict[type, tuple[str, str]] = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Pow: ("**", "*"),
}  # fmt: skip
COMPARES: dict[type, tuple[str, str]] = {
    ast.Lt: ("<", ">"), ast.Gt: (">", "<"), ast.LtE: ("<=", ">"), ast.GtE: (">=", "<"),
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One change of a source: where (line), what, and the whole changed text."""

    module: str
    line: int
    what: str
    text: str


def mutants(module: str) -> list[Mutant]:
    """Every possible mutant of a module."""
    source = (ROOT / "camgeom" / f"{module}.py").read_text()
    starts = [0]
    for line in source.encode().splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    raw = source.encode()

    def begin(node: ast.expr) -> int:
        return starts[node.lineno - 1] + node.col_offset

    def end(node: ast.expr) -> int:
        return starts[(node.end_lineno or 1) - 1] + (node.end_col_offset or 0)

    found: list[Mutant] = []

    def change(low: int, high: int, old: str, new: str, line: int) -> None:
        at = raw.find(old.encode(), low, high)
        if at >= 0:
            text = raw[:at] + new.encode() + raw[at + len(old) :]
            what = f"{old} -> {new}:  {source.splitlines()[line - 1].strip()[:80]}"
            found.append(Mutant(module, line, what, text.decode()))

    def visit(node: ast.AST) -> None:
        if isinstance(node, ast.Raise | ast.JoinedStr | ast.arg):
            return  # messages and annotations hold no arithmetic that matters
        if isinstance(node, ast.BinOp) and type(node.op) in SWAPS:
            old, new = SWAPS[type(node.op)]
            change(end(node.left), begin(node.right), old, new, node.lineno)
        elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARES:
            old, new = COMPARES[type(node.ops[0])]
            change(end(node.left), begin(node.comparators[0]), old, new, node.lineno)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            change(begin(node), begin(node) + 1, "-", "+", node.lineno)
        elif isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant) and node.slice.value in (0, 1, 2):
            old, new = str(node.slice.value), str((node.slice.value + 1) % 3)
            change(begin(node.slice), end(node.slice), old, new, node.lineno)
        elif isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value != 0.0:
            text = raw[begin(node) : end(node)].decode()
            change(begin(node), end(node), text, f"(1.1 * {text})", node.lineno)
        for child in ast.iter_child_nodes(node):
            visit(child)

    visit(ast.parse(source))
    return found


def survives(mutant: Mutant, tree: Path) -> bool:
    """Whether the related tests pass with the mutant in a copy of the tree."""
    place = tree / "camgeom" / f"{mutant.module}.py"
    good = place.read_bytes()
    place.write_text(mutant.text)
    try:
        return passes(TESTS[mutant.module], tree)
    finally:
        place.write_bytes(good)


def passes(tests: tuple[str, ...], tree: Path) -> bool:
    """Whether the tests pass in a tree; False where they take too long."""
    names = [f"tests/{name}" for name in tests if (tree / "tests" / name).exists()]
    command = [sys.executable, "-B", "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *names]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(command, cwd=tree, env=environment, capture_output=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def main() -> int:
    """Run the check; exit status 1 where a mutant survives."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=8, help="mutants a module")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--modules", default=",".join(TESTS))
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    modules = args.modules.split(",")
    trees: SimpleQueue[Path] = SimpleQueue()
    with tempfile.TemporaryDirectory() as folder:
        for i in range(args.jobs):
            tree = Path(folder) / str(i)
            for name in ("camgeom", "tests", "profiles", "scripts"):
                shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__", "node_modules"))
            shutil.copy(ROOT / "pyproject.toml", tree)
            trees.put(tree)

        def judged(mutant: Mutant) -> tuple[Mutant, bool]:
            tree = trees.get()
            try:
                return mutant, survives(mutant, tree)
            finally:
                trees.put(tree)

        chosen: list[Mutant] = []
        for module in modules:
            every = mutants(module)
            chosen += random.Random(f"{args.seed} {module}").sample(every, min(args.each, len(every)))
        counts = {module: [0, 0] for module in modules}
        with ThreadPoolExecutor(args.jobs) as pool:
            for mutant, alive in pool.map(judged, chosen):
                counts[mutant.module][int(alive)] += 1
                fate = "SURVIVES" if alive else "killed  "
                print(f"{fate} {mutant.module}.py:{mutant.line}  {mutant.what}", flush=True)
    print(f"{'module':<36}{'killed':>8}{'survived':>10}")
    for module, (killed, alive) in counts.items():
        print(f"{module:<36}{killed:>8}{alive:>10}")
    return int(any(alive for _, alive in counts.values()))


if __name__ == "__main__":
    sys.exit(main())
