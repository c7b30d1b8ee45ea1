"""`python -m camgeom` is the `camgeom` command."""

from camgeom.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
