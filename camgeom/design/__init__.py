"""Many models: studies, and the choice of sizes from a requirement."""

from __future__ import annotations

from typing import TYPE_CHECKING

from camgeom.immutable import immutable

if TYPE_CHECKING:
    from camgeom.checks.verdict import Finding


@immutable(eq=True)
class Choice:
    """One choice with its reason; a number is in mm."""

    what: str
    value: str | float
    why: str


@immutable(eq=True)
class Design:
    """A finished design: the profile's text, the choices, and what the checks said of it."""

    text: str
    choices: tuple[Choice, ...]
    findings: tuple[Finding, ...]
