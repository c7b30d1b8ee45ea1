"""What a line that is no TOML was meant to say: numbers with units, commas or blanks, brackets, quotes, comments."""

from __future__ import annotations

import re

INCHES = ("in", "inch", "inches", "zoll")
ARRAYS = ("motion", "duty", "operation.force", "duty.force")
"""tables of a profile that come in double brackets, one for each"""
_NUMBER = r"[+-]?\d[\d_]*(?:[.,]\d+)?(?:[eE][+-]?\d+)?"


def line_hint(text: str, message: str) -> str:
    """What the line that a message of the TOML reader names was meant to say; empty where nobody knows."""
    place = re.search(r"at line (\d+)", message)
    lines = text.split("\n")
    if place is None or int(place[1]) > len(lines):
        return ""
    number = int(place[1]) - 1
    line = lines[number][:200].strip()
    if re.match(r"cannot (declare|overwrite)", message.lower()):
        return _stated_twice(lines, number, line)
    if line.startswith("["):
        name = re.match(r"\[+\s*([\w.-]+)", line)
        return "" if name is None else f"write {_header(name[1], line.startswith('[['))}"
    pair = re.match(r"([\w.-]+)\s*([=:])\s*(.*)", line)
    if pair is None:
        return ""
    key, sign, value = pair.groups()
    return value_hint(value) if sign == "=" else f"write {key} = {value}"


def _header(name: str, several: bool = False) -> str:
    return f"[[{name}]]" if several or name in ARRAYS else f"[{name}]"


def _stated_twice(lines: list[str], number: int, line: str) -> str:
    """Where a table or a key stands already."""
    name = re.match(r"\[+\s*([\w.-]+)", line)
    if name is not None and name[1] in ARRAYS:
        return f"write [[{name[1]}]] in double brackets each time: every one of it is a table of its own"
    key = line.split("=")[0].strip()
    same = re.compile(rf"\s*\[\s*{re.escape(name[1])}\s*\]" if name else rf"\s*{re.escape(key)}\s*=")
    above = [i for i in range(number) if same.match(lines[i])]
    what = f"[{name[1]}]" if name else key
    advice = "put its keys there" if name else "take one of the two away"
    return f"{what} stands in line {above[-1] + 1} already: {advice}" if above else ""


def value_hint(value: str) -> str:
    """How a value was to be written; empty where nobody knows."""
    value = value.partition("#")[0].strip()
    if not value:
        return "a value is missing behind ="
    if hint := number_hint(value):
        return hint
    if behind := re.match(rf"({_NUMBER}|\"[^\"]*\"|\w+)\s*(;|//|--|/\*|%)", value):
        return f"a comment begins with #: {behind[1]}  # ..."
    if value.lower() in ("true", "yes", "on", "false", "no", "off"):
        return f"write {'true' if value.lower() in ('true', 'yes', 'on') else 'false'}"
    if ratio := re.fullmatch(r"(?:(\d+)[ -]+)?(\d+(?:\.\d+)?)\s*/\s*(\d+(?:\.\d+)?)(\"?|\s*in)", value):
        below = float(ratio[3])
        return f"a value is a number, no formula: {int(ratio[1] or 0) + float(ratio[2]) / below:.15g}" if below else ""
    if re.match(r"[“”„‘’«]", value) or re.fullmatch(r"[A-Za-z][\w .+-]*", value):
        plain = value.strip("“”„‘’«»")
        return f'a text stands in straight quotes: "{plain}"'
    return ""


def number_hint(text: str) -> str:
    """How a number was to be written that stands with a unit, a decimal comma, blanks or quotes; empty for no number.
    """
    text = text[:60].strip()
    if re.fullmatch(r"[+-]?\.\d+", text):
        return f"a number begins with a digit: {text.replace('.', '0.')}"
    if re.fullmatch(r"[+-]?\d+\.", text):
        return f"a number ends with a digit: {text}0"
    if re.fullmatch(r"[+-]?0\d+(?:\.\d+)?", text):
        return f"a number has no zero in front: {text.lstrip('+-0') or 0}"
    if re.fullmatch(r"[+-]?\d{1,3}(?:[ .']\d{3})+(?:,\d+)?|[+-]?\d{1,3}(?: \d{3})+(?:\.\d+)?", text):
        return f"digits stand together, with a decimal point: {_together(text)}"
    found = re.fullmatch(rf"[\"']?\s*({_NUMBER})\s*([a-zA-Z°µ²³/\"']*)", text)
    if found is None:
        return ""
    point = found[1].replace(",", ".")
    unit = found[2].rstrip("\"'") or ("in" if found[2] == '"' and not text.startswith('"') else "")
    if unit.lower() in INCHES:
        return f'lengths are mm: {point} in is {25.4 * float(point):.7g}; or write units = "inch" at the top'
    if unit:
        return f"a number stands without its unit: {point}"
    return f"a number has a decimal point and no quotes: {point}"


def _together(text: str) -> str:
    """Groups of three digits as one number: behind a comma, or a point after blanks, stand its decimals."""
    whole, _, decimals = text.partition(",")
    if not decimals and " " in whole:
        whole, _, decimals = text.partition(".")
    whole = re.sub(r"[ .']", "", whole)
    return f"{whole}.{decimals}" if decimals else whole
