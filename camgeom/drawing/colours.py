"""Colour scales that read in greyscale and with any colour vision, made by formula in OKLab, and pictures of arrays.

The sequential scale rises steadily in lightness from deep blue over grey to yellow. The diverging scale runs from blue
over near-white to orange; its blue end is the darker one, so that the sign survives in greyscale.
OKLab to sRGB: B. Ottosson, "A perceptual color space for image processing" (2020).
"""

from __future__ import annotations

import struct
import zlib
from base64 import b64encode

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats

Bytes = npt.NDArray[np.uint8]

STEEL = (0.80, 0.82, 0.845)
FLANK = (0.50, 0.66, 0.82)
CUT = (0.95, 0.85, 0.66)
ROLLER = (0.87, 0.55, 0.22)
CARRIER = (0.93, 0.80, 0.64)
"""Blue and orange stay apart in every kind of colour vision, and in grey."""

_LMS = np.array(
    [[1.0, 0.3963377774, 0.2158037573], [1.0, -0.1055613458, -0.0638541728], [1.0, -0.0894841775, -1.2914855480]]
)
_RGB = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)
_SEQUENTIAL = np.array(  # share, lightness, a (green-red), b (blue-yellow)
    [
        [0.0, 0.27, 0.015, -0.12],
        [0.25, 0.43, -0.02, -0.10],
        [0.5, 0.60, -0.035, -0.01],
        [0.75, 0.77, -0.02, 0.09],
        [1.0, 0.94, -0.02, 0.15],
    ]
)
_DIVERGING = np.array(
    [
        [0.0, 0.36, -0.01, -0.14],
        [0.25, 0.64, -0.03, -0.09],
        [0.5, 0.96, 0.0, 0.005],
        [0.75, 0.78, 0.06, 0.10],
        [1.0, 0.57, 0.14, 0.11],
    ]
)


def scale(diverging: bool = False, steps: int = 256) -> Bytes:
    """Colour table (steps, 3), 8-bit sRGB.

    >>> scale(steps=2).tolist()[0][2] > scale(steps=2).tolist()[0][0]
    True
    """
    knots = _DIVERGING if diverging else _SEQUENTIAL
    at = np.linspace(0.0, 1.0, steps)
    lab = np.column_stack([np.interp(at, knots[:, 0], knots[:, i]) for i in (1, 2, 3)])
    linear = np.clip((lab @ _LMS.T) ** 3 @ _RGB.T, 0.0, 1.0)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return np.asarray(np.rint(255.0 * srgb), dtype=np.uint8)


def value_range(values: Floats, diverging: bool) -> tuple[float, float]:
    """Range of the finite values; symmetrical about zero for a diverging scale."""
    finite = values[np.isfinite(values)]
    low, high = float(np.min(finite)), float(np.max(finite))
    if diverging:
        high = max(abs(low), abs(high)) or 1.0
        return -high, high
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def picture(values: Floats, low: float, high: float, diverging: bool) -> str:
    """PNG data URI of an array (m, n), its first row at the bottom; blank where not finite."""
    table = np.vstack([np.c_[scale(diverging, 255), np.full(255, 255)], [[0, 0, 0, 0]]]).astype(np.uint8)
    finite = np.isfinite(values)
    share = np.where(finite, (np.where(finite, values, low) - low) / (high - low), 0.0)
    index = np.where(finite, np.rint(254.0 * np.clip(share, 0.0, 1.0)), 255.0).astype(np.uint8)
    return "data:image/png;base64," + b64encode(_png(index[::-1], table)).decode()


def _png(index: Bytes, table: Bytes) -> bytes:
    """A palette PNG (colour type 3, 8 bit) with transparency; ISO/IEC 15948."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    height, width = index.shape
    rows = np.hstack([np.zeros((height, 1), np.uint8), index]).tobytes()
    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    chunks = [
        chunk(b"IHDR", header),
        chunk(b"PLTE", table[:, :3].tobytes()),
        chunk(b"tRNS", table[:, 3].tobytes()),
        chunk(b"IDAT", zlib.compress(rows, 9)),
        chunk(b"IEND", b""),
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
