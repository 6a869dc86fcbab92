"""What the owners of the haptic formats ask of a file, written from their public rules; and a reader of each.

    AHAP     developer.apple.com: Representing haptic patterns in AHAP files, CHHapticEvent.duration,
             CHHapticParameterCurve.ControlPoint.relativeTime; 16 points a curve as Lofelt's converter wrote
    .haptic  meta-haptics-sdk: resources/haptic-file-spec.md and the strict mode of its validator
    HJIF     MPEG's reference software: what its loader and its conformance checks refuse

Nothing here imports what writes the files. Each `..._played` returns what a player makes of a file.
"""

import itertools
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Json = dict[str, Any]
Points = list[tuple[float, float]]


@dataclass(frozen=True)
class Played:
    """What a player makes of a file: (time in s, amplitude) of pulses; amplitude and frequency as broken lines.

    The amplitude is the given power of its line.
    """

    pulses: Points
    amplitude: Points
    frequency: Points
    power: int = 1

    def amplitude_at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return _line(self.amplitude, times_s) ** self.power

    def frequency_at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return _line(self.frequency, times_s)


def _line(points: Points, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
    if not points:
        return np.zeros(len(times_s))
    line = np.interp(times_s, [time_s for time_s, _ in points], [value for _, value in points])
    return np.asarray(line, dtype=np.float64)


def strict_json(path: Path) -> Any:
    def refuse(name: str) -> None:
        raise AssertionError(f"{path}: {name} is not JSON")

    text = path.read_bytes().decode("utf-8")
    assert not text.startswith("\ufeff")
    return json.loads(text, parse_constant=refuse)


# --- AHAP

EVENT_PARAMETERS = {"HapticIntensity": (0.0, 1.0), "HapticSharpness": (0.0, 1.0)}
CURVE_PARAMETERS = {"HapticIntensityControl": (0.0, 1.0), "HapticSharpnessControl": (-1.0, 1.0)}


def ahap_played(continuous: Path, transients: Path) -> Played:
    """Check both files and play them; amplitude is the square of intensity, frequency the sharpness."""
    events, curves = _ahap(continuous)
    pulses, none = _ahap(transients)
    assert {event["EventType"] for event in events} == {"HapticContinuous"}
    assert {event["EventType"] for event in pulses} == {"HapticTransient"}
    assert none == []
    for event, following in itertools.pairwise(events):
        assert event["Time"] + event["EventDuration"] <= following["Time"] + 1.1e-6
    intensity = _ahap_line(curves, "HapticIntensityControl")
    covered = [(event["Time"] - 1.1e-6, event["Time"] + event["EventDuration"] + 1.1e-6) for event in events]
    for time_s, _ in intensity:
        assert any(start <= time_s <= stop for start, stop in covered), time_s
    full = [_ahap_parameters(event)["HapticIntensity"] for event in events]
    assert set(full) <= {0.0, 1.0}
    return Played(
        [(event["Time"], _ahap_parameters(event)["HapticIntensity"] ** 2) for event in pulses],
        intensity,
        _ahap_line(curves, "HapticSharpnessControl"),
        power=2,
    )


def _ahap(path: Path) -> tuple[list[Json], list[Json]]:
    whole = strict_json(path)
    assert set(whole) == {"Version", "Pattern"}
    assert whole["Version"] == 1.0
    assert any("Event" in entry for entry in whole["Pattern"]), "each pattern contains one or more events"
    events, curves = [], []
    for entry in whole["Pattern"]:
        [kind] = entry
        if kind == "Event":
            events.append(_ahap_event(entry[kind]))
        else:
            assert kind == "ParameterCurve"
            curves.append(_ahap_curve(entry[kind]))
    assert [event["Time"] for event in events] == sorted(event["Time"] for event in events)
    return events, curves


def _ahap_event(event: Json) -> Json:
    assert event["Time"] >= 0.0
    if event["EventType"] == "HapticContinuous":
        assert 0.0 < event["EventDuration"] <= 30.0
    else:
        assert "EventDuration" not in event
    for name, value in _ahap_parameters(event).items():
        low, high = EVENT_PARAMETERS[name]
        assert low <= value <= high
    return event


def _ahap_parameters(event: Json) -> dict[str, float]:
    return {each["ParameterID"]: each["ParameterValue"] for each in event["EventParameters"]}


def _ahap_curve(curve: Json) -> Json:
    points = curve["ParameterCurveControlPoints"]
    low, high = CURVE_PARAMETERS[curve["ParameterID"]]
    assert curve["Time"] >= 0.0
    assert 1 <= len(points) <= 16
    assert points[0]["Time"] == 0.0, "times are relative to the curve's"
    times_s = [point["Time"] for point in points]
    assert times_s == sorted(set(times_s))
    assert all(low <= point["ParameterValue"] <= high for point in points)
    return curve


def _ahap_line(curves: list[Json], parameter: str) -> Points:
    """Return a parameter over time, its curves one after the other; where two meet they must agree."""
    line: Points = []
    for curve in curves:
        if curve["ParameterID"] != parameter:
            continue
        points = [
            (curve["Time"] + point["Time"], point["ParameterValue"]) for point in curve["ParameterCurveControlPoints"]
        ]
        if line and abs(points[0][0] - line[-1][0]) < 1e-9:
            assert points[0][1] == line[-1][1]
            points = points[1:]
        elif line:
            assert points[0][0] > line[-1][0]
            # a player holds what it was told last: between curves that do not meet nothing may sound
            assert parameter != "HapticIntensityControl" or line[-1][1] == 0.0
        line += points
    return line


# --- .haptic


def haptic_played(path: Path) -> Played:
    """Check one file as a reader with 32-bit numbers does, and play it; times count from the reel's start."""
    whole = strict_json(path)
    assert whole["version"] == {"major": 1, "minor": 0, "patch": 0}
    assert set(whole["metadata"]) <= {"author", "editor", "source", "project", "tags", "description"}
    envelopes = whole["signals"]["continuous"]["envelopes"]
    amplitude, frequency = envelopes["amplitude"], envelopes["frequency"]
    times_s = [_float32(point["time"]) for point in amplitude]
    assert len(times_s) >= 2
    assert times_s == sorted(times_s)
    assert times_s[0] >= 0.0
    assert times_s[-1] > times_s[0]
    pulses: Points = []
    for time_s, point in zip(times_s, amplitude, strict=True):
        assert set(point) <= {"time", "amplitude", "emphasis"}
        value = _float32(point["amplitude"])
        assert 0.0 <= value <= 1.0
        if "emphasis" in point:
            emphasis = point["emphasis"]
            assert set(emphasis) == {"amplitude", "frequency"}
            assert value <= _float32(emphasis["amplitude"]) <= 1.0
            assert 0.0 <= _float32(emphasis["frequency"]) <= 1.0
            pulses.append((time_s, emphasis["amplitude"]))
    toned_s = [_float32(point["time"]) for point in frequency]
    assert toned_s == sorted(toned_s)
    assert all(times_s[0] <= time_s <= times_s[-1] for time_s in toned_s)
    assert all(0.0 <= point["frequency"] <= 1.0 for point in frequency)
    line = [(time_s, point["amplitude"]) for time_s, point in zip(times_s, amplitude, strict=True)]
    return Played(pulses, line, [(t, point["frequency"]) for t, point in zip(toned_s, frequency, strict=True)])


def _float32(value: float) -> float:
    return float(np.float32(value))


# --- HJIF

MODALITIES = {"Vibrotactile", "Acceleration", "Force", "Pressure"}
DEVICES = {"Unknown", "LRA", "VCA", "ERM", "Piezo"}
KEYWORDS = {"WeaponCombat/Gun", "WeaponCombat/Machinegun"}
TRANSIENT_S = 0.022


def hjif_played(path: Path) -> list[Played]:
    """Check a file as MPEG's loader and conformance checks do, and play each channel; amplitude of waves and pulses."""
    whole = strict_json(path)
    needed = {"version", "profile", "level", "date", "description", "timescale", "avatars", "perceptions", "syncs"}
    assert set(whole) == needed
    assert re.fullmatch(r"(\d{4})(-[1-9])?", whole["version"])
    assert int(whole["version"][:4]) >= 2023
    assert (whole["profile"], whole["level"], whole["timescale"]) == ("Main", 1, 1000)
    assert re.fullmatch(r"\d{4}(-[01]\d(-[0-3]\d)?)?", whole["date"])
    assert whole["avatars"] == []
    assert all(_whole(sync["timestamp"]) and _whole(sync["timescale"]) for sync in whole["syncs"])
    [perception] = whole["perceptions"]
    return _hjif_perception(perception)


def _hjif_perception(perception: Json) -> list[Played]:
    assert _whole(perception["id"])
    assert perception["avatar_id"] == 0
    assert isinstance(perception["description"], str)
    assert perception["perception_modality"] in MODALITIES
    assert perception["effect_library"] == []
    assert "effect_semantic_scheme" not in perception, "the checker refuses any"
    devices = perception.get("reference_devices", [])
    for device in devices:
        assert device["id"] >= 1
        assert isinstance(device["name"], str)
        assert 0.0 <= device["minimum_frequency"] <= device["maximum_frequency"]
        assert device["type"] in DEVICES
    ids = [device["id"] for device in devices]
    assert len(set(ids)) == len(ids)
    channels = perception["channels"]
    assert 1 <= len(channels) <= 127
    assert len({channel["id"] for channel in channels}) == len(channels)
    assert {channel["reference_device_id"] for channel in channels} <= set(ids)
    assert [channel["body_part_mask"] for channel in channels] == [0x300, 0xC00080]
    return [_hjif_channel(channel) for channel in channels]


def _hjif_channel(channel: Json) -> Played:
    assert _whole(channel["id"])
    assert isinstance(channel["description"], str)
    assert (channel["gain"], channel["mixing_coefficient"]) == (1.0, 1.0)
    transients, waves = channel["bands"]
    assert (transients["band_type"], waves["band_type"]) == ("Transient", "VectorialWave")
    for band in (transients, waves):
        assert "curve_type" not in band
        assert "block_length" not in band
        assert _whole(band["lower_frequency_limit"])
        assert band["lower_frequency_limit"] <= band["upper_frequency_limit"]
        assert len(band["effects"]) <= 65_535
        positions = [_hjif_effect(effect, band) for effect in band["effects"]]
        assert positions == sorted(positions)
    pulses = [(e["position"] / 1000.0, e["keyframes"][0]["amplitude_modulation"]) for e in transients["effects"]]
    for effect in transients["effects"]:
        assert effect.get("semantic_keywords", "WeaponCombat/Gun") in KEYWORDS
    played = Played(pulses, *_hjif_waves(waves["effects"]))
    _within_one(played)
    return played


def _hjif_effect(effect: Json, band: Json) -> int:
    # phase and base_signal: some versions of the loader drop an effect without them, and say so only on stderr
    assert {"effect_type", "position", "phase", "base_signal", "keyframes"} <= set(effect)
    assert (effect["effect_type"], effect["base_signal"]) == ("Basis", "Sine")
    position: int = effect["position"]
    assert _whole(position)
    assert position < 2**25
    keyframes = effect["keyframes"]
    assert 1 <= len(keyframes) <= 65_535
    assert "amplitude_modulation" in keyframes[0], "without it the reference player never ends"
    places = [keyframe["relative_position"] for keyframe in keyframes]
    assert all(_whole(place) for place in places)
    assert places == sorted(set(places))
    assert places[0] == 0
    assert places[-1] <= 65_535
    for keyframe in keyframes:
        assert 0.0 <= keyframe.get("amplitude_modulation", 0.0) <= 1.0
        tone = keyframe.get("frequency_modulation", band["lower_frequency_limit"])
        assert isinstance(tone, int)
        assert band["lower_frequency_limit"] <= tone <= band["upper_frequency_limit"], "the player clamps it"
    return position


def _hjif_waves(effects: list[Json]) -> tuple[Points, Points]:
    lines: dict[str, Points] = {"amplitude_modulation": [], "frequency_modulation": []}
    for effect in effects:
        for key, line in lines.items():
            places = [frame["relative_position"] for frame in effect["keyframes"] if key in frame]
            assert places[0] == 0
            assert places[-1] == effect["keyframes"][-1]["relative_position"]
            assert not line or line[-1][0] <= effect["position"] / 1000.0, "a band plays one wave at a time"
            line += [
                ((effect["position"] + frame["relative_position"]) / 1000.0, frame[key])
                for frame in effect["keyframes"]
                if key in frame
            ]
    return lines["amplitude_modulation"], lines["frequency_modulation"]


def _within_one(played: Played) -> None:
    """Check that transients and waves together never ask for more than the player can give."""
    if not played.pulses:
        return
    starts = np.array([time_s for time_s, _ in played.pulses])
    strengths = np.array([strength for _, strength in played.pulses])
    times_s = np.unique((starts[:, None] + np.linspace(0.0, TRANSIENT_S, 23)).ravel())
    sounding = (times_s[:, None] >= starts - 1e-9) & (times_s[:, None] <= starts + TRANSIENT_S + 1e-9)
    assert np.max(played.amplitude_at(times_s) + sounding @ strengths) <= 1.0 + 1e-9


def _whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0
