"""Draw the packages of camgeom from their imports: docs/architecture.svg.

Rows are the layers of the import contract in pyproject.toml; an arrow is an import of a package by another at run time,
without those that other arrows imply. The figures in a box are Python files and lines.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import grimp

ROOT = Path(__file__).resolve().parents[1]
WIDTH, ROW, BOX, HIGH = 900, 74, 132, 40
Graph = dict[str, set[str]]


def layers() -> list[list[str]]:
    """Package names from the highest layer to the lowest, from the layers contract."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    contract = next(c for c in project["tool"]["importlinter"]["contracts"] if c["type"] == "layers")
    return [[name.strip(" ()") for name in row.split("|")] for row in contract["layers"]]


def imports(names: list[str]) -> Graph:
    """Which of the packages every package imports, without what follows from others."""
    graph = grimp.build_graph("camgeom", exclude_type_checking_imports=True)
    found: Graph = {name: set() for name in names}
    for module in graph.modules:
        parts = module.split(".")
        for other in graph.find_modules_directly_imported_by(module):
            target = other.split(".")
            if len(parts) > 1 and len(target) > 1 and parts[1] != target[1]:
                found[parts[1]].add(target[1])
    return {name: {t for t in found[name] if not _implied(found, name, t)} for name in names}


def _implied(graph: Graph, start: str, end: str) -> bool:
    """Whether `end` is reached from `start` over another package."""
    waiting, seen = [name for name in graph[start] if name != end], set()
    while waiting:
        name = waiting.pop()
        if name == end:
            return True
        if name not in seen:
            seen.add(name)
            waiting.extend(graph[name])
    return False


def size(name: str) -> tuple[int, int]:
    """Python files and lines of a package or a module."""
    place = ROOT / "camgeom" / name
    files = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
    return len(files), sum(len(file.read_text().splitlines()) for file in files)


def draw() -> str:
    """The picture as SVG."""
    rows = layers()
    place = {
        name: (WIDTH * (i + 1) / (len(row) + 1), 50 + ROW * depth)
        for depth, row in enumerate(rows)
        for i, name in enumerate(row)
    }
    high = 50 + ROW * len(rows)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {high}" '
        'font-family="sans-serif" font-size="14">',
        "<title>Packages of camgeom and what they import</title>",
        '<defs><marker id="a" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 0L8 4L0 8z" fill="#5a6b7b"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{high}" fill="#ffffff"/>',
    ]
    for name, targets in imports(list(place)).items():
        for target in sorted(targets):
            (x, y), (u, v) = place[name], place[target]
            y, v = y + HIGH / 2, v - HIGH / 2
            bend = (v - y) / 2
            lines.append(
                f'<path d="M{x:.0f} {y:.0f}C{x:.0f} {y + bend:.0f} {u:.0f} {v - bend:.0f} {u:.0f} {v:.0f}" fill="none" '
                'stroke="#5a6b7b" stroke-width="1.3" marker-end="url(#a)"/>'
            )
    for name, (x, y) in place.items():
        files, length = size(name)
        lines += [
            f'<rect x="{x - BOX / 2:.0f}" y="{y - HIGH / 2:.0f}" width="{BOX}" height="{HIGH}" rx="6" fill="#eef3f8" '
            'stroke="#34526f"/>',
            f'<text x="{x:.0f}" y="{y - 2:.0f}" text-anchor="middle" font-weight="bold" fill="#1d2f40">{name}</text>',
            f'<text x="{x:.0f}" y="{y + 14:.0f}" text-anchor="middle" font-size="11" fill="#45586a">'
            f"{files} file{'s' * (files > 1)}, {length} lines</text>",
        ]
    return "\n".join([*lines, "</svg>", ""])


def circles() -> list[str]:
    """Pairs of packages that import each other at run time; there should be none."""
    graph = grimp.build_graph("camgeom", exclude_type_checking_imports=True)
    names = {module.split(".")[1] for module in graph.modules if "." in module}
    direct: Graph = {name: set() for name in names}
    for module in graph.modules:
        for other in graph.find_modules_directly_imported_by(module):
            pair = [m.split(".")[1] for m in (module, other) if "." in m]
            if len(pair) == 2 and pair[0] != pair[1]:
                direct[pair[0]].add(pair[1])
    return [f"{a} and {b}" for a in sorted(names) for b in sorted(direct[a]) if a < b and a in direct[b]]


def module_circles() -> list[list[str]]:
    """Modules that import each other at run time in a circle, also where a function does when called; none should."""
    graph = grimp.build_graph("camgeom", exclude_type_checking_imports=True)
    reached = {module: graph.find_upstream_modules(module) for module in graph.modules}
    found = {module: [other for other in reached[module] if module in reached[other]] for module in graph.modules}
    every = {tuple(sorted([module, *others])) for module, others in found.items() if others}
    return sorted(map(list, every))


def main() -> int:
    """Write the picture and say what stands in it."""
    target = ROOT / "docs" / "architecture.svg"
    target.write_text(draw())
    print(f"{target.relative_to(ROOT)}: {len(layers())} layers, {sum(len(row) for row in layers())} packages")
    for pair in circles():
        print(f"circle: {pair}")
    rings = module_circles()
    for modules in rings:
        print(f"circle of modules, some of them imported when a function is called: {', '.join(modules)}")
    return int(bool(circles() or rings))


if __name__ == "__main__":
    sys.exit(main())
