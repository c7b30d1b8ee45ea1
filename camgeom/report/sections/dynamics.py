"""Dynamics, where the model has any: indexing drive, elastic follower, impacts in the follower's clearance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from camgeom.drawing.content import Block

if TYPE_CHECKING:
    from camgeom.model import Model


def dynamics(model: Model) -> tuple[Block, ...]:
    """Blocks of what the profile's [dynamics] and [impact] tables ask for; none without them."""
    blocks: tuple[Block, ...] = ()
    program, rotating = model.setup.program, model.profile.rotating
    if model.indexing is not None:
        from camgeom.report.sections.indexing import indexing

        blocks += indexing(model.indexing, program)
    if model.elastic_follower is not None:
        from camgeom.report.sections.elastic import elastic

        blocks += elastic(model.elastic_follower, program, rotating)
    if model.impact is not None:
        from camgeom.report.sections.impacts import impacts

        blocks += impacts(model.impact, rotating)
    return blocks
