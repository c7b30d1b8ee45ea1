"""`python -m camgeom` and the `camgeom` command: the command line in a process of its own."""

import gc

from camgeom.cli import main


def run() -> int:
    """Run the command line. A command makes classes and arrays and ends: looking for cycles every 700 objects, as is
    the default, takes 4 to 8 % of its time."""
    gc.set_threshold(50_000, 20, 20)
    return main()


if __name__ == "__main__":
    raise SystemExit(run())
