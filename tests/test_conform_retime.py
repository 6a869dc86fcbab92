"""An event as a shot of a new cut: all of it moves by one rule, ends with its scene, and is as loud as the new film."""

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
import pytest

from blastline.conform import Course, Film, Placed, Retimed, hear
from blastline.conform.lines import Line
from blastline.conform.retime import retimed
from blastline.conform.segments import MatchedSegment
from blastline.model import Clip, Event, Reflection, Span, Window
from blastline.units import SILENCE_DB
from conform_films import RATE_HZ, InMemory, Samples, heard, murmur
from timelines import SHOT

ONSET = 3 * RATE_HZ
EVENT = msgspec.structs.replace(
    SHOT,
    onset_sample=ONSET,
    peak_dbfs=-6.0,
    heard_in="mains",
    blast=Span(ONSET, ONSET + 90),
    reflections=(Reflection(ONSET + 700, ONSET + 801, 43.75, -9.0),),
    window=Window(ONSET - 97, ONSET + 4_801, 80, 640),
)
OLD = heard(murmur(8.0, seed=50))


def scene(start_s: float, stop_s: float, *, scale: float = 1.0, late_s: float = 0.0) -> Course:
    return Course(MatchedSegment(Line(scale, late_s, start_s, stop_s), start_s, stop_s, 0.9), scale, 0.0, 9)


def moved(
    courses: Sequence[Course], *, event: Event = EVENT, old: Film = OLD, new: Film = OLD, index: int = 0
) -> Retimed:
    """Return an event on a course, exactly where that leads."""
    new_s = courses[index].segment.line.at(event.onset_sample / old.rate_hz)
    return retimed(event, Placed(new_s, 0.0, 1.0, index), courses, old, new)


@pytest.mark.parametrize("new_rate_hz", [8_000, 16_000, 44_100])
@pytest.mark.parametrize("scale", [0.96, 1.0, 1.04])
def test_everything_keeps_its_distance_from_the_onset_in_the_new_film_s_time(new_rate_hz: int, scale: float) -> None:
    new = heard(murmur(9.0, seed=51, rate_hz=new_rate_hz), new_rate_hz)
    made = moved([scene(0.0, 8.0, scale=scale)], new=new)
    shot, rate = made.shot, scale * new_rate_hz / RATE_HZ
    assert shot.onset == pytest.approx(ONSET * rate, abs=0.5)
    [echo] = shot.reflections
    there = [shot.blast.start, shot.blast.stop, echo.start, echo.stop, shot.span.start, shot.span.stop]
    after = [0, 90, 700, 801, 0, 4_801 - 640]  # a shot sounds until its window fades
    assert [at - shot.onset for at in there] == pytest.approx([rate * each for each in after], abs=0.5)
    assert [made.start - shot.onset, made.stop - shot.onset] == pytest.approx([-97 * rate, 4_801 * rate], abs=0.5)
    assert echo.delay_ms == pytest.approx(43.75 * scale)
    assert echo.level_db == EVENT.reflections[0].level_db


@pytest.mark.parametrize("left", [1, 2, 40, 90, 91, 700, 701, 750, 801, 2_000, 4_161, 4_800, 4_801, 4_900])
def test_nothing_of_a_shot_lies_behind_its_scene(left: int) -> None:
    """Whether that ends by a cut or with the new film."""
    cut = moved([scene(0.0, (ONSET + left) / RATE_HZ)])
    ended = moved([scene(0.0, 8.0)], new=heard(murmur(8.0, seed=50)[: ONSET + left]))
    assert msgspec.structs.replace(cut.shot, peak_dbfs=0.0) == msgspec.structs.replace(ended.shot, peak_dbfs=0.0)
    assert (cut.start, cut.stop) == (ended.start, ended.stop)
    shot, end = cut.shot, ONSET + left
    assert (cut.start, cut.stop) == (ONSET - 97, min(end, ONSET + 4_801))
    assert shot.blast == Span(ONSET, min(end, ONSET + 90))
    assert shot.span == Span(ONSET, min(end, ONSET + 4_161))
    assert [(each.start, each.stop) for each in shot.reflections] == [
        (ONSET + 700, min(end, ONSET + 801)) for _ in range(left > 700)
    ]


