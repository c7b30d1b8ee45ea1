"""From a cam and its [cutter] table to the passes that make it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import radians

import numpy as np

from camgeom.errors import DesignError, ProfileError
from camgeom.machining.contour import ContourPath
from camgeom.machining.machine import Machine
from camgeom.machining.path import CentrePath, FlankPath, SidePath, ToolPath
from camgeom.machining.plan import Machining
from camgeom.machining.plate import plate_machining
from camgeom.machining.rows import Rows, rows
from camgeom.machining.spec import LEAST, SAME, CutterSpec
from camgeom.machining.tool import Tool, tool_of
from camgeom.solid import Part
from camgeom.solid.mechanism import Mechanism
from camgeom.solid.prism import FaceGroove, GroovedPlate, Prism
from camgeom.track import Track
from camgeom.track.outline import CircleOutline, Outline, RollerOutline


def machining_of(
    title: str, spec: CutterSpec, mechanisms: Sequence[Mechanism], parts: Sequence[Part]
) -> Machining:
    """The passes of the tool over all flanks of a cam of these parts, whose tracks the mechanisms have.

    Raises ProfileError where the table contradicts the cam, DesignError where the tool cannot make the flanks.
    """
    if found := [problem for one in mechanisms for problem in spec.problems(one)]:
        raise ProfileError(found)
    blank, cutters = mechanisms[0].blank, tuple(track for one in mechanisms for track in one.cutters)
    if mechanisms[0].carriage is not None:
        return plate_machining(title, spec, mechanisms[0], mechanisms[0].carriage)
    if blank is None:
        return _planar(title, spec, mechanisms, parts)
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


def _planar(title: str, spec: CutterSpec, mechanisms: Sequence[Mechanism], parts: Sequence[Part]) -> Machining:
    """Contours of discs, of rims that are a profile, and of the flanks of grooves in the faces of a plate."""
    start, mechanism = radians(spec.start_angle), mechanisms[0]
    radii = [0.5 * roller.diameter + mechanism.running_clearance for roller in mechanism.rollers]
    paths: list[ContourPath] = []
    tools: list[Tool] = []
    safe = 0.0

    def outside(name: str, outline: Outline, ends: tuple[float, float], like: float | None) -> None:
        tool, low = tool_of(spec, None, like), ends[0] - spec.overrun
        path = ContourPath(name, outline, 1.0, tool.radius + spec.allowance, low, ends[1] - low, None, start)
        paths.append(path)
        tools.append(tool)

    for index, part in enumerate(parts):
        if isinstance(part, Prism):
            # Of a pair each disc has its own roller, of other cams all have the first.
            like = radii[min(index, len(radii) - 1)] if radii else None
            outside(part.name, part.outer.outline, (part.z0, part.z1), like)
        elif isinstance(part, GroovedPlate):
            rim = part.rim.outline
            safe = rim.radius if isinstance(rim, CircleOutline) else 0.0
            if part.rim.name == "flank":
                outside("rim", rim, (part.z0, part.z1), -rim.distance if isinstance(rim, RollerOutline) else None)
            for groove in part.grooves:
                inner = groove.inner.outline
                assert isinstance(inner, RollerOutline)
                tool = tool_of(spec, None, -inner.distance, groove.root)
                cuts = _groove_contours(groove, inner, tool.radius + spec.allowance, start, spec)
                if len(mechanisms) > 1:
                    cuts = [replace(cut, name=f"{groove.face} face, {cut.name}") for cut in cuts]
                paths += cuts
                tools += [tool] * len(cuts)
    _refuse_short(spec, paths)
    for path in paths:
        path.refuse_gouge()
    paths = [path.with_lead(spec.lead, tool.radius) for path, tool in zip(paths, tools)]
    way = "plain" if spec.machine == "plain" else "polar"
    machine = Machine(
        spec.rotary or "C", way, False, mechanism.sense, spec.reversed_rotary, over=mechanism.width  # type: ignore[arg-type]
    )
    # What is cut from one face comes before the part is turned over; the same tool stays in as long as it can.
    order = sorted(range(len(paths)), key=lambda i: -paths[i].up)
    return Machining(title, spec, tuple(paths[i] for i in order), tuple(tools[i] for i in order), machine, safe)


def _groove_contours(
    groove: FaceGroove, inner: RollerOutline, reach: float, start: float, spec: CutterSpec
) -> list[ContourPath]:
    """One contour down the middle for a tool as wide as the groove, else one beside each flank."""
    outer, floor, up = groove.outer.outline, groove.floor, groove.way
    half = abs(inner.distance)
    height = abs(groove.top - floor)
    room = half - reach
    if room < -SAME:
        raise DesignError(
            f"cutter.diameter: a tool of {2.0 * (reach - spec.allowance):.6g} mm does not go into the groove; at most "
            f"{2.0 * (half - spec.allowance):.6g} mm"
        )
    if room <= LEAST:
        return [ContourPath("groove", inner, 1.0, reach, floor, height, 0.0, start, outer, up)]
    return [
        ContourPath("inner flank", inner, 1.0, reach, floor, height, max(0.0, room), start, up=up),
        ContourPath("outer flank", outer, -1.0, reach, floor, height, room, start, up=up),
    ]
