"""Draw every profile: stills of cam, mechanism, section and results, a page that shows them, and the README pictures.

    python scripts/gallery.py                   # exports/gallery/index.html
    python scripts/gallery.py NAME ...          # these profiles alone
    python scripts/gallery.py --readme          # docs/pin_insertion.png and docs/gallery.png too

Needs an OpenGL library (Debian: libegl1 libgl1-mesa-dri).
"""

from __future__ import annotations

import argparse
import sys
from html import escape
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
DOCS = ROOT / "docs"
HERO = ("pin_insertion", ("mechanism", "pressure"))
SHOWN = (
    *("disc_offset_roller", "disc_face_groove", "constant_width_press", "conjugate_rocker"),
    *("feeder_runout", "tool_changer", "barrel_indexer", "parallel_index"),
)
"""profiles on the second README picture"""
TILE = (320, 240)
COLOURS = 128


def main() -> int:
    """Draw what is asked for and say where it is."""
    from camgeom.errors import CamgeomError

    parser = argparse.ArgumentParser(description="Pictures of every profile.")
    parser.add_argument("profile", nargs="*", help="names in profiles/; all by default")
    parser.add_argument("--out", type=Path, default=ROOT / "exports" / "gallery", help="folder of the pictures")
    parser.add_argument("--size", type=int, default=1200, help="width of a picture, px")
    parser.add_argument("--readme", action="store_true", help="make the README pictures from them")
    given = parser.parse_args()
    names = given.profile or sorted(path.stem for path in (ROOT / "profiles").glob("*.toml"))
    failed = 0
    for name in names:
        try:
            paths = draw(name, given.out, (given.size, given.size * 3 // 4))
            print(f"{name}: {', '.join(path.stem.removeprefix(name + '-') for path in paths)}")
        except CamgeomError as error:
            failed += 1
            print(f"{name}: {error}", file=sys.stderr)
    (given.out / "index.html").write_text(page(given.out), encoding="utf-8")
    print(given.out / "index.html")
    if given.readme and not failed:
        for path in (hero(given.out), tiles(given.out)):
            print(f"{path.relative_to(ROOT)}: {path.stat().st_size} bytes")
    return int(failed > 0)


def draw(name: str, folder: Path, size: tuple[int, int]) -> list[Path]:
    """The stills of one profile."""
    from camgeom.model import read
    from camgeom.report.pictures import write_pictures

    folder.mkdir(parents=True, exist_ok=True)
    return write_pictures(read(str(ROOT / "profiles" / f"{name}.toml")), folder, name, size)


def page(folder: Path) -> str:
    """A page of all pictures in the folder, by profile."""
    found: dict[str, list[str]] = {}
    for name in sorted(path.stem for path in (ROOT / "profiles").glob("*.toml")):
        found[name] = sorted(path.name for path in folder.glob(f"{name}-*.png"))
    parts = []
    for name, files in found.items():
        pictures = "".join(
            f'<figure><img src="{escape(file)}" alt=""><figcaption>{escape(file[len(name) + 1 : -4])}</figcaption>'
            "</figure>"
            for file in files
        )
        parts.append(f"<h2>{escape(name)}</h2><div>{pictures}</div>" if files else "")
    style = (
        "body{font:16px system-ui,sans-serif;margin:2rem}div{display:flex;flex-wrap:wrap;gap:1rem}"
        "figure{margin:0;width:min(360px,100%)}img{width:100%}"
    )
    return (
        f'<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>Gallery</title><style>{style}</style>'
        f"<h1>Gallery</h1>{''.join(parts)}</html>\n"
    )


def hero(folder: Path) -> Path:
    """The first README picture: mechanism and result of one profile side by side."""
    from PIL import Image

    name, shown = HERO
    cuts = [trimmed(Image.open(folder / f"{name}-{what}.png").convert("RGB")) for what in shown]
    height = 560
    cuts = [one.resize((round(one.width * height / one.height), height), Image.Resampling.LANCZOS) for one in cuts]
    whole = Image.new("RGB", (sum(one.width for one in cuts) + 40, height), "white")
    whole.paste(cuts[0], (0, 0))
    whole.paste(cuts[1], (cuts[0].width + 40, 0))
    whole.save(DOCS / "pin_insertion.png", optimize=True)  # a palette would make bands of the result colours
    return DOCS / "pin_insertion.png"


def trimmed(picture: Any) -> Any:
    """The picture without its white border."""
    from PIL import ImageChops

    white = ImageChops.invert(picture.convert("L")).point([0 if level < 8 else 255 for level in range(256)])
    return picture.crop(white.getbbox())


def tiles(folder: Path) -> Path:
    """The second README picture: mechanisms of several profiles in rows of four."""
    from PIL import Image

    whole = Image.new("RGB", (4 * TILE[0], -(-len(SHOWN) // 4) * TILE[1]), "white")
    for number, name in enumerate(SHOWN):
        one = Image.open(folder / f"{name}-mechanism.png").convert("RGB").resize(TILE, Image.Resampling.LANCZOS)
        whole.paste(one, (number % 4 * TILE[0], number // 4 * TILE[1]))
    path = DOCS / "gallery.png"
    whole.quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)
    return path


if __name__ == "__main__":
    sys.exit(main())
