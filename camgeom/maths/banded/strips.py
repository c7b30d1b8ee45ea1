"""Strips of triangles between chains of vertices that do not stand beside each other."""

from __future__ import annotations

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.banded.facets import Index, Mask


@immutable
class Strips:
    """Triangles between chains of vertices that do not stand beside each other.

    phi, u   of the vertices of the chains, and the vertex of each: number
    corner   (f, 3) places of the triangles' corners among them
    ends     (c, 2) places of both ends of every chord from chain to chain: before each triangle, and the last of each
             strip; links (f, 2): of the links of chains
    is_low   (f,) whether two corners of a triangle are on the lower chain; after (f,): number of the chord behind it
    band     of every triangle, and then of the strips' last chords
    """

    phi: Floats
    u: Floats
    number: Index
    corner: Index
    ends: Index
    links: Index
    is_low: Mask
    after: Index
    band: Index

    @classmethod
    def zipped(
        cls, phi: Floats, u: Floats, number: Index, band: Index, low: Index, high: Index, across: Mask, lean: Floats,
        far: float,
    ) -> Strips:  # fmt: skip
        """Between chains low and high (s, 2): the place of the first vertex of each, and the number of links.

        phi, u  of the vertices of all chains (c,), and the number of each; a chain is a piece of them
        band    (s,) of each strip
        across  (s,) whether the chains run along u, not along phi
        lean    (c,) at vertices of the higher chain, by how much those of the lower one best stand before them
        far     more than phi and u change in all
        Every link is joined to the nearest vertex of the other chain.
        """
        (s, i), (t, j) = _links(low), _links(high)
        one = 0.5 * np.where(across[s], u[i] + u[i + 1], phi[i] + phi[i + 1]) + far * s
        other = 0.5 * np.where(across[t], u[j] + u[j + 1], phi[j] + phi[j + 1]) - lean[j] + far * t
        # Chains must not turn back.
        other = np.maximum.accumulate(other)
        # Each link's place among those of both chains, and how many of the other one come before it.
        passed, gone = np.searchsorted(other, one), np.searchsorted(one, other, side="right")
        size = len(one) + len(other)
        at_low, at_high = np.arange(len(one)) + passed, np.arange(len(other)) + gone
        is_low = np.zeros(size, dtype=bool)
        is_low[at_low] = True
        strip, link, tip = (np.empty(size, dtype=np.int64) for _ in range(3))
        strip[at_low], strip[at_high] = s, t
        link[at_low], link[at_high] = i, j
        tip[at_low] = (high[:, 0] - np.cumsum(high[:, 1]) + high[:, 1])[s] + passed
        tip[at_high] = (low[:, 0] - np.cumsum(low[:, 1]) + low[:, 1])[t] + gone
        a, c = np.where(is_low, link, tip), np.where(is_low, tip, link)
        final = np.flatnonzero(np.append(strip[1:] != strip[:-1], True))
        after = np.arange(1, size + 1)
        after[final] = size + np.arange(len(final))
        last = strip[final]
        ends = np.stack([np.append(a, low[last].sum(axis=1)), np.append(c, high[last].sum(axis=1))], axis=1)
        return cls(
            phi, u, number, np.stack([a, link + 1, c], axis=1), ends, np.stack([link, link + 1], axis=1), is_low, after,
            band[np.append(strip, last)],
        )  # fmt: skip

    @staticmethod
    def middle(x: Floats, ends: Index) -> Floats:
        """Half way (n,) between two places (n, 2)."""
        return np.asarray(0.5 * (x[ends[:, 0]] + x[ends[:, 1]]))

    def middles(self, chords: Floats, links: Floats) -> Floats:
        """True middles (3, 3, f) of the triangles' edges from those of all chords (3, c) and of the links (3, f)."""
        beyond = chords[:, self.after]
        mids = np.empty((3, 3, len(self.is_low)))
        mids[:, 0] = np.where(self.is_low, links, beyond)
        mids[:, 1] = np.where(self.is_low, beyond, links)
        mids[:, 2] = chords[:, : len(self.is_low)]
        return mids


def _links(chains: Index) -> tuple[Index, Index]:
    """Of every link of chains (s, 2) its chain, and the place of its first vertex."""
    return counted(chains[:, 1], chains[:, 0])


def counted(size: Index, start: Index) -> tuple[Index, Index]:
    """Of runs of so many numbers (s,) from their starts, one after the other: the run of each, and the numbers."""
    own = np.repeat(np.arange(len(size)), size)
    return own, np.arange(len(own)) + (start - np.cumsum(size) + size)[own]
