"""What the sources print, computed from their own data by this package, with a verdict for each printed result.

One file a source holds its entries as data; an entry is a printed number or equation, the place where it stands and a
function that computes it. The verdict follows from the numbers alone (`entry`), never from a word in an entry.
"""

from camgeom.validation.catalogue import SOURCES, source_named, validate
from camgeom.validation.entry import Answer, Entry, JudgedEntry, Reading, Source

__all__ = ["SOURCES", "Answer", "Entry", "JudgedEntry", "Reading", "Source", "source_named", "validate"]
