"""The result that scripts rely on: its pieces from the model's facts, the products a command asks for, what it cost."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from math import degrees
from typing import TYPE_CHECKING, Any, Literal, TypeVar, final

from camgeom.errors import Problem, ProfileError, Unmade, unmade
from camgeom.immutable import immutable
from camgeom.maths import within_range
from camgeom.report.data.geometry import blank_data, flank_data, motion_data, solid_data
from camgeom.report.figures import VERSION
from camgeom.version import __version__

if TYPE_CHECKING:
    from camgeom.checks.verdict import Finding, Verdict
    from camgeom.model import Model

PRODUCTS = (
    "motion", "blank", "flank", "checks", "solid", "contact", "fatigue", "body", "dynamics", "cutter", "tolerance",
    "exports", "report",
)
FIRST = {"motion", "blank", "flank"}
"""products that stand before the checks in the result"""
LOADED = {"contact", "fatigue", "dynamics", "tolerance"}
"""products that are another follower's own, on a track that all of them share"""
OWN = {"motion", "flank", "body"}
"""products that it has of its own where its track is its own"""
RIDES = {"impact": "dynamics", "together": "contact", "output_shaft": "contact", "together.tolerance": "tolerance"}
"""sections that are made with another product"""
COMMANDS: dict[str, tuple[str, ...]] = {
    "run": tuple(name for name in PRODUCTS if name != "body"),
    "build": ("motion", "blank", "solid", "cutter", "exports"),
    "check": ("motion", "blank", "flank", "checks"),
    "solve": ("motion", "contact", "fatigue", "dynamics", "tolerance"),
    "report": ("motion", "blank", "flank", "checks", "solid", "contact", "fatigue", "dynamics", "tolerance", "report"),
}


Status = Literal["made", "not applicable", "refused", "failed"]
RANK: dict[Status, int] = {"made": 0, "not applicable": 1, "refused": 2, "failed": 3}
T = TypeVar("T")


@final
@immutable(eq=True)
class Product:
    """One product: a section of the result, a body, a section of the report, a format, a picture.

    status       "made"; "not applicable" where the cam or its profile has no such thing, which is known before anything
                 is computed; "refused" where the design admits none; "failed" where it could not be made
    reason       why it was not made; of what was made, what there is to know of it
    exit_status  what it means for the command: 0, or 1 to 3
    files        names of its files in the folder of the run
    trace        where an error of camgeom itself came from
    """

    name: str
    status: Status
    reason: str = ""
    exit_status: int = 0
    files: tuple[str, ...] = ()
    trace: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The product as plain data for result.json, what is empty left out."""
        data: dict[str, Any] = {"status": self.status, "reason": self.reason, "files": list(self.files)}
        data["trace"] = self.trace.splitlines()
        return {key: value for key, value in data.items() if value}


class Products:
    """The products of one command in the order in which they were tried; names of parts follow a dot, `png.section`.

    shown  how a reason is worded for the user: the place where a file is made is not where it will stand
    """

    def __init__(self, shown: Callable[[str], str] = lambda reason: reason) -> None:
        self._products: dict[str, Product] = {}
        self._shown = shown

    def __iter__(self) -> Iterator[Product]:
        return iter(self._products.values())

    def __contains__(self, name: str) -> bool:
        return name in self._products

    def __getitem__(self, name: str) -> Product:
        return self._products[name]

    def attempt(self, name: str, job: Callable[[], T], files: tuple[str, ...] = ()) -> T | None:
        """The outcome of a job, which makes the named files; None, and the reason noted, where it fails."""
        try:
            found = job()
        except Exception as error:
            self.unmade(name, unmade(error))
            return None
        self.note(Product(name, "made", files=files))
        return found

    def unmade(self, name: str, why: Unmade) -> None:
        """Note a product that could not be made."""
        self.note(Product(name, why.status, self._shown(why.reason), why.exit_status, trace=why.trace))

    def absent(self, name: str, reason: str, exit_status: int = 0) -> None:
        """Note a product that does not apply; exit status 1 where it was asked for by name."""
        self.note(Product(name, "not applicable", reason, exit_status))

    def note(self, product: Product) -> None:
        """Note a product."""
        self._products[product.name] = product

    def gather(self, name: str, whole: bool = True) -> None:
        """Note a product of parts, as good as the worst, with all their files; `whole`: there are no other parts."""
        parts = [product for product in self if product.name.startswith(f"{name}.")]
        worst = max(parts, key=lambda part: RANK[part.status])
        files = tuple(file for part in parts for file in part.files)
        status = max(part.exit_status for part in parts)
        lacking: dict[str, list[str]] = {}
        for part in parts:
            if part.status != "made":
                lacking.setdefault(part.reason, []).append(part.name.partition(".")[2])
        every = len(parts) if whole else -1
        told = (why if len(names) == every else f"{', '.join(names)}: {why}" for why, names in lacking.items())
        reason = "; ".join(told)
        self.note(Product(name, worst.status, reason, status, files))

    @property
    def exit_status(self) -> int:
        """The worst."""
        return max((product.exit_status for product in self), default=0)

    def as_dict(self) -> dict[str, dict[str, Any]]:
        """All products as plain data for result.json, by name."""
        return {product.name: product.as_dict() for product in self}


@immutable
class Result:
    """What a job found: plain data for result.json, the findings, their verdict, and what became of every product."""

    data: dict[str, Any]
    verdict: Verdict
    products: Products

    @property
    def exit_status(self) -> int:
        """The worst of the products; 1 where a finding fails."""
        return max(self.products.exit_status, int(self.verdict.level == "fail"))

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was judged."""
        return self.verdict.findings


