"""Whether a drive does above the band of vibration what nothing asks of it.

What the band leaves out is hardly felt, so no comparison of what is felt shows it: a tone of 3 kHz at a fifth of the
limit lies 47 dB beneath the shot. Nor does the energy of a drive there, since one that turns over between its limits
has as much. But where it is free of its limit for a while, it is the compensator's drive but for what is smooth, or
finer than its corners tell.
"""

import numpy as np

from .. import dsp
from .comparison import Comparison
from .due import FAINT, STRETCH_MS, in_stretches, rms_of
from .feeling import Felt
from .hearing import Heard


def added_above_band(shared: Comparison, heard: Heard, felt: Felt) -> float | None:
    """Return what a solved drive has above the band beside the compensator's, as a share of all of that.

    In the worst stretch that is free of the limit, between others that are; None where there is none, or where the
    making of the drive is known sample for sample.
    """
    if not heard.solved or shared.above_band is None:
        return None
    length = shared.samples(STRETCH_MS)
    where = slice(heard.core.start, max(heard.core.start, heard.core.stop - shared.memory))
    free = np.asarray(in_stretches(felt.free[where].astype(np.float64), length).min(axis=1) == 1.0)
    calm = free[:-2] & free[1:-1] & free[2:]
    if not calm.any():
        return None
    wet = heard.gain * heard.wet
    beside = dsp.run_filter(shared.above_band, felt.drive - wet)
    added, asked = (rms_of(in_stretches(samples[where], length))[1:-1][calm] for samples in (beside, wet))
    return float(np.max(added / (asked + FAINT)))
