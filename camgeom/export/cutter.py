"""What the machine shop gets: the tool's way as a table, in APT and in G-code, and a map of the stock it leaves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import DesignError, ExportError
from camgeom.export import NamedMesh, write_mesh, writer
from camgeom.export.files import atomic_write, write_csv
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh

if TYPE_CHECKING:
    from camgeom.machining.machine import Machine
    from camgeom.machining.outcome import Outcome
    from camgeom.machining.plan import Machining, Pass
    from camgeom.machining.rest import RestField
    from camgeom.model import Model


COLUMNS = (
    "pass", "move", "cam_angle_deg", "x_mm", "y_mm", "z_mm", "i", "j", "k", "contact_x_mm", "contact_y_mm",
    "contact_z_mm", "normal_x", "normal_y", "normal_z", "time_s",
)  # fmt: skip
_CHUNK = 8192


def no_tool(model: Model) -> str:
    """Why no tool is known: without a [cutter] it is like the follower's roller, where the cam takes one."""
    if model.profile.cutter is None and model.mechanism.roller is None:
        return "needs a [cutter] table: the follower has no roller, and so no tool like it"
    return ""


def no_program(model: Model) -> str:
    """Why there is no program for a machine."""
    return NO_CUTTER if model.profile.cutter is None else ""


def no_rest(model: Model) -> str:
    """Why a tool leaves nothing that changes from place to place."""
    from camgeom.machining.spec import leaning

    same = model.mechanism.blank is None and not any(leaning(one.mechanism) for one in model.grooves)
    return no_tool(model) or (SAME_STOCK if same else "")


NO_CUTTER = "G-code needs a [cutter] table: nobody chose tool, spindle speed, feed and machine"
SAME_STOCK = "the contour of a planar cam leaves the same stock everywhere"


@writer(
    ".cutter.csv", "cutter positions: end, axis, contact, normal, time, CSV; exact", takes="machining", missing=no_tool
)
def write_cutter_csv(path: Path, machining: Machining) -> int:
    """Write every block of every pass, one a line, in the cam frame; returns the bytes written.

    Numbers read back to the last bit. `pass` counts from 1; `move` is rapid, feed (in and out) or cut; contact and
    normal (into the cam) are those of the flank that the block belongs to, of the first of two; `time_s` is the time
    the block takes (0 for rapid ones). Raises ExportError where the file cannot be written.
    """
    from camgeom.machining.plan import seconds

    def tables() -> Iterator[tuple[str, Floats]]:
        for number, tool_pass in enumerate(machining.passes("cam"), 1):
            for move, times in zip(tool_pass.moves, seconds(tool_pass.moves, machining.spec)):
                at = move.positions
                rows = [np.degrees(at.phi)[None], at.tip, at.axis, at.contacts[0], at.normals[0], times[None]]
                yield f"{number},{move.kind},", np.concatenate(rows).T

    return write_csv(path, COLUMNS, tables())


def _warned(machining: Machining) -> list[str]:
    """What a ring that is cut from within leaves the angle head, and what of a groove is left standing, in words."""
    words, room = [], machining.room
    if room is not None:
        words.append(f"ANGLE HEAD AND TOOL AT MOST {room.length:.6g} MM LONG, LESS FOR WHAT THE HEAD IS THICKER, "
                     f"TOOL AXIS {room.below:.6g} MM ABOVE THE WEB")  # fmt: skip
        if (length := machining.spec.length or 0.0) > room.length:
            words.append(f"THE TOOL ALONE IS {length:.6g} MM LONG AND STANDS IN THE RING BEHIND IT")
    if machining.standing:
        words.append(f"ROUGH THE GROOVE OUT FIRST: BETWEEN THE PASSES {machining.standing:.6g} MM OF IT STAND")
    return words


