"""A sheet of paper as a PDF of one page: lines, circles and words in the standard Helvetica, nothing embedded.

PDF 1.4 (ISO 32000's predecessor), units of 1/72 inch, y upwards. The fourteen standard faces need no embedding; their
advance widths (thousandths of the size) are those of the published Adobe font metrics.
"""

from __future__ import annotations

import zlib

from camgeom.drawing.paper import Dot, Outline, Paper, Shape, Style, Words, style_of

POINT = 72.0 / 25.4
CIRCLE = 0.5522847498
"""length of a cubic's handle over the radius for a quarter circle"""
INSTEAD = str.maketrans(
    {"\N{NARROW NO-BREAK SPACE}": " ", "\N{NO-BREAK SPACE}": " ", "−": "-", "⌀": "Ø", "≤": "<=", "≥": ">=", "≈": "~",
     "⁻": "-", "⁰": "0", "⁴": "4", "⁵": "5", "⁶": "6", "⁷": "7", "⁸": "8", "⁹": "9"}
)  # fmt: skip
"""signs that the standard encoding lacks"""
_WIDTHS = (
    "278 278 355 556 556 889 667 191 333 333 389 584 278 333 278 278 556 556 556 556 556 556 556 556 556 556 278 278 "
    "584 584 584 556 1015 667 667 722 722 667 611 778 722 278 500 667 556 833 722 778 667 778 722 667 611 722 667 944 "
    "667 667 611 278 278 278 469 556 333 556 556 500 556 556 278 556 556 222 222 500 222 833 556 556 556 556 333 500 "
    "278 556 500 722 500 500 500 334 260 334 584"
)
ADVANCE = {chr(32 + k): int(width) for k, width in enumerate(_WIDTHS.split())}
ADVANCE |= {"°": 400, "²": 333, "³": 333, "¹": 333, "×": 584, "Ø": 778, "±": 584, "·": 278, "µ": 556}


def pdf(paper: Paper) -> bytes:
    """The sheet as a PDF document; the same sheet gives the same bytes."""
    content = zlib.compress("\n".join(_drawn(paper, shape) for shape in paper.ordered).encode("cp1252", "replace"), 9)
    page = f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {paper.width * POINT:.3f} {paper.height * POINT:.3f}] "
    page += "/Contents 4 0 R /Resources << /Font << /F1 5 0 R /F2 6 0 R >> >> >>"
    face = "<< /Type /Font /Subtype /Type1 /BaseFont /{} /Encoding /WinAnsiEncoding >>"
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        page.encode(),
        f"<< /Length {len(content)} /Filter /FlateDecode >>\nstream\n".encode() + content + b"\nendstream",
        face.format("Helvetica").encode(),
        face.format("Helvetica-Bold").encode(),
        b"<< /Title " + b"(" + _literal(paper.title) + b") /Producer (camgeom) >>",
    ]
    out = bytearray(b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n")
    places = []
    for number, body in enumerate(objects, start=1):
        places.append(len(out))
        out += f"{number} 0 obj\n".encode() + body + b"\nendobj\n"
    start = len(out)
    out += f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n".encode()
    out += b"".join(f"{place:010d} 00000 n \n".encode() for place in places)
    out += f"trailer\n<< /Size {len(objects) + 1} /Root 1 0 R /Info 7 0 R >>\nstartxref\n{start}\n%%EOF\n".encode()
    return bytes(out)


def advance(text: str, size: float) -> float:
    """Width of a line of text in Helvetica, in the unit of the size."""
    return size * 1e-3 * sum(ADVANCE.get(char, 556) for char in text.translate(INSTEAD))


def _literal(text: str) -> bytes:
    """The text of a string object: WinAnsi, with brackets and backslashes escaped."""
    plain = text.translate(INSTEAD).encode("cp1252", "replace")
    return plain.replace(b"\\", b"\\\\").replace(b"(", b"\\(").replace(b")", b"\\)")


def _drawn(paper: Paper, shape: Shape) -> str:
    """Drawing operators of a shape."""
    style = style_of(shape.style)
    if isinstance(shape, Words):
        return _text(paper, shape, style)
    path = _circle(paper, shape) if isinstance(shape, Dot) else _polylines(paper, shape)
    paint = {(True, True): "B*", (True, False): "f*", (False, True): "S"}.get((bool(style.fill), bool(style.stroke)))
    if not path or paint is None:
        return ""
    setting = f"{_colour(style.fill, 'rg')} " if style.fill else ""
    if style.stroke:
        dash = " ".join(f"{POINT * part:.3f}" for part in style.dash)
        setting += f"{_colour(style.stroke, 'RG')} {POINT * style.width:.3f} w [{dash}] 0 d 1 j "
    return f"{setting}{path} {paint}"


def _colour(text: str, operator: str) -> str:
    parts = (int(text[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return " ".join(f"{part:.3f}" for part in parts) + f" {operator}"


def _polylines(paper: Paper, shape: Outline) -> str:
    ends = [*shape.closed, *(False,) * (len(shape.lines) - len(shape.closed))]
    parts = []
    for line, closed in zip(shape.lines, ends):
        points = [f"{POINT * x:.3f} {POINT * (paper.height - y):.3f}" for x, y in line.tolist()]
        parts.append(" ".join([f"{points[0]} m", *(f"{point} l" for point in points[1:]), *(["h"] if closed else [])]))
    return " ".join(parts)


def _circle(paper: Paper, shape: Dot) -> str:
    x, y = POINT * shape.centre[0], POINT * (paper.height - shape.centre[1])
    r, k = POINT * shape.radius, POINT * shape.radius * CIRCLE
    quarters = [
        (x + r, y + k, x + k, y + r, x, y + r),
        (x - k, y + r, x - r, y + k, x - r, y),
        (x - r, y - k, x - k, y - r, x, y - r),
        (x + k, y - r, x + r, y - k, x + r, y),
    ]
    curves = " ".join(" ".join(f"{value:.3f}" for value in quarter) + " c" for quarter in quarters)
    return f"{x + r:.3f} {y:.3f} m {curves} h"


def _text(paper: Paper, words: Words, style: Style) -> str:
    share = {"start": 0.0, "middle": 0.5, "end": 1.0}[words.anchor]
    x = words.x - share * advance(words.text, words.size)
    place = f"{POINT * x:.3f} {POINT * (paper.height - words.y):.3f} Td"
    text = f"({_literal(words.text).decode('cp1252')}) Tj"
    face = f"/F{2 if style.bold else 1} {POINT * words.size:.3f} Tf"
    halo = f"1 1 1 RG {0.25 * POINT * words.size:.3f} w [] 0 d 1 j BT {face} 1 Tr {place} {text} ET "
    halo = halo if style.halo else ""
    return f"{halo}{_colour(style.fill, 'rg')} BT {face} 0 Tr {place} {text} ET"
