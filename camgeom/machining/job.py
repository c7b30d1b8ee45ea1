"""From a cam and its [cutter] table to the passes that make it."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians

import numpy as np

from camgeom.errors import DesignError, ProfileError
from camgeom.machining.contour import ContourPath
from camgeom.machining.machine import Machine
from camgeom.machining.path import CentrePath, FlankPath, SidePath, ToolPath
from camgeom.machining.plan import LEAST, Machining
from camgeom.machining.plate import plate_machining
from camgeom.machining.rows import Rows, rows
from camgeom.machining.spec import SAME, CutterSpec
from camgeom.machining.tool import Tool, tool_of
from camgeom.solid.mechanism import Mechanism
from camgeom.solid.prism import FaceGroove, Prism
from camgeom.track import Track
from camgeom.track.outline import CircleOutline, RollerOutline


def machining_of(title: str, spec: CutterSpec, mechanisms: Sequence[Mechanism]) -> Machining:
    """The passes of the tool over all flanks of a cam, whose tracks the mechanisms have.

    Raises ProfileError where the table contradicts the cam, DesignError where the tool cannot make the flanks.
    """
    if found := [problem for one in mechanisms for problem in spec.problems(one)]:
        raise ProfileError(found)
    blank, cutters = mechanisms[0].blank, tuple(track for one in mechanisms for track in one.cutters)
    if mechanisms[0].carriage is not None:
        return plate_machining(title, spec, mechanisms[0], mechanisms[0].carriage)
    if blank is None:
        return _planar(title, spec, mechanisms[0])
    safe = max(r for r, _ in blank.outline) + spec.retract
    tools = tuple(tool_of(spec, track) for track in cutters)
    groups = _ball_rows(spec, cutters) if spec.kind == "ball" else ()
    paths = [p for track, tool in zip(cutters, tools) for p in _paths(spec, track, tool)]
    if groups:
        paths = [row for group in groups for row in group.paths]
    _refuse_short(spec, paths)
    machine = _machine(spec, paths, cutters[0].sense)
    return Machining(title, spec, tuple(paths), tools, machine, safe, cutters, groups)


def _paths(spec: CutterSpec, track: Track, tool: Tool) -> list[ToolPath]:
    """The passes of a tool whose side (or a wheel's plane side) works, along one track."""
    start = radians(spec.start_angle)
    if spec.kind == "ball":
        return []
    if spec.kind == "roller" or spec.path == "centre":
        return [CentrePath(track, start)]
    if spec.kind == "wheel" and spec.contact == "side":
        return [SidePath(track, side, tool.radius, spec.allowance, start) for side in track.sides]
    paths: list[ToolPath] = []
    for side in track.sides:
        path = FlankPath(track, side, tool.radius + spec.allowance, spec.path, spec.axis, start)
        if path.room is not None and path.room <= LEAST and spec.axis == "roller":
            return [CentrePath(track, start)]
        paths.append(path)
    return paths


def _ball_rows(spec: CutterSpec, cutters: Sequence[Track]) -> tuple[Rows, ...]:
    assert spec.diameter is not None
    flanks = [(track, side) for track in cutters for side in track.sides]
    start = radians(spec.start_angle)
    return tuple(
        rows(track, side, 0.5 * spec.diameter, spec.allowance, spec.scallop, start, i)
        for i, (track, side) in enumerate(flanks)
    )


def _refuse_short(spec: CutterSpec, paths: Sequence[ToolPath]) -> None:
    need = max(path.height for path in paths)
    if spec.length is not None and spec.length < need - SAME:
        raise DesignError(f"cutter.length {spec.length:g} mm is too short: the cut is {need:.6g} mm deep")


def _machine(spec: CutterSpec, paths: Sequence[ToolPath], sense: float) -> Machine:
    """The machine that a drum's or globoid's tool needs: with a swing axis where the tool does not stay square."""
    rotary = spec.rotary or "A"
    if any(isinstance(path, SidePath) for path in paths):
        return Machine(rotary, "helix", True, sense, spec.reversed_rotary, spec.pivot)
    first = paths[0]
    phi = np.linspace(first.knots()[0], first.knots()[-1], 65)
    swings = bool(np.abs(first.at(phi).axis[2]).max() > SAME)
    return Machine(rotary, "axis", swings, sense, spec.reversed_rotary, spec.pivot)


def _planar(title: str, spec: CutterSpec, mechanism: Mechanism) -> Machining:
    """Contours of discs and of the flanks of a face groove."""
    parts, start = mechanism.parts, radians(spec.start_angle)
    radii = [0.5 * roller.diameter + mechanism.running_clearance for roller in mechanism.rollers]
    paths: list[ContourPath] = []
    tools: list[Tool] = []
    safe = 0.0
    for index, part in enumerate(parts):
        # Of a pair each disc has its own roller, of other cams all have the first.
        like = radii[min(index, len(radii) - 1)] if radii else None
        if isinstance(part, Prism):
            tool = tool_of(spec, None, like)
            low, reach = part.z0 - spec.overrun, tool.radius + spec.allowance
            cuts = [ContourPath(part.name, part.outer.outline, 1.0, reach, low, part.z1 - low, None, start)]
        elif isinstance(part, FaceGroove):
            tool = tool_of(spec, None, like, part.root)
            cuts = _groove_contours(part, tool.radius + spec.allowance, start, spec)
            rim = part.rim.outline
            safe = rim.radius if isinstance(rim, CircleOutline) else 0.0
        else:
            continue
        paths += cuts
        tools += [tool] * len(cuts)
    _refuse_short(spec, paths)
    for path in paths:
        path.refuse_gouge()
    paths = [path.with_lead(spec.lead, tool.radius) for path, tool in zip(paths, tools)]
    way = "plain" if spec.machine == "plain" else "polar"
    machine = Machine(spec.rotary or "C", way, False, mechanism.sense, spec.reversed_rotary)  # type: ignore[arg-type]
    return Machining(title, spec, tuple(paths), tuple(tools), machine, safe)


def _groove_contours(part: FaceGroove, reach: float, start: float, spec: CutterSpec) -> list[ContourPath]:
    """One contour down the middle for a tool as wide as the groove, else one beside each flank."""
    inner, outer = part.inner.outline, part.outer.outline
    assert isinstance(inner, RollerOutline)
    half = abs(inner.distance)
    height = part.z1 - part.floor
    room = half - reach
    if room < -SAME:
        raise DesignError(
            f"cutter.diameter: a tool of {2.0 * (reach - spec.allowance):.6g} mm does not go into the groove; at most "
            f"{2.0 * (half - spec.allowance):.6g} mm"
        )
    both = ContourPath("inner flank", inner, 1.0, reach, part.floor, height, max(0.0, room), start)
    if room <= LEAST:
        return [ContourPath("groove", inner, 1.0, reach, part.floor, height, 0.0, start, outer)]
    return [both, ContourPath("outer flank", outer, -1.0, reach, part.floor, height, room, start)]
