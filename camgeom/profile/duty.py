"""The operating states of a machine, [[duty]]: what differs in each from [operation], and how long it lasts.

Shares of the running time, or hours, weigh the damage of a state (Miner): L = 1 / sum(weight / L_state), in hours.
Starts and stops are states with a count: their damage comes on top of every hour of running. A measured history of the
load becomes a spectrum by rainflow counting (ASTM E1049): each class of its counted cycles is a state of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose
from typing import TYPE_CHECKING, Annotated, Self, final

from pydantic import BeforeValidator, Field, model_validator

from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.keys import Section
from camgeom.mechanics.lubricant import Celsius
from camgeom.profile.sections import Force

if TYPE_CHECKING:
    from camgeom.profile import Profile

MOST_SAMPLES = 200_000
"""of a measured history"""
CLASSES = 10
"""into which the maxima of the cycles of a history are counted, each judged at its upper end"""
SUM = 1e-6
"""by which shares of the running time may miss 1"""

Factor = Annotated[float, Field(ge=0.0, le=1e3, allow_inf_nan=False)]


def _listed(values: object) -> object:
    """A list, which is what TOML gives, as the tuple that a frozen section holds."""
    return tuple(values) if isinstance(values, list) else values


@final
class OperatingState(Section):
    """One state of [[duty]]; what it leaves out is as in [operation]."""

    name: Annotated[str, Field(max_length=80)] = Field("", description="shown in results; default its number")
    speed: Annotated[float, Field(gt=0.0, le=1e6)] | None = Field(
        None, description="r/min, cam speed; default that of [operation]")
    load_factor: Factor = Field(1.0, description="1, by which the applied forces are multiplied")
    force: Annotated[tuple[Force, ...], Field(max_length=1000)] | None = Field(
        None, description="applied forces of this state, instead of those of [operation]; a [[track]] or [[station]] "
        "with forces of its own keeps them")
    history: Annotated[tuple[Factor, ...], Field(min_length=2, max_length=MOST_SAMPLES),
                       BeforeValidator(_listed)] | None = Field(
        None, description="1, measured load factors in order of time, or `history_file`, a CSV file with one column of "
        "them; counted by rainflow (ASTM E1049), the maxima of its cycles are the load factors")
    temperature: Celsius | None = Field(None, description="°C, of the lubricant; default that of [lubricant]")
    share: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        None, description="1, of the running time; those of all states add up to 1")
    hours: Annotated[float, Field(gt=0.0, le=1e9)] | None = Field(
        None, description="h, of all the hours that the states give, instead of shares")
    starts: Annotated[float, Field(gt=0.0, le=1e6)] | None = Field(
        None, description="1/h, starts or stops of this kind in an hour of running, instead of a share or hours; their "
        "damage comes on top")
    turns: Annotated[float, Field(gt=0.0, le=1e6)] | None = Field(
        None, description="1, turns of the cam in each start or stop; default 1")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if sum(one is not None for one in (self.share, self.hours, self.starts)) != 1:
            raise ValueError("a state needs one of share (of the running time), hours and starts (in an hour)")
        if self.turns is not None and self.starts is None:
            raise ValueError("`turns` are those of each of the `starts`: a state that lasts has none")
        if self.history is not None and "load_factor" in self.model_fields_set:
            raise ValueError("`load_factor` beside a `history`, which has the load factors")
        return self


@final
@immutable(eq=True)
class RunningState:
    """A state as it is computed: its profile without [[duty]], and its weight in the damage of an hour of running.

    weight  the share of the running time; of starts and stops the hours that they take in an hour of running, on top
    """

    name: str
    profile: Profile
    load_factor: float
    weight: float

    @property
    def speed(self) -> float:
        """Cam speed, r/min."""
        assert self.profile.operation is not None
        return self.profile.operation.speed


def running_states(profile: Profile) -> tuple[RunningState, ...]:
    """The states of [[duty]], those with a history one by one of its classes; none without [[duty]]."""
    if profile.operation is None:
        return ()
    hours = sum(state.hours or 0.0 for state in profile.operating_states)
    found = []
    for number, state in enumerate(profile.operating_states, start=1):
        name, speed = state.name or f"state {number}", state.speed or profile.operation.speed
        force = profile.operation.force if state.force is None else state.force
        operation = profile.operation.model_copy(update={"speed": speed, "force": force})
        oil = profile.oil
        if oil is not None and state.temperature is not None:
            oil = oil.model_copy(update={"temperature": state.temperature})
        alone = profile.model_copy(update={"operation": operation, "lubricant": oil, "duty": ()})
        if state.starts is not None:
            weight = state.starts * (state.turns or 1.0) / (60.0 * speed)
        else:
            weight = state.share if state.share is not None else (state.hours or 0.0) / hours
        if state.history is None:
            found.append(RunningState(name, alone, state.load_factor, weight))
            continue
        for factor, share in _classes(state.history):
            found.append(RunningState(f"{name}, load factor {factor:.4g}", alone, factor, weight * share))
    return tuple(found)


def _classes(history: tuple[float, ...]) -> Iterator[tuple[float, float]]:
    """Load factors, the upper ends of equal classes, and the share of the counted cycles in each that has any."""
    import numpy as np

    from camgeom.mechanics.rainflow import rainflow

    cycles = rainflow(history)
    tops, counts = cycles.mean + 0.5 * cycles.range, cycles.count
    highest = float(tops.max())
    place = np.ceil(CLASSES * tops / highest * (1.0 - 1e-12)).astype(int) if highest > 0.0 else np.full(len(tops), 1)
    for number in sorted(set(place.tolist())):
        yield highest * number / CLASSES, float(counts[place == number].sum() / counts.sum())


def duty_problems(profile: Profile) -> Iterator[Problem]:
    """What no state knows alone: shares that do not add up, states without an [operation], factors of no force."""
    duty = profile.operating_states
    if profile.operation is None:
        yield Problem("duty", "means nothing here", None, "", "give [operation]: a state says what differs from it")
        return
    timed = [state for state in duty if state.starts is None]
    shares = [state.share for state in timed if state.share is not None]
    if not timed:
        yield Problem("duty", "has starts alone", None, "", "give the states between them, with a share or hours")
    elif 0 < len(shares) < len(timed):
        yield Problem("duty", "mixes share and hours", None, "", "give every state a share, or every state hours")
    elif shares and not isclose(sum(shares), 1.0, abs_tol=SUM):
        hint = "shares are of the time in which the machine runs"
        yield Problem("duty", "has shares that do not add up to 1", sum(shares), "1", hint)
    if profile.operation.force and all(state.force is not None for state in duty):
        hint = "every state of [[duty]] has forces of its own"
        yield Problem("operation.force", "means nothing here", None, "", hint)
    stated = [("operation.speed", profile.operation.speed, [state.speed for state in duty])]
    if profile.oil is not None:
        stated.append(("lubricant.temperature", profile.oil.temperature, [state.temperature for state in duty]))
    for key, found, each in stated:
        if None not in each and found not in each:
            word = key.partition(".")[2]
            hint = f"every state of [[duty]] has a {word} of its own: leave out that of the state that runs at this one"
            yield Problem(key, "is that of no state", found, "", hint)
    for number, state in enumerate(duty):
        if state.temperature is not None and profile.lubricant is None:
            yield Problem(f"duty[{number}].temperature", "means nothing here", state.temperature, "",
                          "it is that of the oil: give [lubricant]")
        forces = profile.operation.force if state.force is None else state.force
        if not forces and (state.load_factor != 1.0 or state.history is not None):
            key = "history" if state.history is not None else "load_factor"
            value = None if state.history is not None else state.load_factor
            yield Problem(f"duty[{number}].{key}", "means nothing here", value, "",
                          "it multiplies the applied forces: give an [[operation.force]] or a [[duty.force]]")
        if state.history is not None and len(set(state.history)) == 1:
            yield Problem(f"duty[{number}].history", "never changes", state.history[0], "", "give it as load_factor")
