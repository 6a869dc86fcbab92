"""What is measured before a drive model is chosen."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SceneEvidence:
    """What the cheap drive models would do in a window, measured before one is chosen.

    `direct_level_db` is the level of the perceived vibration under direct conversion against the target, the sound in
    the band; `direct_fidelity` their correlation; `filter_peak` the compensator's peak against the actuator's limit.
    """

    direct_level_db: float
    direct_fidelity: float
    filter_peak: float
