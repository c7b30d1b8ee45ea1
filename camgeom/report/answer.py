"""What the page is told of a profile, in the order in which it is known: motion, flanks, coarse bodies, the checks of
these, loads, their checks, those of the body, the verdict, bodies.

Everything is made from the profile's text alone, so that any number of pages may ask, and a lost one loses nothing.
"""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from threading import Lock, local
from time import perf_counter
from typing import TYPE_CHECKING, Any, final

import numpy as np

from camgeom.checks import LOADED, Check, Heard, Need, checks, judge
from camgeom.drawing.content import Chart, Figure, Series
from camgeom.drawing.plots import NARROW, WIDE, chart_sheet
from camgeom.drawing.sheet import number
from camgeom.errors import CamgeomError, ProfileError, unmade, visible
from camgeom.immutable import immutable
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.profile.editing import edited
from camgeom.profile.text import load
from camgeom.report.page import verdict_box
from camgeom.report.scene import scene_json
from camgeom.report.sections.bodies import cam_meshes, kept
from camgeom.report.sections.judgement import headed, key_figures
from camgeom.report.sections.mechanism import scene
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.checks.verdict import Verdict

Stage = dict[str, Any]
COARSE = 1e-3
"""chord error of the first bodies as a share of the cam's size: a pixel of a small view"""
COARSE_FRAMES = 61
QUICK = 1
"""gzip level of the bodies: over the loopback time counts and not size"""
SOLVERS: frozenset[Need] = frozenset({"dynamics", "impact", "cutter", "tolerance", "root"})
"""what checks need that are made last"""
LATER: frozenset[Need] = LOADED | SOLVERS | {"solid"}
"""what checks need that is not known when figures and coarse bodies are"""
MOST_MODELS = 6
MOST_TABS = 1000
"""models that are remembered, for undo and for the variant that is compared with; pages whose newest request is"""


class Stale(BaseException):
    """Nobody waits for the answer any more; no error, so that nothing on the way tells it as one."""


@final
class Memory:
    """The models of the last texts, and which request of each page is the newest."""

    def __init__(self, file: str) -> None:
        self.file = file
        self._models: OrderedDict[str, tuple[Model, _Watcher]] = OrderedDict()
        self._newest: dict[str, int] = {}
        self._lock = Lock()

    def model(self, text: str, fresh: Callable[[], bool] = lambda: True) -> Model:
        """The model of a text, remembered or new; what this thread asks of it ends with Stale where nobody waits.

        Raises ProfileError with every problem found.
        """
        with self._lock:
            found = self._models.pop(text, None)
        if found is None:
            watcher = _Watcher()
            found = Model(parse(text, self.file), None, watcher), watcher
        found[1].fresh = fresh
        with self._lock:
            self._models[text] = found
            while len(self._models) > MOST_MODELS:
                self._models.popitem(last=False)
        return found[0]

    def arrived(self, tab: str, serial: int) -> Callable[[], bool]:
        """Note a request of a page; what tells whether it is still the newest of that page."""
        with self._lock:
            if len(self._newest) > MOST_TABS:
                self._newest.clear()
            self._newest[tab] = max(serial, self._newest.get(tab, serial))
        return lambda: self._newest.get(tab, serial) <= serial


@final
class _Watcher(local):
    """Ends what a thread computes between two facts, where nobody waits for it."""

    fresh: Callable[[], bool] = staticmethod(lambda: True)

    def __call__(self, event: str, name: str, seconds: float) -> None:
        if event == "start" and not self.fresh():
            raise Stale


@final
@immutable
class Question:
    """A model, the one that is compared with, and the width of plots, px."""

    model: Model
    other: Model | None
    width: float


