"""Bands side by side round an axis, meshed with a guaranteed chord error: columns and rows of each band its own.

A band is a surface x(phi, u), phi the angle round and u = 0 .. 1 the way across, whose edge u = 1 is the next band's
edge u = 0. With the second form L, M, N in (phi, u) a cell of h by g has sags |L| h² / 8 and |N| g² / 8 along its sides
and |L h² +- 2 M h g + N g²| / 8 along a diagonal, the better of which is taken. From that follows, for any number of
rows, the longest step of the columns, and so the number that makes the fewest triangles, block by block of the turn.
Between two bands stands an edge with steps of its own; what lies between it and the first row of a band is joined
vertex by vertex, as is the one column in which the number of rows changes. Where a band has no width to speak of its
edges and columns have the same steps.

What is stated is measured: the true surface in the middle of every cell and of every edge. Edges that are off by more
than the tolerance are split there.
"""

from __future__ import annotations

from collections.abc import Sequence

from camgeom.maths import Floats
from camgeom.maths.banded.facets import Band, Banded, Index, Shares, within
from camgeom.maths.banded.plan import Longest, forms_of, planned
from camgeom.maths.banded.rows import meshed

__all__ = ["Band", "Banded", "Index", "banded", "forms_of"]


def banded(
    bands: Sequence[Band], knots: Floats, closed: bool = True, shares: Shares | None = None,
    longest: Longest | None = None, steady: bool = False,
) -> Banded:
    """Mesh bands from the first of the knots to the last, where they close on themselves or end.

    knots   (k,) angles at which a derivative may jump, with both ends. NotConverged where it takes too many triangles.
    shares  of the tolerance that facets are kept to, told from their corners (3, 3, f); None: all of it
    longest  steps (2, n) of the first edge and of the last at angles (n,) and points (2, 3, n), for what is beyond
    steady   whether numbers of rows are kept where a change would cost more than it saves
    """
    return within(bands, meshed(bands, planned(bands, knots, closed, longest, steady), shares))