def chosen(command: str, only: Iterable[str] | None) -> tuple[tuple[str, ...], tuple[str, ...] | None]:
    """Products and checks that a command computes; `only` narrows them. Raises ProfileError for an unknown name.

    A body that is asked for is judged, too.
    """
    products = COMMANDS[command]
    if only is None:
        return products, None
    from difflib import get_close_matches

    from camgeom.checks import checks

    names = tuple(only)
    known = (*PRODUCTS, *checks())
    for name in names:
        if name not in known:
            near = get_close_matches(name, known, 1, 0.5)
            hint = f"did you mean {near[0]}?" if near else ""
            raise ProfileError([Problem("--only", "unknown product or check", name, ", ".join(known), hint)])
    wanted = tuple(name for name in names if name in PRODUCTS)
    single = tuple(name for name in names if name not in PRODUCTS)
    if "body" in wanted and "checks" not in wanted:
        single = (*single, "root-stress")
    return tuple(dict.fromkeys((*wanted, *(("checks",) if single else ())))), single or None


def compute(
    model: Model, wanted: Iterable[str], only_checks: Iterable[str] | None = None, products: Products | None = None
) -> Result:
    """The result of the named products, each computed, or its reason in its place; `products` takes the notes."""
    from camgeom.checks.verdict import Verdict

    asked, noted = set(wanted), products if products is not None else Products()
    if "contact" in asked and model.root_limit is not None:
        asked.add("body")
    data: dict[str, Any] = {"schema": VERSION, "name": model.profile.name, "kind": model.profile.kind}
    data["version"] = __version__
    if model.profile.units_note:
        data["units"] = model.profile.units_note
    if model.profile.reproduces is not None:
        data["reproduces"] = model.profile.reproduces
    data |= _sections(model, asked & FIRST, noted)
    verdict = Verdict(())
    if "checks" in asked:
        from camgeom.checks import judge

        verdict = noted.attempt("checks", partial(judge, model, only_checks)) or verdict
        data["verdict"] = verdict.level
        if verdict.loads is not None:
            data["loads"] = verdict.loads.as_dict()
        data["not_judged"] = [word.as_dict() for word in verdict.not_judged]
        data["checks"] = [finding.as_dict() for finding in verdict.findings]
        for name, why in verdict.lost:
            noted.unmade(f"checks.{name}", why)
        if verdict.lost:
            noted.gather("checks", whole=False)
    data |= _sections(model, asked - FIRST, noted)
    if len(model.bindings) > 1:
        data["followers"] = [
            {"angle_deg": degrees(one.angle), "track": one.groove + 1,
             **_sections(one, asked & (LOADED | OWN if one in model.grooves else LOADED), noted,
                         f"follower {one.number + 1}.")}
            for one in model.bindings[1:]
        ]
    data["files"] = []
    return Result(data, verdict, noted)


def _sections(model: Model, asked: set[str], products: Products, prefix: str = "") -> dict[str, Any]:
    """The sections asked for; the reason in the place of what cannot be made, nothing of what does not apply."""
    data: dict[str, Any] = {}
    for name, (source, absent) in SOURCES.items():
        if RIDES.get(name, name) not in asked or (name in ONLY and not ONLY[name](model)):
            continue
        product = f"{prefix}{name}"
        job = partial(_within, name, source, model)
        # Whether there is such a thing may hang on what cannot be made: that is the product's own reason too.
        reason = products.attempt(product, partial(absent, model))
        found = None if reason is None else {} if reason else products.attempt(product, job)
        if found is None:
            told = products[product]
            found = {told.status: told.reason}
        elif not found:
            products.absent(product, reason or "the cam has nothing of the kind")
            continue
        if name == "impact":
            data.setdefault("dynamics", {})["impact"] = found
        elif name == "together.tolerance":
            data.setdefault("together", {})["tolerance"] = found
        else:
            data[name] = found
    return data


def _within(name: str, source: Callable[[Model], dict[str, Any]], model: Model) -> dict[str, Any]:
    """A section's data; NotConverged where a number leaves its range on the way."""
    with within_range(name):
        return source(model)


