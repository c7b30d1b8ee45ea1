"""Everything a profile asks for, where there is no bash: python scripts/run.py [PROFILE] [camgeom run options].

Makes .venv with camgeom in it the first time (any Python from 3.11 on; Windows, macOS, Linux), later goes straight on.
Pictures need an OpenGL; on Linux without one scripts/run installs it, or tells how.
"""

from __future__ import annotations

import subprocess
import sys
from hashlib import sha256
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
PYTHON = VENV / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
STAMP = VENV / ".stamp-run-py"


def main() -> int:
    """Set up where that was not done, then run; the exit status is that of camgeom."""
    if sys.version_info < (3, 11):  # noqa: UP036  (any Python may run this file)
        print(f"camgeom set-up: needs Python 3.11 or newer (this is {sys.version.split()[0]})", file=sys.stderr)
        return 2
    made_from = sha256((ROOT / "pyproject.toml").read_bytes() + str(ROOT).encode()).hexdigest()
    if not PYTHON.is_file() or not STAMP.is_file() or STAMP.read_text() != made_from:
        print("camgeom set-up: installing camgeom into .venv (once; a minute or two)", file=sys.stderr)
        steps = [[str(PYTHON), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-e", f"{ROOT}[full]"]]
        if not PYTHON.is_file():
            steps.insert(0, [sys.executable, "-m", "venv", str(VENV)])
        for step in steps:
            if subprocess.run(step, check=False).returncode:
                print(f"camgeom set-up: this failed: {' '.join(step)}", file=sys.stderr)
                return 2
        STAMP.write_text(made_from)
    words = sys.argv[1:]
    if not words or words[0].startswith("-"):
        words = [str(ROOT / "profiles" / "pin_insertion.toml"), *words]
    return subprocess.run([str(PYTHON), "-m", "camgeom", "run", *words], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
