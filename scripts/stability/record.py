"""What every profile and starter gives, recorded and compared, so that a change of the house is seen to change nothing.

    record.py make DIR [NAME ...]      of every profile and starter (or those named): result.json, the text of check and
                                       solve with their exit status, every export and the report; and the text of the
                                       commands that need no profile
    record.py compare OLD NEW [--rel]  files that are not equal byte by byte, with the largest relative difference of
                                       their numbers; exit status 1 where one exceeds --rel or other text differs

Times, costs, progress, dates, random identifiers and the digests of files that hold such are taken out before a file is
kept. Relative differences are taken against the larger of the two numbers, or a thousandth of the largest on the same
line (a coordinate near zero).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = (["laws"], ["laws", "--json"], ["schema"], ["formats"], ["formats", "--json"])
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
VOLATILE = (
    (re.compile(r'("cost_s": \{)[^}]*\}'), r"\1}"),
    (re.compile(r"^((?:  )?\"explain\": \[)[^\]]*\]", re.M), r"\1]"),
    (re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[-+]\d\d:?\d\d)?"), "TIME"),
    (re.compile(r"D:\d{14}[^)]*"), "TIME"),
    (re.compile(r"^camgeom: +[\d.]+ s .*\n", re.M), ""),
    (re.compile(r'("file": "(?:report\.html|result\.json)",[^}]*"bytes": )\d+(,\s*"sha256": ")\w+'), r"\1N\2SUM"),
)
EXPORT = """
import json, sys
from pathlib import Path
import camgeom
profile, folder, extensions = sys.argv[1], Path(sys.argv[2]), sys.argv[3:]
model, refused = camgeom.read(profile), {}
for extension in extensions:
    try:
        camgeom.write(model, folder / f"cam.{extension}")
    except camgeom.CamgeomError as error:
        refused[extension] = str(error).replace(str(folder), "DIR")
(folder / "refused.json").write_text(json.dumps(refused, indent=1))
"""


def call(*words: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Python of this environment on the checkout that stands in RECORD_ROOT (this one by default)."""
    root = os.environ.get("RECORD_ROOT", str(ROOT))
    steady = {"PYTHONPATH": root, "COLUMNS": "120", "PYTHONWARNINGS": "ignore", "PYTHONHASHSEED": "0"}
    environment = {**os.environ, **steady}
    command = [sys.executable, *words]
    return subprocess.run(command, cwd=cwd or root, env=environment, capture_output=True, text=True, check=False)



def plain(text: str) -> str:
    """A text without what differs from run to run."""
    for pattern, instead in VOLATILE:
        text = pattern.sub(instead, text)
    return text


def make_one(name: str, profile: Path, folder: Path, extensions: list[str]) -> str:
    """Record one profile in folder/name; gives a line for the screen."""
    place = folder / name
    place.mkdir(parents=True, exist_ok=True)
    for command in ("check", "solve"):
        ran = call("-m", "camgeom", command, str(profile), "--json")
        (place / f"{command}.json").write_text(plain(ran.stdout))
        ran = call("-m", "camgeom", command, str(profile))
        (place / f"{command}.txt").write_text(plain(f"{ran.stdout}--\n{ran.stderr}-- {ran.returncode}\n"))
    ran = call("-m", "camgeom", "run", str(profile), "--out", str(place), "--formats", "stl")
    text = plain(f"{ran.stdout}--\n{ran.stderr}-- {ran.returncode}\n")
    (place / "run.txt").write_text(re.sub(r"[\d.]+ s\b", "TIME", text.replace(str(place), "DIR")))
    for result in (place / "result.json", place / "manifest.json"):
        if result.exists():
            result.write_text(plain(result.read_text().replace(str(place), "DIR")))
    report = place / "report.html"
    if report.exists():
        page = report.read_text()
        # The table of costs, and the size of the packed 3D buffers, differ from run to run and machine to machine.
        page = re.sub(r'(<section[^>]*id="cost".*?</section>)', "COST", page, flags=re.S)
        report.write_text(plain(re.sub(r">\s*<", ">\n<", page)))
    ran = call("-c", EXPORT, str(profile), str(place), *extensions)
    (place / "export.txt").write_text(plain(ran.stderr.replace(str(place), "DIR")))
    for file in place.glob("cam.*"):
        if file.suffix in (".dxf", ".step", ".stp", ".xml", ".gcode", ".apt", ".pdf", ".svg"):
            file.write_bytes(steady(file))
    return f"{name}: {sum(1 for _ in place.iterdir())} files"


def steady(file: Path) -> bytes:
    """A file's bytes without dates and random identifiers."""
    text = file.read_bytes().decode("latin-1")
    if file.suffix == ".dxf":
        text = re.sub(r"(\$(?:TD|TU|VERSIONGUID|FINGERPRINTGUID)\w*\s*\r?\n\s*\d+\r?\n)[^\r\n]*", r"\1X", text)
        text = re.sub(r"\{[0-9A-F-]{36}\}", "{ID}", text)
        text = re.sub(r"\d+\.\d+\.\d+ @ \S+", "WRITER", text)
    return plain(text).encode("latin-1")