def answers(
    memory: Memory,
    text: str,
    changes: Mapping[str, Any],
    fresh: Callable[[], bool],
    kept_text: str = "",
    width: float = WIDE,
) -> Iterator[Stage]:
    """The stages of an answer, each as soon as it is known; the last one is named "done" or "problems".

    kept_text  the profile that is compared with, whose lines are drawn beside
    width      px, that the page has for a plot
    Ends without a last stage where the request is no longer fresh.
    """
    began = perf_counter()

    def stage(name: str, **data: Any) -> Stage:
        return {"stage": name, "ms": round(1e3 * (perf_counter() - began), 1), **data}

    try:
        try:
            text = edited(text, changes, memory.file)
            data = load(text, memory.file)[0]
            model = memory.model(text, fresh)
        except ProfileError as error:
            yield stage("problems", text=text, data=_data(text), problems=_problems(error))
            return
        yield stage("profile", text=text, data=data)
        asked = Question(model, _kept(memory, kept_text), min(max(NARROW, width), WIDE))
        for name, job in STAGES.items():
            if not fresh():
                return
            yield stage(name, **_told(partial(job, asked)))
        yield stage("done")
    except Stale:
        return


def _told(job: Callable[[], Stage]) -> Stage:
    """What a stage says, or why it cannot."""
    try:
        return job()
    except (CamgeomError, MemoryError) as error:
        return {"reason": visible(unmade(error).reason)}


def _data(text: str) -> Stage:
    """The plain data of a text, empty where it is no TOML."""
    try:
        return load(text, "")[0]
    except ProfileError:
        return {}


def _problems(error: ProfileError) -> list[Stage]:
    """The problems of a profile, by key, as texts."""
    return [{"key": problem.key, "text": visible(str(problem))} for problem in error.problems]


def _kept(memory: Memory, text: str) -> Model | None:
    """The model that is compared with; None without one, or where it is none."""
    try:
        return memory.model(text) if text else None
    except ProfileError:
        return None


def _moved(asked: Question) -> Stage:
    """Title, timing diagram, the figures of the motion and its plot: what needs no flank."""
    model = asked.model
    page = headed(model, None, ())
    theta = np.linspace(0.0, TURN, 361)
    one, unit = model.profile.lift_unit
    carriage, span = model.mechanism.carriage, model.profile.cam.MOTION_SPAN
    lift = model.setup.program.jet(theta, 0)[0]
    if carriage is not None:
        # The diagram is that of the profile: over the travel, in its unit of length.
        span, lift = carriage.stroke / one, carriage.lift(theta * (carriage.stroke / TURN), 0)[0]
    return {
        "title": page.title,
        "kind": page.kind,
        "unit": unit,
        "span": span,
        "over": "°" if carriage is None else f" {unit}",
        "per": 1.0 if carriage is None else 360.0 / span,
        "lift": np.round(lift / one, 6).tolist(),
        **_compared(asked, ("motion",)),
        "plots": _plots(model, asked.other, asked.width, _motion),
    }


def _figures(asked: Question) -> Stage:
    """The figures of the flank and its plot."""
    return {
        **_compared(asked, ("flank",)),
        "plots": _plots(asked.model, asked.other, asked.width, _flank),
    }


def _load(asked: Question) -> Stage:
    """The figures of contact and life."""
    return _compared(asked, ("contact", "fatigue"))


def _compared(asked: Question, groups: tuple[str, ...]) -> Stage:
    """Key figures of some groups, and those of the model that is compared with."""
    kept_figures = [] if asked.other is None else list(map(_figure, key_figures(asked.other, groups)))
    return {"figures": list(map(_figure, key_figures(asked.model, groups))), "kept": kept_figures}


def _figure(figure: Figure) -> Stage:
    value = figure.value
    shown = number(value) if isinstance(value, int | float) else str(value)
    return {"label": figure.label, "value": shown, "unit": figure.unit, "note": figure.note}


def _plots(
    model: Model, other: Model | None, width: float, charts: Callable[[Model], Chart | None]
) -> list[Stage]:
    """A chart of both models as SVG; where it cannot be drawn, the reason; nothing where there is none."""
    try:
        chart = charts(model)
        beside = charts(other) if other is not None else None
    except CamgeomError as error:
        return [{"reason": visible(str(error))}]
    if chart is None:
        return []
    both = chart if beside is None else with_kept(chart, beside)
    return [{"caption": both.caption, "svg": chart_sheet(both, width).render(both.caption)}]


def _motion(model: Model) -> Chart | None:
    from camgeom.report.sections.motion import diagrams

    return diagrams(model)


