"""The source document that a profile is the machine of: every printed result beside ours."""

from __future__ import annotations

from typing import TYPE_CHECKING

from camgeom.drawing.content import Block, Text

if TYPE_CHECKING:
    from camgeom.model import Model


def source(model: Model) -> tuple[Block, ...]:
    """The results of the source with their verdicts and reasons; nothing of a profile that names none.

    They are computed from the source's own data, whatever the profile says beside them.
    """
    name = model.profile.reproduces
    if name is None:
        return ()
    from camgeom.validation import source_named, validate
    from camgeom.validation.page import results

    document = source_named(name)
    rows, left = validate((document,), slow=False), sum(entry.slow for entry in document.entries)
    more = f", among them {left} more that take some seconds" if left else ""
    text = (
        f"{document.title}. {document.reference}. Computed from the data that the source prints, whatever this profile "
        f"says beside them; camgeom validate {name} --out DIR draws its figures anew and has all results{more}."
    )
    return (Text((text,)), *results(document, rows))
