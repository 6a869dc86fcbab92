"""The drive of one window: by direct conversion, by the compensator, or within the limit; and what it does."""

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from .. import dsp
from ..correlate import normalised_product
from ..model import Background, Clip, DriveInfo, DriveModel, SceneEvidence, Shot, Span
from ..ruleset import RenderRules
from ..units import SILENCE_DB, db_from_gain, samples_from_ms, share_text
from .constrained import SolveSummary, constrained_drive
from .filters import DriveFilters, Samples, felt
from .heard import HeardWindow
from .windows import PlannedWindow


@dataclass(frozen=True, eq=False)
class RenderedWindow:
    """The drive of a window: one column over exactly its span, within the limit; one `DriveInfo` for each shot."""

    planned: PlannedWindow
    clip: Clip
    drives: tuple[DriveInfo, ...]


def measure(heard: HeardWindow) -> SceneEvidence:
    """Return what direct conversion and the compensator would do in a window, for the choice between the models.

    The compensator's peak is the higher of those with and without the shots' gains: a window beyond its limit is not
    for it where it is only wanted softer, or it would be softer by more than that.
    """
    core = _within(heard.planned.core, heard.planned)
    target = heard.target[core]
    direct = felt(_limited(heard.asked), heard.filters)[core]
    return SceneEvidence(
        direct_level_db=_level_db(direct, target),
        direct_fidelity=normalised_product(direct, target),
        filter_peak=max(_peak(heard.unlimited), _peak(heard.unlimited / heard.gains)),
    )


def render_window(
    heard: HeardWindow, shots: Sequence[Shot], *, model: DriveModel, reason: str, background: Background
) -> RenderedWindow:
    """Return the drive of a window, |drive| <= 1 everywhere.

    `shots` are all shots of the film. Inside a window the background, too, keeps to the limit, as the file that will
    hold the drive does.
    """
    planned, filters = heard.planned, heard.filters
    direct = _limited(heard.sound)
    own = [shots[index] for index in planned.shots]
    starts = _starts(planned, own, filters, heard.rules)
    wet = _limited(heard.asked) if model == "direct" else heard.unlimited
    if model == "filter" and (peak := _excess(wet, heard.gains)) > 1.0:
        wet = wet / peak
        reason = (
            f"{reason}; the compensator's peak is {share_text(peak)} of the limit, so the window is scaled down by it"
        )
    summaries: Sequence[SolveSummary | None] = [None] * len(own)
    if model == "constrained":
        wet, summaries = constrained_drive(
            heard.target,
            starts=starts,
            impulse=filters.impulse,
            recursion=filters.recursion,
            rate_hz=filters.rate_hz,
            warm_start=wet,
            rules=heard.rules,
        )
    dry = _limited(heard.background) if background == "direct" else np.zeros_like(direct)
    drive = _limited(dsp.cross_fade(dry, wet, _weights(planned)))
    infos = _drive_infos(drive, direct, heard, own, starts, model=model, reason=reason)
    infos = tuple(_with_summary(info, summary) for info, summary in zip(infos, summaries, strict=True))
    return RenderedWindow(planned, Clip(drive[:, None], filters.rate_hz, planned.window.start), infos)


def _with_summary(info: DriveInfo, summary: SolveSummary | None) -> DriveInfo:
    if summary is None:
        return info
    return msgspec.structs.replace(info, solver_steps=summary.steps, explained=summary.explained)


def _excess(wet: Samples, gains: Samples) -> float:
    """Return what a drive is divided by to keep to the limit, with its gains and without them.

    So a shot that is wanted softer is softer, though scaling to the limit alone would undo its gain.
    """
    return max(1.0, _peak(wet / gains), _peak(wet))


def _starts(planned: PlannedWindow, shots: Sequence[Shot], filters: DriveFilters, rules: RenderRules) -> list[int]:
    """Return where in the window the drive of each shot may begin: the lead before its onset."""
    lead = samples_from_ms(rules.lead_ms, filters.rate_hz)
    return [max(0, shot.onset - lead - planned.window.start) for shot in shots]


def _drive_infos(
    drive: Samples,
    direct: Samples,
    heard: HeardWindow,
    shots: Sequence[Shot],
    starts: Sequence[int],
    *,
    model: DriveModel,
    reason: str,
) -> tuple[DriveInfo, ...]:
    """Return for each shot its peak and what is felt, from its onset to where the drive of the next may begin.

    Both predictions start from rest at the window. The fidelity is against the target, the sound in the band, so
    that the delay of a causal band is not counted as a fault of the drive.
    """
    planned = heard.planned
    felt_drive, felt_direct = felt(drive, heard.filters), felt(direct, heard.filters)
    infos = []
    ends = [*(planned.window.start + start for start in starts[1:]), planned.core.stop]
    gains_db = [gain_db for _, gain_db in planned.gains] or [0.0] * len(shots)
    for shot, gain_db, start, stop, end in zip(
        shots, gains_db, [0, *starts[1:]], [*starts[1:], len(drive)], ends, strict=True
    ):
        core = _within(Span(shot.onset, max(end, shot.onset + 1)), planned)
        infos.append(
            DriveInfo(
                model,
                reason,
                peak=float(np.max(np.abs(drive[start : max(stop, start + 1)]))),
                perceived_gain_db=_level_db(felt_drive[core], felt_direct[core]),
                fidelity=normalised_product(felt_drive[core], heard.target[core]),
                made_of=heard.made_of,
                raised_db=gain_db + heard.rules.level_db,
            )
        )
    return tuple(infos)


def _within(span: Span, planned: PlannedWindow) -> slice:
    """Return where a span of the film lies in the arrays of a window."""
    inside = span & planned.window.span
    return slice(inside.start - planned.window.start, inside.stop - planned.window.start)


def _weights(planned: PlannedWindow) -> Samples:
    window = planned.window
    weights = np.ones(len(window.span))
    weights[: window.fade_in_samples] = dsp.fade(window.fade_in_samples)
    weights[len(weights) - window.fade_out_samples :] = dsp.fade(window.fade_out_samples)[::-1]
    return weights


def _limited(samples: Samples) -> Samples:
    return np.clip(samples, -1.0, 1.0)


def _peak(samples: Samples) -> float:
    return float(np.max(np.abs(samples)))


def _level_db(samples: Samples, reference: Samples) -> float:
    """Return the level of one signal against another; 0 where both are silent."""
    level, against = _norm(samples), _norm(reference)
    if against == 0.0:
        return 0.0 if level == 0.0 else -SILENCE_DB
    return min(db_from_gain(level / against), -SILENCE_DB)


def _norm(samples: Samples) -> float:
    return float(np.sqrt(np.sum(samples * samples)))