@pytest.mark.parametrize("moved_by", [-2_000, -90, -30, 30, 200])
@pytest.mark.parametrize("left", [1, 20, 100, 1_000])
def test_a_blast_beside_an_onset_that_was_moved_stays_between_that_and_the_end(moved_by: int, left: int) -> None:
    """Who moves an onset in a timeline leaves the blast where it was; of each at least a sample is left."""
    event = msgspec.structs.replace(EVENT, blast=Span(ONSET + moved_by, ONSET + moved_by + 90))
    shot = moved([scene(0.0, (ONSET + left) / RATE_HZ)], event=event).shot
    there = event.blast & Span(ONSET, ONSET + left)
    if there:
        assert shot.blast == there
    else:
        at = ONSET if moved_by < 0 else ONSET + left - 1
        assert shot.blast == Span(at, at + 1)


def test_the_shortest_scene_and_the_shortest_window_hold_their_shot() -> None:
    cut = moved([scene(0.0, (ONSET + 0.3) / RATE_HZ)])
    assert (cut.stop, cut.shot.blast, cut.shot.span) == (ONSET + 1, Span(ONSET, ONSET + 1), Span(ONSET, ONSET + 1))
    short = msgspec.structs.replace(EVENT, window=Window(ONSET - 97, ONSET + 1, 80, 0))
    made = moved([scene(0.0, 8.0)], event=short, new=heard(murmur(8.0, seed=51, rate_hz=8_000), 8_000))
    assert made.stop == made.shot.onset + 1


def test_a_shot_sounds_as_long_as_its_blast_whatever_its_window_leaves_of_it() -> None:
    early = msgspec.structs.replace(EVENT, window=Window(ONSET - 97, ONSET + 100, 80, 50))
    assert moved([scene(0.0, 8.0)], event=early).shot.span == Span(ONSET, ONSET + 90)


def test_a_shot_on_the_last_sample_of_its_film_is_one_sample() -> None:
    """Its place may round to just behind the film."""
    new = heard(murmur(8.0, seed=50)[: ONSET + 1])
    made = retimed(EVENT, Placed((ONSET + 0.9) / RATE_HZ, 0.0, 1.0, 0), [scene(0.0, 8.0)], OLD, new)
    assert (made.shot.onset, made.shot.blast, made.shot.span) == (ONSET, Span(ONSET, ONSET + 1), Span(ONSET, ONSET + 1))
    assert (made.stop, made.shot.reflections) == (ONSET + 1, ())


@pytest.mark.parametrize("behind", [0, 1, 50, 97, 98, ONSET])
def test_a_window_begins_no_earlier_than_its_scene(behind: int) -> None:
    made = moved([scene((ONSET - behind) / RATE_HZ, 8.0)])
    assert made.start == ONSET - min(behind, 97)


def test_no_window_begins_before_the_new_film() -> None:
    made = moved([scene(0.0, 8.0, late_s=-(ONSET - 40) / RATE_HZ)])
    assert (made.shot.onset, made.start) == (40, 0)


@pytest.mark.parametrize("ended_before_s", [0.0, 0.01, 1.5])
def test_a_shot_behind_the_end_of_its_scene_is_felt_to_its_own_end(ended_before_s: float) -> None:
    """It is heard there: the sound around it was dubbed over, which tells of no cut."""
    whole = moved([scene(0.0, 8.0)])
    assert moved([scene(0.0, 3.0 - ended_before_s)]) == whole


@pytest.mark.parametrize("left", [1, 30, 500])
def test_a_shot_behind_the_end_of_its_scene_ends_where_something_else_comes(left: int) -> None:
    """That is the next scene of the old film, or what the new one has there."""
    own, end_s = scene(0.0, 2.5, late_s=1.25), (ONSET + left) / RATE_HZ
    far = scene(5.0, 6.0, late_s=2.0)
    old_goes_on = [own, scene(end_s, 5.0, late_s=3.0), far]
    new_goes_on = [scene(0.5, 2.0, late_s=end_s + 1.25 - 0.5), own, far]  # an earlier scene comes later
    for courses, index in ((old_goes_on, 0), (new_goes_on, 1)):
        made = moved(courses, index=index)
        assert (made.stop - made.shot.onset, len(made.shot.span)) == (left, left)
    with_it = [own, scene(ONSET / RATE_HZ, 5.0, late_s=3.0)]
    assert moved(with_it) == moved([own])