SAME_FEED = 0.01
"""share by which the feed of the tool's end may change before it is said anew"""
_IN_APT, _IN_GCODE = "$/", "()%;"
"""characters with a meaning of their own"""
_GOTO = "GOTO/{:.6f},{:.6f},{:.6f},{:.8f},{:.8f},{:.8f}\n"


@writer(
    ".apt", "cutter location data in APT: GOTO/x,y,z,i,j,k of the tool's end and axis", takes="machining",
    missing=no_tool,
)
def write_apt(path: Path, machining: Machining) -> int:
    """Write the passes as APT: mm, cam frame, positions to 1e-6 mm, axes to 1e-8; returns the bytes written.

    GOTO is the end of the tool on its axis (the lowest point of a ball, the middle of a wheel's end) and the unit
    vector from there to the spindle. FEDRAT, mm/min of the tool's end, follows the surface speed at the contact to one
    per cent. Raises ExportError where the file cannot be written.
    """
    spec = machining.spec
    height = spec.length or max(path.height for path in machining.paths)
    head = [
        f"PARTNO/{_capitals(machining.title, _IN_APT)[:64]}",
        f"PPRINT/CAMGEOM, LENGTHS MM, CAM FRAME: ORIGIN {machining.machine.origin}"
        if machining.machine.slides else "PPRINT/CAMGEOM, LENGTHS MM, CAM FRAME: ORIGIN AND Z ON THE CAM AXIS",
        f"PPRINT/CHORD ERROR AT MOST {spec.tolerance:.6g} MM, ALLOWANCE {spec.allowance:.6g} MM",
        f"PPRINT/FEDRAT KEEPS {spec.feed:.6g} MMPM AT THE CONTACT",
        *(["PPRINT/NO CUTTER TABLE: TOOL, SPINDLE AND FEED ARE ASSUMED"] if machining.assumed else []),
        *(f"PPRINT/{line}" for line in _warned(machining)),
        "UNITS/MM",
        "MULTAX/ON",
    ]
    turned = False
    with atomic_write(path) as stream:
        stream.write(("\n".join(head) + "\n").encode("ascii"))
        for tool_pass in machining.passes("cam"):
            lines = []
            if tool_pass.below and not turned:
                turned = True
                lines += ["COOLNT/OFF", "SPINDL/OFF", "PPRINT/TURN THE PART OVER: THE SPINDLE COMES FROM -Z", "STOP"]
            if tool_pass.begins:
                tool = machining.different[tool_pass.tool]
                lines += [
                    f"PPRINT/TOOL {_capitals(tool.about, _IN_APT)}",
                    "CUTTER/" + ",".join(f"{value:.6f}" for value in tool.apt(height)),
                    f"LOADTL/{spec.tool_number + tool_pass.tool},LENGTH,{height:.6f}",
                    f"SPINDL/{spec.spindle:.6g},RPM,CLW",
                    "COOLNT/ON",
                ]
            lines.append(f"PPRINT/PASS {_capitals(tool_pass.name, _IN_APT)}")
            stream.write(("\n".join(lines) + "\n").encode("ascii"))
            for text in _apt_moves(machining, tool_pass):
                stream.write(text.encode("ascii"))
        stream.write(b"COOLNT/OFF\nSPINDL/OFF\nFINI\n")
        return stream.tell()


def _apt_moves(machining: Machining, tool_pass: Pass) -> Iterator[str]:
    """The lines of one pass, some at a time."""
    from camgeom.machining.plan import seconds

    last: Floats | None = None
    said = 0.0
    for move, times in zip(tool_pass.moves, seconds(tool_pass.moves, machining.spec)):
        at = move.positions
        way = np.concatenate([at.tip[:, :1] if last is None else last, at.tip], axis=1)
        length = np.sqrt((np.diff(way, axis=1) ** 2).sum(axis=0))
        feeds = 60.0 * length / np.where(times > 0.0, times, np.inf)
        last = at.tip[:, -1:]
        table = np.concatenate([at.tip, at.axis]).T
        for start in range(0, len(table), _CHUNK):
            lines = []
            for row, feed in zip(table[start : start + _CHUNK].tolist(), feeds[start : start + _CHUNK].tolist()):
                if move.kind == "rapid":
                    lines.append("RAPID\n")
                    said = 0.0
                elif feed > 0.0 and abs(feed - said) > SAME_FEED * feed:
                    lines.append(f"FEDRAT/{feed:.3f},MMPM\n")
                    said = feed
                lines.append(_GOTO.format(*row))
            yield "".join(lines)


