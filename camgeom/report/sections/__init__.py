"""The report of a model: its facts as sections of a page, each computed only where it is shown.

Every module here writes one or a few sections; `SECTIONS` is their order on the page. A section takes the model and
gives its blocks, an empty tuple where it has nothing to say. What a section cannot compute stands in it as a reason.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, final

from camgeom.drawing.content import Block, Chapter, Page, Text
from camgeom.errors import Problem, ProfileError
from camgeom.maths import within_range
from camgeom.report.result import Products

if TYPE_CHECKING:
    from camgeom.checks.verdict import Verdict
    from camgeom.model import Model

Writer = Callable[["Model"], tuple[Block, ...]]
LOST = "This section cannot be computed"


@final
@dataclass(frozen=True, slots=True)
class SectionEntry:
    """A section: its key and title, and where its writer lives (`module:function` under this package)."""

    key: str
    title: str
    place: str

    def blocks(self, model: Model, products: Products) -> tuple[Block, ...]:
        """What the section shows; where it cannot be computed, the reason instead."""
        name = f"report.{self.key}{f', follower {model.number + 1}' if model.number else ''}"
        blocks = products.attempt(name, lambda: self._written(model))
        if blocks is None:
            return (Text((f"{LOST}: {products[name].reason}",)),)
        if not blocks:
            products.absent(name, "there is nothing of the kind to show")
        return blocks

    def _written(self, model: Model) -> tuple[Block, ...]:
        module, _, function = self.place.partition(":")
        writer: Writer = getattr(import_module(f"{__name__}.{module}"), function)
        with within_range(f"section {self.key}"):
            return writer(model)


SECTIONS = (
    SectionEntry("checks", "Checks", "judgement:check_table"),
    SectionEntry("design", "Design", "design:design"),
    SectionEntry("solid", "Mechanism in 3D", "mechanism:mechanism"),
    SectionEntry("motion", "Motion", "motion:motion"),
    SectionEntry("flank", "Flank geometry", "flank:flank"),
    SectionEntry("contact", "Contact and drive", "load:contact"),
    SectionEntry("fatigue", "Fatigue life", "life:life"),
    SectionEntry("followers", "Followers together", "followers:followers"),
    SectionEntry("body", "Stress in the body", "body:body"),
    SectionEntry("dynamics", "Dynamics", "dynamics:dynamics"),
    SectionEntry("cutter", "Cutter data", "cutter:cutter"),
    SectionEntry("tolerance", "Tolerances", "tolerance:tolerance"),
    SectionEntry("validation", "Validation", "record:validation"),
    SectionEntry("source", "The source, recomputed", "record:source"),
    SectionEntry("parameters", "Parameters", "record:parameters"),
    SectionEntry("cost", "What was computed", "record:cost"),
)
"""The sections in their order; checks also give the verdict at the head of the page."""
OWN = ("motion", "flank", "contact", "fatigue", "body", "dynamics")
"""sections that stand again for every further track of the body"""
LOADED = ("tolerance",)
"""sections that stand again for every further follower"""


def report(
    model: Model,
    only: Collection[str] | None = None,
    judged: Verdict | None = None,
    products: Products | None = None,
) -> Page:
    """The page about a model; `only` names the sections wanted, `judged` the verdict where it is known already.

    products  what became of the other products, which the page then tells; takes the notes on its sections
    Raises ProfileError for an unknown section.
    """
    wanted, noted = chosen(only), products if products is not None else Products()
    told = tuple(noted)
    from camgeom.report.sections.bodies import KEPT
    from camgeom.report.sections.judgement import head, key_figures
    from camgeom.report.sections.record import product_table

    if judged is not None:
        KEPT.setdefault(model, {})["checks"] = judged

    figures = noted.attempt("report.figures", lambda: key_figures(model, wanted)) or ()
    sections = []
    for entry in SECTIONS:
        followers = model.bindings if entry.key in LOADED else model.grooves if entry.key in OWN else (model,)
        own = len(followers) > 1
        for one in (model, *followers[1:]):
            if entry.key in wanted and (blocks := entry.blocks(one, noted)):
                key = entry.key if one is model else f"{entry.key}-{one.number + 1}"
                whose = f", follower {one.number + 1}" if own else ""
                sections.append(Chapter(key, entry.title + whose, blocks))
    if told and only is None:
        sections.append(Chapter("products", "What was made", (product_table(told),)))
    return head(model, "checks" in wanted, figures, tuple(sections))


def chosen(only: Collection[str] | None) -> tuple[str, ...]:
    """Keys of the sections wanted, in page order. Raises ProfileError for an unknown one."""
    known = tuple(entry.key for entry in SECTIONS)
    if only is None:
        return known
    strange = [name for name in only if name not in known]
    if strange:
        from camgeom.errors import did_you_mean

        text = "unknown report section"
        raise ProfileError([Problem("--only", text, n, ", ".join(known), did_you_mean(n, known)) for n in strange])
    return tuple(key for key in known if key in only)


def write_report(
    model: Model,
    path: str | Path,
    only: Collection[str] | None = None,
    judged: Verdict | None = None,
    products: Products | None = None,
) -> Path:
    """Write the report as one HTML file, whole or not at all, and give its path; arguments as of `report`."""
    from camgeom.export.files import write_whole
    from camgeom.report.page import render

    text = render(report(model, only, judged, products), products)
    write_whole(path, text)
    return Path(path)
