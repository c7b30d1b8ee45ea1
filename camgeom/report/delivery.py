"""From what a command was asked for to the folder of its files: every product on its own, whatever others become."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from camgeom.errors import CamgeomError, DesignError, ExportError, unmade
from camgeom.immutable import immutable
from camgeom.report.result import Product, Products, Result, compute, explain

if TYPE_CHECKING:
    from camgeom.export import Format
    from camgeom.export.folder import RunFolder
    from camgeom.model import Model

RESULT, PAGE = "result.json", "report.html"
RESERVE = 1 << 26
"""bytes kept until the result is put together: what was made and what was not is told where memory runs out, too"""


@final
@immutable(eq=True)
class Order:
    """What a command was asked for.

    products  of `report.result.PRODUCTS`; checks: names, None for all
    formats   of the profile or the command line, known ones; written where "exports" is among the products, pictures,
              films and the printed page also where the report is
    sections  of the report, None for all
    stem      how the names of its files begin
    """

    command: str
    products: tuple[str, ...]
    checks: tuple[str, ...] | None
    formats: tuple[str, ...]
    sections: tuple[str, ...] | None
    stem: str
    explained: bool = False


def deliver(model: Model, order: Order, folder: RunFolder | None, say: Callable[[str], None]) -> Result:
    """The result of an order; with a folder its files appear there, together.

    say  takes what there is to know of a file that was made
    Formats that cannot apply are told before anything is computed. Raises ExportError where the result itself cannot be
    written; what stood in the folder then stands as it was.
    """
    # Of what was read, whatever becomes of its files while they are worked on.
    design = model.profile.digest() if folder is not None else ""
    if folder is not None:
        folder.path(RESULT)
    reserve = bytes(RESERVE)
    products = Products(folder.shown if folder else lambda reason: reason)
    possible = [name for name in order.formats if _applies(model, name, order, products)]
    result = compute(model, order.products, order.checks, products)
    if folder is not None:
        try:
            _files(model, order, possible, folder, result, say)
        except MemoryError as error:
            reserve = b""
            for name in possible if "exports" in order.products else ():
                if name not in products:
                    products.unmade(name, unmade(error))
            if "report" in order.products and "report" not in products:
                products.unmade("report", unmade(error))
    del reserve
    named = dict.fromkeys(file for one in products for file in one.files)
    result.data["files"] = [str(folder.folder / file) for file in named] if folder else []
    result.data.update(model.ledger.notes)
    result.data["products"] = products.as_dict()
    result.data["cost_s"] = {name: round(seconds, 6) for name, seconds in model.ledger.costs.items()}
    if order.explained:
        result.data["explain"] = explain(model, order.products)
    result = Result(finite(result.data), result.verdict, products)
    if folder is not None:
        _close(model, order, folder, result, design)
    return result


def _applies(model: Model, name: str, order: Order, products: Products) -> bool:
    """Whether the cam may have such a file; where it may not, that is noted."""
    from camgeom.report.files import EXTRAS, format_of

    reason = ""
    if name not in EXTRAS:
        try:
            reason = format_of(name).missing(model)
        except Exception as error:
            products.unmade(name, unmade(error))
            return False
    elif name == "pdf" and "exports" in order.products and "report" not in order.products:
        reason = "it is printed from the report; ask for that too"
    if reason:
        products.absent(name, reason, 1)
    return not reason


def _files(
    model: Model, order: Order, formats: list[str], folder: RunFolder, result: Result, say: Callable[[str], None]
) -> None:
    """Write every file that was asked for but the result, the report after what it tells of."""
    from camgeom.report.files import EXTRAS, format_of
    from camgeom.report.movie import MOVIES

    products = result.products
    if "exports" in order.products:
        for name in formats:
            if name not in EXTRAS:
                _format(model, name, format_of(name), f"{order.stem}{format_of(name).extension}", folder, products, say)
    if "png" in formats:
        _pictures(model, order.stem, folder, products)
    films = tuple(name for name in formats if name in MOVIES)
    if films:
        _films(model, order.stem, films, folder, products)
    if "report" in order.products:
        from camgeom.report.sections import write_report

        judged = result.verdict if "checks" in order.products else None
        job = lambda: write_report(model, folder.path(PAGE), order.sections, judged, products)  # noqa: E731
        page = products.attempt("report", lambda: model.ledger.book("report", job), (PAGE,))
        if "pdf" in formats and page is not None:
            from camgeom.report.pdf import write_pdf

            name = Path(PAGE).with_suffix(".pdf").name
            printed = lambda: write_pdf(page, folder.path(name))  # noqa: E731
            products.attempt("pdf", lambda: model.ledger.book("pdf", printed), (name,))
        elif "pdf" in formats:
            products.note(Product("pdf", "failed", "there is no report to print", 1))


def _format(
    model: Model,
    name: str,
    form: Format,
    file: str,
    folder: RunFolder,
    products: Products,
    say: Callable[[str], None],
) -> None:
    from camgeom.report.files import write

    def job() -> str:
        path = folder.path(file)
        if form.body:
            refuse_bodiless(model)
        write(model, path)
        return _rounded(model) if form.extension == ".stl" else ""

    if told := products.attempt(name, lambda: model.ledger.book(name, job), (file,)):
        products.note(Product(name, "made", told, 0, (file,)))
        say(f"{folder.folder / file}: {told}")


def refuse_bodiless(model: Model) -> None:
    """Raise DesignError where the design admits no body; one that could not be made for another reason is no matter."""
    try:
        _ = model.solids
    except DesignError:
        raise
    except (CamgeomError, MemoryError):
        return


def _rounded(model: Model) -> str:
    """What an STL's 32-bit coordinates add to a fine tolerance; empty where it is little."""
    from camgeom.export.triangles import NOTED, rounding

    lost = max(rounding(solid.mesh) for solid, _ in model.workpieces)
    if lost <= NOTED * model.tolerance:
        return ""
    moved = f"32-bit coordinates move vertices by up to {lost:.2g} mm"
    return f"{moved} beside the tolerance {model.tolerance:g} mm; 3mf, ply and step keep it"


