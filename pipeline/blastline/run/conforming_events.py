"""The events of a film cut anew: as its channels play them, in windows that are planned anew."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import msgspec
import numpy as np

from ..conform import Retimed
from ..detect import audio_around, shot_in_clearer_mix, with_azimuths
from ..model import Channels, Decision, Event, Shot, Source, Span, Window
from ..render import plan_windows, window_between
from ..ruleset import QualityRules, Rules, WindowRules
from ..soundtrack import Soundtrack
from ..timecode import timecode_at
from ..units import samples_from_ms

MovedShot = tuple[Event, Retimed]
"""An event of the old film, and what it is in the new one."""

_SAME = 2.0**-13
"""Samples that are nearer to each other are the same: so near is a copy in 16 bits, dithered."""


def as_played(
    shots: Sequence[MovedShot],
    tracks: tuple[Soundtrack, Soundtrack],
    sources: tuple[Source, Source],
    *,
    alike: bool,
    tier: QualityRules,
) -> list[MovedShot]:
    """Return the shots with the mix of the new film that they are heard in, and from where they come there.

    `tracks` and `sources` are the old film's and the new one's. What `alike` channels play as they did is heard as it
    was; of the rest azimuths are measured in the new film's channels. Where those cannot be read again, the old film's
    hold if its channels are alike.
    """
    new, source = tracks[1], sources[1]
    same = [alike and _is_played_alike(event, each.shot, tracks, sources, tier) for event, each in shots]
    mixed = [
        msgspec.structs.replace(each.shot, heard_in=event.heard_in)
        if is_same
        else _in_its_mix(event, each.shot, new, source, tier)
        for (event, each), is_same in zip(shots, same, strict=True)
    ]
    channels = new.channels_in_space
    beside = [shot.onset for shot in mixed if shot.heard_in == "sides"]
    toward = with_azimuths(mixed, channels, rate_hz=new.rate_hz, rules=tier.channels, side_onsets=beside)
    kept = [is_same or _is_kept(channels, shot, alike) for is_same, shot in zip(same, toward, strict=True)]
    return [
        (event, replace(each, shot=_with_azimuth_of(event, shot) if is_kept else shot))
        for (event, each), shot, is_kept in zip(shots, toward, kept, strict=True)
    ]


def _is_played_alike(
    event: Event,
    shot: Shot,
    tracks: tuple[Soundtrack, Soundtrack],
    sources: tuple[Source, Source],
    tier: QualityRules,
) -> bool:
    """Return whether both films have the same samples around a shot's attack, in their mixes and in their channels."""
    old, new = tracks
    if old.rate_hz != new.rate_hz:
        return False
    around = samples_from_ms(2.0 * tier.channels.azimuth_ms, new.rate_hz)
    before = min(around, event.onset_sample, shot.onset)
    left = min(sources[0].frames - event.onset_sample, sources[1].frames - shot.onset)
    after = min(max(around, shot.blast.stop - shot.onset), left)
    here, there = (Span(onset - before, onset + after) for onset in (event.onset_sample, shot.onset))
    ours, theirs = old.read(here, sides=True), new.read(there, sides=True)
    pairs = [(ours.samples, theirs.samples), (ours.sides, theirs.sides)]
    if old.channels_in_space is not None and new.channels_in_space is not None:
        pairs.append((old.channels_in_space.read(here), new.channels_in_space.read(there)))
    return all(
        one is None or other is None or (one.shape == other.shape and bool(np.all(np.abs(one - other) <= _SAME)))
        for one, other in pairs
    )


def _is_kept(channels: Channels | None, shot: Shot, alike: bool) -> bool:
    """Return whether the azimuth that a shot had holds, for want of channels that can be read again."""
    return alike and (channels is None or channels.read(Span(shot.onset, shot.onset + 1)) is None)


