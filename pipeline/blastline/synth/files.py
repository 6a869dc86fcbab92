"""A scene written to a folder: its sound as WAV, its truth as JSON."""

import shutil
from pathlib import Path

from ..errors import OutputError
from ..model import Span
from ..staging import require_utf_8, staged
from .master import quantised
from .mix import SceneAudio
from .scene import Scene, load_scene
from .spread import expanded
from .truth import NegativeTruth, ShotTruth, Truth, encode_truth

BLOCK_S = 5


def render_scene(scene: Scene) -> SceneAudio:
    """Return the sound of a scene, ready to be read; what `[random]` asks for is spread over it first."""
    return SceneAudio(expanded(scene))


def truth_of(audio: SceneAudio) -> Truth:
    """Return everything that a scene contains."""
    whole = Span(0, audio.frames)
    return _truth(audio, list(audio.shot_truths(whole)), list(audio.negative_truths(whole)))


def synthesise(scene_path: Path, folder: Path, *, overwrite: bool = False) -> Truth:
    """Write `NAME.wav` and `NAME.truth.json` for a scene file into a folder and return the truth.

    Raises RuleError for a scene that does not fit, OutputError where a file exists or cannot be written.
    """
    require_utf_8(folder)
    require_utf_8(scene_path, advice="rename the file")  # the sound is named after it
    scene = load_scene(scene_path)
    names = [f"{scene.name}.wav", f"{scene.name}.truth.json"]
    with staged(folder, names=names, overwrite=overwrite) as hidden:
        return write_scene(scene, hidden)


def write_scene(scene: Scene, folder: Path) -> Truth:
    """Write the sound and the truth of a scene into a folder that exists, in one pass, and return the truth.

    Raises OutputError where the disk refuses.
    """
    import soundfile

    audio = render_scene(scene)
    shots: list[ShotTruth] = []
    negatives: list[NegativeTruth] = []
    subtype = f"PCM_{scene.master.bits}"
    wav = folder / f"{scene.name}.wav"
    bytes_long = audio.frames * audio.channels * scene.master.bits // 8
    container = "RF64" if bytes_long >= 2**32 - 2**16 else "WAV"
    try:
        with soundfile.SoundFile(
            wav, "w", samplerate=audio.rate_hz, channels=audio.channels, subtype=subtype, format=container
        ) as file:
            for start, block in audio.blocks(BLOCK_S * audio.rate_hz):
                file.write(quantised(block, start, master=scene.master, seed=scene.seed))
                span = Span(start, start + len(block))
                shots += audio.shot_truths(span)
                negatives += audio.negative_truths(span)
    except soundfile.SoundFileError as error:
        left = shutil.disk_usage(folder).free
        raise OutputError(
            f"{wav}: cannot write the sound: it takes {bytes_long} bytes, {left} are left on the disk ({error})"
        ) from error
    truth = _truth(audio, shots, negatives)
    (folder / f"{scene.name}.truth.json").write_bytes(encode_truth(truth))
    return truth


def _truth(audio: SceneAudio, shots: list[ShotTruth], negatives: list[NegativeTruth]) -> Truth:
    return Truth(
        schema="blastline.truth/1",
        scene=audio.scene.name,
        rate_hz=audio.rate_hz,
        frames=audio.frames,
        channels=audio.channels,
        shots=tuple(shots),
        negatives=tuple(negatives),
    )
