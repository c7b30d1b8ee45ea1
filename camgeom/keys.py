"""The ground every profile section stands on: frozen, hashable, strict pydantic models and bounded number types.

A section states its keys once, with unit, range and meaning in `Field(description=...)`; the reader, the JSON Schema,
the reference page and the starter profiles all come from that. Angles are degrees in a section (the edge of the
package); a `*_rad` property gives what the inside wants.
"""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

MAX_LENGTH = 1e5
"""mm; a cam part larger than 100 m is a slip of the keyboard"""
MIN_LENGTH = 1e-6
"""mm; a nanometre"""

Length = Annotated[float, Field(gt=MIN_LENGTH, le=MAX_LENGTH, allow_inf_nan=False)]
"""A size in mm, strictly positive."""
SignedLength = Annotated[float, Field(ge=-MAX_LENGTH, le=MAX_LENGTH, allow_inf_nan=False)]
"""A coordinate or offset in mm."""
Gap = Annotated[float, Field(ge=0.0, le=MAX_LENGTH, allow_inf_nan=False)]
"""A length in mm that may be zero."""
Clearance = Annotated[float, Field(ge=0.0, le=1000.0, allow_inf_nan=False)]
"""Of a roller in its groove, mm: a metre is no fit of any machine, and more takes an undercut body minutes."""
Degrees = Annotated[float, Field(ge=-3.6e6, le=3.6e6, allow_inf_nan=False)]
"""An angle in degrees."""
Share = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]
"""A fraction, 0 to 1."""


class Section(BaseModel):
    """Base of every profile section: unknown keys are errors, no value is coerced from text, nothing mutates."""

    # defer_build: a section's validator is compiled when the first profile has it, not when its module is imported
    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, populate_by_name=True, defer_build=True
    )
