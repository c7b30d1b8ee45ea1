"""ISO 286: limits of size of holes and shafts, and the clearance of their fits, mm.

Grades IT5 to IT11 and the deviations of the letters that shops use between cams, shafts, rollers and pins, up to
500 mm. Tables of ISO 286-1:2010 (standard tolerance grades; fundamental deviations of shafts), um. Holes C to H lie
above the nominal size as the shafts of their letter lie below it (general rule of the standard).
"""

from __future__ import annotations

import re
from bisect import bisect_left

SIZES = (3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0, 180.0, 250.0, 315.0, 400.0, 500.0)
"""mm, upper ends of the steps of nominal sizes; each step holds its upper end"""
GRADES = {
    4: (3, 4, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20),
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29, 32, 36, 40),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72, 81, 89, 97),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115, 130, 140, 155),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185, 210, 230, 250),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290, 320, 360, 400),
}
"""um, standard tolerances"""
BELOW = {
    "d": (20, 30, 40, 50, 65, 80, 100, 120, 145, 170, 190, 210, 230),
    "e": (14, 20, 25, 32, 40, 50, 60, 72, 85, 100, 110, 125, 135),
    "f": (6, 10, 13, 16, 20, 25, 30, 36, 43, 50, 56, 62, 68),
    "g": (2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 18, 20),
    "h": (0,) * 13,
}
"""um, by which the largest shaft stands below the nominal size"""
C_SIZES = (3.0, 6.0, 10.0, 18.0, 30.0, 40.0, 50.0, 65.0, 80.0, 100.0, 120.0, 140.0, 160.0, 180.0, 200.0, 225.0, 250.0,
           280.0, 315.0, 355.0, 400.0, 450.0, 500.0)  # fmt: skip
"""mm, upper ends of the finer steps of the letter c"""
BELOW_C = (60, 70, 80, 95, 110, 120, 130, 140, 150, 170, 180, 200, 210, 230, 240, 260, 280, 300, 330, 360, 400, 440,
           480)  # fmt: skip
"""um, of shafts c likewise (as excerpted in JIS B 0401, whose c9 has the same); the letter c ends at 500 mm"""
ABOVE = {
    "k": (0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5),
    "m": (2, 4, 6, 7, 8, 9, 11, 13, 15, 17, 20, 21, 23),
    "n": (4, 8, 10, 12, 15, 17, 20, 23, 27, 31, 34, 37, 40),
    "p": (6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62, 68),
}
"""um, by which the smallest shaft stands above it; k of the grades 4 to 7, beyond them 0"""
ALLOWED = f"a letter of c, {', '.join([*BELOW, 'js', *ABOVE])} (shafts) or C to H, JS (holes) and a grade 4 to 11"


def limits(code: str, size: float) -> tuple[float, float]:
    """Least and largest deviation, mm, of a hole ("H7") or shaft ("k6") of a nominal size, mm, from that size.

    Raises ValueError for what the tables here do not hold.
    """
    found = re.fullmatch(r"([A-Za-z]{1,2})(\d{1,2})", code.strip())
    grade = int(found[2]) if found else 0
    if found is None or grade not in GRADES:
        raise ValueError(f"{code!r}: needs {ALLOWED}")
    if not 0.0 <= size <= SIZES[-1]:
        raise ValueError(f"a nominal size of {size:g} mm: allowed: up to {SIZES[-1]:g} mm")
    step, letter = bisect_left(SIZES, size), found[1]
    width = GRADES[grade][step]
    low: float
    if letter in ("js", "JS"):
        low = -0.5 * width
    elif letter.lower() in ("c", *BELOW):
        off = BELOW_C[bisect_left(C_SIZES, size)] if letter.lower() == "c" else BELOW[letter.lower()][step]
        low = off if letter.isupper() else -off - width
    elif letter in ABOVE:
        low = ABOVE[letter][step] if letter != "k" or grade <= 7 else 0
    else:
        raise ValueError(f"{code!r}: needs {ALLOWED}")
    return 1e-3 * low, 1e-3 * (low + width)


def clearance(fit: str, size: float) -> tuple[float, float]:
    """Least and largest clearance, mm, of a fit such as "H7/k6"; below zero: interference. Raises ValueError."""
    hole, slash, shaft = fit.partition("/")
    if not slash or not hole.strip()[:1].isupper() or not shaft.strip()[:1].islower():
        raise ValueError(f"{fit!r}: needs a hole and a shaft, such as 'H7/k6'")
    (least, largest), (thin, thick) = limits(hole, size), limits(shaft, size)
    return least - thick, largest - thin