def _pictures(model: Model, stem: str, folder: RunFolder, products: Products) -> None:
    from camgeom.report.pictures import stills

    def found() -> dict[str, Callable[[Path], int]]:
        refuse_bodiless(model)
        return stills(model)

    book = model.ledger.book
    drawn = products.attempt("png", lambda: book("png", found))
    if drawn is None:
        return
    for what, draw in drawn.items():
        file = f"{stem}-{what}.png"
        products.attempt(f"png.{what}", lambda: book(f"png.{what}", lambda: draw(folder.path(file))), (file,))  # noqa: B023
    products.gather("png")


def _films(model: Model, stem: str, kinds: tuple[str, ...], folder: RunFolder, products: Products) -> None:
    from camgeom.report.movie import Films

    films = Films(model, kinds)
    for kind in kinds:
        file = f"{stem}-turning.{kind}"

        def job() -> None:
            refuse_bodiless(model)
            films.write(kind, folder.path(file))  # noqa: B023

        products.attempt(kind, lambda: model.ledger.book(kind, job), (file,))  # noqa: B023


def _close(model: Model, order: Order, folder: RunFolder, result: Result, digest: str) -> None:
    """Write the result and let all files appear; digest: of the profile."""
    import hashlib
    import json

    from camgeom.export.files import write_whole

    text = json.dumps(result.data, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    try:
        write_whole(folder.path(RESULT), text)
    except ExportError as error:
        raise ExportError(folder.shown(str(error))) from error
    products, version = result.products, result.data["version"]
    made = {file: one.name for one in products for file in one.files if not one.name.startswith("png.")}
    about = {
        "name": model.profile.name,
        "stem": order.stem,
        "command": order.command,
        "version": version,
        "tolerance_mm": model.tolerance,
        "profile_sha256": digest,
    }
    design = hashlib.sha256(json.dumps([about[k] for k in ("profile_sha256", "version", "tolerance_mm")]).encode())
    asked = {one.name for one in products} | {RESULT}
    folder.close(about, design.hexdigest(), {**made, RESULT: RESULT}, asked)


def finite(value: Any) -> Any:
    """Plain data with null for every number that JSON cannot say (an endless life, a curvature at a cusp)."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value
