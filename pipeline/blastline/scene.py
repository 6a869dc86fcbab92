"""What a scene requires: the cheapest drive model that is good enough, with the reason in figures."""

from .model import DriveChoice, DriveModel, SceneEvidence
from .ruleset import SceneRules


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
    peak = f"the compensator's peak is {evidence.filter_peak:.3g} of the limit"
    if evidence.filter_peak <= 1.0:
        return "filter", f"{level} {alike}; {peak}"
    return "constrained", f"{level} {alike}; {peak}, which is too much"
