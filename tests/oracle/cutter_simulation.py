"""A second opinion on cutter data: files read back, the tool's body moved through them, flanks written by hand.

Nothing here is taken from the package: the readers know the file formats, the kinematics of the G-code are those its
comments describe, and the flanks come from the machines' description (cycloidal motions, n = u x v).
"""

from __future__ import annotations

import re

import numpy as np

NUMBER = r"[-+]?\d+\.?\d*"


def read_apt(path):
    """Tool numbers (CUTTER), header words, and passes: lists of (kind, tips (n, 3), axes (n, 3))."""
    words, passes, rapid, cutter = [], [], False, None
    for line in path.read_text("ascii").splitlines():
        word, _, rest = line.partition("/")
        words.append(word)
        if line.startswith("PPRINT/PASS"):
            passes.append([])
        if word == "CUTTER":
            cutter = [float(x) for x in rest.split(",")]
        elif word == "RAPID":
            rapid = True
        elif word == "GOTO":
            passes[-1].append(("rapid" if rapid else "feed", [float(x) for x in rest.split(",")]))
            rapid = False
    return cutter, words, passes


def fed(blocks):
    """Tool ends and axes (n, 3) of a pass from where it comes down to where it leaves: all that is not rapid."""
    table = np.array([values for kind, values in blocks if kind == "feed"])
    return table[:, :3], table[:, 3:6]


def read_gcode(path):
    """Blocks as dicts (G, axes, F, mode), in order, from where the tool's length counts (G43); words checked."""
    blocks, state, motion, mode, held = [], {}, None, "G94", False
    for line in path.read_text("ascii").splitlines():
        plain = re.sub(r"\([^)]*\)", "", line).strip()
        if not plain or plain == "%":
            continue
        found = re.findall(rf"([A-Z])({NUMBER})", plain)
        assert "".join(a + b for a, b in found) == plain.replace(" ", ""), plain
        feed = None
        moves = False
        if ("G", "53") in found:
            continue  # machine coordinates
        held = held or ("G", "43") in found
        for letter, number in found:
            if letter == "G":
                word = f"G{int(float(number))}"
                motion = word if word in ("G0", "G1") else motion
                mode = word if word in ("G93", "G94") else mode
            elif letter in "XYZABC":
                assert "." in number, plain
                state[letter] = float(number)
                moves = True
            elif letter == "F":
                assert "." in number, plain
                feed = float(number)
        if moves and held:
            blocks.append({"G": motion, "mode": mode, "F": feed, **state})
    return blocks


def forward_rotary_a(blocks, pivot=0.0):
    """Ends and axes of the tool in the cam frame, of blocks on a machine with A about X (cam axis), spindle along Z.

    B tilts the tool about Y (zero: along +Z; positive towards +X); A plus turns the cam counter-clockwise seen from +X,
    so that a place of the cam is where it was, turned back by A.
    """
    x, y, z, a, b = (np.array([block.get(letter, 0.0) for block in blocks]) for letter in "XYZAB")
    a, b = np.radians(a), np.radians(b)
    # Machine (X, Y, Z) is cam (z, -y, x): X along the cam's axis, Z outwards.
    axis = np.stack([np.cos(b), 0.0 * b, np.sin(b)], axis=1)
    point = np.stack([z, -y, x], axis=1) - pivot * axis
    return turned(point, -a), turned(axis, -a)


LETTERS = {"A": "ZYXBC", "B": "ZXYAC", "C": "XYZBA"}
"""radial, across and axial linear axes, the swing about the across axis and about the radial one"""
UNIT = {"X": [1.0, 0.0, 0.0], "Y": [0.0, 1.0, 0.0], "Z": [0.0, 0.0, 1.0]}


