"""The fuzz campaign of the reader: hostile bytes, structure, values, CSV tables and formulas, from printed seeds.

    scripts/fuzz --count 40000 --first 0

Every input must end within LIMIT seconds as a profile (whose setup can be made) or as a ProfileError of one readable
message: no other exception, no warning, no message of the validator. Exit status 1 where one does not.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import random
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from camgeom.cams import kinds, starter  # noqa: E402
from camgeom.errors import CamgeomError, ProfileError  # noqa: E402
from camgeom.mechanics.applied import FUNCTIONS, VARIABLES, compile_expression  # noqa: E402
from camgeom.profile import from_data, parse, read  # noqa: E402
from camgeom.profile.text import load  # noqa: E402

LIMIT = 10
"""s that one input may take"""
TOKENS = [
    *FUNCTIONS, *VARIABLES, "pi", "e", "+", "-", "*", "/", "**", "(", ")", ",", "1", "0", "1e308", "9" * 40, "import",
    "__class__", ".", "lambda", ":", "[", "]", "'a'", "if", "else", "**32", "**33", "~", "@", "\n", "\x00", "é",
]  # fmt: skip
NUMBERS: list[Any] = [
    0, -0.0, 1, -1, 1e-300, 5e-324, 1e300, 1e308, -1e308, 2**63, -(2**63), 1e-9, 360, 359.9999999999, 1e5, 1e9, 1e-6,
    1e-7, 0.5, True, "1", (), {},
]  # fmt: skip
PIECES = (b"[", b"]", b"=", b'"', b"\n", b"#", b".", b"{", b"-", b"e9", b"\xff", b"\x00")
NAMES = ("t.csv", "t.csv", "t.csv", "../t.csv", "/dev/zero", "a/../../t.csv", "~/t.csv", "", "t\x00.csv", ".")
JUNK = ("nan, 1", "1", "1,2,3", "inf,0", "1e400,0", "x,y", "#", "0, 1e308", "-1, 2", "9" * 5000)
PROFILES = [path.read_text() for path in sorted((ROOT / "profiles").glob("*.toml"))]
SOURCES = PROFILES + [starter(kind) for kind in kinds()]
KINDS = ("bytes", "lines", "values", "structure", "table", "formula")


def fuzz(seed: int) -> tuple[int, str, str, str]:
    """Seed, kind, outcome ("profile", "refused" or "FAILURE") and the reason of a failure."""
    dice, kind = random.Random(seed), KINDS[seed % len(KINDS)]
    signal.signal(signal.SIGALRM, _late)
    signal.alarm(LIMIT)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            outcome = globals()[f"_{kind}"](dice)
    except ProfileError as error:
        text = str(error)
        plain = text and "Input should" not in text and "Traceback" not in text and len(text) < 200_000
        outcome, why = ("refused", "") if plain else ("FAILURE", f"message: {text[:200]!r}")
        return seed, kind, outcome, why
    except CamgeomError as error:
        return seed, kind, "FAILURE", f"{type(error).__name__}: {error}"
    except Exception as error:
        return seed, kind, "FAILURE", f"{type(error).__name__}: {str(error)[:300]}"
    finally:
        signal.alarm(0)
    return seed, kind, outcome, ""


def _late(*_: Any) -> None:
    raise TimeoutError(f"more than {LIMIT} s")


def _made(text: str) -> str:
    parse(text, "fuzz.toml").setup()
    return "profile"


def _bytes(dice: random.Random) -> str:
    """A profile file with bytes changed, cut out, repeated or made up."""
    content = bytearray(dice.choice(SOURCES).encode())
    for _ in range(dice.randint(1, 8)):
        at, much = dice.randrange(len(content) or 1), dice.choice((1, 1, 2, 8, 64))
        how = dice.randrange(4)
        if how == 0:
            content[at : at + much] = dice.randbytes(much)
        elif how == 1:
            del content[at : at + much]
        elif how == 2:
            content[at:at] = content[at : at + much] * dice.choice((1, 2, 50))
        else:
            content[at : at + 1] = dice.choice(PIECES)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "p.toml"
        path.write_bytes(content)
        read(path).setup()
    return "profile"


def _lines(dice: random.Random) -> str:
    """A profile with whole lines shuffled, dropped, doubled, or taken from another one."""
    lines = dice.choice(SOURCES).splitlines()
    for _ in range(dice.randint(1, 6)):
        at = dice.randrange(len(lines) or 1)
        how = dice.randrange(4)
        if how == 0 and lines:
            del lines[at]
        elif how == 1 and lines:
            lines.insert(dice.randrange(len(lines)), lines[at])
        elif how == 2:
            lines.insert(at, dice.choice(dice.choice(SOURCES).splitlines()))
        else:
            lines[at:at] = [f"[{'a.' * dice.choice((1, 5, 40, 3000))}b]", "x = " + "[" * dice.choice((1, 11, 13, 5000))]
    return _made("\n".join(lines))


def _places(data: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, tuple) else ()
    return [at] * bool(at) + [place for key, value in items for place in _places(value, (*at, key))]


def _put(data: Any, path: tuple[Any, ...], value: Any) -> Any:
    if not path:
        return value
    if isinstance(data, tuple):
        return tuple(_put(item, path[1:], value) if i == path[0] else item for i, item in enumerate(data))
    return {**data, path[0]: _put(data.get(path[0], {}), path[1:], value)} if isinstance(data, dict) else data


def _values(dice: random.Random) -> str:
    """Numbers of a good profile made extreme."""
    data: Any = load(dice.choice(SOURCES), "")[0]
    numbers = [p for p in _places(data) if isinstance(_at(data, p), int | float)]
    for _ in range(dice.randint(1, 4)):
        path = dice.choice(numbers)
        old = _at(data, path)
        if not isinstance(old, int | float):  # what an earlier change put there
            continue
        new = dice.choice(NUMBERS) if dice.random() < 0.5 else old * 10.0 ** dice.uniform(-12.0, 12.0)
        whole = isinstance(old, int) and isinstance(new, float) and abs(new) < 1e15
        data = _put(data, path, int(new) if whole else new)
    from_data(data, "fuzz.toml").setup()
    return "profile"


def _at(data: Any, path: tuple[Any, ...]) -> Any:
    for part in path:
        data = data[part] if isinstance(data, dict | tuple) else None
    return data


def _structure(dice: random.Random) -> str:
    """Values of a profile replaced by other parts of profiles, of the wrong type as often as not."""
    data: Any = load(dice.choice(SOURCES), "")[0]
    other: Any = load(dice.choice(SOURCES), "")[0]
    for _ in range(dice.randint(1, 3)):
        path, new = dice.choice(_places(data)), _at(other, dice.choice(_places(other)))
        for _ in range(dice.choice((0, 0, 1, 3, 20))):
            new = dice.choice(((new,), {"a": new}, (new, new)))
        data = _put(data, path, new)
    from_data(data if isinstance(data, dict) else {}, "fuzz.toml").setup()
    return "profile"


def _table(dice: random.Random) -> str:
    """CSV files of a force or a measured law: rows out of order, wrong width, huge, binary, links, pipes, devices."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder) / "home"
        home.mkdir()
        name = dice.choice(NAMES)
        target = home / "t.csv"
        how = dice.randrange(8)
        if how == 0:
            target.write_bytes(dice.randbytes(dice.choice((0, 10, 4000))))
        elif how == 1:
            os.mkfifo(target)
        elif how == 2:
            target.symlink_to(dice.choice(("/dev/zero", "/etc/passwd", "t.csv", "../none", "/proc/self/mem")))
        elif how == 3:
            target.mkdir()
        else:
            rows = sorted(dice.uniform(0.0, 360.0) for _ in range(dice.choice((0, 1, 2, 5, 50))))
            text = [f"{x!r}, {dice.uniform(-5, 5)!r}" for x in rows]
            for _ in range(dice.randint(0, 3)):
                text.insert(dice.randrange(len(text) + 1), dice.choice(JUNK))
            target.write_text("\n".join(text))
        base = SOURCES[0] if dice.random() < 0.2 else STARTERS
        spelled = name.replace("\x00", "\\u0000")
        law = f'[[motion]]\nuntil = 180\nto = 10\nlaw = "table"\nfile = "{spelled}"\n'
        law += '[[motion]]\nuntil = 360\nto = 0\nlaw = "3-4-5"\n'
        force = f'[operation]\nspeed = 60\n[[operation.force]]\nfrom = 0\nuntil = 360\nfile = "{spelled}"\n'
        path = home / "p.toml"
        path.write_text(base + (law if dice.random() < 0.5 else MOTION + force))
        read(path).setup()
    return "profile"


