"""A cam as one of its followers sees it, in one operating state; and which other models of the cam move as it does."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians
from typing import TYPE_CHECKING, Any, cast

from camgeom.maths.frozen import TWIN, Ledger, Observer, Sealed, cached_property, fact, frozen
from camgeom.model.body import Body
from camgeom.profile import Profile
from camgeom.solid.mechanism import Mechanism
from camgeom.track.follower import Setup

if TYPE_CHECKING:
    from camgeom.cams import Cam
    from camgeom.model import Model
    from camgeom.profile.duty import RunningState


class Seen(Sealed):
    """A profile, the follower and the state that it is seen from, and the models of the others; abstract, `Model` is
    final. What several models have in common is computed by the first of them (`fact_of`)."""

    profile: Profile
    number: int
    groove: int
    """which of several tracks its follower runs on"""
    angle: float
    """of its follower's place about the cam axis, rad: its own cam angle, from which all counts, is less by that"""
    body: Body
    state: RunningState | None
    """the operating state of [[duty]] in which this model sees its cam; None as [operation] says"""
    _others: tuple[Model, ...]

    def __init__(
        self,
        profile: Profile,
        tolerance: float | None = None,
        observer: Observer | None = None,
        *,
        body: Body | None = None,
        number: int = 0,
        angle: float = 0.0,
        groove: int = 0,
        state: RunningState | None = None,
    ) -> None:
        mine = vars(self)
        mine.update(profile=profile, number=number, angle=angle, groove=groove, body=body, state=state, _others=())
        if body is not None:
            return
        allowed = tolerance if tolerance is not None else profile.output.tolerance
        mine["body"] = Body(profile, allowed, Ledger(observer))
        kind = type(self._me)
        others = [(station.profile(profile), station.angle, 0) for station in profile.stations]
        others += [(track.whole, track.angle, groove) for groove, track in enumerate(profile.tracks, start=1)]
        mine["_others"] = tuple(
            kind(own, body=self.body, number=number, angle=radians(angle), groove=groove)
            for number, (own, angle, groove) in enumerate(others, start=1)
        )
        self.body.seen_by(self._me, *self._others)

    def __setstate__(self, state: dict[str, Any]) -> None:
        # Pickling loses what no pickle holds: the weak links of the body, and that arrays are read-only.
        vars(self).update(frozen(state))
        if self.number == 0 and self.state is None:
            self.body.seen_by(self._me, *self._others)

    @property
    def _me(self) -> Model:
        """This model: there is no other kind of what is seen."""
        return cast("Model", self)

    @property
    def bindings(self) -> tuple[Model, ...]:
        """The models of all followers of the cam, this one among them."""
        return self.body.bindings

    @property
    def mates(self) -> tuple[Model, ...]:
        """The models of the followers on its track, this one among them."""
        return tuple(one for one in self.bindings if one.groove == self.groove)

    @property
    def grooves(self) -> tuple[Model, ...]:
        """The model of the first follower on every track of the body."""
        return tuple({one.groove: one for one in reversed(self.bindings)}.values())[::-1]

    @fact
    def _running(self) -> tuple[Model, ...]:
        """A model in every operating state of [[duty]], on the same body and mechanism; none without [[duty]]."""
        from camgeom.profile.duty import running_states

        models: list[Model] = []
        kind = type(self._me)
        for state in running_states(self.profile):
            models.append(kind(state.profile, body=self.body, number=self.number, angle=self.angle,
                               groove=self.groove, state=state))  # fmt: skip
            last = models[-1]
            vars(last).update(setup=self.setup, mechanism=self.mechanism)
            twin = next(one for one in models if one._runs_as == last._runs_as)
            if twin is not last and len(self.bindings) == 1:  # else another follower's state may differ
                vars(last)[TWIN] = twin
        return tuple(models)

    @property
    def states(self) -> tuple[Model, ...]:
        """This cam in every state in which it runs: those of [[duty]], without them the one of [operation]."""
        return self._running if self.profile.duty else (self._me,)

    @fact
    def _moving(self) -> Model:
        """The first model, of all followers in all operating states, that moves as this one does under the same load.
        """
        return next((one for one in self._kin if one._moves_as == self._moves_as), self._me)

    @fact
    def _alike(self) -> Model:
        """The first one of these that runs in the same oil too."""
        return next((one for one in self._kin if one._runs_as == self._runs_as), self._me)

    @property
    def _kin(self) -> Iterator[Model]:
        """The models of all followers in all operating states."""
        return (state for one in self.bindings for state in one.states)

    @cached_property
    def _moves_as(self) -> tuple[Any, ...]:
        """All that the motion of its follower and the load on it hang on, wherever on the body it stands."""
        profile, spec = self.profile, self.profile.dynamics_spec
        if profile.operation is None:
            return (self.number,)
        cam = {key: value for key, value in profile.cam if key not in profile.cam.PLACES}
        below = self.number if spec is not None and spec.body_compliance else 0
        factor = 1.0 if self.state is None else self.state.load_factor
        return (profile.operation, factor, below, profile.follower, profile.roller, profile.return_roller,
                profile.motion, cam, profile.dynamics, profile.impact)  # fmt: skip

    @property
    def _runs_as(self) -> tuple[Any, ...]:
        return *self._moves_as, self.profile.oil

    @property
    def at_once(self) -> tuple[Model, ...]:
        """The models of all followers of the cam in this operating state, this one among them."""
        if self.state is None:
            return self.bindings
        state = self.bindings[self.number].states.index(self)
        return tuple(one.states[state] for one in self.bindings)

    @property
    def tolerance(self) -> float:
        """Largest chord error of the solids' faces that followers touch, mm."""
        return self.body.tolerance

    @property
    def free_tolerance(self) -> float:
        """Largest chord error of all other faces, mm: that of [output], at least the tolerance."""
        return self.body.free_tolerance

    @property
    def ledger(self) -> Ledger:
        """Where the costs of facts are booked."""
        return self.body.ledger

    @property
    def cam(self) -> Cam:
        """The [cam] table."""
        return self.profile.cam

    @fact
    def setup(self) -> Setup:
        """Follower, roller and motion program in internal units."""
        return self.profile.setup()

    @cached_property
    def mechanism(self) -> Mechanism:
        """The cam bound to its follower, roller and program."""
        return self.profile.cam.mechanism(self.setup)

    @property
    def alike(self) -> list[Model]:
        """The first of those that move alike in the same oil too."""
        return list({id(one._alike): one._alike for one in tuple(self._kin) or (self._me,)}.values())

    @property
    def runs(self) -> list[Model]:
        """The first of those that move alike, of all followers in all operating states."""
        return list({id(one._moving): one._moving for one in tuple(self._kin) or (self._me,)}.values())

    @property
    def _differing(self) -> int:
        """How many followers of the cam do not move as an earlier one does."""
        return len({id(one.states[0]._moving) for one in self.bindings}) or 1
