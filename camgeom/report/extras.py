"""What a report can bring along on request: stills, a turning mechanism, the page as PDF."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from camgeom.errors import DesignError, ExportError

if TYPE_CHECKING:
    from camgeom.model import Model

EXTRAS = {
    "png": "stills of cam, mechanism, section and results; several files, drawn without a display",
    "gif": "the mechanism turning",
    "mp4": "the mechanism turning, needs ffmpeg",
    "webm": "the mechanism turning, needs ffmpeg",
    "pdf": "the report printed, needs Chromium or Chrome",
}
"""formats that are pictures or pages of a model and no file of its bodies"""


def write_extras(
    model: Model,
    folder: Path,
    stem: str,
    kinds: tuple[str, ...],
    page: Path | None,
    refused: bool,
    say: Callable[[str], None],
) -> list[Path]:
    """Write the kinds asked for and give their paths; what cannot be made here is said and left out.

    page is the written report, which a PDF is printed from; refused: the design admits no body to draw.
    """
    from camgeom.report.movie import MOVIES, find_encoder, write_movies
    from camgeom.report.pdf import write_pdf
    from camgeom.report.pictures import write_pictures

    written: list[Path] = []

    def attempt(what: str, job: Callable[[], list[Path]]) -> bool:
        try:
            written.extend(job())
        except (ExportError, DesignError) as error:
            say(f"camgeom: no {what}: {error}")
            return False
        return True

    if "png" in kinds and not refused:
        attempt("pictures", lambda: write_pictures(model, folder, stem))
    movies = [kind for kind in kinds if kind in MOVIES and not refused]
    # One kind without an encoder does not stop the others.
    possible = tuple(kind for kind in movies if kind == "gif" or attempt(kind, partial(_encodes, find_encoder, kind)))
    if possible:
        attempt(" ".join(possible), lambda: write_movies(model, folder, stem, possible))
    if "pdf" in kinds:
        if page is None:
            say("camgeom: no PDF: it is printed from the report; ask for that too")
        else:
            attempt("PDF", lambda: [write_pdf(page, page.with_suffix(".pdf"))])
    return written


def _encodes(find: Callable[[tuple[str, ...]], object], kind: str) -> list[Path]:
    find((kind,))
    return []