def make(folder: Path, names: list[str]) -> int:
    """Record all profiles and starters, two at a time."""
    folder.mkdir(parents=True, exist_ok=True)
    root = Path(os.environ.get("RECORD_ROOT", str(ROOT)))
    listed = json.loads(call("-m", "camgeom", "formats", "--json").stdout)
    rows = listed["formats"] if isinstance(listed, dict) else listed
    pictures = {"png", "gif", "mp4", "webm", "pdf"}
    extensions = [row["format"] for row in rows if row["format"] not in pictures]
    kinds = json.loads(call("-c", "import json; from camgeom.cams import kinds; print(json.dumps(kinds()))").stdout)
    profiles = {path.stem: path for path in sorted((root / "profiles").glob("*.toml"))}
    starters = folder / "starters"
    starters.mkdir(exist_ok=True)
    for kind in kinds:
        path = starters / f"{kind}.toml"
        path.write_text(call("-m", "camgeom", "new", kind).stdout)
        profiles[f"starter-{kind}"] = path
    if not names:
        for command in COMMANDS:
            (folder / f"{'-'.join(command).replace('---', '-')}.txt").write_text(call("-m", "camgeom", *command).stdout)
    wanted = {name: path for name, path in profiles.items() if not names or name in names}
    with ThreadPoolExecutor(max_workers=2) as pool:
        for line in pool.map(lambda item: make_one(item[0], item[1], folder, extensions), wanted.items()):
            print(line, flush=True)
    return 0


def difference(old: bytes, new: bytes, name: str) -> float | str:
    """Largest relative difference of two files' numbers; a reason where more than numbers differ."""
    if name.endswith(".3mf"):
        return _zipped(old, new)
    if name.endswith((".glb", ".npz", ".ply", ".vtu", ".stl")):
        if len(old) != len(new):
            return f"{len(old)} and {len(new)} bytes"
        if name.endswith(".stl"):
            first, second = (_stl(data) for data in (old, new))
            return float(np.max(np.abs(first - second)) / np.max(np.abs(first)))
        return "binary content differs"
    try:
        before, after = old.decode(), new.decode()
    except UnicodeDecodeError:
        return "binary content differs"
    lines = before.split("\n"), after.split("\n")
    if len(lines[0]) != len(lines[1]):
        return f"{len(lines[0])} and {len(lines[1])} lines"
    worst = 0.0
    for a, b in zip(*lines):
        if a == b:
            continue
        if NUMBER.sub("#", a) != NUMBER.sub("#", b):
            return f"text: {a.strip()[:90]!r} -> {b.strip()[:90]!r}"
        x, y = (np.array([float(word) for word in NUMBER.findall(text)]) for text in (a, b))
        scale = np.maximum(np.maximum(np.abs(x), np.abs(y)), 1e-3 * np.max(np.abs(x), initial=0.0))
        worst = max(worst, float(np.max(np.abs(x - y) / np.where(scale > 0.0, scale, 1.0), initial=0.0)))
    return worst


def _stl(data: bytes) -> np.ndarray:
    kind = np.dtype([("numbers", "<f4", 12), ("end", "<u2")])
    return np.frombuffer(data[84:], kind)["numbers"].astype(float)


def _zipped(old: bytes, new: bytes) -> float | str:
    import io

    first, second = (zipfile.ZipFile(io.BytesIO(data)) for data in (old, new))
    if first.namelist() != second.namelist():
        return "other members"
    worst = 0.0
    for member in first.namelist():
        found = difference(first.read(member), second.read(member), member.removesuffix(".3mf"))
        if isinstance(found, str):
            return found
        worst = max(worst, found)
    return worst


def compare(old: Path, new: Path, rel: float) -> int:
    """Print every file that differs; 1 where one differs by more than `rel`."""
    first, second = ({str(p.relative_to(d)): p for p in d.rglob("*") if p.is_file()} for d in (old, new))
    bad = equal = close = 0
    for name in sorted(first | second):
        if name not in first or name not in second:
            print(f"{name}: only in {old if name in first else new}")
            bad += 1
            continue
        a, b = first[name].read_bytes(), second[name].read_bytes()
        if a == b:
            equal += 1
            continue
        found = difference(a, b, name)
        within = not isinstance(found, str) and found <= rel
        close, bad = close + within, bad + (not within)
        print(f"{name}: {found if isinstance(found, str) else f'relative {found:.3g}'}{'' if within else '  <--'}")
    print(f"{equal} equal, {close} within {rel:g}, {bad} different")
    return int(bad > 0)


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    sub = parser.add_subparsers(dest="command", required=True)
    one = sub.add_parser("make")
    one.add_argument("folder", type=Path)
    one.add_argument("names", nargs="*")
    two = sub.add_parser("compare")
    two.add_argument("old", type=Path)
    two.add_argument("new", type=Path)
    two.add_argument("--rel", type=float, default=1e-12)
    given = parser.parse_args()
    if given.command == "make":
        return make(given.folder.resolve(), given.names)
    return compare(given.old, given.new, given.rel)


if __name__ == "__main__":
    sys.exit(main())
