"""The tables of an actuator profile."""

from typing import Annotated, Literal

from msgspec import Meta

from .table import Positive, Table


class LowPass(Table, frozen=True):
    """The Butterworth low-pass that follows the compensator: its `corner_hz` and its `order`."""

    corner_hz: Positive
    order: Annotated[int, Meta(ge=1, le=12)]


class HighPass(Table, frozen=True):
    """The Butterworth high-pass that keeps DC and rumble out of the drive: its `corner_hz` and its `order`."""

    corner_hz: Annotated[float, Meta(ge=0.1)]
    order: Annotated[int, Meta(ge=1, le=4)]


class Response(Table, frozen=True):
    """The felt response of actuator and skin together, H(s) = gain * prod(s - zero) / prod(s - pole).

    `gain` is that of the formula, `zeros_rad_s` and `poles_rad_s` its zeros and poles as [real, imaginary] pairs;
    complex ones are listed with their conjugate.
    """

    gain: Annotated[float, Meta(gt=0.0)]
    zeros_rad_s: tuple[tuple[float, float], ...]
    poles_rad_s: Annotated[tuple[tuple[float, float], ...], Meta(min_length=1)]


class ActuatorProfile(Table, frozen=True):
    """`actuators/*.toml`: a seat actuator with the skin behind it, the filters its drive needs, and its `name`."""

    schema: Literal[1]
    name: Annotated[str, Meta(min_length=1)]
    response: Response
    lowpass: LowPass
    highpass: HighPass
