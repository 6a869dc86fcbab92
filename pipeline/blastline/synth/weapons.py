"""The weapons: how large their blast is, and what else one hears when they fire.

Ranges, not portraits: the same gun on and off its axis differs more than two guns (Beck, Nakasone and Marr 2011), and
shots of one gun differ too (Maher 2006). Positive phases near the muzzle are 0.3-0.6 ms for a pistol and 1-3 ms for
a large rifle or a shotgun; cyclic rates are 450-1200 rounds a minute.
"""

from dataclasses import dataclass
from typing import Literal

WeaponName = Literal["pistol", "rifle", "shotgun", "smg", "lmg", "suppressed"]


@dataclass(frozen=True)
class Weapon:
    """The ranges from which a weapon is drawn; levels in dB are against the peak of its blast."""

    positive_ms: tuple[float, float]
    rise_ms: tuple[float, float]
    jet_db: tuple[float, float]
    jet_decay_ms: tuple[float, float]
    mechanics_db: tuple[float, float]
    supersonic: float
    rpm: tuple[float, float] | None
    muffle: tuple[float, float] = (0.4, 1.0)


WEAPONS: dict[WeaponName, Weapon] = {
    "pistol": Weapon((0.28, 0.8), (0.02, 0.2), (-22.0, 0.0), (0.5, 8.0), (-45.0, -12.0), 0.15, None),
    "rifle": Weapon((0.5, 2.2), (0.02, 0.25), (-22.0, 2.0), (0.8, 14.0), (-50.0, -18.0), 0.55, (500.0, 900.0)),
    "shotgun": Weapon((0.9, 3.2), (0.03, 0.4), (-18.0, 3.0), (1.0, 20.0), (-50.0, -18.0), 0.0, None),
    "smg": Weapon((0.28, 0.9), (0.02, 0.2), (-20.0, 0.0), (0.5, 8.0), (-35.0, -8.0), 0.1, (450.0, 1_200.0)),
    "lmg": Weapon((0.6, 2.5), (0.02, 0.3), (-20.0, 2.0), (0.8, 14.0), (-40.0, -12.0), 0.4, (500.0, 1_000.0)),
    "suppressed": Weapon(
        (0.3, 1.6), (0.2, 2.0), (-10.0, 8.0), (1.0, 16.0), (-24.0, -3.0), 0.1, (450.0, 900.0), (0.08, 0.5)
    ),
}
