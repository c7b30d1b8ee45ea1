"""From a cam and its [cutter] table to the passes that make it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import radians

import numpy as np

from camgeom.errors import DesignError, ProfileError
from camgeom.machining.contour import HALVINGS, PER_TURN, TOUCHING, ContourPath
from camgeom.machining.machine import Machine, Way
from camgeom.machining.path import CentrePath, FlankPath, Positions, SidePath, ToolPath
from camgeom.machining.plan import SHARE, Hollow, Machining, quarter
from camgeom.machining.plate import plate_machining
from camgeom.machining.rows import RowPath, Rows, rows
from camgeom.machining.spec import LEAST, CutterSpec
from camgeom.machining.tool import Tool, tool_of
from camgeom.machining.wall import SAME, cosine_of, depth_of, roller_at, slope_to_tip, wall_ends
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.solid import Part
from camgeom.solid.mechanism import Mechanism
from camgeom.solid.prism import FaceGroove, GroovedPlate, Prism
from camgeom.track import Track
from camgeom.track.flank import Flank
from camgeom.track.outline import CircleOutline, Outline, RollerOutline

TrackPath = CentrePath | FlankPath | SidePath | RowPath


def machining_of(
    title: str, spec: CutterSpec, mechanisms: Sequence[Mechanism], parts: Sequence[Part]
) -> Machining:
    """The passes of the tool over all flanks of a cam of these parts, whose tracks the mechanisms have.

    Raises ProfileError where the table contradicts the cam, DesignError where the tool cannot make the flanks.
    """
    found = [problem for one in mechanisms for problem in spec.problems(one)]
    if not found and all(one.face_groove is not None for one in mechanisms):
        found = spec.no_overrun()
    if found:
        raise ProfileError(found)
    blank, cutters = mechanisms[0].blank, tuple(track for one in mechanisms for track in one.cutters)
    if mechanisms[0].carriage is not None:
        return plate_machining(title, spec, mechanisms[0], mechanisms[0].carriage)
    if blank is None:
        return _planar(title, spec, mechanisms, parts)
    drum = mechanisms[0].drum
    hollow = Hollow(drum.radius, drum.low, drum.high) if drum is not None and drum.hollow else None
    safe = max(r for r, _ in blank.outline) + spec.retract if hollow is None else hollow.radius - spec.retract
    paths, groups = _along(spec, cutters)
    _refuse_short(spec, paths)
    machine = _machine(spec, paths, cutters[0].sense, hollow is not None)
    tools = [tool_of(spec, path.track) for path in paths]
    return Machining(title, spec, tuple(paths), tuple(tools), machine, safe, cutters, groups, hollow)


def _along(spec: CutterSpec, cutters: Sequence[Track], before: int = 0) -> tuple[list[TrackPath], tuple[Rows, ...]]:
    """The passes along rollers' tracks, and the rows that they are of a ball; before: flanks that others have."""
    if spec.kind != "ball":
        return [path for track in cutters for path in _paths(spec, track, tool_of(spec, track))], ()
    groups = _ball_rows(spec, cutters, before)
    return [row for group in groups for row in group.paths], groups


def _paths(spec: CutterSpec, track: Track, tool: Tool) -> list[TrackPath]:
    """The passes of a tool whose side (or a wheel's plane side) works, along one track."""
    start = radians(spec.start_angle)
    if spec.kind == "roller" or spec.path == "centre":
        return [CentrePath(track, start)]
    if spec.kind == "wheel" and spec.contact == "side":
        return [SidePath(track, side, tool.radius, spec.allowance, start) for side in track.sides]
    paths: list[TrackPath] = []
    for side in track.sides:
        path = FlankPath(track, side, _reach(spec, track, tool), spec.path, spec.axis, start)
        if path.room is not None and path.room <= LEAST and spec.axis == "roller":
            return [CentrePath(track, start)]
        paths.append(path)
    return paths


def _reach(spec: CutterSpec, track: Track, tool: Tool) -> float:
    """From the flank along its normal to the tool's axis, mm, at the middle of the wall."""
    if not spec.half_angle:
        return tool.radius + spec.allowance
    cosine, place = cosine_of(track), roller_at(track, 0.5 * sum(wall_ends(track)))[0]
    own = tool.radius + slope_to_tip(track) * abs(place - track.tip)
    return (own + spec.allowance / cosine) / cosine


