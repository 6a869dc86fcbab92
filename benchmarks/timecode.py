"""Timecode against opentimelineio for every frame of 24 hours: `python benchmarks/timecode.py`.

29.97 and 59.94 drop-frame, and the rates without it; the tests hold a dense sample of the same. Prints how many frames
were compared and how many differ, and ends with 1 where one does. About two minutes. At 29.97 without drop-frame
opentimelineio starts again after 24 hours of real time, at 23:58:33:18, so the comparison ends there.
"""

import sys
import time
from argparse import ArgumentParser
from fractions import Fraction

from opentimelineio.opentime import RationalTime, from_timecode

from blastline.timecode import frame_of, frames_per_day, label

RATES = [
    ("29.97 DF", Fraction(30_000, 1001), True),
    ("59.94 DF", Fraction(60_000, 1001), True),
    ("29.97 NDF", Fraction(30_000, 1001), False),
    ("24", Fraction(24), False),
    ("25", Fraction(25), False),
]


def differences(rate: Fraction, *, drop_frame: bool) -> tuple[int, int]:
    """Return how many frames a day has, and how many of them we and opentimelineio name or number differently."""
    nominal, rate_hz = -(-rate.numerator // rate.denominator), float(rate)
    frames, differ = frames_per_day(nominal, drop_frame=drop_frame or rate.denominator != 1), 0
    for frame in range(frames):
        text = label(frame, nominal, drop_frame=drop_frame)
        theirs = RationalTime(frame, rate_hz)
        same = text == theirs.to_timecode(rate_hz, drop_frame)
        same = same and frame == frame_of(text, nominal, drop_frame=drop_frame)
        differ += not (same and from_timecode(text, rate_hz).value == frame)
    return frames, differ


def main() -> int:
    """Write a line for each rate and return how many frames differ."""
    ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    wrong = 0
    for name, rate, drop_frame in RATES:
        started = time.perf_counter()
        frames, differ = differences(rate, drop_frame=drop_frame)
        wrong += differ
        print(f"{name:<10} {frames:>9} frames, {differ} differ, {time.perf_counter() - started:.0f} s", flush=True)
    return wrong


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
