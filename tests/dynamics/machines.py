"""Drives and followers that the tests of dynamics change, and what their verdicts say."""

from __future__ import annotations

import re

from camgeom.checks import judge
from camgeom.model import Model
from camgeom.profile import parse
from tests.places import PROFILES
from tests.reference.planar_machines import ELASTIC

TOOL_CHANGER = (PROFILES / "tool_changer.toml").read_text()
_HEAD, _, _REST = (PROFILES / "conjugate_rocker.toml").read_text().partition("[impact]")
ROCKER = _HEAD + _REST.partition("\n\n")[2]
"""the rocker without its own [impact]"""
OWN = ("dynamic-pressure", "dynamic-life", "lift-off", "settling", "resonance", "stability", "impact-pressure")


def changed(text, *pairs):
    for old, new in pairs:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


def changer(speed, *pairs):
    return Model(parse(changed(TOOL_CHANGER, ("speed = 120", f"speed = {speed}"), *pairs)))


def follower(speed, *pairs, more=""):
    text = ELASTIC.format(law="cycloidal")
    own = (("polydyne = true", "linkage_damping = 250"), ("spring_preload = 400", "spring_preload = 90"))
    return Model(parse(changed(text, ("speed = 900", f"speed = {speed}"), *own, *pairs) + more))


def levels(model, *names):
    return {finding.check: finding.level for finding in judge(model, names or OWN).findings}


def finding(model, name):
    (found,) = judge(model, (name,)).findings
    return found


def limited(text, *lines):
    """A profile's text with further limits."""
    more = "".join(f"{line}\n" for line in lines)
    if "[limits]" not in text:
        return f"{text}\n[limits]\n{more}"
    return re.sub(r"(\[limits\][^\n]*\n)", lambda table: table[1] + more, text)


IMPACTS = ROCKER + "\n[impact]\nturns = 3\n"
