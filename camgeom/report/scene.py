"""A 3D scene as text for the page: positions in 16 bits of the body's box, fields in 16 bits of their range, gzip'd.

The view is a picture: 16 bits of a 200 mm part are 3 um, a hundredth of a pixel. Facts are read from the tables.
"""

from __future__ import annotations

import gzip
import json
from base64 import b64encode
from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt

from camgeom.drawing.colours import scale, value_range
from camgeom.drawing.content import Actor, Axis, Scene
from camgeom.drawing.sheet import Ticks, ticks
from camgeom.maths import Floats

Pack = Callable[[npt.NDArray[np.generic]], str]
_TOP = 65534
"""largest code of a value; 65535 says that a vertex has none"""


def scene_json(scene: Scene, level: int = 9) -> str:
    """The scene as JSON for the viewer, its arrays gzip'd at a level 1 (quick) to 9; safe inside a script element."""
    pack = partial(_packed, level=level)
    data = {
        "angles": pack(scene.angles.astype(np.float32)),
        "frames": len(scene.angles),
        "speed": scene.speed,
        **({} if scene.eye is None else {"eye": scene.eye}),
        "bodies": [_body(body, scene, pack) for body in scene.bodies],
        "shades": [
            {
                "key": s.key,
                "label": s.label,
                "unit": s.unit,
                "groups": list(s.groups),
                "scale": _hex(s.diverging),
                **_range(scene, s.key, s.diverging),
            }
            for s in scene.shades
        ],
        "readouts": [_readout(axis, values, pack) for axis, values in scene.readouts],
    }
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _body(body: Actor, scene: Scene, pack: Pack) -> dict[str, object]:
    mesh = body.mesh
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = np.where(high > low, high - low, 1.0)
    group = mesh.group if mesh.group is not None else np.zeros(len(mesh.faces), np.uint8)
    return {
        "name": body.name,
        "role": body.role,
        "low": low.tolist(),
        "size": size.tolist(),
        "vertices": pack(_deltas(np.rint((mesh.vertices - low) / size * 65535.0).astype(np.uint16))),
        "faces": pack(_deltas(mesh.faces.astype(np.uint32))),
        "groups": list(mesh.groups),
        "group": pack(group),
        "poses": None if body.poses is None else pack(_quaternions(body.poses).astype(np.float32)),
        "fields": {
            shade.key: pack(_codes(body.fields[shade.key], *_limits(scene, shade.key, shade.diverging)))
            for shade in scene.shades
            if shade.key in body.fields
        },
    }


def _deltas(rows: npt.NDArray[np.uint16] | npt.NDArray[np.uint32]) -> npt.NDArray[np.unsignedinteger]:
    """Differences from row to row, column after column (modulo the word): small numbers that compress well."""
    return np.ascontiguousarray(np.diff(rows, axis=0, prepend=np.zeros((1, rows.shape[1]), rows.dtype)).T)


def _packed(array: npt.NDArray[np.generic], level: int) -> str:
    """Little-endian bytes, the bytes of equal weight together, gzip'd and in base64."""
    words = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<"), copy=False).ravel()
    planes = words.view(np.uint8).reshape(-1, words.itemsize).T
    return b64encode(gzip.compress(planes.tobytes(), level, mtime=0)).decode()


def _limits(scene: Scene, key: str, diverging: bool) -> tuple[float, float]:
    values = [body.fields[key] for body in scene.bodies if key in body.fields]
    return value_range(np.concatenate(values), diverging)


def _range(scene: Scene, key: str, diverging: bool) -> dict[str, object]:
    low, high = _limits(scene, key, diverging)
    found = ticks(low, high, 4, tight=True)
    return {"low": low, "high": high, "factor": found.factor, "ticks": _tick_texts(found, low, high)}


def _tick_texts(found: Ticks, low: float, high: float) -> list[list[float | str]]:
    return [[(v - low) / (high - low), t] for v, t in zip(found.at.tolist(), found.texts)]


def _codes(values: Floats, low: float, high: float) -> npt.NDArray[np.uint16]:
    finite = np.isfinite(values)
    share = (np.where(finite, values, low) - low) / (high - low)
    return np.where(finite, np.rint(np.clip(share, 0.0, 1.0) * _TOP), 65535).astype(np.uint16)


def _readout(axis: Axis, values: Floats, pack: Pack) -> dict[str, object]:
    return {"label": axis.label, "unit": axis.unit, "values": pack(values.astype(np.float32))}


def _hex(diverging: bool) -> str:
    return scale(diverging).tobytes().hex()


def _quaternions(poses: Floats) -> Floats:
    """(n, 7) unit quaternions x y z w and positions of poses [R | t]; neighbours on the same half of the sphere.

    Per rotation the largest of the four squared components is found first, which keeps the division safe.
    """
    r = poses[:, :, :3]
    trace = np.einsum("nii->n", r)
    squares = np.column_stack([1.0 + 2.0 * np.einsum("nii->ni", r) - trace[:, None], 1.0 + trace]) / 4.0
    largest = np.argmax(squares, axis=1)
    skew = np.column_stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]])
    products = np.empty((len(r), 4, 4))  # 4 q_i q_j
    products[:, :3, :3] = r + r.transpose(0, 2, 1)
    products[:, :3, 3] = products[:, 3, :3] = skew
    products[:, range(4), range(4)] = 4.0 * squares
    row = products[np.arange(len(r)), largest]
    q = row / np.linalg.norm(row, axis=1, keepdims=True)
    flips = np.sign(np.einsum("ni,ni->n", q[1:], q[:-1]))
    q[1:] *= np.cumprod(np.where(flips < 0.0, -1.0, 1.0))[:, None]
    return np.hstack([q, poses[:, :, 3]])