LINEAR = "%.4f"
ROTARY = "%.5f"
"""decimals of mm and degrees: 0.05 µm and, at 100 mm from the axis, 0.01 µm"""
FASTEST = 1e6
"""1/min or mm/min; a faster block would only be a rounding of its own length"""


@writer(
    ".gcode", "G-code for a rotary-table mill, feed by surface speed (G93, or G94)", takes="machining",
    missing=no_program,
)
def write_gcode(path: Path, machining: Machining) -> int:
    """Write the passes as G-code in mm and degrees, absolute; returns the bytes written.

    Blocks are straight in the machine's coordinates, and their chord error on the part keeps spec.tolerance; what
    rounding to the last decimals adds is said in the head. The program works in G54 with the length of the tool that
    `tool_number` names (G43), and begins and ends with the spindle's axis at the machine's reference (G53): first the
    rotary axes turn, then the tool goes over its start, then down. In G93
    every cutting block has its own F, 1/min, so that the contact moves at spec.feed; in G94 F is mm/min of the linear
    axes, or degrees/min where only the rotary ones move. Raises DesignError where the profile has no [cutter], so that
    tool, speed and feed would be invented, or the machine's axes cannot hold the tool; ExportError where the file
    cannot be written.
    """
    from camgeom.machining.plan import lead_radius

    if machining.assumed:
        raise DesignError(NO_CUTTER)
    spec, machine = machining.spec, machining.machine
    rounding = _rounding(machining)
    leads = [lead_radius(spec.lead, path.room, machining.tool.radius) for path in machining.paths if path.closed]
    tools = [f"T{spec.tool_number + k}: {tool.about}" for k, tool in enumerate(machining.different)]
    inverse = spec.feed_mode == "inverse-time"
    where = "TOOL END" if machine.pivot == 0.0 else "SWING AXIS"
    notes = [
        f"CAMGEOM: {machining.title}",
        f"TOOL {'; '.join(tools)}; COORDINATES OF THE {where}",
        *machine.about,
        *_warned(machining),
        *(machine.about_over if any(path.below for path in machining.paths) else []),
        f"PATH WITHIN {spec.tolerance + rounding:.3g} MM: CHORDS {spec.tolerance:.6g}, DECIMALS {rounding:.2g}; "
        f"ALLOWANCE {spec.allowance:.6g} MM",
        f"G54 {machine.origin}; G43 H{spec.tool_number}; G53 {machine.retreat}0 CLEARS THE PART",
        *(["THE TOOL PLUNGES STRAIGHT DOWN: IT CUTS TO ITS CENTRE, OR THE START IS OPEN"] if 0.0 in leads else []),
        f"{'G93: F IS 1/MIN' if inverse else 'G94'}; SURFACE SPEED {spec.feed:.6g} MM/MIN AT THE CONTACT",
    ]
    head = ["%", *(f"({_capitals(note, _IN_GCODE)})" for note in notes), "G21 G90 G17 G40 G49 G80 G94"]
    clear, begun, turned = f"G53 G0 {machine.retreat}0.", False, False
    with atomic_write(path) as stream:
        stream.write(("\n".join(head) + "\n").encode("ascii"))
        for tool_pass in machining.passes("machine"):
            lines = []
            if tool_pass.begins:
                lines += ["G94", clear, "G49", "M9", "M5"] if begun else []
                over = tool_pass.below and not turned
                lines += ["(TURN THE PART OVER)", "M0"] if over and begun else []
                lines += ["G55" if over else "G54"] if over or not begun else []
                lines += [] if begun else [clear]
                lines += [f"T{spec.tool_number + tool_pass.tool} M6", f"S{spec.spindle:.0f} M3", "M8"]
                begun, turned = True, tool_pass.below
            lines.append(f"({_capitals('PASS ' + tool_pass.name, _IN_GCODE)})")
            stream.write(("\n".join(lines) + "\n").encode("ascii"))
            for text in _gcode_moves(path, machining, tool_pass, inverse, tool_pass.begins):
                stream.write(text.encode("ascii"))
        stream.write(f"G94\n{clear}\nG49\nM9\nM5\nM30\n%\n".encode("ascii"))
        return stream.tell()


