"""Films and compressed sound through PyAV: which stream, when it starts, and its samples in one sequential pass."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import SoundtrackError
from ..plurals import times
from .appended import Appended, appended_warning, find_appended
from .boxes import ends_before_its_index
from .chunks import ChunkTable, overflow_warning
from .corrections import correction_warnings
from .decode import Tally, decoded, packed, set_up_decoder
from .ending import stops_early
from .facts import UNSTAMPED, film_facts, header_frames, origin_of, sound_streams, title_of
from .first_stamp import origin_by_others
from .layouts import ChannelNames, taken_names
from .lengths import lacking_warning
from .placement import Placement
from .probe import opened, picture_warnings, told_start
from .singles import unjoined
from .titles import is_spoken_over
from .track import Samples, TrackFacts, stamp_warnings

if TYPE_CHECKING:
    from av import AudioFrame
    from av.audio.stream import AudioStream
    from av.container import InputContainer

_PLAYLISTS = frozenset({"concat", "dash", "hls", "imf", "sdp"})
_MAX_UNDECLARED_S = 24 * 3600
_SLACK_S = 10
_COMPARED_FRAMES = 24
"""How many frames the first time stamp is compared with; in a transport stream it may be that of eight frames."""


class FilmTrack:
    """One sound stream of a file, decoded from its first packet to its last."""

    def __init__(
        self,
        container: "InputContainer",
        stream: "AudioStream",
        table: ChunkTable | None,
        names: ChannelNames,
        *,
        is_cut: bool,
        hints: Sequence[str],
        appended: Appended | None,
    ) -> None:
        """Take over an open container and decode the first frame, which says what the sound really is.

        `names` are those of the channels in each of its streams. `is_cut` tells that the file stops before its own
        end. `hints` are lines for a user who may not know that there are other streams. `appended` is another file
        behind this one.
        """
        self._appended = appended
        self._container, self._stream, self._names, self._hints = container, stream, names, hints
        self.number = container.streams.audio.index(stream)
        self._tally = Tally()
        set_up_decoder(stream)
        self._frames = decoded(container, stream, self._tally)
        first = next(self._frames, None)
        if first is None:
            self._tally.require_readable()
            raise SoundtrackError(f"no sound could be decoded from sound stream {self.number}")
        self._origin = origin_of(first, stream, self._tally)
        self._first = [first, *islice(self._frames, _COMPARED_FRAMES)]
        self._first_stamp_off_s = 0.0
        self.facts = film_facts(container, stream, first, self._origin, names, is_cut=is_cut)
        self._overrule_first_stamp(is_cut=is_cut)
        if _is_open(table):  # what it declares is wrong, and is told to be
            self.facts = replace(self.facts, declared_frames=None)
        self._placement: Placement[AudioFrame] = Placement(self.facts.rate_hz, _longest(self.facts), self._origin)
        self._table = table
        self._played = 0
        # where a length is declared, that tells whether any sound is missing
        tells = self.facts.declared_frames is not None and self.facts.breaks_off
        self._end_is_missing = is_cut and not tells and header_frames(container, stream, self.facts.rate_hz) is None

    @property
    def title(self) -> str | None:
        """Return what the stream is called, None where it has no name."""
        return title_of(self._stream)

    @property
    def origin(self) -> Fraction | None:
        """Return when sample 0 plays by the file's clock, in seconds; None where nothing says."""
        return self._origin

    def pieces(self) -> Iterator[Samples]:
        """Yield all samples in order, shape (frames, channels). Raises SoundtrackError where too much is damaged."""
        first, self._first = self._first, []  # not held any longer than needed: some codecs have a second in a frame
        placed = self._placement.place(chain(first, self._frames))
        del first
        for samples in packed(placed, rate_hz=self.facts.rate_hz, channels=self.facts.channels):
            self._played += samples.shape[0]
            yield samples
        self._tally.require_readable()

    def read_approximately(self, start_s: float, frames: int) -> Iterator[Samples]:
        """Yield at least so many samples, if there are, from about that time on.

        The track cannot be decoded as a whole afterwards. Raises SoundtrackError where no place in it can be found.
        """
        from av.error import FFmpegError

        stream, base = self._stream, Fraction(self._stream.time_base or Fraction(1, 1_000_000))
        told = None if self._first_stamp_off_s else told_start(stream)
        begin = (self._origin or Fraction(0)) if told is None else told
        start = round((begin + Fraction(start_s)) / base)
        try:
            self._container.seek(start, stream=stream)
        except FFmpegError as error:
            raise SoundtrackError(f"cannot be read from {start_s:.0f} s on: {error.strerror}") from error
        heard, left = decoded(self._container, stream, Tally(), earliest_s=start * base), frames
        for samples in packed(heard, rate_hz=self.facts.rate_hz, channels=self.facts.channels):
            yield samples
            left -= samples.shape[0]
            if left <= 0:
                return

    def warnings(self) -> list[str]:
        """Return what was damaged, filled or overruled, one line each."""
        tally, played_s = self._tally, self._played / self.facts.rate_hz
        lines = [*self._hints]
        if tally.failed:
            packets = f"{tally.failed} of {tally.packets} packets of sound"
            lines.append(f"{packets} could not be decoded ({tally.last_error}){self._place(tally.first_failed_time)}")
        is_stamped = self._container.format.name not in UNSTAMPED
        lines += correction_warnings(self._placement, self._first_stamp_off_s, is_stamped=is_stamped)
        if self._table is not None and (self._table.goes_on or self._table.data_bytes == 0):
            lines.append(overflow_warning(self._table, is_read=self._table.is_wave))
        elif self._table is not None and self._table.lacking_bytes:
            lines.append(lacking_warning(self._table.lacking_bytes))
        if self._appended is not None:
            lines.append(appended_warning(self._appended))
        if self.facts.declared_frames is None:
            lines += tally.reach.warnings(Path(self._container.name), played_s)
        if self._end_is_missing:
            lines.append(
                "the file stops or breaks before its own end: the end of the sound is missing, from "
                f"{played_s:.3f} s on"
            )
        if tally.resumed:
            lines.append(f"reading broke off {times(tally.resumed)} and went on behind the damage")
        if tally.stopped:
            lines.append(f"reading stopped early: {tally.stopped}")
        return lines + picture_warnings(self.facts) + stamp_warnings(self.facts)

    def _overrule_first_stamp(self, *, is_cut: bool) -> None:
        """Begin the track where most stamps say but the first one, unless the first frame may be followed by a gap."""
        origin = origin_by_others(self._first, self.facts.rate_hz)
        if origin is None or self._origin is None:
            return
        facts = film_facts(self._container, self._stream, self._first[0], origin, self._names, is_cut=is_cut)
        if 0 <= origin - self._origin <= Fraction(_longest(facts), facts.rate_hz):
            return
        self._first_stamp_off_s = float(self._origin - origin)
        self._origin, self.facts = origin, facts

    def _place(self, time: Fraction | None) -> str:
        """Return where in the sound a time stamp is, to be added to a line; nothing where there is no stamp."""
        origin = self._placement.origin
        return "" if time is None or origin is None else f", first at {max(0.0, float(time - origin)):.3f} s"

    def close(self) -> None:
        """Close the file."""
        self._frames.close()
        self._container.close()


