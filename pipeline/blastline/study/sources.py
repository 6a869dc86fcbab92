"""What a study listens to: scenes, recordings as they are, or film-like sounds made of recordings."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from ..errors import RuleError
from ..plurals import counted
from .cases import FILM_S, Case, random_films, recordings, scenes
from .corpus import Recording, read_corpus
from .datasets import FOLD_SEED, FOLDS, by_fold
from .filmlike import CLIP_S, film_mixes, one_shot_clips, stock
from .mixes import MIX_S, Levels


@dataclass(frozen=True)
class StudySource:
    """Scenes of a folder and so many `random` films, or recordings of some corpora: as they are, in mixes, or in clips.

    `fold` takes only the part of the recordings' sources that training leaves out with `--hold-out`.
    """

    fixtures: Path | None = None
    corpus: tuple[Path, ...] = ()
    mix: Levels | None = None
    clips: bool = False
    fold: int | None = None
    random: int = 0
    films: int = 24
    seed: int = 1

    def cases(self, into: Path, *, jobs: int = 1) -> Iterator[Case]:
        """Yield the films; what has to be made is made in a folder, so many scenes at once, and stays there.

        Raises RuleError where there are neither scenes nor recordings, or both.
        """
        synthetic = self.fixtures is not None or self.random > 0
        if synthetic == bool(self.corpus):
            raise RuleError("study: give either --fixtures or --random, or --corpus")
        if synthetic:
            if self.mix is not None or self.clips or self.fold is not None:
                raise RuleError("study: --mix, --clips and --fold are about recordings; give --corpus alone")
            made = scenes(self.fixtures, into, jobs=jobs) if self.fixtures is not None else ()
            return chain(made, random_films(into, films=self.random, seed=self.seed, jobs=jobs))
        if self.clips and self.mix is not None:
            raise RuleError("study: --clips have levels of their own; give either --clips or --mix")
        found = self._recordings()
        if self.clips:
            return one_shot_clips(stock(found), into, clips=self.films, seed=self.seed)
        if self.mix is not None:
            return film_mixes(stock(found), into, films=self.films, levels=self.mix, seed=self.seed)
        return recordings(found)

    def _recordings(self) -> Sequence[Recording]:
        every = read_corpus(self.corpus)
        if self.fold is None:
            return every
        parts = by_fold(every, FOLDS, FOLD_SEED)
        if self.fold >= len(parts):
            sources = counted(len(parts), "source")
            raise RuleError(f"study: --fold {self.fold}: the recordings have only {sources} of a kind")
        return parts[self.fold]

    @property
    def protocol(self) -> str:
        """Return what is listened to, in a line."""
        if self.clips:
            return (
                f"{counted(self.films, 'clip')} of {CLIP_S:g} s, every other one with a single shot at -6, 0 or 6 dB "
                f"rms, seed {self.seed}; as in DCASE 2017, no score of it{self._part}"
            )
        if self.mix is not None:
            low, high, of = self.mix
            return (
                f"{self.films} mixes of {MIX_S:g} s, {of} {low:g} to {high:g} dB over the bed, one in four without "
                f"a shot, seed {self.seed}{self._part}"
            )
        if self.corpus:
            return f"recordings as they are{self._part}"
        kinds = ["scenes"] if self.fixtures is not None else []
        films = f"{counted(self.random, 'random film')} of {FILM_S:g} s, seed {self.seed}"
        kinds += [films] if self.random else []
        return " and ".join(kinds)

    @property
    def _part(self) -> str:
        return "" if self.fold is None else f", fold {self.fold} of the sources"