def _rounding(machining: Machining) -> float:
    """How far from the exact place a rounded block's tool end and contact may stand, mm."""
    machine = machining.machine
    reaches = (float(np.hypot(*path.at(path.knots()).tip[:2]).max()) for path in machining.paths)
    radius = max(machining.safe_radius, *reaches)
    rotary = [radius] if machine.way != "plain" else []
    rotary += [machine.pivot + max(path.height for path in machining.paths)] if machine.swings else []
    return float(0.5e-4 * np.sqrt(3.0) + sum(rotary) * np.radians(0.5e-5))


def _approach(machine: Machine, number: int, row: list[float]) -> str:
    """The way from the machine's reference: rotary axes, then over the start, then down with the tool's length."""
    decimals = [LINEAR] * 3 + [ROTARY] * len(machine.letters[3:])
    words = {letter: f" {letter}{form % value}" for letter, form, value in zip(machine.letters, decimals, row)}
    turns = "".join(words[letter] for letter in machine.letters[3:])
    over = "".join(words[letter] for letter in machine.letters[:3] if letter != machine.retreat)
    return (f"G0{turns}\n" if turns else "") + f"G0{over}\nG43 H{number} G0{words[machine.retreat]}\n"


def _gcode_moves(path: Path, machining: Machining, tool_pass: Pass, inverse: bool, begins: bool) -> Iterator[str]:
    """The blocks of one pass, some at a time."""
    from camgeom.machining.machine import in_degrees
    from camgeom.machining.plan import seconds

    machine = machining.machine
    letters = machine.letters
    block = "".join(f" {letter}{LINEAR if i < 3 else ROTARY}" for i, letter in enumerate(letters))
    last: Floats | None = None
    mode = ""
    for move, times in zip(tool_pass.moves, seconds(tool_pass.moves, machining.spec)):
        table = in_degrees(machine.solve(move.positions))
        if last is not None and move.kind != "rapid":
            # Every move counts its turns from nought; a tool in the cut must not go round once more.
            table[3:] += 360.0 * np.round((last[3:] - table[3:, :1]) / 360.0)
        table[:3], table[3:] = np.round(table[:3], 4) + 0.0, np.round(table[3:], 5) + 0.0
        if not np.all(np.isfinite(table)):
            raise ExportError(f"{path}: a coordinate of pass {tool_pass.name!r} is not finite")
        if move.kind == "rapid":
            yield "G94\n" if inverse and mode != "G94" else ""
            mode = "G94"
            stops = table.T.tolist()
            if begins and last is None:
                yield _approach(machine, machining.spec.tool_number + tool_pass.tool, stops.pop(0))
            yield "".join("G0" + block % tuple(row) + "\n" for row in stops)
        else:
            before = table[:, :1] if last is None else last
            feeds = _feeds(np.concatenate([before, table], axis=1), times, inverse)
            rows = np.concatenate([table, feeds[None]]).T
            yield "G93\n" if inverse and mode != "G93" else ""
            mode = "G93"
            for start in range(0, len(rows), _CHUNK):
                part = rows[start : start + _CHUNK].tolist()
                yield "".join(f"G1{block % tuple(row[:-1])} F{_feed(row[-1])}\n" for row in part)
        last = table[:, -1:]