def _leaning(spec: CutterSpec, track: Track, before: int) -> tuple[list[TrackPath], tuple[Rows, ...]]:
    """The passes along the flanks of a disc that lean, from the side that its roller comes from.

    Round a profile the tool passes the further face. A mill that leans beneath an overhang stands lower by what the rim
    of its end is higher there.
    """
    if len(track.sides) > 1:
        return _along(spec, (track,), before)
    ball = 0.5 * (spec.diameter or 0.0) + spec.allowance if spec.kind == "ball" else 0.0
    beneath = max(0.0, -slope_to_tip(track)) if spec.axis == "fitted" else 0.0
    lower = spec.overrun + ball + 2.0 * (0.5 * (spec.diameter or 0.0) + spec.allowance) * beneath * cosine_of(track)
    deep = replace(track, tip=track.tip + track.tip_sign * lower)
    if spec.kind == "ball":
        lines, (group,) = _along(spec, (deep,), before)
        foot = track.contact[int(track.tip_sign > 0.0)]
        left = max(0.0, track.tip_sign * (foot - roller_at(deep, group.paths[0].t)[0]))
        return lines, (replace(group, foot_left=left),)
    tool = tool_of(spec, deep)
    if tool.kind == "roller" and tool.thinnest(depth_of(deep)) <= 0.0:
        raise DesignError(f"cutter.overrun {spec.overrun:g} mm: the cone comes to its point before it is that deep")
    reach = _reach(spec, deep, tool)
    if spec.kind == "roller":
        reach = roller_at(deep, 0.5 * sum(wall_ends(deep)))[1] / cosine_of(deep)
    path = FlankPath(deep, deep.sides[0], reach, "flank", spec.axis, radians(spec.start_angle))
    return [_with_lead(spec, path, tool)], ()


def _with_lead(spec: CutterSpec, path: FlankPath, tool: Tool) -> FlankPath:
    """The path with room for an arc in and out that stays off the flank.

    Raises DesignError where the wanted arc, cutter.lead, does not fit.
    """
    radius = tool.radius if spec.lead is None else spec.lead
    track = path.track
    phi, _ = piece_grid(track.knots(), PER_TURN)
    flank = Flank(track, phi, np.array([track.meridian.parameter(end) for end in track.contact]), path.side)
    points, at = flank.x.reshape(3, -1), path.at(path.knots()[:1])
    for _ in range(HALVINGS):
        arcs = [quarter(at, radius, 1e-3 * max(radius, LEAST), way) for way in (-1.0, 1.0)]
        if all(arc is None or _clear(arc, tool, points, spec.allowance) for arc in arcs):
            return replace(path, free=radius / SHARE)
        if spec.lead is not None:
            raise DesignError(f"{path.name}: cutter.lead {radius:g} mm cuts into the profile; use a smaller one")
        radius *= 0.5
    return replace(path, free=0.0)


def _clear(arc: Positions, tool: Tool, points: Floats, stock: float) -> bool:
    """Whether a tool keeps off points (3, n) of a flank."""
    for tip, axis in zip(arc.tip.T, arc.axis.T):
        off = points - tip[:, None]
        s = axis @ off
        across = np.sqrt(np.maximum((off * off).sum(axis=0) - s * s, 0.0))
        if float(tool.distance(s, across).min()) < stock - TOUCHING:
            return False
    return True


def _ball_rows(spec: CutterSpec, cutters: Sequence[Track], before: int) -> tuple[Rows, ...]:
    assert spec.diameter is not None
    flanks = [(track, side) for track in cutters for side in track.sides]
    start = radians(spec.start_angle)
    return tuple(
        rows(track, side, 0.5 * spec.diameter, spec.allowance, spec.scallop, start, i)
        for i, (track, side) in enumerate(flanks, before)
    )


def _refuse_short(spec: CutterSpec, paths: Sequence[ToolPath]) -> None:
    need = max(path.height for path in paths)
    if spec.length is not None and spec.length < need - SAME:
        raise DesignError(f"cutter.length {spec.length:g} mm is too short: the cut is {need:.6g} mm deep")