STARTERS = """[cam]
kind = "disc"
base_radius = 30
width = 10
[follower]
kind = "translating"
[roller]
diameter = 10
length = 8
"""
MOTION = '[[motion]]\nuntil = 180\nto = 10\nlaw = "3-4-5"\n[[motion]]\nuntil = 360\nto = 0\nlaw = "3-4-5"\n'


def _formula(dice: random.Random) -> str:
    """A force expression of random tokens; where it is accepted it is computed on 1 000 angles."""
    text = dice.choice(("", " ")).join(dice.choice(TOKENS) for _ in range(dice.choice((1, 3, 5, 9, 30, 200))))
    if dice.random() < 0.3:
        text = "(" * dice.choice((3, 50, 400)) + text
    phi = np.linspace(0.0, 6.0, 1000)
    found = compile_expression(text)(phi, phi, phi, phi)
    return "profile" if np.isfinite(found).all() else "NaN"


def main() -> int:
    """Run the campaign; exit status 1 where an input ends otherwise."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=40_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    print(f"seeds {args.first} .. {args.first + args.count - 1}")
    began, counts, failed = time.perf_counter(), Counter[tuple[str, str]](), 0
    with multiprocessing.get_context("forkserver").Pool(args.jobs) as pool:
        for seed, kind, outcome, why in pool.imap_unordered(fuzz, range(args.first, args.first + args.count), 50):
            counts[kind, outcome] += 1
            if outcome == "FAILURE":
                failed += 1
                print(f"seed {seed} ({kind}): {why}", flush=True)
    print(f"{'kind':<12}{'profile':>9}{'refused':>9}{'FAILURE':>9}")
    for kind in KINDS:
        print(f"{kind:<12}" + "".join(f"{counts[kind, o]:>9}" for o in ("profile", "refused", "FAILURE")))
    print(f"{time.perf_counter() - began:.0f} s")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