def _feeds(table: Floats, times: Floats, inverse: bool) -> Floats:
    """F of every block between the columns of a table (mm, degrees)."""
    minutes = np.maximum(times, 1e-9) / 60.0
    if inverse:
        return np.asarray(np.minimum(1.0 / minutes, FASTEST))
    step = np.diff(table, axis=1)
    linear = np.sqrt((step[:3] ** 2).sum(axis=0))
    turning = np.sqrt((step[3:] ** 2).sum(axis=0))
    return np.asarray(np.clip(np.where(linear > 0.5e-4, linear, turning) / minutes, 1e-3, FASTEST))


def _feed(value: float) -> str:
    """F with seven digits, always with a point: some controls take a number without one for thousandths."""
    return f"{value:.{max(1, 6 - len(str(int(value))))}f}"


def _capitals(text: str, reserved: str) -> str:
    """Text in capitals without what a control would read: anything reserved or outside printable ASCII."""
    shown = "".join(c if c.isascii() and c.isprintable() and c not in reserved else " " for c in text)
    return " ".join(shown.upper().split())


ROUND = "drums, globoids and discs of conical rollers"
"""cams whose flanks are no straight walls: what a tool leaves there changes from place to place"""
REST_COLUMNS = ("track", "side", "cam_angle_deg", "roller_mm", "x_mm", "y_mm", "z_mm", "rest_mm")


@writer(".rest.csv", "stock that the tool leaves on flanks (gouges negative), CSV", "machined", ROUND, no_rest)
def write_rest_csv(path: Path, outcome: Outcome) -> int:
    """Write the stock at points of every flank, mm, one a line; returns the bytes written.

    Raises ExportError for a planar cam, whose contour leaves the same stock everywhere, or where the file cannot be
    written.
    """
    fields = _rest_fields(path, outcome)

    def table(field: RestField) -> Floats:
        angle, height = np.degrees(field.phi)[:, None], field.delta
        columns = np.broadcast_arrays(angle, height, *field.flank.x, field.rest)
        return np.stack([column[field.valid] for column in columns], axis=1)

    return write_csv(path, REST_COLUMNS, ((f"{_named(field, ',')},", table(field)) for field in fields))


@writer(".rest.vtu", "flanks with the stock that the tool leaves as a field, VTU; exact", "machined", ROUND, no_rest)
def write_rest_vtu(path: Path, outcome: Outcome) -> int:
    """Write every flank as a surface with `rest_mm` on its points; returns the bytes written. Errors as for the CSV."""
    bodies = []
    for field in _rest_fields(path, outcome):
        mesh = _rest_surface(field)
        if len(mesh.faces):
            bodies.append(NamedMesh(_named(field, " "), mesh))
    return write_mesh(bodies, path)


def _rest_fields(path: Path, outcome: Outcome) -> tuple[RestField, ...]:
    if not outcome.fields:
        raise ExportError(f"{path}: {SAME_STOCK}")
    return outcome.fields


def _named(field: RestField, mark: str) -> str:
    """The flank of a field: its track and side."""
    return f"{field.track.name}{mark}{field.side:+.0f}"


def _rest_surface(field: RestField) -> Mesh:
    """The flank's grid as triangles; cells with a corner off the blank are left out."""
    n, m = field.rest.shape
    index = np.arange(n * m).reshape(n, m)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    whole = field.valid[:-1, :-1] & field.valid[1:, :-1] & field.valid[1:, 1:] & field.valid[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1)[whole], np.stack([a, c, d], -1)[whole]]).astype(np.int32)
    points = np.moveaxis(field.flank.x, 0, -1).reshape(-1, 3)
    return Mesh(np.ascontiguousarray(points), faces, ("flank",), None, {"rest_mm": field.rest.ravel().copy()})
