"""The rules by which an actuator is measured, and the curves of what the skin perceives."""

from typing import Annotated, Literal

from msgspec import Meta

from .table import Count, Positive, Ratio, Table, ascending


class IdentifyRules(Table, frozen=True):
    """How a frequency response is estimated from two recordings, and what of it counts as known.

    The segments are the longest of `segments_s` of which there are `fewest_segments`. The response may be late by
    `longest_delay_s`. The usable band, `highest_hz` at most, is where the gain, averaged over a third of an octave, has
    a standard error of at most `random_error_db` and the coherence is at least `least_coherence`. A response of which
    `clipped_ratio` stands at its peak is refused; so is an excitation if it was clipped after it was sent.
    """

    segments_s: Annotated[tuple[Annotated[float, Meta(ge=0.1, le=60.0)], ...], Meta(min_length=1)]
    fewest_segments: Annotated[int, Meta(ge=4, le=10_000)]
    longest_delay_s: Annotated[float, Meta(ge=0.001, le=10.0)]
    highest_hz: Annotated[float, Meta(ge=20.0, le=1e6)]
    random_error_db: Positive
    least_coherence: Ratio
    clipped_ratio: Ratio


class FitRules(Table, frozen=True):
    """How a measured response becomes a rational model, and which band filters its profile gets.

    What lies more than `largest_gain_db` below the peak is taken as no weaker than that, so that the inverse is
    bounded. Models of up to `most_poles` compete; a further one has to be worth it by Schwarz's criterion, to which an
    error of `negligible_db` is none. Nothing above `highest_hz` is fitted. The profile's low-pass is at `band_hz`, or
    where what is known ends, if lower; its high-pass at the lowest known frequency, at least `rumble_hz`.
    """

    largest_gain_db: Annotated[float, Meta(ge=6.0, le=120.0)]
    most_poles: Annotated[Count, Meta(le=11)]
    negligible_db: Positive
    highest_hz: Positive
    band_hz: Positive
    rumble_hz: Annotated[float, Meta(ge=0.1, le=1e6)]

    def __post_init__(self) -> None:
        """Refuse a high-pass that leaves nothing of the band below the low-pass, or above what is fitted."""
        ascending(self, "rumble_hz", "band_hz")
        ascending(self, "rumble_hz", "highest_hz")


class MeasuringRules(Table, frozen=True):
    """`measuring.toml`."""

    schema: Literal[1]
    identify: IdentifyRules
    fit: FitRules


class PerceptionCurve(Table, frozen=True):
    """`perception/*.toml` (a user's may be `*.csv`): an absolute threshold of vibration over frequency.

    `threshold_db` is the level of the weakest sinusoid that is felt, in dB against any reference: the sensitivity is
    scaled to a peak of 1. The curve holds from its first frequency to its last.
    """

    schema: Literal[1]
    name: Annotated[str, Meta(min_length=1)]
    frequencies_hz: Annotated[tuple[Positive, ...], Meta(min_length=2)]
    threshold_db: Annotated[tuple[Annotated[float, Meta(ge=-400.0, le=400.0)], ...], Meta(min_length=2)]

    def __post_init__(self) -> None:
        """Refuse columns of different lengths and frequencies that do not ascend."""
        if len(self.frequencies_hz) != len(self.threshold_db):
            lengths = f"{len(self.frequencies_hz)} and {len(self.threshold_db)} values"
            raise ValueError(f"frequencies_hz, threshold_db have {lengths}: expected as many of both")
        for before, after in zip(self.frequencies_hz, self.frequencies_hz[1:], strict=False):
            if after <= before:
                raise ValueError(f"frequencies_hz has {after:g} after {before:g}: expected ascending frequencies")
