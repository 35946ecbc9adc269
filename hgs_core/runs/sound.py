"""The sound of a run's scene: of its capture, of a file, or of the scene before."""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator, Mapping
from pathlib import Path

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.sound.sound_pieces import CutSound, cut_sound
from hgs_core.capture.sound.sound_track import has_sound, sound_begin
from hgs_core.codec.format.audio import AudioEntry, AudioPiece, CodedAudio
from hgs_core.codec.format.scene_folder import CHUNKS, MANIFEST, chunk_id, load_manifest, read_audio, stored_sizes
from hgs_core.runs.run_folder import RunFolder, RunSpec
from hgs_core.runs.sound_choice import CAMERA_SOUND, NO_SOUND, OWN_SOUND, camera_of_sound

__all__ = ["replace_sound", "require_sound_file", "require_sounding_video", "scene_sound", "write_sound"]

log = logging.getLogger(__name__)


def require_sound_file(audio: str) -> str:
    """Return the request of `--audio`, a file by its absolute path.

    Raises:
        InputError: there is no such file, or it has no sound.
    """
    if audio in (OWN_SOUND, NO_SOUND) or camera_of_sound(audio) is not None:
        return audio
    file = Path(audio)
    cure = f"give a file with sound, {CAMERA_SOUND}NAME, {OWN_SOUND} or {NO_SOUND}"
    if not file.is_file():
        raise _refused(audio, "there is no such file", cure)
    if not has_sound(file):
        raise _refused(audio, "the file has no sound", cure)
    return str(file.resolve())


def require_sounding_video(audio: str, videos: Mapping[str, Path | None]) -> None:
    """Refuse a camera's sound that is not among the `videos`, by the cameras' names.

    Raises:
        InputError: there is no such camera, or it has pictures instead of a video, or its video has no sound.
    """
    name = camera_of_sound(audio)
    if name is None:
        return
    if name not in videos:
        raise _refused(audio, "there is no such camera", f"its cameras are {', '.join(videos)}")
    video = videos[name]
    if video is None or not has_sound(video):
        raise _refused(audio, "its camera has no video with sound", "give another one, or a file")


def scene_sound(
    folder: RunFolder, spec: RunSpec, capture: Capture | None, start: float, end: float
) -> CodedAudio | None:
    """Return the sound that a run's scene is to have from `start` to `end`, seconds of its clock.

    A run without a capture keeps what its scene has.

    Raises:
        InputError: the file or the camera's video that the run was given is gone or damaged; a capture's own sound that
            is damaged is left out, and a line says so.
    """
    if spec.given.audio == NO_SOUND:
        return None
    if (name := camera_of_sound(spec.given.audio)) is not None:
        path, offset = _video_of(name, capture)
        return _coded(cut_sound(path, start, end, offset), path)
    if spec.given.audio != OWN_SOUND:
        file = Path(spec.given.audio)
        return _coded(cut_sound(file, start, end, _placed(file, capture) - sound_begin(file)), file)
    if capture is None:
        return read_audio(folder.scene, load_manifest(folder.manifest)) if folder.manifest.exists() else None
    for path, offset in _sounding_videos(capture):
        try:
            return _coded(cut_sound(path, start, end, offset), path)
        except InputError as error:
            log.warning("%s; the scene gets none", error)
            return None
    return None


def replace_sound(run: Path, audio: str) -> None:
    """Give a run's encoded scene another sound, or none: `audio` is as of `--audio`. Nothing else of it changes.

    Raises:
        InputError: the run has no encoded scene, or its capture is gone, or the file has no sound.
    """
    folder = RunFolder(run)
    manifest, spec = load_manifest(folder.manifest), folder.read_spec()
    capture = None if audio == NO_SOUND or spec.without_capture else spec.open_capture()
    spec = spec.with_audio(require_sound_file(audio))
    sound = scene_sound(folder, spec, capture, manifest.start, manifest.end)
    write_sound(folder.scene, sound)
    folder.replace_spec(spec)


def write_sound(scene: Path, sound: CodedAudio | None) -> None:
    """Replace the sound of a scene folder, the manifest last."""
    document = json.loads((scene / MANIFEST).read_bytes())
    document.pop("audio", None)
    if sound is not None:
        for name, data in sound.chunks.items():
            write_bytes(scene / CHUNKS / name, data)
        document["audio"] = sound.entry.to_json()
    text = json.dumps(document, allow_nan=False, separators=(",", ":")).encode()
    if text != (scene / MANIFEST).read_bytes():
        write_bytes(scene / MANIFEST, text)
    named = stored_sizes(load_manifest(scene))
    for file in (scene / CHUNKS).glob("*"):
        if file.name not in named:
            file.unlink()


def _sounding_videos(capture: Capture) -> Iterator[tuple[Path, float]]:
    """Yield the videos with sound, with the offsets of their times."""
    for camera in range(len(capture.cameras)):
        video = capture.video(camera)
        if video is not None and has_sound(video[0]):
            yield video


def _video_of(name: str, capture: Capture | None) -> tuple[Path, float]:
    """Return a camera's video, with the offset of its times."""
    if capture is not None:
        for camera, one in enumerate(capture.cameras):
            if one.name == name and (video := capture.video(camera)) is not None:
                return video
    raise _refused(f"{CAMERA_SOUND}{name}", "the run has no video of this camera", "give a file")


def _placed(file: Path, capture: Capture | None) -> float:
    """Return when a file begins, seconds of the capture's clock: where its sound fits a camera's, else at 0."""
    from hgs_core.check.starts import starts_by_sound

    video = None if capture is None else next(_sounding_videos(capture), None)
    if video is None:
        return 0.0
    path, offset = video
    try:
        found = starts_by_sound(file, [path.name, "it"], [path, file], silent).values
    except InputError as error:
        log.warning("%s: %s; it is taken to begin with the scene", file, error.problem)
        return 0.0
    return sound_begin(path) + offset + found["it"] - found[path.name]


def _coded(cut: CutSound | None, source: object) -> CodedAudio | None:
    if cut is None:
        log.warning("%s has no sound while the scene lasts", source)
        return None
    if cut.encoded_from:
        log.warning("the sound of %s is %s, which browsers do not play: encoded as Opus", source, cut.encoded_from)
    chunks = {chunk_id(piece.data): piece.data for piece in cut.pieces}
    pieces = tuple(AudioPiece(chunk_id(one.data), len(one.data), one.start, one.end) for one in cut.pieces)
    return CodedAudio(AudioEntry(cut.codec, cut.sample_rate, cut.channels, pieces), chunks)


def _refused(audio: str, problem: str, cure: str) -> InputError:
    return InputError(f"--audio {audio}", problem, cure, field="audio")
