"""What a window hears: its sound, filtered once for all that is measured and rendered from it."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .. import dsp
from ..model import Clip, MadeOf, Span
from ..ruleset import RenderRules
from ..units import gain_from_db, samples_from_ms
from .filters import DriveFilters, Samples, filtered_audio, preroll, settled_band, settled_compensated
from .windows import PlannedWindow


@dataclass(frozen=True, eq=False)
class HeardWindow:
    """A window with its sound, exactly over its span, shape (frames,), and how it is to be rendered.

    `gains` are those of its shots, sample by sample. With them and the level of the rules, `asked` is the sound,
    `target` the sound in the band, which is to be felt, and `unlimited` the compensator's drive. `made_of` says
    what the sound is of, and `background` is what is heard beside the windows.
    """

    planned: PlannedWindow
    filters: DriveFilters
    rules: RenderRules
    sound: Samples
    gains: Samples
    asked: Samples
    target: Samples
    unlimited: Samples
    background: Samples
    made_of: MadeOf = "mains"


def hear_window(
    audio: Clip, planned: PlannedWindow, *, filters: DriveFilters, rules: RenderRules, made_of: MadeOf = "mains"
) -> HeardWindow:
    """Return what a window hears; `audio` covers `needed_audio`, more of it changes nothing.

    Raises ValueError where the filters are for another rate.
    """
    if audio.rate_hz != filters.rate_hz:
        raise ValueError(f"filters for {filters.rate_hz} Hz cannot render audio at {audio.rate_hz} Hz")
    filtered = filtered_audio(planned, frames=audio.span.stop, filters=filters, rules=rules)
    clip = audio.slice((filtered & audio.span) | planned.window.span)
    before = planned.window.start - clip.start
    inside = slice(before, before + len(planned.window.span))
    sound = np.asarray(clip.driving_of(made_of), dtype=np.float64)
    centred = sound - dsp.level_at(
        planned.window.start,
        lambda start, stop: audio.slice(Span(start, stop)).driving_of(made_of),
        preroll=preroll(filters, rules),
        frames=audio.span.stop,
        rate_hz=filters.rate_hz,
    )
    gains = _gains(planned, filters, rules)
    gain = gain_from_db(rules.level_db) * gains
    return HeardWindow(
        planned,
        filters,
        rules,
        sound[inside],
        gains,
        asked=gain * sound[inside],
        target=gain * settled_band(centred, inside, filters, rules),
        unlimited=gain * settled_compensated(centred, inside, filters, rules),
        background=np.asarray(clip.driving, dtype=np.float64)[inside],
        made_of=made_of,
    )


def _gains(planned: PlannedWindow, filters: DriveFilters, rules: RenderRules) -> Samples:
    """Return the gain of a window's every sample: each shot's from its onset on, reached over the lead before it.

    A shot that is nearer to the one before than that keeps off its onset.
    """
    gains = np.ones(len(planned.window.span))
    lead = samples_from_ms(rules.lead_ms, filters.rate_hz)
    if planned.gains:
        _, first_db = planned.gains[0]
        gains *= gain_from_db(first_db)
    for (before, _), (at, gain_db) in pairwise(planned.gains):
        onset, gain = at - planned.window.start, gain_from_db(gain_db)
        start = min(onset, max(0, before - planned.window.start + 1, onset - lead))
        gains[start:onset] = np.linspace(gains[start], gain, onset - start, endpoint=False)
        gains[onset:] = gain
    return gains