@pytest.mark.parametrize("since", [0, 1, 30, 96])
def test_a_shot_before_the_beginning_of_its_scene_begins_behind_something_else(since: int) -> None:
    own, begin_s = scene(3.5, 8.0, late_s=-1.25), (ONSET - since) / RATE_HZ
    old_went_on = [scene(1.0, begin_s, late_s=4.0), own]
    new_went_on = [own, scene(6.0, 7.0, late_s=begin_s - 1.25 - 7.0)]
    for courses, index in ((old_went_on, 1), (new_went_on, 0)):
        made = moved(courses, index=index)
        assert made.shot.onset - made.start == since
    alone = moved([own])
    assert alone.shot.onset - alone.start == 97


def with_bangs(samples: Samples, *places: int) -> Samples:
    sound = samples.copy()
    sound[list(places)] = 0.3
    return sound


@pytest.mark.parametrize("factor", [0.01, 0.5, 1.0, 2.5])
def test_a_shot_is_as_much_louder_as_the_new_film_is(factor: float) -> None:
    """A constant is no level, and what comes before a shot, or long after it, is not its own."""
    quiet = 1e-3 * murmur(8.0, seed=52)
    old, behind = heard(with_bangs(quiet, ONSET)), ONSET + 50 * RATE_HZ // 1000
    raised_db = -6.0 + 20.0 * np.log10(factor)
    for places in ((ONSET,), (ONSET - 1, ONSET), (ONSET, behind), (behind - 1,)):
        new = heard(factor * with_bangs(quiet, *places) + 0.01)
        assert moved([scene(0.0, 8.0)], old=old, new=new).shot.peak_dbfs == pytest.approx(raised_db, abs=0.05)
    for beside in (ONSET - 1, behind):
        assert moved([scene(0.0, 8.0)], old=old, new=heard(with_bangs(quiet, beside))).shot.peak_dbfs < -30.0


def test_no_level_is_below_what_silence_is_called() -> None:
    faint = msgspec.structs.replace(EVENT, peak_dbfs=SILENCE_DB + 10.0)
    softer = heard(0.01 * murmur(8.0, seed=50))
    assert moved([scene(0.0, 8.0)], event=faint, new=softer).shot.peak_dbfs == SILENCE_DB


@dataclass(frozen=True, eq=False)
class Stereo(InMemory):
    """Samples, beside which another sound is in the sides, for who asks for it."""

    def read(self, span: Span, *, sides: bool = False) -> Clip:
        mains = super().read(span).samples
        return Clip(mains, self.rate_hz, span.start, 0.25 * mains[:, 0] ** 2 if sides else None)


def test_what_is_heard_beside_the_middle_is_as_loud_as_it_is_there() -> None:
    """Here the sides are the square of the mains: twice as loud a film has them four times as loud."""
    sound = murmur(8.0, seed=54)
    one, two = (Stereo(factor * sound) for factor in (1.0, 2.0))
    old, new = hear(one, one.blocks()), hear(two, two.blocks())
    for mix, raised in (("mains", 2.0), ("sides", 4.0)):
        event = msgspec.structs.replace(EVENT, heard_in=mix)
        assert moved([scene(0.0, 8.0)], event=event, old=old, new=new).shot.peak_dbfs == pytest.approx(
            -6.0 + 20.0 * np.log10(raised)
        )


def test_where_nothing_tells_the_level_it_is_the_old_one() -> None:
    silent = heard(np.concatenate([murmur(2.9, seed=53), np.zeros(round(5.1 * RATE_HZ))]))
    assert moved([scene(0.0, 8.0)], new=silent).shot.peak_dbfs == -6.0
    assert moved([scene(0.0, 8.0)], old=silent, new=OLD).shot.peak_dbfs == -6.0
    beside = msgspec.structs.replace(EVENT, heard_in="sides")  # these films have none
    assert moved([scene(0.0, 8.0)], event=beside).shot.peak_dbfs == -6.0
