"""What every benchmark section shares: timing, tables, the machine, and how results are written."""

from __future__ import annotations

import argparse
import csv
import json
import os
import platform
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

Row = dict[str, Any]


@dataclass(frozen=True)
class Plot:
    """A log-log picture of a table: columns for x, y and the series; rows without both numbers are left out."""

    x: str
    y: str
    series: str
    x_label: str
    y_label: str


@dataclass(frozen=True)
class Table:
    """Rows of one comparison. `name` is the stem of its files; `note` says what the figures mean."""

    name: str
    title: str
    rows: list[Row]
    note: str = ""
    plot: Plot | None = None

    @property
    def columns(self) -> list[str]:
        """Every column any row has, in order of first use."""
        return list(dict.fromkeys(key for row in self.rows for key in row))


def best(
    work: Callable[[], Any], runs: int, longest: float = 20.0, clock: Callable[[], float] = perf_counter
) -> tuple[float, Any]:
    """Shortest time of some runs, s (fewer once they have taken `longest` s together), and the last result."""
    times: list[float] = []
    result = None
    while len(times) < runs and sum(times) < longest:
        began = clock()
        result = work()
        times.append(clock() - began)
    return min(times), result


def short(value: float, digits: int = 4) -> float:
    """A figure rounded to some significant digits."""
    return float(f"{value:.{digits}g}")


def milli(seconds: float) -> float:
    """Milliseconds to four digits."""
    return short(seconds * 1e3)


def machine() -> Row:
    """Processor, cores, system and the versions of what is measured."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "memory_gb": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9, 1),
        "load_at_start": round(os.getloadavg()[0], 2),
        "python": platform.python_version(),
        **{name: _version(name) for name in ("numpy", "scipy", "manifold3d", "pydantic", "trimesh", "meshio")},
    }


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def markdown(table: Table) -> str:
    """The table as GitHub Markdown."""
    columns = table.columns
    lines = ["| " + " | ".join(column.replace("_", " ") for column in columns) + " |"]
    numeric = [all(isinstance(row.get(c, 0), int | float) for row in table.rows) for c in columns]
    lines.append("|" + "|".join("---:" if right else "---" for right in numeric) + "|")
    lines += ["| " + " | ".join(_cell(row.get(c, "")) for c in columns) + " |" for row in table.rows]
    return "\n".join(lines)


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int) and abs(value) >= 10_000:
        return f"{value:,}".replace(",", " ")
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value)


def draw(table: Table, path: Path) -> None:
    """The table's plot as SVG."""
    import matplotlib

    matplotlib.use("svg")
    import matplotlib.pyplot as plt

    plot = table.plot
    assert plot is not None
    series: dict[str, list[tuple[float, float]]] = {}
    for row in table.rows:
        x, y = row.get(plot.x), row.get(plot.y)
        if isinstance(x, int | float) and isinstance(y, int | float) and x > 0 and y > 0:
            series.setdefault(str(row[plot.series]), []).append((x, y))
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "camgeom", "font.size": 9.5})
    figure, axes = plt.subplots(figsize=(7.2, 4.2), layout="constrained")
    colours = ["#0072b2", "#d55e00", "#009e73", "#7b5ea7", "#8a6d00", "#56b4e9", "#444444", "#cc79a7"]
    for k, (name, points) in enumerate(series.items()):
        points.sort()
        axes.plot(*zip(*points), marker="osD^vPX*"[k % 8], ms=4.5, lw=1.3, color=colours[k % 8], label=name,
                  ls=("-", "--", ":", "-.")[k // 8 % 4])
    axes.set(xscale="log", yscale="log", xlabel=plot.x_label, ylabel=plot.y_label)
    axes.set_title(table.title, fontsize=10.5, loc="left")
    axes.grid(True, which="major", color="#d8d8d8", lw=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    if len(series) > 6:
        figure.legend(loc="outside right center", frameon=False, fontsize=8)
    else:
        axes.legend(frameon=False, fontsize=8.5)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def write_csv(table: Table, path: Path) -> None:
    """The rows as CSV."""
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, table.columns, restval="")
        writer.writeheader()
        writer.writerows(table.rows)


def run(tables: Callable[[bool], list[Table]], doc: str) -> None:
    """The command line of one section: print its tables as Markdown, and write them as JSON where asked."""
    parser = argparse.ArgumentParser(description=doc.split("\n", 1)[0])
    parser.add_argument("--quick", action="store_true", help="fewer and smaller cases")
    parser.add_argument("--json", type=Path, help="also write the tables here")
    options = parser.parse_args()
    made = tables(options.quick)
    for table in made:
        print(f"\n## {table.title}\n\n{markdown(table)}\n" + (f"\n{table.note}\n" if table.note else ""))
    if options.json:
        options.json.write_text(json.dumps([asdict(table) for table in made], indent=1, allow_nan=False))
