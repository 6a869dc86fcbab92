"""What a study listens to: scenes, recordings as they are, or film-like sounds made of recordings."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..errors import RuleError
from .cases import Case, recordings, scenes
from .filmlike import CLIP_S, film_mixes, one_shot_clips, stock
from .lessons import MIX_S


@dataclass(frozen=True)
class Source:
    """Scenes of a folder, or recordings of some corpora: as they are, in mixes at `mix_db`, or in clips."""

    fixtures: Path | None = None
    corpus: tuple[Path, ...] = ()
    mix_db: tuple[float, float] | None = None
    clips: bool = False
    films: int = 20
    seed: int = 1

    def cases(self, into: Path) -> Iterator[Case]:
        """Yield the films; what has to be made is made in a folder, and stays there.

        Raises RuleError where there are neither scenes nor recordings, or both.
        """
        if (self.fixtures is None) == (not self.corpus):
            raise RuleError("study: give either --fixtures or --corpus")
        if self.fixtures is not None:
            if self.mix_db is not None or self.clips:
                raise RuleError("study: --mix and --clips are made of recordings; give --corpus instead of --fixtures")
            return scenes(self.fixtures, into)
        if self.clips:
            return one_shot_clips(stock(self.corpus), into, clips=self.films, seed=self.seed)
        if self.mix_db is not None:
            return film_mixes(stock(self.corpus), into, films=self.films, levels_db=self.mix_db, seed=self.seed)
        return recordings(self.corpus)

    @property
    def protocol(self) -> str:
        """Return what is listened to, in a line."""
        if self.clips:
            return (
                f"{self.films} clips of {CLIP_S:g} s, every other one with a single shot at -6, 0 or 6 dB rms, "
                f"seed {self.seed}; as in DCASE 2017, no score of it"
            )
        if self.mix_db is not None:
            low, high = self.mix_db
            return (
                f"{self.films} mixes of {MIX_S:g} s, peaks {low:g} to {high:g} dB over the bed, one in four without "
                f"a shot, seed {self.seed}"
            )
        return "scenes" if self.fixtures else "recordings as they are"
