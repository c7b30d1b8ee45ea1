"""Dynamics, where the model has any: the indexing drive, and the impacts in the follower's clearance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from camgeom.report.content import Block

if TYPE_CHECKING:
    from camgeom.dynamics.impact_run import ImpactRun
    from camgeom.dynamics.indexing import IndexingDrive
    from camgeom.dynamics.indexing_response import Response
    from camgeom.dynamics.indexing_sweep import Sweep
    from camgeom.model import Model


class Indexing(Protocol):
    """What a model knows of an indexing drive: the drive, its periodic response, and a sweep where one was asked."""

    @property
    def drive(self) -> IndexingDrive: ...

    @property
    def steady(self) -> Response: ...

    @property
    def sweep_speeds(self) -> object: ...

    @property
    def sweep(self) -> Sweep: ...


def dynamics(model: Model) -> tuple[Block, ...]:
    """Blocks of `model.indexing` and of the solved run `model.impact`; none for a model without them."""
    blocks: tuple[Block, ...] = ()
    drive: Indexing | None = getattr(model, "indexing", None)
    if drive is not None:
        from camgeom.report.sections.indexing import indexing

        sweep = drive.sweep if drive.sweep_speeds is not None else None
        blocks += indexing(drive.drive, model.setup.program, drive.steady, sweep)
    run: ImpactRun | None = getattr(model, "impact", None)
    if run is not None:
        from camgeom.report.sections.impacts import impacts

        blocks += impacts(run, model.profile.rotating)
    return blocks
