"""The tables of the page: every shot, every check, what was rejected, and how the result was made."""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence

from ..model import Check, Edits, Event, Rejection, Source, Timeline
from ..plurals import counted
from ..streams import streams_text
from ..timecode import timecode_at
from .words import allowed, by_hand, claim, figure, fixed, is_decided, link, measured, safe, typeset

_STRONGEST = 5


def shots_table(events: Sequence[Event], *, failed: Mapping[str, int], linked: Collection[str]) -> str:
    """Return every shot, one row each; a click on a column's head sorts.

    Where the table is wider than the page its end is hidden, so what the checks came to stands near its start.
    What was set by hand, and the azimuth, have a column where a shot has one.
    """
    edited = any(by_hand(event) for event in events)
    in_space = any(event.azimuth_deg is not None for event in events)
    heads = [
        ("Shot", ""),
        ("Timecode", ""),
        ("Checks", ""),
        ("Onset, s", "n"),
        ("Confidence", "n"),
        ("Peak, dBFS", "n"),
        ("Over background, dB", "n"),
        *([("Azimuth, °", "n")] if in_space else []),
        ("Reflections", "n"),
        ("Burst", "n"),
        *([("By hand", "")] if edited else []),
        ("Drive", ""),
        ("Drive peak", "n"),
        ("Felt against direct, dB", "n"),
        ("Fidelity", "n"),
    ]
    head = "".join(f'<th scope="col" class="{kind}">{name.replace(", ", ",&nbsp;")}</th>' for name, kind in heads)
    rows = "".join(
        _shot_row(event, failed.get(event.id, 0), linked=event.id in linked, edited=edited, in_space=in_space)
        for event in events
    )
    return f'<div class="scroll"><table id="shots"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'


def _shot_row(event: Event, failed: int, *, linked: bool, edited: bool, in_space: bool) -> str:
    drive, name = event.drive, safe(event.id)
    hand = safe(by_hand(event))
    burst = "" if event.burst is None else f"{event.burst}.{event.shot_in_burst}"
    cells = [
        (f'<a href="{link(f"shot-{event.id}")}">{name}</a>' if linked else name, name, ""),
        (safe(event.timecode), safe(event.timecode), ""),
        (
            f'<span class="failed">{failed} failed</span>' if failed else '<span class="ok">passed</span>',
            str(failed),
            "",
        ),
        (f"{event.onset_s:.4f}", repr(event.onset_s), "n"),
        (fixed(event.confidence, 2), repr(event.confidence), "n"),
        (fixed(event.peak_dbfs, 1), repr(event.peak_dbfs), "n"),
        (fixed(event.snr_db, 1), repr(event.snr_db), "n"),
        *([_azimuth(event.azimuth_deg)] if in_space else []),
        (str(len(event.reflections)), str(len(event.reflections)), "n"),
        (burst, str(-1 if event.burst is None else event.burst * 1000 + (event.shot_in_burst or 0)), "n"),
        *([(hand, hand, "")] if edited else []),
        (drive.model if drive else "–", drive.model if drive else "", ""),
        (fixed(drive.peak, 2) if drive else "–", repr(drive.peak) if drive else "-1", "n"),
        (fixed(drive.perceived_gain_db, 1) if drive else "–", repr(drive.perceived_gain_db) if drive else "-999", "n"),
        (fixed(drive.fidelity, 3) if drive else "–", repr(drive.fidelity) if drive else "-1", "n"),
    ]
    body = "".join(f'<td class="{kind}" data-v="{value}">{shown}</td>' for shown, value, kind in cells)
    return f'<tr id="row-{name}" data-failed="{failed}">{body}</tr>'


def _azimuth(azimuth_deg: float | None) -> tuple[str, str, str]:
    return ("–", "-999.0", "n") if azimuth_deg is None else (fixed(azimuth_deg, 0), repr(azimuth_deg), "n")


def checks_tables(checks: Sequence[Check], *, linked: Collection[str]) -> str:
    """Return failed checks as a table, and those that passed as a folded one."""
    failed = [check for check in checks if not check.passed]
    passed = [check for check in checks if check.passed]
    parts = []
    if failed:
        parts.append(f"<h3>{len(failed)} failed</h3>{_checks_table(failed, linked)}")
    if passed:
        decided = sum(map(is_decided, passed))
        counts = f"{decided} passed"
        if decided < len(passed):
            counts += f", {len(passed) - decided} could not be held to a limit"
        parts.append(f"<details><summary>{counts}</summary>{_checks_table(passed, linked)}</details>")
    return "".join(parts) or "<p>No checks were made.</p>"


