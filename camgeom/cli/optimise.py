"""`camgeom optimise`: the front of a profile within ranges of some keys, every member judged, its profile written."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.cli import Console, whole
from camgeom.cli.model import output_folder, refuse_nameless, refuse_unwritable
from camgeom.cli.optimise_page import Told
from camgeom.cli.study import engine_of
from camgeom.design.engine import Engine
from camgeom.design.front import (
    PASSING,
    Archive,
    ByBatch,
    ByModel,
    Evaluator,
    Foretelling,
    front_of,
    judged,
    learnt,
    search,
)
from camgeom.design.requirement import Aim, Bound, Requirement, figure_name, free, limits_of
from camgeom.design.sampling import tie
from camgeom.design.study import Row
from camgeom.errors import Problem, ProfileError
from camgeom.report.measured import STUDIED, measure, product_of
from camgeom.report.result import compute

if TYPE_CHECKING:
    from camgeom.profile import Profile

POPULATION = {True: 128, False: 48}
"""points of a generation, by the batch and by exact models"""
POINTS = {True: 25_600, False: 768}
"""points of a search; a batch looks at some ten thousand a second, a process at some ten"""
MEMBERS = 24
SEARCHES = 3
"""searches, each after the first with bounds that foretell what checks the members before them failed"""
EVERY = ("motion", "blank", "flank", "checks", "contact", "fatigue")
"""products of a member, with all checks"""
HEAVY = ("solid", "dynamics", "cutter")
"""products that figures may need beside"""


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Search, judge, write; returns 0 where a member passes, else 1."""
    from camgeom.profile import from_data, read_data

    refuse_nameless(arguments.out)
    points, members = whole(arguments.points, "--points", 10, 10**7), whole(arguments.members, "--members", 1, 500)
    engine = engine_of(arguments)
    data = read_data(arguments.profile)
    profile = from_data(data, arguments.profile)
    keys = tuple(free(text) for text in arguments.free)
    name = str(data.get("name", Path(arguments.profile).stem))
    folder = output_folder(arguments.out, name)
    refuse_unwritable(folder)

    base, findings, offered = _own(profile, (*arguments.least, *arguments.most, *arguments.under, *arguments.over))
    aims = tuple(
        Aim(figure_name(word, offered, f"--{key}"), sign)
        for key, sign, words in (("least", 1.0, arguments.least), ("most", -1.0, arguments.most))
        for word in words
    )
    asked = tuple(
        _bound(text, f"--{key}", sign, offered)
        for key, sign, texts in (("under", 1.0, arguments.under), ("over", -1.0, arguments.over))
        for text in texts
    )
    ties = tuple(map(tie, arguments.tie))
    wanted = Requirement(data, arguments.profile, keys, aims, asked, ties)
    why_not = _why_not(profile, wanted)
    if why_not is None:
        from camgeom.design.batch import offered as of_batch

        known: Sequence[str] = of_batch(profile)
    else:
        searched = {*STUDIED, *HEAVY} - {"checks"}  # exact models search without judging
        known = [figure for figure in base.figures if product_of(figure) in searched]
    wanted = replace(wanted, bounds=(*asked, *limits_of(base, findings, known)))

    began = perf_counter()
    evaluate = _evaluator(wanted, profile, engine, why_not)
    rows: list[Row] = []
    evaluated, foretold = 0, wanted
    for _ in range(SEARCHES):
        archive = _searched(foretold, evaluate, why_not is None, points, console)
        evaluated += archive.evaluated
        new = _judged(archive, engine, members or MEMBERS, console)
        rows += new
        bounds, checks = learnt(wanted, rows, findings)
        if not bounds or all(row.verdict in PASSING for row in new):
            break
        foretold = replace(wanted, bounds=(*wanted.bounds, *bounds))
        evaluate = Foretelling(_evaluator(wanted, profile, engine, why_not), wanted, checks)
    took = perf_counter() - began
    front = front_of(wanted, rows, members or MEMBERS)
    return Told(name, wanted, archive, evaluated, front, why_not, took, folder).deliver(console, arguments.json)


def _own(profile: Profile, words: Sequence[str]) -> tuple[Row, list[dict[str, Any]], list[str]]:
    """The profile's own figures, findings, and the names of all figures; the costly ones where a word asks for one."""
    from camgeom.checks import light_checks
    from camgeom.design.batch import offered
    from camgeom.model import Model

    model, checks = Model(profile), light_checks()
    products: tuple[str, ...] = STUDIED
    for more in ((), HEAVY):
        products = (*products, *more)
        figures, verdict, reason = measure(model, products, checks)
        names = (key for key, value in figures.items() if not isinstance(value, str))
        known = list(dict.fromkeys((*names, *offered(profile))))
        try:
            for word in words:
                figure_name(word.partition("=")[0], known, "")
            break
        except ProfileError:
            continue
    findings = compute(model, ("checks",), checks).data.get("checks", [])
    return Row((), figures, verdict, reason), findings, known


def _bound(text: str, key: str, sign: float, known: Sequence[str]) -> Bound:
    word, equals, written = text.partition("=")
    try:
        value = float(written)
    except ValueError:
        value = np.nan
    if not equals or not np.isfinite(value):
        raise ProfileError([Problem(key, "needs FIGURE=VALUE", text[:200], f"for example {key[2:]} size=1e6")])
    figure = figure_name(word, known, key)
    return Bound(figure, sign, value, f"{key} {text}")


def _why_not(profile: Profile, wanted: Requirement) -> str | None:
    """Why the exact model has to search; None where the batch does."""
    from camgeom.design.batch import offered, supports

    for one in wanted.free:
        if any(isinstance(value, str) for value in one.axis.values):
            return f"{one.axis.key}: is no number"
    if reason := supports(profile, [one.key for one in wanted.axes]):
        return reason
    missing = [figure for figure in wanted.figures if figure not in offered(profile)]
    return f"the batch does not give {', '.join(missing)}" if missing else None


def _evaluator(wanted: Requirement, profile: Profile, engine: Engine, why_not: str | None) -> Evaluator:
    """What searches: the batch, or exact models without checks."""
    if why_not is None:
        return ByBatch(profile, wanted)
    heavy = _heavy(wanted)
    light = tuple(name for name in STUDIED if name != "checks")
    return ByModel(wanted, partial(measure, products=(*light, *heavy), checks=()), engine)


def _heavy(wanted: Requirement) -> list[str]:
    """The costly products that its figures need."""
    return [name for name in HEAVY if any(product_of(figure) == name for figure in wanted.figures)]


def _searched(
    wanted: Requirement, evaluate: Evaluator, by_batch: bool, points: int | None, console: Console
) -> Archive:
    population = min(POPULATION[by_batch], points or POPULATION[by_batch])
    total = points or POINTS[by_batch]

    def said(count: int) -> None:
        console.progress(f"searched {count} of {total} points")

    archive = search(wanted, evaluate, population, max(1, total // population), said)
    console.progress("")
    return archive


def _judged(archive: Archive, engine: Engine, members: int, console: Console) -> list[Row]:
    wanted = archive.requirement
    asked = _heavy(wanted)
    tables = (("dynamics", "dynamics"), ("impact", "dynamics"), ("cutter", "cutter"))
    solved = [product for table, product in tables if table in wanted.data]
    products = tuple(dict.fromkeys((*EVERY, *asked, *solved)))

    def said(count: int) -> None:
        console.progress(f"judged {count} members")

    rows = judged(archive, partial(measure, products=products, checks=None), engine, members, said)
    console.progress("")
    return rows