def _machine(spec: CutterSpec, paths: Sequence[ToolPath], sense: float, inside: bool) -> Machine:
    """The machine that a drum's or globoid's tool needs: with a swing axis where the tool does not stay square; within
    a ring with an angle head."""
    if inside:
        return Machine(spec.rotary or "C", "inside", False, sense, spec.reversed_rotary)
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
    paths: list[ContourPath | TrackPath] = []
    tools: list[Tool] = []
    groups: tuple[Rows, ...] = ()
    tracks: list[Track] = []
    cutters = [track for one in mechanisms for track in one.cutters]
    safe = 0.0

    def leaning(track: Track, face: str = "") -> None:
        nonlocal groups
        track = replace(track, name=f"{face} face, {track.name}") if face and len(mechanisms) > 1 else track
        along, rows_ = _leaning(spec, track, len(groups))
        paths.extend(along)
        groups += rows_
        tracks.append(along[0].track)
        tools.extend(tool_of(spec, path.track) for path in along)

    def outside(name: str, outline: Outline, ends: tuple[float, float], like: float | None) -> None:
        tool, low = tool_of(spec, None, like), ends[0] - spec.overrun
        path = ContourPath(name, outline, 1.0, tool.radius + spec.allowance, low, ends[1] - low, None, start)
        paths.append(path)
        tools.append(tool)

    for index, part in enumerate(parts):
        if isinstance(part, Prism) and part.outer.upper is not None:
            leaning(cutters[index])
        elif isinstance(part, Prism):
            # Of a pair each disc has its own roller, of other cams all have the first.
            like = radii[min(index, len(radii) - 1)] if radii else None
            outside(part.name, part.outer.outline, (part.z0, part.z1), like)
        elif isinstance(part, GroovedPlate):
            rim = part.rim.outline
            safe = rim.radius if isinstance(rim, CircleOutline) else 0.0
            if part.rim.upper is not None:
                leaning(next(one for one in mechanisms if one.face_groove is None).cutters[0])
            elif part.rim.name == "flank":
                outside("rim", rim, (part.z0, part.z1), -rim.distance if isinstance(rim, RollerOutline) else None)
            grooved = [one for one in mechanisms if one.face_groove is not None]
            for groove, own in zip(part.grooves, grooved):
                if groove.inner.upper is not None:
                    leaning(own.cutters[0], groove.face)
                    continue
                inner = groove.inner.outline
                assert isinstance(inner, RollerOutline)
                tool = tool_of(spec, None, -inner.distance, groove.root)
                cuts = _groove_contours(groove, inner, tool.radius + spec.allowance, start, spec)
                if len(mechanisms) > 1:
                    cuts = [replace(cut, name=f"{groove.face} face, {cut.name}") for cut in cuts]
                paths += cuts
                tools += [tool] * len(cuts)
    _refuse_short(spec, paths)
    # What is cut from one face comes before the part is turned over; the same tool stays in as long as it can.
    order = sorted(range(len(paths)), key=lambda i: paths[i].below)
    made = [(paths[i], tools[i]) for i in order]
    led = tuple(_led(path, spec, tool) if isinstance(path, ContourPath) else path for path, tool in made)
    return Machining(title, spec, led, tuple(tool for _, tool in made), _plate_machine(spec, led, mechanism), safe,
                     tuple(tracks), groups)  # fmt: skip


def _led(path: ContourPath, spec: CutterSpec, tool: Tool) -> ContourPath:
    path.refuse_gouge()
    return path.with_lead(spec.lead, tool.radius)


def _plate_machine(spec: CutterSpec, paths: Sequence[ToolPath], mechanism: Mechanism) -> Machine:
    """The machine that a disc's tool needs: with a swing axis where it leans."""
    rotary, over = spec.rotary or "C", mechanism.envelope[1]
    for path in paths:
        at = path.at(path.knots()[:1])
        leaning = at.axis[:2, 0]
        if float(np.abs(leaning).max()) > SAME:
            # So that the tool stands on the radial letter's + side of the cam.
            aside = 1.0 if float(leaning @ at.tip[:2, 0]) >= 0.0 else -1.0
            return Machine(rotary, "lean", True, mechanism.sense, spec.reversed_rotary, spec.pivot, over=over,
                           aside=aside)  # fmt: skip
    way: Way = "plain" if spec.machine == "plain" else "polar"
    return Machine(rotary, way, False, mechanism.sense, spec.reversed_rotary, over=over)


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
        return [ContourPath("groove", inner, 1.0, reach, floor, height, 0.0, start, outer, up, 2.0 * half)]
    return [
        ContourPath(name, outline, side, reach, floor, height, room, start, up=up, width=2.0 * half)
        for name, outline, side in (("inner flank", inner, 1.0), ("outer flank", outer, -1.0))
    ]