def _flank(model: Model) -> Chart | None:
    from camgeom.report.sections.flank import lines, profile

    if model.profiles is not None:
        return next((block for block in profile(model, model.profiles) if isinstance(block, Chart)), None)
    if not model.flanks:
        return None
    folded = any(survey.margin.value <= 0.0 for survey in model.flanks)
    return lines(model, model.flanks[0], curved=not folded)


def with_kept(chart: Chart, other: Chart) -> Chart:
    """A chart with the first line of each panel of another beside its own, where both have that panel."""
    beside = {panel.y.label: panel.series[0] for panel in other.panels if panel.series}
    panels = []
    for panel in chart.panels:
        line = beside.get(panel.y.label)
        more = () if line is None else (Series("kept", line.x, line.y, 4),)
        panels.append(replace(panel, series=(*panel.series, *more)))
    return replace(chart, panels=tuple(panels))


def _first_checks(asked: Question) -> Stage:
    """The verdict of the quick checks that need neither load nor body nor solver: not yet the verdict."""
    return _so_far(asked.model, "load, body and solvers", lambda entry: not (entry.slow or LATER & set(entry.needs)))


def _load_checks(asked: Question) -> Stage:
    """The verdict of the quick checks that need neither body nor solver; nothing where there is no load."""
    if asked.model.profile.operation is None:
        return {}
    later = SOLVERS | {"solid"}
    return _so_far(asked.model, "body and solvers", lambda entry: not (entry.slow or later & set(entry.needs)))


def _body_checks(asked: Question) -> Stage:
    """The verdict of the checks that need no solver; nothing where there is none to wait for."""
    profile, root = asked.model.profile, asked.model.root_limit
    if not any((profile.dynamics, profile.impact, profile.cutter, profile.tolerance, root)):
        return {}
    return _so_far(asked.model, "solvers", lambda entry: not SOLVERS & set(entry.needs))


def _so_far(model: Model, waiting: str, asked: Callable[[Check], bool]) -> Stage:
    """The verdict of some of the checks, and whose words are still waited for."""
    names = [name for name, entry in checks(model).items() if asked(entry)]
    return {**_verdict(model, judge(model, names, _heard(model)), whole=False), "waiting": waiting}


def _heard(model: Model) -> Heard:
    """What the checks of earlier stages said of a model, which the later ones need not ask again."""
    found: Heard = kept(model, "_heard", dict)
    return found


def _verdict(model: Model, verdict: Verdict, whole: bool) -> Stage:
    page = headed(model, verdict, ())
    return {"level": verdict.level, "whole": whole, "sentence": verdict.sentence, "html": verdict_box(page)}


def _all_checks(asked: Question) -> Stage:
    model = asked.model
    return _verdict(model, kept(model, "checks", lambda: judge(model, None, _heard(model))), whole=True)


def _coarse(asked: Question) -> Stage:
    """Bodies as quick as can be, in plain colours."""
    model = asked.model
    model.refuse_folded()
    diameter, length = model.envelope
    tolerance = max(COARSE * max(diameter, length), model.tolerance)
    meshes = tuple((part.name, part.rough(tolerance).mesh) for part in model.parts)
    return {"scene": scene_json(scene(model, meshes, COARSE_FRAMES, whole=False), QUICK)}


def _fine(asked: Question) -> Stage:
    """Bodies as the report shows them, with their results, and the figures of the body."""
    model = asked.model
    found = kept(model, "3D view", lambda: scene(model, cam_meshes(model)))
    return {"scene": scene_json(found, QUICK), **_compared(asked, ("solid",))}


STAGES: dict[str, Callable[[Question], Stage]] = {
    "motion": _moved,
    "figures": _figures,
    "coarse": _coarse,
    "checks": _first_checks,
    "load": _load,
    "loaded": _load_checks,
    "bodies": _body_checks,
    "verdict": _all_checks,
    "fine": _fine,
}
"""What the page is told after the profile, in order."""


def line(stage: Stage) -> bytes:
    """A stage as a line of JSON."""
    return json.dumps(stage, allow_nan=False, separators=(",", ":")).encode() + b"\n"