def _longest(facts: TrackFacts) -> int:
    """Return how many frames a track has at most, gaps included."""
    if facts.declared_frames is None:
        return _MAX_UNDECLARED_S * facts.rate_hz
    return facts.declared_frames + _SLACK_S * facts.rate_hz


def _is_open(table: ChunkTable | None) -> bool:
    """Return whether the sound of a WAV goes on beyond what its header declares."""
    return table is not None and table.is_wave and (table.goes_on or table.data_bytes == 0)


def open_film(path: Path, *, stream: int | None, table: ChunkTable | None) -> FilmTrack:
    """Open one sound stream, the default or first one where `stream` is None; `table` is what a WAV header declares.

    Raises SoundtrackError where the file is not media, has no such stream, or nothing can be decoded.
    """
    from av.error import FFmpegError

    try:
        container = opened(path, {"ignore_length": "1"} if _is_open(table) else {})
    except FFmpegError as error:
        if ends_before_its_index(path):
            raise SoundtrackError("breaks off before its index (moov), without which it cannot be read") from error
        raise SoundtrackError(f"is not a sound file or film that can be read: {error.strerror}") from error
    try:
        if container.format.name in _PLAYLISTS:
            raise SoundtrackError("is a list of other files; expected a film or sound file itself")
        names = taken_names(container)
        is_cut = stops_early(path, container.format.name)
        chosen = _chosen(container, stream, names)
        hints = _hints(container, chosen, names) if stream is None else ()
        appended = find_appended(path, container.format.name) if table is None else table.appended
        return FilmTrack(container, chosen, table, names, is_cut=is_cut, hints=hints, appended=appended)
    except BaseException:
        container.close()
        raise


def _chosen(container: "InputContainer", index: int | None, names: ChannelNames) -> "AudioStream":
    """Return the stream with a number, or the film's own sound: what is no commentary and the like, by default."""
    from av.stream import Disposition

    streams = container.streams.audio
    if not streams:
        raise SoundtrackError("has no sound stream")
    if index is None:
        aside = Disposition.comment | Disposition.hearing_impaired | Disposition.visual_impaired
        stream = min(streams, key=lambda s: (bool(s.disposition & aside), not s.disposition & Disposition.default))
    elif 0 <= index < len(streams):
        stream = streams[index]
    else:
        raise SoundtrackError(f"has no sound stream {index}; it has {'; '.join(sound_streams(container, names))}")
    if stream.codec_context is None:
        raise SoundtrackError(f"sound stream {streams.index(stream)} is in a format that cannot be decoded")
    return stream


def _hints(container: "InputContainer", chosen: "AudioStream", names: ChannelNames) -> list[str]:
    """Return what to tell of a stream that nobody chose: it may be a channel alone, or no sound of the film at all."""
    unheard = unjoined(container, chosen, names)
    hints = [] if unheard is None else [unheard]
    described = sound_streams(container, names)
    if len(described) > 1 and is_spoken_over(title_of(chosen)):
        heard = described.pop(container.streams.audio.index(chosen))
        hints.append(
            f"sound stream {heard} is heard, which its title says is spoken over the film's sound; "
            f"--stream chooses another: {'; '.join(described)}"
        )
    return hints
