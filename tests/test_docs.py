"""The pages for readers: every link leads somewhere, README names every page, and every file that is named is there."""

import re
from pathlib import Path

import pytest

from blastline.report import CHECKS

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
LINK = re.compile(r"\]\(([^)\s]+)\)")
MODULE = re.compile(r"`([\w/-]+\.py)`")


def anchors(page: Path) -> set[str]:
    """Return what a link may end with after #: the headings in small letters, with hyphens, without other signs."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", head).strip().lower().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_to_a_file_or_a_heading_leads_there(page: Path) -> None:
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        if link.startswith("http"):
            continue
        file, _, heading = link.partition("#")
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), link
        assert not heading or heading in anchors(target), link


def test_the_readme_names_every_page() -> None:
    named = set(LINK.findall(PAGES[0].read_text(encoding="utf-8")))
    pages = {page.relative_to(ROOT).as_posix() for page in PAGES[1:]}
    assert "docs/detection.md" in pages
    assert pages <= named


def test_every_module_that_a_page_names_is_there() -> None:
    modules = [path.as_posix() for path in ROOT.rglob("*.py") if ".venv" not in path.parts]
    named = {(page.name, name) for page in PAGES for name in MODULE.findall(page.read_text(encoding="utf-8"))}
    assert named
    missing = [each for each in named if not any(module.endswith(f"/{each[1]}") for module in modules)]
    assert missing == []


@pytest.mark.parametrize("page", PAGES[2:], ids=lambda page: page.name)
def test_a_page_begins_with_what_it_is_for(page: Path) -> None:
    title, _, first, *_ = page.read_text(encoding="utf-8").splitlines()
    assert title.startswith("# ")
    assert re.match(r"\w|`", first), "expected a sentence under the title"


def test_every_check_is_explained_under_its_words_and_its_name() -> None:
    page = (ROOT / "docs" / "checks.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (.+?) \| `(\w+)` \| .+ \| .+ \|$", page, re.MULTILINE)
    assert sorted((name, words) for words, name in rows) == sorted(CHECKS.items())
