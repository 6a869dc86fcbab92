"""What a scene requires: the cheapest way that is good enough, with the reason in figures.

`choose`, for each window
    drive         is direct conversion close already, does the compensator fit the limit
`decisions`, for each event, as detection took them
    verifier      was the candidate clear after the first network
    reflections   can there be any that is worth a segment
    window        how long the decay needs it to be
"""

from collections.abc import Iterator

import msgspec

from .model import FIRE, DecayEnd, Decision, DriveChoice, DriveModel, Reflection, SceneEvidence, Shot, ShotEvidence
from .ruleset import QualityRules, SceneRules
from .units import ms_from_samples, share_text

_ENDED: dict[DecayEnd, str] = {
    "fallen": "its level has fallen by {decay_db:g} dB by then",
    "background": "its level has come down to the background by then",
    "next sound": "another sound begins by then",
    "longest": "it is still heard at the longest that is rendered, or at the film's end",
    "last reflection": "its last reflection is over by then",
}


def choose(evidence: SceneEvidence, rules: SceneRules, choice: DriveChoice) -> tuple[DriveModel, str]:
    """Return the drive model for a window and why.

    "auto" takes direct conversion where it is felt nearly as strong as the target and follows it, else the filter
    where its peak stays within the actuator's limit, else the constrained drive. Any other choice is taken as it is.

    >>> rules = SceneRules("a study", 1, direct_level_db=1.0, direct_fidelity=0.9)
    >>> choose(SceneEvidence(direct_level_db=-12.0, direct_fidelity=0.8, filter_peak=0.5), rules, "auto")[0]
    'filter'
    """
    if choice != "auto":
        return choice, "asked for"
    level = f"direct conversion is felt {evidence.direct_level_db:+.1f} dB against the target"
    alike = f"with a correlation of {evidence.direct_fidelity:.3f}"
    near = abs(evidence.direct_level_db) <= rules.direct_level_db
    if near and evidence.direct_fidelity >= rules.direct_fidelity:
        return "direct", f"{level} {alike}, which is close enough"
    peak = f"the compensator's peak is {share_text(evidence.filter_peak)} of the limit"
    if evidence.filter_peak <= 1.0:
        return "filter", f"{level} {alike}; {peak}"
    return "constrained", f"{level} {alike}; {peak}, which is too much"


def decisions(shot: Shot, tier: QualityRules, *, rate_hz: int) -> tuple[Decision, ...]:
    """Return how closely a shot was looked at and why; nothing for one of which that is not known."""
    if shot.evidence is None:
        return ()
    return (
        *_verifier(shot.evidence, shot.confidence, tier),
        _reflections(shot.evidence, shot.reflections, tier),
        _window(shot.evidence.decay_end, ms_from_samples(len(shot.span), rate_hz), tier),
    )


def _verifier(measured: ShotEvidence, confidence: float, tier: QualityRules) -> Iterator[Decision]:
    """Yield how many networks judged; nothing where no screen did, because somebody else found the shot."""
    if measured.screen is None:
        return
    evidence = {"screen": measured.screen, "confidence": confidence}
    said = f"the screen gives it {measured.screen:.4g}"
    if measured.even_row in FIRE:
        said += ", and all of its even row together sound like gunfire"
    if measured.networks == 1:
        left = "one network is all that this quality asks" if tier.verify.networks == 1 else "a network left no doubt"
        yield Decision("verifier", "one network", f"{said}; {left}", evidence)
    else:
        reason = f"{said}; the network before left room for doubt"
        yield Decision("verifier", f"{measured.networks} networks", reason, evidence)


def _reflections(measured: ShotEvidence, found: tuple[Reflection, ...], tier: QualityRules) -> Decision:
    least_db, room_db = tier.segment.reflection_level_db, measured.echo_room_db
    if room_db is None or least_db is None:
        return _found_as_sounds(found, {}) or Decision(
            "reflections", "none looked for", "this quality does without", {}
        )
    room = f"what follows, over as long a time, is at most {room_db:.1f} dB against the blast"
    evidence = {"echo_room_db": room_db, "reflections": float(len(found))}
    if room_db < least_db:
        nothing = Decision("reflections", "none looked for", f"{room}, too little for a reflection", evidence)
        return _found_as_sounds(found, evidence) or nothing
    if not found and measured.copies:
        many = "what copies it is a later shot" if measured.copies == 1 else "what copies it are later shots"
        return Decision("reflections", "none", f"{room}, but {many}, or an echo of one", evidence)
    if not found:
        return Decision("reflections", "none", f"{room}, but nothing in it that stands out is a copy", evidence)
    return _told(found, evidence)


def _found_as_sounds(found: tuple[Reflection, ...], evidence: dict[str, float]) -> Decision | None:
    """Return what is said of reflections that nobody looked for: softer sounds that copy the shot; None for none."""
    if not found:
        return None
    told = _told(found, evidence | {"reflections": float(len(found))})
    own = "a sound of its own" if len(found) == 1 else "sounds of their own"
    return msgspec.structs.replace(told, reason=f"{told.reason}; found as {own}, no others looked for")


def _told(found: tuple[Reflection, ...], evidence: dict[str, float]) -> Decision:
    loudest = max(found, key=lambda echo: echo.level_db)
    evidence = evidence | {"level_db": loudest.level_db, "delay_ms": loudest.delay_ms}
    many = "1 copies" if len(found) == 1 else f"{len(found)} copy"
    reason = f"{many} the blast, the loudest {loudest.level_db:.1f} dB against it after {loudest.delay_ms:.1f} ms"
    return Decision("reflections", "segmented", reason, evidence)


def _window(ended: DecayEnd, decay_ms: float, tier: QualityRules) -> Decision:
    reason = _ENDED[ended].format(decay_db=tier.segment.decay_db)
    return Decision("window", f"{decay_ms:.0f} ms", reason, {"decay_ms": decay_ms})
