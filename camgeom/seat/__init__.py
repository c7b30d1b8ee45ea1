"""What a designer's program holds: models that show themselves, and studies as arrays (`variants`).

`camgeom.read` and `camgeom.Model` are those of here: a line with the verdict where a model was judged, in a notebook
the head of its report.
"""

from __future__ import annotations

from html import escape

from camgeom.model import PAINTERS, TELLERS, Model, read

__all__ = ["Model", "read"]

HEIGHT = 760
"""px of the frame in a notebook"""


def told(model: Model) -> str:
    """What a model's line says of its verdict; nothing is judged for it."""
    from camgeom.report.sections.bodies import KEPT

    verdict = KEPT.get(model, {}).get("checks")
    return verdict.sentence if verdict is not None else "not judged yet"


def painted(model: Model) -> str:
    """The model's verdict, key figures and main section as a frame of HTML; judges it where that was not done."""
    from camgeom.drawing.content import Chapter, Text
    from camgeom.errors import CamgeomError
    from camgeom.report.page import render
    from camgeom.report.sections.bodies import cam_meshes
    from camgeom.report.sections.design import views
    from camgeom.report.sections.judgement import head, key_figures

    figures = key_figures(model, ("motion", "flank", "contact", "fatigue", "solid"))
    try:
        drawn = Chapter("section", "Section", (views(model, cam_meshes(model))[0],))
    except CamgeomError as error:
        drawn = Chapter("section", "Section", (Text((f"No body can be drawn: {error}.",)),))
    page = render(head(model, True, figures, (drawn,)))
    style = f"width:100%;height:{HEIGHT}px;border:0"
    return f'<iframe title="{escape(model.profile.name)}" srcdoc="{escape(page)}" style="{style}"></iframe>'


if told not in TELLERS:
    TELLERS.append(told)
    PAINTERS.append(painted)
