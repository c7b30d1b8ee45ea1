"""The mechanism turning, as GIF by Pillow, as MP4 or WebM where an encoder is present."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from camgeom.errors import ExportError
from camgeom.export.files import atomic_write
from camgeom.report.pictures import moving_bodies, seen_from
from camgeom.report.sections.bodies import cam_meshes
from camgeom.report.views import View, stage
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.model import Model

MOVIES = ("gif", "mp4", "webm")
FRAMES, SECONDS = 45, 6.0
"""pictures of one turn of the cam in a GIF (films have twice as many), and how long it is shown"""
COLOURS = 96
"""of a GIF: steel, orange and sand in some shades each"""
_CODECS = {
    "mp4": (("libx264", ("-crf", "20", "-preset", "medium")), ("mpeg4", ("-q:v", "4"))),
    "webm": (("libvpx-vp9", ("-crf", "32", "-b:v", "0", "-row-mt", "1")), ("libvpx", ("-crf", "16", "-b:v", "2M"))),
}
"""codecs of a kind with their settings, the better first"""
Pixels = npt.NDArray[np.uint8]


def write_movies(
    model: Model, folder: Path, stem: str, kinds: tuple[str, ...], size: tuple[int, int] = (640, 480)
) -> list[Path]:
    """Draw one turn of the mechanism into <stem>-turning.<kind> for every kind of MOVIES and give the paths.

    Raises ExportError before anything is drawn where no OpenGL library works here or a kind has no encoder, and where
    a file cannot be written; DesignError where the cam is undercut.
    """
    encoder = find_encoder(tuple(kind for kind in kinds if kind != "gif"))
    pictures = list(frames(model, size, FRAMES if encoder is None else 2 * FRAMES))
    paths = []
    for kind in kinds:
        path = folder / f"{stem}-turning.{kind}"
        if kind == "gif":
            write_gif(pictures[:: len(pictures) // FRAMES], path, SECONDS)
        elif encoder is not None:
            encoder.write(pictures, path, kind, len(pictures) / SECONDS)
        paths.append(path)
    return paths


def frames(model: Model, size: tuple[int, int], count: int) -> Iterator[Pixels]:
    """Pictures (h, w, 3) of cam and follower over one turn; the last is a step before the first."""
    cams = cam_meshes(model)
    phi = TURN * np.arange(count) / count
    moving = moving_bodies(model, cams, phi)
    view = View(camera=seen_from(cams), size=size, soft=False)
    with stage([body for body, _ in moving], view, _reach(moving)) as scene:
        for k in range(count):
            for body, motion in moving:
                scene.place(body.name, motion[k])
            yield scene.image().astype(np.uint8)


def _reach(moving: list[Any]) -> npt.NDArray[np.float64]:
    """Points (n, 3) of every body all round the turn: what the picture has to hold."""
    found = []
    for body, motion in moving:
        points = body.mesh.vertices[:: max(1, len(body.mesh.vertices) // 4000)]
        found += [points @ pose[:, :3].T + pose[:, 3] for pose in motion[:: max(1, len(motion) // 36)]]
    return np.concatenate(found)


def write_gif(pictures: list[Pixels], path: Path, seconds: float) -> None:
    """An endless GIF; all pictures share one palette, so that nothing flickers and equal pixels cost nothing."""
    from PIL import Image

    some = np.vstack(pictures[:: max(1, len(pictures) // 4)])
    palette = Image.fromarray(some).quantize(COLOURS, Image.Quantize.MEDIANCUT)
    flat = [Image.fromarray(one).quantize(palette=palette, dither=Image.Dither.NONE) for one in pictures]
    # A GIF counts time in hundredths of a second.
    step = max(20, round(1000.0 * seconds / len(flat) / 10.0) * 10)
    with atomic_write(path) as stream:
        flat[0].save(stream, format="gif", save_all=True, append_images=flat[1:], duration=step, loop=0, optimize=True)


@dataclass(frozen=True)
class Encoder:
    """An ffmpeg program and the codecs it has."""

    program: str
    codecs: frozenset[str]

    def choice(self, kind: str) -> tuple[str, tuple[str, ...]] | None:
        """The best codec for a kind with its settings; None where there is none."""
        return next((entry for entry in _CODECS[kind] if entry[0] in self.codecs), None)

    def write(self, pictures: list[Pixels], path: Path, kind: str, rate: float) -> None:
        """Encode pictures (h, w, 3), even in width and height. Raises ExportError with the encoder's own words."""
        entry = self.choice(kind)
        assert entry is not None
        height, width = pictures[0].shape[:2]
        with TemporaryDirectory(prefix="camgeom-") as place:
            made = Path(place) / f"turning.{kind}"
            words = [self.program, "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s"]
            words += [f"{width}x{height}", "-r", f"{rate:g}", "-i", "-", "-an", "-c:v", entry[0], *entry[1]]
            words += ["-pix_fmt", "yuv420p", *(("-movflags", "+faststart") if kind == "mp4" else ()), str(made)]
            done = subprocess.run(words, input=b"".join(one.tobytes() for one in pictures), capture_output=True)
            if done.returncode or not made.exists():
                reason = " ".join(done.stderr.decode(errors="replace").split())[-200:]
                raise ExportError(f"{path}: the encoder failed: {reason or f'exit status {done.returncode}'}")
            with atomic_write(path) as stream:
                stream.write(made.read_bytes())


def find_encoder(kinds: tuple[str, ...]) -> Encoder | None:
    """ffmpeg for the kinds, on the path or from imageio-ffmpeg; None where no kind is asked for.

    Raises ExportError that says how to get one.
    """
    if not kinds:
        return None
    program = shutil.which("ffmpeg") or _bundled()
    if program is None:
        raise ExportError(
            f"no {' or '.join(kinds)} can be made: there is no ffmpeg; pip install imageio-ffmpeg, or install ffmpeg "
            "from your system; a GIF needs none"
        )
    encoder = Encoder(program, _codecs(program))
    lacking = [kind for kind in kinds if encoder.choice(kind) is None]
    if lacking:
        wanted = " or ".join(name for name, _ in _CODECS[lacking[0]])
        raise ExportError(f"no {lacking[0]} can be made: {program} has no {wanted}; pip install imageio-ffmpeg")
    return encoder


def _bundled() -> str | None:
    try:
        import imageio_ffmpeg
    except ImportError:
        return None
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:
        return None


def _codecs(program: str) -> frozenset[str]:
    try:
        done = subprocess.run([program, "-hide_banner", "-encoders"], capture_output=True, text=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ExportError(f"{program}: does not run: {error}") from error
    return frozenset(words[1] for line in done.stdout.splitlines() if len(words := line.split()) > 1)
