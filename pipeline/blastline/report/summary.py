"""What a designer wants to know in ten seconds."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from statistics import median

from ..model import Check, Event, Source, Timeline
from ..plurals import counted
from ..timebase import rate_text
from ..timecode import frame_scale
from .words import allowed, by_name, claim, duration, figure, is_decided, measured, safe, signed

_SHOWN_FAILURES = 6

_OF_PLACES = {"sample_rate", "frames", "silence_outside_windows", "sound_outside_windows", "timeline_order"} | {
    "drive_shift",
    "drive_drift",
    "drive_speed",
    "felt_lag",
    "felt_onset",
    "drive_lag",
    "drive_onset",
    "lag_as_rendered",
    "onset_as_rendered",
    "fade_in_before_onset",
    "audio_rise",
}
"""The checks of where film, drive and timeline are; the others tell what the drive is like there."""


def heading(timeline: Timeline) -> str:
    """Return the film's name and what it is."""
    source = timeline.source
    facts = [
        duration(source.frames / source.sample_rate_hz),
        f"from {source.start_timecode}" if source.start_timecode else "no timecode",
        _counting(source),
        f"{figure(source.sample_rate_hz / 1000, 3)} kHz",
        counted(source.channels, "channel"),
    ]
    return (
        '<p class="product">blastline report</p>'
        f'<h1>{safe(source.name)}</h1><p class="facts">{safe(" · ".join(fact for fact in facts if fact))}</p>'
    )


def _counting(source: Source) -> str:
    """Return how many frames a second the film has, as --frame-rate is given, and whether they count as drop-frame."""
    if source.frame_rate is None:
        return ""
    scale = frame_scale(source)
    rate = scale.rate if scale else Fraction(source.frame_rate)
    return f"{rate_text(rate)} frames a second" + (", drop-frame" if scale and scale.drop_frame else "")


def verdict(timeline: Timeline) -> str:
    """Return in one sentence whether film and drive are aligned, with what failed."""
    checks = timeline.checks
    failed = [check for check in checks if not check.passed]
    decided = sum(map(is_decided, checks))
    if not checks:
        return '<div class="verdict warn" role="status"><strong>Not checked.</strong></div>'
    if not failed:
        left = f" ({len(checks) - decided} more could not be held to a limit)" if decided < len(checks) else ""
        passed = f"All {decided} checks passed{left}"
        plays_on = any(check.name == "sound_outside_windows" for check in checks)
        if not timeline.events:
            text = "is the film's own sound" if plays_on else "is at rest"
            text = f"{passed}: the drive {text} from start to end."
            return f'<div class="verdict good" role="status"><strong>No shots.</strong> <span>{text}</span></div>'
        text = f"{passed}: every vibration starts with its bang, and nothing moves in between."
        if plays_on:
            text = f"{passed}: every vibration starts with its bang."
        return f'<div class="verdict good" role="status"><strong>Aligned.</strong> <span>{text}</span></div>'
    text = f"{len(failed)} of {decided} checks failed. Do not use this drive before you have looked at them."
    word = "Not aligned." if any(check.name in _OF_PLACES for check in failed) else "Not as it should be."
    return f'<div class="verdict bad" role="alert"><strong>{word}</strong> <span>{text}</span>{_worst(failed)}</div>'


def _worst(failed: Sequence[Check]) -> str:
    """Return the failures of the film, then each kind of failure among the shots with their number."""
    lines = [
        f"{safe(claim(c))}: <em>no</em>, {safe(measured(c))} ({safe(allowed(c))})" for c in failed if c.event is None
    ]
    for checks in by_name(check for check in failed if check.event is not None):
        first = checks[0]
        where = first.event if len(checks) == 1 else f"{len(checks)} shots, the first is {first.event}"
        lines.append(
            f"{safe(claim(first))}: <em>not in</em> {safe(where)}, {safe(measured(first))} ({safe(allowed(first))})"
        )
    more = f'<li><a href="#checks">{len(lines) - _SHOWN_FAILURES} more</a></li>' if len(lines) > _SHOWN_FAILURES else ""
    return f"<ul>{''.join(f'<li>{line}</li>' for line in lines[:_SHOWN_FAILURES])}{more}</ul>"


def warnings(timeline: Timeline) -> str:
    """Return what the reader had to mend."""
    items = "".join(f"<li>{safe(warning)}</li>" for warning in timeline.source.warnings)
    if not items:
        return ""
    return (
        '<div class="verdict warn" role="status"><strong>The film was not read without trouble.</strong>'
        f"<ul>{items}</ul></div>"
    )


def tiles(timeline: Timeline) -> str:
    """Return the key figures."""
    events = timeline.events
    bursts = {event.burst for event in events if event.burst is not None}
    shots = [("Shots", str(len(events)), _of_bursts(events, len(bursts)))]
    if events:
        loudest = max(events, key=lambda event: event.peak_dbfs)
        shots.append(("Strongest shot", f"{figure(loudest.peak_dbfs, 1)} dBFS", f"{loudest.id} at {loudest.timecode}"))
    drives = [event.drive for event in events if event.drive is not None]
    if drives:
        gain_db = median(drive.perceived_gain_db for drive in drives)
        shots.append(("Felt beside direct", f"{signed(gain_db)} dB", "median of all shots"))
        shots.append(("Fidelity", f"{median(drive.fidelity for drive in drives):.3f}", "felt against heard, median"))
    lag_checks = [check for check in timeline.checks if check.name in ("felt_lag", "drive_lag")]
    lags = [check.measured for check in lag_checks if check.measured is not None]
    if lags:
        worst = max(lags, key=abs)
        of = "" if len(lags) == len(lag_checks) else f" of {len(lags)}; {len(lag_checks) - len(lags)} not measured"
        shots.append(("Lag behind the bang", f"{figure(median(lags))} ms", f"median; largest {figure(worst)} ms{of}"))
    actuator = timeline.actuator.name if timeline.actuator else "none"
    models = sorted({drive.model for drive in drives})
    note = "; ".join([f"quality {timeline.quality}", *([", ".join(models)] if models else []), *asked_of(timeline)])
    shots.append(("Actuator", f'<span class="name">{safe(actuator)}</span>', note))
    items = "".join(
        f'<div class="tile"><dt>{name}</dt><dd>{value}<small>{safe(note)}</small></dd></div>'
        for name, value, note in shots
    )
    return f'<dl class="tiles">{items}</dl>'


def asked_of(timeline: Timeline) -> Iterator[str]:
    """Yield what was asked of the drive that is not as usual: its phase, its level, the film's sound beside it."""
    if timeline.actuator is None:
        return
    if timeline.phase != "causal":
        yield f"phase {timeline.phase}"
    if timeline.level_db:
        yield f"level {signed(timeline.level_db)} dB"
    if timeline.background == "direct":
        yield "the film's own sound between the shots"


def _of_bursts(events: Sequence[Event], bursts: int) -> str:
    if not bursts:
        return "all single" if events else ""
    singles = sum(event.burst is None for event in events)
    return f"{singles} single, the others in {counted(bursts, 'burst')}"