def _in_its_mix(event: Event, shot: Shot, track: Soundtrack, source: Source, tier: QualityRules) -> Shot:
    """Return a shot with the mix in which it is heard: other channels may have in the middle what was beside it."""
    if event.heard_in == "mains":
        return shot
    span = audio_around(shot.onset, frames=source.frames, rate_hz=track.rate_hz, tier=tier)
    there = shot_in_clearer_mix(shot.onset, track.read(span, sides=True), confidence=shot.confidence, tier=tier)
    peak_dbfs = shot.peak_dbfs if there.heard_in == "sides" else there.peak_dbfs
    return msgspec.structs.replace(shot, heard_in=there.heard_in, peak_dbfs=peak_dbfs)


def _with_azimuth_of(event: Event, shot: Shot) -> Shot:
    return msgspec.structs.replace(shot, azimuth_deg=event.azimuth_deg, azimuth_focus=event.azimuth_focus)


def moved_events(shots: Sequence[MovedShot], begun: Collection[str], source: Source, rules: Rules) -> tuple[Event, ...]:
    """Return the shots as events of the new film, each under its old id, in windows that are planned anew.

    `begun` has the ids of those whose windows begin where somebody has set it.
    """
    planned = plan_windows(
        [each.shot for _, each in shots],
        frames=source.frames,
        rate_hz=source.sample_rate_hz,
        rules=rules.tier.windows,
        given=_kept_ends(shots, begun, source, rules.tier.windows),
    )
    window_of = {index: each.window for each in planned for index in each.shots}
    return tuple(
        msgspec.structs.replace(
            event,
            onset_sample=shot.onset,
            onset_s=shot.onset / source.sample_rate_hz,
            timecode=timecode_at(source, shot.onset),
            burst=shot.burst,
            shot_in_burst=shot.shot_in_burst,
            decisions=_still_true(event, shot.onset, window_of[index]),
            peak_dbfs=shot.peak_dbfs,
            heard_in=shot.heard_in,
            azimuth_deg=shot.azimuth_deg,
            azimuth_focus=shot.azimuth_focus,
            blast=shot.blast,
            reflections=shot.reflections,
            window=window_of[index],
            drive=None,
        )
        for index, (event, shot) in enumerate((event, each.shot) for event, each in shots)
    )


def _still_true(event: Event, onset: int, window: Window) -> tuple[Decision, ...]:
    """Return an event's decisions; those about its window only if that is what it was, moved with the shot."""
    late = onset - event.onset_sample
    before = msgspec.structs.replace(event.window, start=event.window.start + late, stop=event.window.stop + late)
    return tuple(each for each in event.decisions if each.about != "window" or window == before)


def _kept_ends(
    shots: Sequence[MovedShot], begun: Collection[str], source: Source, rules: WindowRules
) -> dict[int, Window]:
    """Return the windows, by the shot's index, that somebody has `begun` elsewhere or that would end later than before.

    Somebody has set their ends, or their fade-outs are shorter than those of the rules.
    """
    rate_hz = source.sample_rate_hz
    fade_out = samples_from_ms(rules.fade_out_ms, rate_hz)
    given = {}
    for index, (event, each) in enumerate(shots):
        start = each.start if event.id in begun else None
        stop = each.stop if each.stop < min(each.shot.span.stop + fade_out, source.frames) else None
        if start is not None or stop is not None:
            given[index] = window_between(
                each.shot, start=start, stop=stop, frames=source.frames, rate_hz=rate_hz, rules=rules
            )
    return given


def begun_by_hand(events: Sequence[Event], rate_hz: int, plans: Collection[WindowRules]) -> set[str]:
    """Return the ids of the events, in order of time, that are first in a window which begins as no plan has it."""
    leads = {samples_from_ms(rules.guard_ms, rate_hz) + samples_from_ms(rules.fade_in_ms, rate_hz) for rules in plans}
    first: dict[Window, Event] = {}
    for event in events:
        first.setdefault(event.window, event)
    return {
        each.id
        for each in first.values()
        if all(each.window.start != max(0, each.onset_sample - lead) for lead in leads)
    }
