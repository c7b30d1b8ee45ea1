"""The mechanism turning, as GIF by Pillow, as MP4 or WebM where an encoder is present."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from camgeom.errors import ExportError
from camgeom.export.files import atomic_write, write_whole
from camgeom.immutable import immutable
from camgeom.maths.frozen import cached_property
from camgeom.report.painter import stage
from camgeom.report.pictures import moving_bodies, on_edge, seen_from
from camgeom.report.sections.bodies import cam_meshes
from camgeom.report.views import View
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


class Films:
    """One turn of a mechanism as films of some kinds of MOVIES; its pictures are drawn once, for the first of them."""

    def __init__(self, model: Model, kinds: tuple[str, ...], size: tuple[int, int] = (640, 480)) -> None:
        self._model, self._size = model, size
        self._encoders: dict[str, Encoder | ExportError] = {}
        for kind in kinds:
            if kind != "gif":
                try:
                    self._encoders[kind] = find_encoder(kind)
                except ExportError as error:
                    self._encoders[kind] = error

    @cached_property
    def pictures(self) -> list[Pixels]:
        """Pictures (h, w, 3); a GIF alone needs fewer."""
        finer = any(isinstance(encoder, Encoder) for encoder in self._encoders.values())
        return list(frames(self._model, self._size, 2 * FRAMES if finer else FRAMES))

    def write(self, kind: str, path: Path) -> None:
        """Write a film of a kind.

        Raises ExportError before anything is drawn where the kind has no encoder, where no OpenGL library works here,
        and where the file cannot be written; DesignError where the cam is undercut.
        """
        encoder = self._encoders.get(kind)
        if isinstance(encoder, ExportError):
            raise encoder
        if encoder is None:
            write_gif(self.pictures[:: len(self.pictures) // FRAMES], path, SECONDS)
        else:
            encoder.write(self.pictures, path, kind, len(self.pictures) / SECONDS)


def frames(model: Model, size: tuple[int, int], count: int) -> Iterator[Pixels]:
    """Pictures (h, w, 3) of cam and follower over one turn; the last is a step before the first."""
    cams = cam_meshes(model)
    phi = TURN * np.arange(count) / count
    moving = moving_bodies(model, cams, phi)
    view = View(camera=seen_from(cams, model.mechanism.inside, on_edge(model)), size=size, soft=False)
    with stage([body for body, _ in moving], view, _reach(moving)) as scene:
        for k in range(count):
            for body, motion in moving:
                scene.place(body.name, motion[k])
            yield scene.image()


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


@immutable(eq=True)
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
            write_whole(path, made.read_bytes())


def find_encoder(kind: str) -> Encoder:
    """ffmpeg for a kind of film, on the path or from imageio-ffmpeg. Raises ExportError that says how to get one."""
    program = shutil.which("ffmpeg") or _bundled()
    if program is None:
        raise ExportError(
            "there is no ffmpeg; pip install imageio-ffmpeg, or install ffmpeg "
            "from your system; a GIF needs none"
        )
    encoder = Encoder(program, _codecs(program))
    if encoder.choice(kind) is None:
        wanted = " or ".join(name for name, _ in _CODECS[kind])
        raise ExportError(f"{program} has no {wanted}; pip install imageio-ffmpeg")
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