def own_sections(others: Sequence[Mapping[str, Any]]) -> set[str]:
    """Sections of the result that are each follower's own, by the rows of the further ones; none of one follower."""
    # On one track motion and flank are those of all.
    return (LOADED if others else set()) | (OWN if any(other["track"] > 1 for other in others) else set())


def explain(model: Model, products: Iterable[str]) -> list[str]:
    """What was computed and what it cost, and what was skipped and why."""
    lines = [f"{seconds * 1e3:9.2f} ms  {name}" for name, seconds in model.ledger.costs.items()]
    facts = ("flanks", "solids", "clearances", "mass", "duty")
    skipped = [name for name in facts if name not in model.ledger.costs]
    reasons = dict.fromkeys(skipped, "not asked for")
    if "duty" in skipped and not model.duties:
        reasons["duty"] = "the profile has no [operation], or no roller that one load bears on"
    lines += [f"  skipped     {name}: {reason}" for name, reason in reasons.items()]
    missing = [name for name in PRODUCTS if name not in set(products)]
    if missing:
        lines.append(f"  not asked   {', '.join(missing)}")
    import sys

    heavy = [m for m in ("scipy", "trimesh", "pyvista", "meshio", "manifold3d", "ezdxf") if m in sys.modules]
    lines.append(f"  imported    {', '.join(heavy) if heavy else 'none of the heavy libraries'}")
    return lines


NO_ROOT = ("stress in the body is found under an [operation] at the root of a closed groove, in a body with a bore, "
           "and in a frame with a plate")  # fmt: skip


def body_data(model: Model) -> dict[str, Any]:
    """Nominal and peak stress at a root. Raises DesignError where its volume is not meshed."""
    assert model.root_stress is not None
    return model.root_stress.data()


def cutter_data(model: Model) -> dict[str, Any]:
    """The tool's passes and what they leave. Raises DesignError where the tool cannot make the cam."""
    return model.machined.data()


def tolerance_data(model: Model) -> dict[str, Any]:
    """What the errors of [tolerance] do, each alone and all together."""
    from camgeom.tolerance.study import tolerance_data as told

    return told(model.tolerances)


def machine_data(model: Model) -> dict[str, Any]:
    """What the limits of [tolerance] come to for all followers of a machine together."""
    from camgeom.tolerance.machine import machine_data as told

    return told(model.machine_tolerances)


def _told_by(module: str, name: str) -> Callable[[Model], dict[str, Any]]:
    """A section's data from a module of `report.data`, which only who asks for the section enters."""

    def told(model: Model) -> dict[str, Any]:
        found: dict[str, Any] = getattr(import_module(f"camgeom.report.data.{module}"), name)(model)
        return found

    return told


def _unless(known: object, reason: str) -> str:
    return "" if known else reason


NO_OPERATION = "the profile has no [operation]"
ONLY: dict[str, Callable[[Model], bool]] = {
    "together": lambda model: not model.number and len(model.bindings) > 1,
    "together.tolerance": lambda model: not model.number and len(model.bindings) > 1,
    "output_shaft": lambda model: model.profile.follower.shares,
}
"""sections that say nothing of other cams, not even that they do not apply"""
Source = tuple[Callable[["Model"], dict[str, Any]], Callable[["Model"], str]]
SOURCES: dict[str, Source] = {
    "motion": (motion_data, lambda model: ""),
    "blank": (blank_data, lambda model: ""),
    "flank": (flank_data, lambda model: ""),
    "solid": (solid_data, lambda model: ""),
    "contact": (_told_by("load", "contact_data"), lambda model: _unless(model.profile.operation, NO_OPERATION)),
    "together": (_told_by("load", "together_data"), lambda model: _unless(model.profile.operation, NO_OPERATION)),
    "output_shaft": (
        _told_by("load", "output_data"),
        lambda model: _unless(model.profile.output_shaft, "the profile has no [output_shaft]")
        or _unless(model.profile.operation, NO_OPERATION),
    ),
    "fatigue": (_told_by("load", "fatigue_data"), lambda model: _unless(model.profile.operation, NO_OPERATION)),
    "body": (body_data, lambda model: _unless(model.root_stress, NO_ROOT)),
    "dynamics": (
        _told_by("solved", "dynamics_data"),
        lambda model: _unless(model.profile.dynamics_spec, "the profile has no [dynamics]"),
    ),
    "impact": (
        _told_by("solved", "impact_data"),
        lambda model: _unless(model.profile.impact_spec, "the profile has no [impact]"),
    ),
    "cutter": (cutter_data, lambda model: _unless(model.profile.cutter, "the profile has no [cutter]")),
    "tolerance": (tolerance_data, lambda model: _unless(model.profile.tolerance, "the profile has no [tolerance]")),
    "together.tolerance": (
        machine_data,
        lambda model: _unless(model.profile.tolerance, "the profile has no [tolerance]")
        or _unless(model.machine_tolerances.limited, "the table gives no limit"),
    ),
}
"""How a section of the result is made, and why it does not apply to a model, empty where it does."""
