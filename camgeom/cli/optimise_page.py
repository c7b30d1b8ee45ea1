"""What is told of a search: the lines, the data, a profile of every member of the front and the page with its plots."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, final

import numpy as np

from camgeom.cli import Console, aligned, number
from camgeom.cli.model import write_set
from camgeom.design.front import Archive, Bools, Front, Ints, balanced, members_in, nothing
from camgeom.design.requirement import Free, Requirement, bounded
from camgeom.design.study import Row
from camgeom.drawing.content import (
    Axis,
    Block,
    Chapter,
    Chart,
    Column,
    Figure,
    Level,
    Mark,
    Page,
    Panel,
    Parallel,
    Series,
    Table,
    Text,
)
from camgeom.errors import ExportError
from camgeom.export.files import write_whole
from camgeom.export.folder import FRONT, read_manifest
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.profile.text import dump
from camgeom.report.delivery import finite
from camgeom.report.page import render

DRAWN = 1000
"""points of the search in the chart of the front"""
MOST_AIMS = 3
"""aims that are drawn over each other"""
SIGNS = {1.0: "<=", -1.0: ">="}
LEVELS = {"pass": Level.PASS, "warn": Level.WARN}


@final
@immutable
class Told:
    """A finished search on its way to the user.

    archive    of the last search; evaluated: points of all searches, which with the judging took so many seconds
    why_not    why exact models searched, None where the batch did
    """

    name: str
    wanted: Requirement
    archive: Archive
    evaluated: int
    front: Front
    why_not: str | None
    took: float
    folder: Path

    @property
    def members(self) -> tuple[Row, ...]:
        """Rows of the front."""
        return self.front.members

    @property
    def shown(self) -> tuple[str, ...]:
        """Figures that are shown: of the aims, and of the bounds that were asked for."""
        asked = (bound.figure for bound in self.wanted.bounds if not bound.own)
        return tuple(dict.fromkeys([*(aim.figure for aim in self.wanted.aims), *asked]))

    @property
    def chosen(self) -> int | None:
        """Number of the balanced member; None where there is none."""
        return balanced(self.members, self.wanted) if self.members else None

    def deliver(self, console: Console, as_json: bool) -> int:
        """Write profiles and page, tell the result; the exit status."""
        every = list(members_in(self.members, self.wanted))
        members = {f"{k:02d}.toml": self._profile(data, f"member {k}") for k, data in enumerate(every, start=1)}
        whole = {}
        if self.chosen is not None:
            which = f"member {self.chosen + 1}, the balanced one,"
            whole["chosen.toml"] = self._profile(every[self.chosen], which)
        copies = self.wanted.study([self.members[0].values], nothing).copies() if members else ()
        profiles = self._written(self.folder / "front", members, copies, console)
        whole["front.html"] = render(self.page())
        files = [*profiles, *self._written(self.folder, whole, copies, console)]
        if as_json:
            console.out(json.dumps(finite(self._data(profiles, files)), indent=2, allow_nan=False))
        else:
            for line in (*self._lines(), *(f"  wrote {file}" for file in files[len(profiles) :])):
                console.out(line)
        return 0 if self.members else 1

    def _written(
        self, folder: Path, contents: dict[str, str], copies: Sequence[tuple[str, bytes]], console: Console
    ) -> list[Path]:
        """Files that appear together in a folder; those of an earlier search that are none of them move away.

        copies   data files that profiles name, as they are; one that lies there alike and is the user's stays his
        """
        earlier = read_manifest(folder, FRONT)
        if contents or earlier:
            ours = {entry["file"] for entry in earlier.get("files", ())}
            data = [one for one in copies if one[0] in ours or not _alike(folder / one[0], one[1])]
            below = [one for one in data if re.search(r"[\\/]", one[0])]  # no manifest knows of folders
            for name, content in below:
                if (folder / name).exists():
                    raise ExportError(f"{folder / name}: is another file than that of the profile: move it away")
                write_whole(folder / name, content)
            data = [one for one in data if one not in below]
            write_set(folder, FRONT, self.name, "optimise", {**contents, **dict(data)}, console, "front")
        return [folder / name for name in contents]

    def _profile(self, data: dict[str, Any], which: str) -> str:
        """The profile of a member, which says where it comes from."""
        sought = ", ".join(aim.words for aim in self.wanted.aims)
        head = f"# {which} of a front of {self.wanted.file}: {sought}\n"
        head += "".join(f"# {one.axis.key} was free\n" for one in self.wanted.free)
        head += "".join(f"# {one.key} was tied\n" for one in self.wanted.ties)
        return head + "\n" + dump(data)

    def _data(self, profiles: Sequence[Path], files: Sequence[Path]) -> dict[str, Any]:
        """The result as plain data."""
        keys = [one.key for one in self.wanted.axes]
        members = [
            {**dict(zip(keys, row.values)), **row.figures, "verdict": row.verdict, "reason": row.reason,
             "file": str(file)}
            for row, file in zip(self.members, profiles)
        ]  # fmt: skip
        return {
            "name": self.name,
            "least": [aim.figure for aim in self.wanted.aims if aim.sign > 0.0],
            "most": [aim.figure for aim in self.wanted.aims if aim.sign < 0.0],
            "bounds": [
                {"figure": b.figure, "comparison": SIGNS[b.sign], "value": b.value, "of": b.said}
                for b in self.wanted.bounds
            ],
            "searched_by": "exact model" if self.why_not else "batch",
            "why_not_batch": self.why_not,
            "searched": self.evaluated,
            "took_s": self.took,
            "judged": self.front.judged,
            "refused": dict(self.front.refused.most_common()),
            "chosen": None if self.chosen is None else self.chosen + 1,
            "front": members,
            "files": [str(file) for file in files],
        }

    def _lines(self) -> list[str]:
        lines = [f"{self.name}: {self._story()}"]
        lines += [f"  {text}" for text in self._notes()]
        lines += [f"  kept: {b.figure} {SIGNS[b.sign]} {b.value:g} ({b.said})" for b in self.wanted.bounds]
        if not self.members:
            return lines
        heads = ["", *(one.key for one in self.wanted.axes), *self.shown, "verdict"]
        cells = [
            [str(i), *(number(value) for value in row.values), *(number(row.figures[f]) for f in self.shown),
             row.verdict + (" <- balanced" if i - 1 == self.chosen else "")]
            for i, row in enumerate(self.members, start=1)
        ]  # fmt: skip
        return [*lines, *(f"  {line}" for line in aligned([heads, *cells])), f"  profiles: {self.folder / 'front'}"]

    def _story(self) -> str:
        """What was done, in a sentence."""
        count, by = self.evaluated, "exact models" if self.why_not else "points of the batch"
        return f"{self._head()}; {count} {by} searched and {self.front.judged} exact models judged in {self.took:.3g} s"

    def _head(self) -> str:
        """How many members there are, and what they pass."""
        what = "what was judged" if self._open() else "every check"
        return f"{len(self.members) or 'no'} member{'s' * (len(self.members) != 1)} of the front, passing {what}"

    def _open(self) -> list[str]:
        """Checks that apply to members and were not judged."""
        return sorted({word for row in self.members for word in str(row.figures["not_judged"] or "").split()})

    def _notes(self) -> list[str]:
        """What the reader has to know beside the members."""
        notes = [] if self.why_not is None else [f"searched by exact models, fewer points: {self.why_not}"]
        if open_ := self._open():
            notes.append(f"not judged, for want of a key: {', '.join(open_)}; camgeom check says what to give")
        if self.front.refused:
            told = ", ".join(f"{reason} ({count})" for reason, count in self.front.refused.most_common(5))
            notes.append(f"refused by the exact model: {told}")
        if not len(self.archive.shares):
            notes.append("no point of the ranges can exist; widen them or look at the profile itself")
        elif not len(self.archive.front()):
            notes.append("no point keeps all bounds; loosen them or widen the ranges")
        return notes

    def page(self) -> Page:
        """The page of the front."""
        aims = self.wanted.aims
        blocks: list[Block] = [Text(tuple(f"{text[0].upper()}{text[1:]}." for text in (self._story(), *self._notes())))]
        if self.members and len(aims) > 1:
            blocks += [self._chart(i, j) for i, j in combinations(range(min(len(aims), MOST_AIMS)), 2)]
        if len(self.members) > 1:
            blocks.append(self._parallel())
        if self.members:
            blocks.append(self._table())
        if self.wanted.bounds:
            bounds = self.wanted.bounds
            kept = tuple((_label(b.figure), SIGNS[b.sign], b.value, unit_of(b.figure), b.said) for b in bounds)
            heads = tuple(map(Column, ("Figure", "", "Limit", "Unit", "Asked by")))
            blocks.append(Table("What the search kept to", heads, kept))
        figures = []
        if self.chosen is not None:
            best = self.members[self.chosen]
            figures = [Figure(_label(name), best.figures[name], unit_of(name)) for name in self.shown[:6]]
        return Page(
            title=self.name,
            kind=f"front of {', '.join(aim.words for aim in aims)}",
            level=None,
            headline=self._head().capitalize(),
            figures=tuple(figures),
            sections=(Chapter("front", "The front", tuple(blocks)), *self._chosen_chapter()),
        )

    def _chosen_chapter(self) -> tuple[Chapter, ...]:
        if self.chosen is None:
            return ()
        row = self.members[self.chosen]
        text = (
            f"Member {self.chosen + 1} is the nearest to the best of every aim at once. Its profile is chosen.toml; "
            "those of all members are in the folder front. Each is ready for camgeom run."
        )
        free_ = tuple((one.key, value) for one, value in zip(self.wanted.axes, row.values))
        return (Chapter("chosen", "The balanced member", (
            Text((text,)), Table("Its keys", (Column("Key"), Column("Value")), free_),
        )),)  # fmt: skip

    def _chart(self, i: int, j: int) -> Chart:
        """Two aims over each other: what was searched, the front, the members."""
        wanted, (x, y) = self.wanted, (self.wanted.aims[i].figure, self.wanted.aims[j].figure)
        seen = np.flatnonzero(np.all(wanted.excess(self.archive.figures) <= 0.0, axis=1))
        front = self.archive.front()
        shown = {name: np.array([float(row.figures[name] or 0.0) for row in self.members]) for name in (x, y)}
        at = {name: bounded(name, self.archive.figures[name]) for name in (x, y)}
        near = seen[_near(wanted.scores(self.archive.figures)[:, [i, j]], seen, front)]
        near = near[:: max(1, len(near) // DRAWN)]
        dots = [Series("searched", at[x][near], at[y][near], 4, dots=True)] if len(near) else []
        best = self.chosen or 0
        return Chart(
            f"{_label(y)} over {_label(x)}: the members before what was searched",
            Axis(_label(x), unit_of(x)),
            (Panel(Axis(_label(y), unit_of(y)),
                   (*dots, Series("members of the front", shown[x], shown[y], 0, dots=True)),
                   marks=(Mark(float(shown[x][best]), float(shown[y][best]), f"{best + 1}, balanced"),), height=1.6),),
        )  # fmt: skip

    def _parallel(self) -> Parallel:
        free_ = [one for one in self.wanted.free if not any(isinstance(v, str) for v in one.axis.values)]
        at = [self.wanted.free.index(one) for one in free_]
        lines = np.array([
            [*(float(row.values[k]) for k in at), *(float(row.figures[f] or 0.0) for f in self.shown)]
            for row in self.members
        ])  # fmt: skip
        ranges = (Axis(one.axis.key, "", *_ends(one)) for one in free_)
        axes = (*ranges, *(Axis(_label(name), unit_of(name)) for name in self.shown))
        return Parallel("Every member across its free keys and figures", axes, lines, self.chosen or 0)

    def _table(self) -> Table:
        heads = [Column("Member"), *(Column(one.key) for one in self.wanted.axes),
                 *(Column(_label(name), unit_of(name)) for name in self.shown), Column("Verdict")]  # fmt: skip
        rows = tuple(
            (i, *row.values, *(row.figures[name] for name in self.shown), LEVELS[row.verdict])
            for i, row in enumerate(self.members, start=1)
        )
        return Table("Members of the front, in the order of the first aim", tuple(heads), rows)


def _alike(path: Path, content: bytes) -> bool:
    """Whether a file of these bytes is there."""
    try:
        return path.stat().st_size == len(content) and path.read_bytes() == content
    except OSError:
        return False


def _near(scores: Floats, seen: Ints, front: Ints) -> Bools:
    """Which of the seen points are beyond the front by no more than its own extent: the others are far off."""
    low, high = scores[front].min(axis=0), scores[front].max(axis=0)
    return np.asarray(np.all(scores[seen] <= high + (high - low), axis=1))


def _ends(one: Free) -> tuple[float, float]:
    """Of the range or the list of a free key."""
    values = [float(value) for value in one.axis.values]
    return min(values), max(values)


UNITS = {"deg": "°", "mm": "mm", "mm3": "mm³", "mpa": "MPa", "n": "N", "h": "h", "kg": "kg"}


def unit_of(name: str) -> str:
    """The unit at the end of a figure's name, as it is printed; empty where it has none or the name is a key."""
    if name.endswith("_n_m"):
        return "N m"
    return UNITS.get(name.rpartition("_")[2], "") if "." in name and "_" in name else ""


def _label(name: str) -> str:
    """A figure's name to be read: its last part without the unit."""
    words = name.rpartition(".")[2] if unit_of(name) else name.removeprefix("flank.")
    unit = "_n_m" if words.endswith("_n_m") else f"_{words.rpartition('_')[2]}" if unit_of(name) else ""
    section = "blank " if name.startswith("blank.") else ""
    return section + words.removesuffix(unit).replace("_", " ")
