"""Over how much of a file its sound reaches, where the file does not say how long it is.

What is lost before the first packet of sound or behind the last one leaves no gap between time stamps, and a transport
stream may go on with its sound in a stream that nobody knew of at the start. The bytes tell:

file   [ ~ 5 s without sound ][sound][picture][sound][picture] ... [sound][ ~ 9 s without sound ]
"""

from dataclasses import dataclass
from pathlib import Path

_LEAST_S = 2.0
"""Pictures and sound that play together lie less than this apart; so may either end before the other."""

_STEPS = 2
"""So many times the longest distance between packets of sound may lie before the first and behind the last."""

_TAGS = (b"ID3", b"TAG", b"APETAGEX", b"LYRICSBEGIN")
"""What programs put before and behind bare sound."""


@dataclass
class Reach:
    """Where in a file the packets of a stream begin, in bytes."""

    first: int | None = None
    last: int = 0
    last_bytes: int = 0
    longest_step: int = 0

    def note(self, place: int | None, size: int) -> None:
        """Add the packet that follows; some share a place with the one before and have none of their own."""
        if place is None or place < self.last:
            return
        if self.first is None:
            self.first = place
        else:
            self.longest_step = max(self.longest_step, place - self.last)
        self.last, self.last_bytes = place, size

    def warnings(self, path: Path, played_s: float) -> list[str]:
        """Return a line for each end of a file of which much holds no sound; `played_s` is how long the sound is."""
        if self.first is None:
            return []
        file_bytes = path.stat().st_size
        with path.open("rb") as file:
            head = file.read(16)
            file.seek(self.last + self.last_bytes)
            tail = file.read(16)
        lines = []
        if self._is_much(self.first, played_s) and not head.startswith(_TAGS):
            share = percent(self.first, file_bytes)
            lines.append(f"the first {share} of the file holds no sound: where it should, the beginning is missing")
        if self._is_much(file_bytes - self.last, played_s) and not tail.startswith(_TAGS):
            share = percent(file_bytes - self.last, file_bytes)
            lines.append(
                f"the last {share} of the file holds nothing of this sound: "
                "where it should, the end is missing, or goes on in another stream"
            )
        return lines

    def _is_much(self, silent: int, played_s: float) -> bool:
        """Return whether so many bytes would hold more sound than may properly be lacking."""
        spanned = max(1, self.last - (self.first or 0))
        return silent > _STEPS * self.longest_step and silent * played_s > _LEAST_S * spanned


def percent(part: int, whole: int) -> str:
    """Return a part of a whole as the user is told it."""
    share = 100.0 * part / whole
    return f"{share:.0f} %" if share >= 10.0 else f"{share:.2g} %"
