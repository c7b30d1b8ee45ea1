"""Write docs/validation.md, every printed result of the sources beside ours, from what `camgeom validate` computes.

    python scripts/validation_page.py            # writes docs/validation.md
    python scripts/validation_page.py --check    # exit status 1 where the page is not what comes out
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
PAGE = ROOT / "docs" / "validation.md"


def main() -> int:
    """Write the page, or compare it; 0 when it is current."""
    from camgeom.validation import SOURCES, validate
    from camgeom.validation.page import markdown

    parser = argparse.ArgumentParser(description="The validation page.")
    parser.add_argument("--check", action="store_true", help="compare only")
    check = parser.parse_args().check
    text = markdown(SOURCES, validate())
    if check:
        return int(not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != text)
    PAGE.write_text(text, encoding="utf-8")
    print(f"{PAGE.relative_to(ROOT)}: {len(text.splitlines())} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
