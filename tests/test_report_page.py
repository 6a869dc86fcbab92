"""The report says what happened, of every shot, safely and without the network."""

import html
import re
from collections.abc import Sequence
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import msgspec
import numpy as np
import pytest

from align_films import PROFILE, Film, make_film
from blastline.model import Check, Decision, DriveInfo, Event, Rejection, Timeline
from blastline.report import ExportRow, OverviewMeter, write_report

VOID = {"meta", "br", "hr", "img", "input", "link"}


class Page(HTMLParser):
    """A page that has been read: it is an error if its elements do not nest."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []
        self.tags: list[str] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name in ("href", "src", "xlink:href"):
                self.links.append(value or "")
            if name == "id":
                self.ids.append(value or "")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(self.words)


@cache
def film() -> Film:
    return make_film(onsets_s=(0.7, 1.6, 2.9), peaks=(0.05, 0.5, 0.1), seconds=4.0)


def written(folder: Path, film: Film, timeline: Timeline | None = None, exports: Sequence[ExportRow] = ()) -> str:
    meter = OverviewMeter(film.audio.rate_hz)
    for _ in meter.watch(film.audio.blocks()):
        pass
    path = folder / "report.html"
    write_report(
        path,
        timeline or film.timeline,
        overview=meter.overview(),
        audio=film.audio,
        drive=film.drive,
        profile=PROFILE,
        exports=exports,
        options={"phase": "causal"},
    )
    return path.read_text(encoding="utf-8")


def passing(event: Event | None = None) -> Check:
    return Check("felt_lag" if event else "frames", event.id if event else None, True, 0.35, 0.5, "ms")


def test_the_page_holds_every_shot_and_nothing_from_outside(tmp_path: Path) -> None:
    timeline = msgspec.structs.replace(film().timeline, checks=(passing(), *map(passing, film().timeline.events)))
    text = written(tmp_path, film(), timeline)
    page = Page(text)
    for event in timeline.events:
        assert f"row-{event.id}" in page.ids
        assert f"shot-{event.id}" in page.ids
        assert event.timecode in page.text
    assert page.tags.count("article") == len(timeline.events)
    assert page.links
    assert all(link.startswith("#") for link in page.links)
    assert {unquote(link[1:]) for link in page.links} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    outside = re.sub(r'xmlns(:\w+)?="[^"]*"', "", text)
    assert "http:" not in outside
    assert "https:" not in outside
    assert not re.search(r"""(src|href|url)\s*[=(]\s*["']?//""", outside)
    assert "@import" not in outside
    assert "Aligned." in page.text
    assert timeline.rules_digest in page.text


def test_failures_come_first_and_in_words(tmp_path: Path) -> None:
    bad = Check("felt_lag", "shot-0003", False, 10.35, 0.5, "ms")
    whole = Check("drive_shift", None, False, 480.0, 0.5, "samples")
    timeline = msgspec.structs.replace(film().timeline, checks=(passing(), bad, whole))
    page = Page(written(tmp_path, film(), timeline))
    assert "Not aligned." in page.text
    assert "2 of 3 checks failed" in page.text
    assert page.text.index("480 samples") < page.text.index("Every shot")


def test_a_drive_that_is_in_its_place_but_unlike_the_sound_is_not_called_out_of_place(tmp_path: Path) -> None:
    bad = Check("drive_correlation", "shot-0003", False, 0.72, 0.9, "")
    page = Page(written(tmp_path, film(), msgspec.structs.replace(film().timeline, checks=(passing(), bad))))
    assert "Not as it should be." in page.text
    assert "ligned." not in page.text


def test_what_was_set_by_hand_is_told_of_each_shot_in_its_card_and_in_the_table(tmp_path: Path) -> None:
    one, two, three = film().timeline.events
    moved, louder = (
        msgspec.structs.replace(one, origin="moved", gain_db=-6.0),
        msgspec.structs.replace(two, gain_db=2.5),
    )
    text = written(tmp_path, film(), msgspec.structs.replace(film().timeline, events=(moved, louder, three)))
    cards = [" ".join(Page(card).words) for card in re.findall("<article.*?</article>", text, re.DOTALL)]
    rows = [" ".join(Page(row).words) for row in re.findall('<tr id="row.*?</tr>', text, re.DOTALL)]
    assert len(cards) == len(rows) == 3
    for told in (cards, rows):
        assert "moved, gain −6 dB" in told[0]
        assert "gain +2.5 dB" in told[1]
        assert not re.search(r"\bgain\b|moved", told[2])


def test_no_number_of_the_page_has_a_hyphen_for_a_minus(tmp_path: Path) -> None:
    """Reasons come from the timeline, where a minus is a hyphen; names and ranges keep theirs."""
    timeline = film().timeline
    why = Decision("reflections", "segmented", "the loudest -12.3 dB (-0.5 at most) after 3-4 ms, as shot-0001", {})
    drive = DriveInfo("filter", "direct conversion is felt -9.4 dB against it", 0.5, -3.0, 0.9, 0, 0.9, {})
    events = tuple(
        msgspec.structs.replace(event, decisions=(why,), drive=drive, peak_dbfs=-3.5, gain_db=-6.0)
        for event in timeline.events
    )
    turned_down = (Rejection(4_000, "-8 dB against its neighbours", {"level_db": -8.0}),)
    late = Check("felt_lag", events[0].id, False, -2.5, 0.5, "ms")
    changed = msgspec.structs.replace(timeline, events=events, rejections=turned_down, checks=(late,))
    text = Page(re.sub(r"(?s)<(script|style)\b.*?</\1>", "", written(tmp_path, film(), changed))).text
    assert re.findall(r"(?<![\w.])-\d", text) == []
    assert {"−12.3 dB", "(−0.5 at most)", "−9.4 dB", "−8 dB", "3-4 ms", "shot-0001"} <= set(
        re.findall(r"−12\.3 dB|\(−0\.5 at most\)|−9\.4 dB|−8 dB|3-4 ms|shot-0001", text)
    )
    assert "1 candidate was not taken" in text


def test_the_table_of_shots_calls_what_it_shows_as_the_cards_do(tmp_path: Path) -> None:
    text = written(tmp_path, film())
    (table,) = re.findall('<table id="shots">.*?</thead>', text, re.DOTALL)
    heads = {head.partition(",&nbsp;")[0] for head in re.findall("<th[^>]*>(.*?)</th>", table)}
    cards = set(re.findall("<dt>(.*?)</dt>", "".join(re.findall("<article.*?</article>", text, re.DOTALL))))
    assert {"Confidence", "Over background", "Reflections", "Felt against direct", "Fidelity"} <= heads & cards


def test_what_the_checks_came_to_is_never_at_the_hidden_end_of_the_table(tmp_path: Path) -> None:
    bad = Check("felt_lag", "shot-0002", False, 10.35, 0.5, "ms")
    text = written(tmp_path, film(), msgspec.structs.replace(film().timeline, checks=(bad,)))
    (table,) = re.findall('<table id="shots">.*?</table>', text, re.DOTALL)
    assert re.findall("<th [^>]*>(.*?)</th>", table)[:3] == ["Shot", "Timecode", "Checks"]
    third = [re.findall("<td.*?</td>", row)[2] for row in re.findall("<tr id=.*?</tr>", table)]
    assert ["1 failed" in cell for cell in third] == [False, True, False]


def test_a_lag_that_could_not_be_measured_is_counted_beside_those_that_were(tmp_path: Path) -> None:
    """A median of what was found alone would read "0 ms" of a drive in which most shots were not found."""
    lags = [Check("felt_lag", f"shot-000{n}", n == 1, 0.25 if n == 1 else None, 0.5, "ms") for n in (1, 2, 3)]
    told = Page(written(tmp_path, film(), msgspec.structs.replace(film().timeline, checks=tuple(lags)))).text
    assert "median; largest 0.25 ms of 1; 2 not measured" in told
    told = Page(written(tmp_path, film(), msgspec.structs.replace(film().timeline, checks=(lags[0],)))).text
    assert "ms of 1" not in told


def test_a_shot_tells_where_it_was_heard_and_from_where_it_came_and_no_other_does(tmp_path: Path) -> None:
    timeline = film().timeline
    plain = timeline.events[0]
    beside = msgspec.structs.replace(plain, azimuth_deg=-112.0, azimuth_focus=0.875, heard_in="sides", gain_db=-3.0)
    told = [
        Page(written(tmp_path, film(), msgspec.structs.replace(timeline, events=(event,)))).text
        for event in (plain, beside)
    ]
    facts = ("Azimuth", "Heard in", "By hand")
    assert [[fact in text for fact in facts] for text in told] == [[False] * 3, [True] * 3]
    assert re.search(r"Azimuth\s+[−-]112°, focus 0\.8[78]\s+Heard in\s+the sides", told[1])


def test_hostile_names_stay_text(tmp_path: Path) -> None:
    evil = '"><script>alert(1)</script><img src=//x onerror=y>&'
    events = tuple(
        msgspec.structs.replace(event, id=f"{index}{evil}", timecode=evil)
        for index, event in enumerate(film().timeline.events)
    )
    source = msgspec.structs.replace(film().timeline.source, name=evil, warnings=(evil,))
    checks = (Check(evil, events[0].id, False, 1.0, 0.5, evil), Check("felt_lag", events[1].id, True, 0.1, 0.5, "ms"))
    rejected = (msgspec.structs.replace(film().timeline.rejections[0], reason=evil, evidence={evil: 1.0}),)
    timeline = msgspec.structs.replace(
        film().timeline, source=source, events=events, checks=checks, rejections=rejected, version=evil
    )
    text = written(tmp_path, film(), timeline)
    page = Page(text)
    assert page.tags.count("script") == 1
    assert "img" not in page.tags
    assert html.escape(evil) in text


@pytest.mark.parametrize("identity", ["100 %41", "take\t2 ", "a#b", "né"])
def test_links_lead_to_the_shot_whatever_its_name(tmp_path: Path, identity: str) -> None:
    """A browser takes tabs and spaces at the end off an address and reads what follows a per cent sign as a letter."""
    [event, *_] = film().timeline.events
    named = msgspec.structs.replace(event, id=identity)
    timeline = msgspec.structs.replace(film().timeline, events=(named,), checks=(passing(named),))
    page = Page(written(tmp_path, film(), timeline))
    followed = [unquote(re.sub(r"[\t\n\r]", "", link).strip()[1:]) for link in page.links]
    assert followed.count(f"shot-{identity}") == 3, "from the film, the shots and the checks"


def test_files_for_other_tools_are_linked_where_they_were_written(tmp_path: Path) -> None:
    evil = '<b>&"'
    rows = (
        ExportRow("avid", ("timeline.avid.txt",), "Avid", "Tools > Markers", "nearest frame", False),
        ExportRow("csv", (f"timeline {evil}.csv",), f"any {evil}", f"open {evil}", f"exact {evil}", True),
    )
    page = Page(written(tmp_path, film(), exports=rows))
    assert "files" in page.ids
    assert [link for link in page.links if not link.startswith("#")] == [f"timeline {evil}.csv"]
    assert all(word in page.text for word in ("Tools > Markers", "nearest frame", f"open {evil}", f"exact {evil}"))
    assert page.text.index(f"any {evil}") < page.text.index("Tools > Markers")
    assert "blastline export timeline.json" in page.text
    assert "files" not in Page(written(tmp_path, film())).ids


def test_on_a_narrow_screen_pictures_are_moved_aside_rather_than_made_too_small_to_read(tmp_path: Path) -> None:
    """The smallest letters of a picture as wide as the page lets it become have 8 pixels or more."""
    text = written(tmp_path, film())
    [least] = [int(width) for width in re.findall(r"\.scroll svg\{min-width:(\d+)px\}", text)]
    pictures = re.findall(r'(.{20})<svg class="(\w+)" viewBox="0 0 ([\d.]+) [^>]*>(.*?)</svg>', text, re.DOTALL)
    assert [kind for _, kind, _, _ in pictures] == ["track", "shot", "shot", "shot"]
    for before, _, width, drawn in pictures:
        assert before.endswith('<div class="scroll">')
        sizes = [float(size) for size in re.findall(r'font(?:-size="|-size: |: )([\d.]+)', drawn)]
        assert min(sizes) * least / float(width) >= 8.0


def test_the_letters_of_pictures_are_in_the_pages_font(tmp_path: Path) -> None:
    """Whatever font a letter of a picture names itself, the style sheet's counts: only `!important` does."""
    style = written(tmp_path, film()).split("<style>")[1].split("</style>")[0]
    assert "svg text{font-family:inherit!important}" in style


def test_no_name_without_a_break_makes_the_page_wider(tmp_path: Path) -> None:
    """Whatever is not in a table, which has a scroll bar of its own, may break within a word."""
    style = written(tmp_path, film()).split("<style>")[1].split("</style>")[0]
    wraps = {rule.split("{")[0].strip(): rule for rule in style.split("}") if "overflow-wrap" in rule}
    assert "overflow-wrap:anywhere" in wraps.pop("body")
    assert "overflow-wrap:normal" in wraps.pop("table")
    assert not wraps


def test_a_film_without_shots_says_so(tmp_path: Path) -> None:
    timeline = msgspec.structs.replace(film().timeline, events=(), rejections=(), checks=(passing(),))
    page = Page(written(tmp_path, film(), timeline))
    assert "No shots." in page.text
    assert "no shots were found in this film" in page.text
    assert page.tags.count("article") == 0


def test_the_same_run_gives_the_same_page(tmp_path: Path) -> None:
    one = make_film(onsets_s=(0.3,), peaks=(0.5,), seconds=1.0)
    assert written(tmp_path, one) == written(tmp_path, one)


@pytest.mark.parametrize("block", [1, 7, 1000, 65_536])
def test_the_overview_does_not_depend_on_blocks(block: int) -> None:
    from align_films import Held

    samples = np.random.default_rng(1).uniform(-1, 1, 12_345)
    meter = OverviewMeter(8000)
    for _ in meter.watch(Held(samples, 8000, block).blocks()):
        pass
    overview = meter.overview()
    expected = [np.abs(samples[at : at + overview.step]).max() for at in range(0, 12_345, overview.step)]
    assert overview.peaks == pytest.approx(np.array(expected), abs=1e-6)
    assert overview.columns(10).max() == pytest.approx(np.abs(samples).max(), abs=1e-6)
    assert len(overview.columns(10)) == 10
