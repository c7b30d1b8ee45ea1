"""Studies of many variants by the batch: columns of a piece at a time, judged as far as the figures decide."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, product
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.design.batch import LEVELS, evaluate, leveled, offered, supports
from camgeom.design.batch.judged import BEARING, FACE, JUDGED, LIFE, LIVES, Words, check_of, judged
from camgeom.design.batch.variants import SOLVED
from camgeom.design.sampling import Column, Plan
from camgeom.design.study import Data, Value, replaced
from camgeom.errors import ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

TRIED = 24
"""variants by which it is told whether anything hangs on a key"""


@final
@immutable(eq=True)
class Bulk:
    """The variants of a plan, which figures are wanted of them (names of a study's columns), and how near an indexer's
    pressures have to be."""

    data: Data
    file: str
    plan: Plan
    figures: tuple[str, ...] = ()
    level: float = LEVELS[0]

    def refused(self) -> str | None:
        """Why the exact model must compute these variants; None where the batch does."""
        from camgeom.profile import from_data

        for key, (table, *_) in self._words.items():
            if table in SOLVED:
                return f"{key}: [{table}] is answered by a solver"
        try:
            for words in self._profiles():
                profile = from_data(words, self.file)
                why = supports(profile, self._numeric, self._trial)
                lacking = [name for name in self.figures if name not in offered(profile)]
                if why is None and lacking:
                    why = f"the batch has no figure {lacking[0]} of this profile"
                if why is not None:
                    return why
        except ProfileError as error:
            return f"the profile itself cannot be made ({error.problems[0]})"
        return None

    @cached_property
    def _trial(self) -> dict[str, Floats]:
        """A few variants, spread over all, by keys that take numbers."""
        numbers = dict.fromkeys(np.linspace(0, len(self.plan) - 1, TRIED).astype(int).tolist())
        rows = [self.drawn(range(number, number + 1)) for number in numbers]
        return {key: np.array([float(row[key][0]) for row in rows]) for key in self._numeric}

    @property
    def leveled(self) -> bool:
        """Whether the profile's pressures hang on the level."""
        from camgeom.profile import from_data

        return leveled(from_data(self.data, self.file))

    @property
    def _numeric(self) -> list[str]:
        """Keys that take numbers."""
        return [key for key in self.plan.keys if key not in self._words]

    @property
    def _words(self) -> dict[str, tuple[str | int, ...]]:
        """Keys that take words, with their paths: each combination of them is a profile of its own."""
        return {one.key: one.path for one in self.plan.axes if any(isinstance(value, str) for value in one.values)}

    def _parts(self, keys: Mapping[str, Column], count: int) -> list[tuple[Data, npt.NDArray[np.intp]]]:
        """The profile's data with every combination of words, and which of `count` rows have it."""
        rows: dict[tuple[Value, ...], list[int]] = {}
        if not self._words:
            return [(self.data, np.arange(count))]
        for i, words in enumerate(zip(*(keys[key] for key in self._words))):
            rows.setdefault(words, []).append(i)
        return [(self._with(words), np.array(where)) for words, where in rows.items()]

    def _profiles(self) -> Iterator[Data]:
        """The profile's data with every combination of words that may come."""
        values = ([str(one) for one in axis.values] for axis in self.plan.axes if axis.key in self._words)
        return map(self._with, product(*values))

    def _with(self, words: Sequence[Value]) -> Data:
        data = self.data
        for (key, path), word in zip(self._words.items(), words):
            data = replaced(data, path, word, key)
        return data

    @cached_property
    def _names(self) -> tuple[str, ...]:
        """Names of the figures of any row, in one order for all pieces."""
        from camgeom.profile import from_data

        every = (self.figures or offered(from_data(words, self.file)) for words in self._profiles())
        return tuple(dict.fromkeys(chain.from_iterable(every)))

    def drawn(self, piece: range) -> dict[str, Column]:
        """Values of all keys of these variants."""
        return self.plan.columns(piece, self.data)

    def columns(self, keys: Mapping[str, Column]) -> dict[str, Column | Words]:
        """The rows of variants that are not `refused` by columns: keys, figures (infinite where there is none),
        verdict and reason."""
        from camgeom.profile import from_data

        count = len(next(iter(keys.values())))
        figures = {name: np.full(count, np.inf) for name in self._names}
        verdict, reason = np.empty(count, dtype=object), np.empty(count, dtype=object)
        for data, where in self._parts(keys, count):
            varied = {key: np.asarray(keys[key], dtype=np.float64)[where] for key in self._numeric}
            profile = from_data(data, self.file)
            names = self.figures or offered(profile)
            batch = evaluate(profile, varied, names, self.level)
            verdict[where], reason[where] = judged(profile, varied, batch)
            for name, values in batch.figures.items():
                figures[name][where] = np.where(batch.reason == 0, values, np.inf)
        return {**keys, **figures, "verdict": verdict, "reason": reason}

    def judged_checks(self) -> set[str]:
        """Names of the checks that the verdicts of the rows rest on."""
        from camgeom.profile import from_data

        found: set[str] = {"undercut", "face-curvature", "continuity"}
        left: set[str] = set()
        for data in self._profiles():
            profile = from_data(data, self.file)
            names = self.figures or offered(profile)
            found |= {check_of(check, profile) for check, figure, *_ in JUDGED if figure in names}
            width = getattr(profile.follower, "face_width", None)
            if width is None and "follower.face_width" not in self.plan.keys:
                left.add(FACE)
            rated = profile.roller is not None and profile.roller.dynamic_rating is not None
            lives = {*LIVES, *(BEARING if rated or "roller.dynamic_rating" in self.plan.keys else ())}
            asked = profile.limits.life_h is not None or "limits.life_h" in self.plan.keys
            if not asked or not lives <= set(names):
                left.add(check_of(LIFE, profile))
        return found - left