def rotated(v: np.ndarray, axis: str, angle: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) turned right-handed about a machine axis (Rodrigues)."""
    k = np.array(UNIT[axis])
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return v * c + np.cross(np.broadcast_to(k, v.shape), v) * s + (v @ k)[:, None] * k * (1.0 - c)


def forward(
    blocks: list[dict], rotary: str, helix: bool = False, inside: bool = False, upright: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Ends and axes in the cam frame: the machine's frame is right-handed with the cam along its axial letter.

    helix: a wheel that swings about the radial axis; inside: an angle head whose tool points to the radial axis' +;
    upright: a spindle along the cam's axis, from where the tool is tilted about the across axis
    """
    radial, across, axial, tilt, about_radial = LETTERS[rotary]
    columns = {w: np.array([b.get(w, 0.0) for b in blocks]) for w in "XYZABC"}
    point = np.stack([columns[w] for w in "XYZ"], axis=1)
    n = len(blocks)
    sign = float(np.dot(np.cross(UNIT[axial], UNIT[radial]), UNIT[across]))
    if helix:
        zero = np.tile(sign * np.array(UNIT[across]), (n, 1))
        spindle = rotated(zero, radial, np.radians(columns[about_radial]))
    elif upright:
        spindle = rotated(np.tile(UNIT[axial], (n, 1)), across, np.radians(columns[tilt]))
    elif inside:
        spindle = np.tile(-np.array(UNIT[radial]), (n, 1))
    else:
        spindle = rotated(np.tile(UNIT[radial], (n, 1)), across, np.radians(columns[tilt]))
    # Cam x, y, z are the radial direction, the third one, and the axial direction.
    frame = np.array([UNIT[radial], np.cross(UNIT[axial], UNIT[radial]), UNIT[axial]])
    turn = -np.radians(columns[rotary])
    return turned(point @ frame.T, turn), turned(spindle @ frame.T, turn)


def fed_passes(blocks):
    """Blocks that are fed, by passes: those between rapid ways."""
    found = [[]]
    for block in blocks:
        if block["G"] == "G1":
            found[-1].append(block)
        elif found[-1]:
            found.append([])
    return [one for one in found if one]


def dense(blocks, rotary, **how):
    """Ends and axes as a machine passes them between its blocks, straight in its own coordinates."""
    letters = [w for w in "XYZABC" if any(w in block for block in blocks)]
    table = np.array([[block.get(w, 0.0) for w in letters] for block in blocks])
    at = np.arange(len(table))
    turn = np.abs(np.diff(table[:, letters.index(rotary)])) if rotary in letters else np.zeros(len(table) - 1)
    parts = np.maximum(2, np.ceil(turn / 0.06)).astype(int)  # an arc of 100 mm within 1.4e-5 mm
    where = np.concatenate([i + np.arange(n) / n for i, n in enumerate(parts)] + [at[-1:]])
    fine = np.stack([np.interp(where, at, column) for column in table.T], axis=1)
    return forward([dict(zip(letters, row)) for row in fine], rotary, **how)


