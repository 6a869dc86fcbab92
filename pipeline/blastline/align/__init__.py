"""Checks between soundtrack, drive and timeline, on the files as they were written.

    the film    same rate and length, within the limit, still outside windows, neither displaced nor at another speed
    each shot   window whole, attack on time, lag, likeness, level and pre-echo of what is felt, and the drive
                  against what is due of it, to its end

What is felt is predicted: the drive through H, the response of actuator and skin. It is compared with the sound in the
band of vibration. Where the actuator is at its limit no drive can follow the sound, and so the drive is compared with
what is due of it (`due`): that makes displacement by a single sample, a late start and a pre-echo visible even in
saturated shots. A check that cannot tell passes, with nothing measured.
"""

from .checks import check_files, check_timeline
from .sanity import changed_shots

__all__ = ["changed_shots", "check_files", "check_timeline"]
