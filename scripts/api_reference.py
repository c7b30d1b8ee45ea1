"""Write docs/api.md, the reference of camgeom's Python names, from their docstrings.

    python scripts/api_reference.py            # writes docs/api.md
    python scripts/api_reference.py --check    # exit status 1 where the file is not what the docstrings say
"""

from __future__ import annotations

import argparse
import inspect
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
PAGE = ROOT / "docs" / "api.md"

HEAD = """# camgeom from Python

Made from the docstrings by `scripts/api_reference.py`. Lengths are mm and angles rad in arrays and facts, degrees in
profiles and results; forces N, stresses MPa, torques N mm inside and N m in results. Arrays are numpy and read-only.
Everything is computed when it is first asked for, once. The programs in `examples/` show it at work: a groove cam, a
disc from a lift table, an indexer with its dynamics, a study of impacts, a search, an inspection.

```python
import camgeom

model = camgeom.read("profiles/pin_insertion.toml")      # a path, a TOML text, a dict or an open file
model                                                    # in a notebook: verdict, key figures, section
model.with_(cam__diameter=150).pressure_angle.value      # another cam, judged like a file
found = camgeom.study(model, {"cam.diameter": [140, 150, 160]})
found["contact.peak_pressure_mpa"][found.passed]
```
"""


def main() -> int:
    """Write the page, or compare it; 0 when it is current."""
    parser = argparse.ArgumentParser(description="Reference of Python names.")
    parser.add_argument("--check", action="store_true", help="compare only")
    text = reference()
    if parser.parse_args().check:
        return int(not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != text)
    PAGE.write_text(text, encoding="utf-8")
    print(f"wrote {PAGE.relative_to(ROOT)}")
    return 0


def reference() -> str:
    """The page."""
    import camgeom
    from camgeom.checks.verdict import Finding
    from camgeom.maths.extremum import Extreme
    from camgeom.model.arrays import MotionArrays
    from camgeom.seat.variants import Results
    from camgeom.solid import Solid
    from camgeom.track.flank import Flank

    parts = [HEAD]
    functions = [name for name in camgeom.__all__ if inspect.isfunction(getattr(camgeom, name))]
    classes = [camgeom.Model, Results, MotionArrays, Flank, Solid, Extreme, Finding, camgeom.Claims, camgeom.Piece,
               camgeom.Parameter]  # fmt: skip
    parts.append("## Functions\n")
    parts += [_function(f"camgeom.{name}", getattr(camgeom, name)) for name in functions]
    parts += [text for one in classes for text in _class(one)]
    parts.append("## Errors\n")
    errors = [getattr(camgeom, name) for name in camgeom.__all__ if name.endswith("Error") or name == "NotConverged"]
    parts += [f"- `camgeom.{one.__name__}`: {_doc(one).splitlines()[0]}" for one in errors]
    return "\n".join(parts).rstrip() + "\n"


def _doc(thing: Any) -> str:
    return inspect.getdoc(thing) or ""


def _shown(doc: str) -> str:
    """A docstring as text that Markdown leaves as it is: lists and examples keep their lines."""
    first, _, rest = doc.partition("\n")
    body = rest.strip("\n")
    return first + (f"\n\n```text\n{body}\n```" if body else "") + "\n"


def _function(name: str, thing: Any) -> str:
    signature = str(inspect.signature(thing)).replace("''", '""').replace("'", "")
    return f"### `{name}`\n\n```python\n{name.rpartition('.')[2]}{signature}\n```\n\n{_shown(_doc(thing))}"


def _class(one: type) -> Iterator[str]:
    yield f"## `{one.__name__}`\n\n{_shown(_doc(one))}"
    own = [kind for kind in reversed(one.__mro__) if kind.__module__.startswith("camgeom.")]
    members = {name: thing for kind in own for name, thing in vars(kind).items() if not name.startswith("_")}
    facts = [name for name, thing in members.items() if not inspect.isroutine(thing) and _doc_of(thing)]
    if facts:
        yield "| attribute | what it is |\n|---|---|"
        yield from (f"| `{name}` | {_cell(_doc_of(members[name]))} |" for name in facts)
        yield ""
    for name, thing in members.items():
        if inspect.isfunction(thing):
            yield _function(f"{one.__name__}.{name}", thing)


def _doc_of(thing: Any) -> str:
    """The docstring of a property or fact; none of a plain value, whose class has another."""
    own = inspect.isdatadescriptor(thing) or type(thing).__name__ in ("fact", "cached_property")
    return _doc(thing) if own and not inspect.ismemberdescriptor(thing) else ""


def _cell(doc: str) -> str:
    return " ".join(doc.split()).replace("|", "\\|")


if __name__ == "__main__":
    sys.exit(main())
