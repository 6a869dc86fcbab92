"""The table of `study rendering`."""

from typing import TYPE_CHECKING, Final, get_args

from ..model import Phase

if TYPE_CHECKING:
    from ..study.rendering import RenderingScore

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
