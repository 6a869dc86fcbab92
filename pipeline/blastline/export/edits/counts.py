"""Whole numbers that count something else than the film's samples, told by the original: no row says what it counts.

A ruler that shows frames, or the samples of a project at another rate, writes times that are those of the original
multiplied by one factor.

    original  | 595201  948000  1305604      samples at 48 kHz
    file      |    310     494      680      frames at 25 a second
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction

from ...errors import TimelineError
from ...timecode import STANDARD_RATES
from .row import EditedFile, Pair

_PROJECT_RATES_HZ = (8000, 11_025, 16_000, 22_050, 32_000, 44_100, 48_000, 88_200, 96_000, 176_400, 192_000)


def refuse_other_counts(edited: EditedFile, pairs: Sequence[Pair], *, rate_hz: int) -> None:
    """Raise TimelineError where most rows of a file that shows samples are where their originals are in another count.

    A row whose number fits its original as it is, to one, tells nothing.
    """
    rows = [(pair, pair.edit.onset.sample, pair.was.onset_sample) for pair in pairs if pair.was is not None]
    for count_hz, said in _counts(rate_hz):
        scaled = [
            pair
            for pair, number, onset in rows
            if number is not None and abs(number - onset) > 1 and abs(number - onset * count_hz / rate_hz) <= 1
        ]
        if 2 * len(scaled) > len(rows):
            edit = scaled[0].edit
            raise TimelineError(
                f"{edited.path}: {edit.place}: {edit.onset.said[0]}: counts {said}, as the original's times tell; "
                f"expected seconds, or samples at {rate_hz} Hz: set the ruler to seconds and export again"
            )


def _counts(rate_hz: int) -> Iterator[tuple[Fraction, str]]:
    """Yield what a ruler may count, in numbers a second, and in words."""
    for rate in STANDARD_RATES:
        yield rate, "frames"
    for project_hz in _PROJECT_RATES_HZ:
        if project_hz != rate_hz:
            yield Fraction(project_hz), f"samples at {project_hz} Hz"
