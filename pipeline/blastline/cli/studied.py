"""The tables of `study rendering` and `study segmentation`."""

from typing import TYPE_CHECKING, Final, get_args

from ..model import Phase

if TYPE_CHECKING:
    from ..study.rendering import RenderingScore
    from ..study.segmentation import Interval, SegmentationScore

_DRIVES: Final = ("direct", "clipped", "scaled", "constrained")


def rendering_table(score: "RenderingScore") -> str:
    """Return the weak shots with their drives, the means, the optima and the bars."""
    lines = [
        f"quality {score.quality}, {score.actuator}: {len(score.shots['causal'])} of {score.all_shots} shots are weak:",
        "felt at less than half in direct conversion, and the compensator exceeds the limit",
        "ratio: felt rms / that of the sound in the band; corr: their correlation; lag of the constrained drive, ms",
        "",
        f"{'':<22} {'needs':>6}" + "".join(f" {name:>13}" for name in _DRIVES) + f" {'lag':>7} {'steps':>5}",
        f"{'':<22} {'x':>6}" + "  ratio   corr" * len(_DRIVES),
    ]
    for row in score.shots["causal"]:
        cells = "".join(f" {row.felt[name].ratio:6.3f} {row.felt[name].correlation:6.3f}" for name in _DRIVES)
        lag_ms = row.felt["constrained"].lag_ms
        lines.append(f"{row.scene[:12]:<12} {row.onset_s:7.3f} s {row.needed:6.2f}{cells} {lag_ms:7.3f} {row.steps:5d}")
    for phase in get_args(Phase):
        lines += ["", f"means, phase {phase}"]
        for scene in (*dict.fromkeys(row.scene for row in score.shots[phase]), None):
            means = [score.means(phase, name, scene) for name in _DRIVES]
            cells = "".join(f" {each.ratio:6.3f} {each.correlation:6.3f}" for each in means)
            lines.append(f"{scene or 'all':<29}{cells} {means[-1].lag_ms:7.3f}")
    return "\n".join([*lines, "", *map(str, score.bars)])


def segmentation_table(score: "SegmentationScore") -> str:
    """Return how the reflections were found at true and at found onsets, and the bars."""

    def drawn(figure: "Interval") -> str:
        return f"{figure.value:.3f} ({figure.low:.3f}-{figure.high:.3f})"

    lines = [f"quality {score.quality}, {score.films} films; reflections at 2 ms, 8-500 ms after the onset", ""]
    lines += [f"{'':<16} {'heard':>6} {'precision':>10} {'recall':>8}  F1 and 95 % of draws"]
    for name, at in (("true onsets", score.at_true), ("found onsets", score.at_found)):
        strong = f"{at.asked:6d} {at.precision:10.3f} {at.recall:8.3f}  {drawn(at.f1)}"
        every = f"{at.every_asked:6d} {at.every_precision:10.3f} {at.every_recall:8.3f}  {drawn(at.every_f1)}"
        lines += [f"{name}, {at.shots} shots", f"{'  from -12 dB on':<16} {strong}", f"{'  every':<16} {every}"]
    lines += [
        "",
        f"{score.echoes_as_shots} of {score.echoes_heard} echoes are among the {score.found_shots} found shots",
    ]
    return "\n".join([*lines, "", *(str(bar) for bar in score.bars)])