def turned(v, angle):
    """Vectors (n, 3) turned about Z by angles (n,)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1], v[:, 2]], axis=1)


def tool_distance(x, tip, axis, cutter):
    """Signed distance of points to a tool with APT's seven numbers (cylinder, ball or cone), in its half plane.

    An eighth number is its length: beyond it there is nothing.
    """
    diameter, corner, _, _, _, side, _, *length = cutter  # of a ball only the ball: its shank is thinner
    axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    d = x - tip
    s = np.einsum("...i,...i->...", d, axis)
    across = np.sqrt(np.maximum(np.einsum("...i,...i->...", d, d) - s * s, 0.0))
    if corner > 0.0:
        assert corner == 0.5 * diameter
        return np.hypot(across, s - corner) - corner
    slope = np.tan(np.radians(side))
    wall = (across - 0.5 * diameter - slope * s) / np.hypot(1.0, slope)
    beyond = np.maximum(-s, s - length[0]) if length else -s
    return np.where(beyond <= 0.0, wall, np.hypot(np.maximum(wall, 0.0), beyond))


def swept(x, tip, axis, cutter):
    """Least distance (p,) of points (p, 3) from the tool as it moves straight between its positions (n, 3)."""
    best = np.full(len(x), np.inf)
    for part in np.array_split(np.arange(len(x)), max(1, len(x) * len(tip) // 400_000)):
        coarse = tool_distance(x[part][:, None], tip[None], axis[None], cutter)
        rows = np.arange(len(part))
        for _ in range(2):
            # The second time elsewhere: a closed path passes its start again.
            nearest = np.argmin(coarse, axis=1)
            best[part] = np.minimum(best[part], coarse[rows, nearest])
            for step in (-2, -1, 0, 1):
                first = np.clip(nearest + step, 0, len(tip) - 2)
                best[part] = np.minimum(best[part], _on_segment(x[part], tip, axis, first, cutter))
            for step in range(-4, 5):
                coarse[rows, np.clip(nearest + step, 0, len(tip) - 1)] = np.inf
    return best


def _on_segment(x, tip, axis, first, cutter):
    low, high = np.zeros(len(x)), np.ones(len(x))
    least = np.full(len(x), np.inf)
    for _ in range(4):
        share = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, 9)
        p = (1.0 - share)[..., None] * tip[first][:, None] + share[..., None] * tip[first + 1][:, None]
        u = (1.0 - share)[..., None] * axis[first][:, None] + share[..., None] * axis[first + 1][:, None]
        value = tool_distance(x[:, None], p, u, cutter)
        k = np.argmin(value, axis=1)
        rows = np.arange(len(x))
        least = np.minimum(least, value[rows, k])
        low, high = share[rows, np.maximum(k - 1, 0)], share[rows, np.minimum(k + 1, 8)]
    return least


def cycloidal(x):
    """Lift share and its derivative of the cycloidal law."""
    return x - np.sin(2.0 * np.pi * x) / (2.0 * np.pi), 1.0 - np.cos(2.0 * np.pi * x)


def motion(phi, steps):
    """Lift and derivative over the cam angle: steps (until deg, to or None), cycloidal; it repeats or steps on."""
    phi = np.asarray(phi, float)
    turn = np.floor(phi / (2.0 * np.pi))
    angle = phi - 2.0 * np.pi * turn
    final = [to for _, to in steps if to is not None][-1]
    s, ds = np.zeros_like(phi), np.zeros_like(phi)
    begin, at = 0.0, 0.0
    for until, to in steps:
        end = np.radians(until)
        here = (angle >= begin) & (angle <= end)
        goal = at if to is None else to
        share, slope = cycloidal((angle[here] - begin) / (end - begin))
        s[here] = at + (goal - at) * share
        ds[here] = (goal - at) * slope / (end - begin)
        begin, at = end, goal
    return s + turn * (final if abs(final) > 1e-9 else 0.0), ds


def drum_flank(phi, delta, radius, start, steps, side):
    """Points and normals (n, 3) of a groove drum's flank: the roller's axis radial at azimuth -phi, z = start + s."""
    s, ds = motion(phi, steps)
    c, sn = np.cos(phi), np.sin(phi)
    zero = np.zeros_like(phi)
    u, du = np.stack([c, -sn, zero], axis=1), np.stack([-sn, -c, zero], axis=1)
    a, da = np.stack([zero, zero, start + s], axis=1), np.stack([zero, zero, ds], axis=1)
    return _flank(a, da, u, du, delta, radius, side)


def globoid_flank(phi, delta, radius, centre, shift, steps, side):
    """The same for a right-hand globoid: the turret's axis along Y at x = centre, the roller at turret angle tau."""
    s, ds = motion(phi, [(until, None if to is None else np.radians(to)) for until, to in steps])
    tau = s + shift
    # Rollers next to the cam move towards +Z: at tau the roller points to (-cos tau, 0, sin tau).
    zero = np.zeros_like(phi)
    u0 = np.stack([-np.cos(tau), zero, np.sin(tau)], axis=1)
    du0 = ds[:, None] * np.stack([np.sin(tau), zero, np.cos(tau)], axis=1)
    a0 = np.stack([centre + zero, zero, zero], axis=1)
    u, a = turned(u0, -phi), turned(a0, -phi)
    du = turned(du0, -phi) - np.cross([0.0, 0.0, 1.0], u)
    da = -np.cross([0.0, 0.0, 1.0], a)
    return _flank(a, da, u, du, delta, radius, side)


def globoid_pose(phi, shift, centre, steps):
    """A point on the turret's axis and the roller's direction from it, each (n, 3), in the cam frame."""
    tau = motion(phi, [(until, None if to is None else np.radians(to)) for until, to in steps])[0] + shift
    zero = np.zeros_like(tau)
    u0 = np.stack([-np.cos(tau), zero, np.sin(tau)], axis=1)
    a0 = np.stack([centre + zero, zero, zero], axis=1)
    return turned(a0, -np.asarray(phi)), turned(u0, -np.asarray(phi))


def _flank(a, da, u, du, delta, radius, side):
    v = da + delta[:, None] * du
    n = np.cross(u, v)
    n *= side / np.linalg.norm(n, axis=1, keepdims=True)
    return a + delta[:, None] * u + radius * n, n


def forward_rotary_c(blocks):
    """Ends of the tool in the cam frame on a machine with C about Z (cam axis, spindle): C plus turns the cam ccw."""
    x, y, z, c = (np.array([block.get(letter, 0.0) for block in blocks]) for letter in "XYZC")
    return turned(np.stack([x, y, z], axis=1), -np.radians(c))


def disc_profile(phi, base, radius, steps):
    """Points (n, 2) of a disc cam's profile: roller centres at base + radius + s, at azimuth -phi."""
    s, ds = motion(phi, steps)
    reach = base + radius + s
    c, sn = np.cos(phi), np.sin(phi)
    centre = np.stack([reach * c, -reach * sn], axis=1)
    tangent = np.stack([ds * c - reach * sn, -ds * sn - reach * c], axis=1)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    inward = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    return centre + radius * inward
