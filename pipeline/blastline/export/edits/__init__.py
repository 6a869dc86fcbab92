"""What a designer's editing tool hands back: the events of an edited file, and how they differ from the original's.

file ──► rows, each with its place in the file ──► matched with the timeline that they were exported from ──► wanted

Numbers are kept as they are written, with the step of their last digit: so an onset that a tool has merely rounded can
be told from one that somebody has moved.
"""

from .document import MADE_WITH, value_at
from .matching import Wanted, Wish, match
from .reading import read_edits
from .row import Edit, EditedFile, Point

__all__ = ["MADE_WITH", "Edit", "EditedFile", "Point", "Wanted", "Wish", "match", "read_edits", "value_at"]
