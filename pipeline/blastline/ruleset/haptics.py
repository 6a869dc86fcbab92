"""The rules by which the drive becomes haptic formats."""

from typing import Annotated, Literal

from msgspec import Meta

from .table import NonNegative, Ratio, Table


class HapticRules(Table, frozen=True):
    """`haptics.toml`: how the drive becomes the breakpoints of the haptic formats.

    The amplitude is sqrt(2) times the RMS over `average_ms`, read every `step_ms`; the frequency the mean of the
    spectrum over the next `spectrum_ms`, read every `spectrum_step_ms`. Straight lines between breakpoints stay within
    `amplitude_error` of full scale, and within `frequency_error`, a part of the frequency. An echo is a pulse where its
    attack reaches `least_echo` of the actuator's limit, `echo_apart_ms` after the pulse before it. A `.haptic` file
    covers about `reel_s` of the film.
    """

    schema: Literal[1]
    average_ms: Annotated[float, Meta(ge=1.0, le=100.0)]
    step_ms: Annotated[float, Meta(ge=1.0, le=20.0)]
    spectrum_ms: Annotated[float, Meta(ge=5.0, le=200.0)]
    spectrum_step_ms: Annotated[float, Meta(ge=1.0, le=50.0)]
    amplitude_error: Annotated[float, Meta(gt=0.0, le=0.2)]
    frequency_error: Annotated[float, Meta(gt=0.0, le=1.0)]
    least_echo: Ratio
    echo_apart_ms: NonNegative
    reel_s: Annotated[float, Meta(ge=10.0, le=960.0)]
