"""From a file to a sound track that is open for reading: uncompressed sound by itself, all else through PyAV."""

from contextlib import ExitStack
from pathlib import Path

from ..errors import SoundtrackError
from ..plurals import counted
from ..streams import Streams, streams_text
from ..timebase import AS_FILMED, Timebase
from .chunks import chunk_table
from .files import file_state, naming, require_file
from .mix import mix_matrix, mix_name
from .pcm import PcmTrack, open_pcm
from .reader import Soundtrack
from .spool import Spool
from .track import Track

MIN_RATE_HZ, MAX_RATE_HZ = 8_000, 384_000


def open_soundtrack(
    path: Path,
    *,
    stream: Streams | None = None,
    mix: str = "mains",
    spool_folder: Path | None = None,
    rereadable: bool = True,
    timebase: Timebase = AS_FILMED,
) -> Soundtrack:
    """Open one sound track of an audio file or a film.

    `stream` counts the sound tracks from 0; several, of one channel each, are joined as the channels of one. Without it
    the one that the file marks as default is taken, else the first. `mix` is explained in `mix.py`. Compressed sound is
    spooled to a temporary file in `spool_folder`, unless it is not to be `rereadable`: nothing of it can be read again
    then. `timebase` is what the user knows better about its timecode. Raises SoundtrackError where the file cannot be
    read or has no such track or channel, RuleError where the time base does not go with the film.
    """
    with naming(path), ExitStack() as unless_opened:
        require_file(path)
        state = file_state(path)
        track = _open_track(path, stream)
        unless_opened.callback(track.close)
        facts = track.facts
        if not MIN_RATE_HZ <= facts.rate_hz <= MAX_RATE_HZ:
            limits = f"{MIN_RATE_HZ} to {MAX_RATE_HZ} Hz"
            raise SoundtrackError(f"the sample rate is {facts.rate_hz} Hz; expected {limits}")
        matrix = mix_matrix(facts.layout, facts.channels, mix)
        spool = None
        if rereadable and not isinstance(track, PcmTrack):
            spool = Spool(spool_folder)
            unless_opened.callback(spool.close)
        opened = Soundtrack(path, track, matrix=matrix, mix=mix_name(mix), spool=spool, timebase=timebase, opened=state)
        opened.describe()
        unless_opened.pop_all()
    return opened


def _open_track(path: Path, stream: Streams | None) -> Track:
    table = chunk_table(path)
    pcm = open_pcm(path, table)
    if pcm is None:
        from .film import open_film
        from .joined import open_joined

        if isinstance(stream, tuple):
            return open_joined(path, stream, table=table)
        return open_film(path, stream=stream, table=table)
    if stream not in (None, 0):
        pcm.close()
        kind = counted(pcm.facts.channels, "channel")
        raise SoundtrackError(f"has no sound stream {streams_text(stream or 0)}; it has 0 ({kind})")
    return pcm