def _checks_table(checks: Sequence[Check], linked: Collection[str]) -> str:
    rows = []
    for check in checks:
        anchor = f"shot-{check.event}" if check.event in linked else f"row-{check.event}"
        where = "the film" if check.event is None else f'<a href="{link(anchor)}">{safe(check.event)}</a>'
        state = '<span class="ok">passed</span>' if check.passed else '<span class="failed">failed</span>'
        state = state if is_decided(check) else "–"
        rows.append(
            f'<tr><td>{state}</td><td class="wide">{safe(claim(check))}</td><td>{where}</td>'
            f'<td class="n">{safe(measured(check))}</td><td class="n">{safe(allowed(check))}</td>'
            f"<td><code>{safe(check.name)}</code></td></tr>"
        )
    heads = '<th>Result</th><th>Claim</th><th>Of</th><th class="n">Measured</th><th class="n">Allowed</th><th>Name</th>'
    return f'<div class="scroll"><table><thead><tr>{heads}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'


def rejections_table(rejections: Sequence[Rejection], source: Source) -> str:
    """Return how many candidates were not taken for shots, by reason, with those that came nearest, folded.

    Each has its time as a shot has it in the table of shots: who adds it to the timeline types that.
    """
    if not rejections:
        return "<p>No candidate was turned down.</p>"
    count_of = "1 candidate was" if len(rejections) == 1 else f"{len(rejections)} candidates were"
    counts = Counter(rejection.reason for rejection in rejections)
    rows = []
    for reason, count in counts.most_common():
        nearest = sorted((r for r in rejections if r.reason == reason), key=lambda r: (-_probability(r), r.at_sample))
        shown = "; ".join(_rejection(rejection, source) for rejection in nearest[:_STRONGEST])
        why = safe(typeset(reason))
        rows.append(f'<tr><td>{why}</td><td class="n">{count}</td><td class="wide">{safe(shown)}</td></tr>')
    heads = '<th>Reason</th><th class="n">Candidates</th><th>The nearest to being shots, with the evidence</th>'
    return (
        f"<details><summary>{count_of} not taken for shots</summary>"
        f'<div class="scroll"><table><thead><tr>{heads}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
        "</details>"
    )


def _probability(rejection: Rejection) -> float:
    return rejection.evidence.get("probability", max(rejection.evidence.values(), default=0.0))


def _rejection(rejection: Rejection, source: Source) -> str:
    at = rejection.at_sample
    where = f"{timecode_at(source, at)}, {at / source.sample_rate_hz:.4f} s"
    return f"{where} ({_evidence(rejection)})" if rejection.evidence else where


def _evidence(rejection: Rejection) -> str:
    return ", ".join(
        f"{name.replace('_', ' ')} {figure(value)}" for name, value in list(rejection.evidence.items())[:4]
    )


def origin_list(timeline: Timeline, options: Mapping[str, str]) -> str:
    """Return where the result comes from: program, rules, source and options."""
    source, actuator = timeline.source, timeline.actuator
    facts = {
        "blastline": timeline.version,
        "Quality": timeline.quality,
        "Rules": timeline.rules_digest,
        **({"Budget": timeline.budget.note} if timeline.budget else {}),
        **_edits(timeline.edits),
        "Film": source.name,
        "Film's SHA-256": source.sha256,
        "Sound": f"stream {streams_text(source.stream)}, mix {source.mix}, {counted(source.channels, 'channel')}, "
        f"{source.sample_rate_hz} Hz, {source.frames} frames",
        "First sample after the picture's start": f"{figure(source.start_offset_s, 6)} s",
        "Actuator": f"{actuator.name} ({actuator.digest})" if actuator else "none",
        **options,
    }
    rows = "".join(f"<dt>{safe(name)}</dt><dd>{safe(value)}</dd>" for name, value in facts.items())
    return f'<dl class="origin">{rows}</dl>'


def _edits(edits: Edits | None) -> dict[str, str]:
    if edits is None:
        return {}
    counts = (
        f"{edits.kept} kept, {edits.moved} moved, {edits.changed} changed, {edits.added} added, {edits.deleted} deleted"
    )
    if edits.as_given:
        counts += f", {edits.as_given} as given"
    return {"Edited by hand": "; ".join([f"{edits.file}: {counts}", *edits.notes])}
