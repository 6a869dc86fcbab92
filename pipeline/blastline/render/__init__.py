"""Making the drive: windows around the shots, and in each the signal whose vibration is felt like the sound.

windows = plan_windows(shots, ...)                  where
filters = drive_filters(profile, ...)               with what
hear_window -> measure -> (scene.choose) -> render_window          for each window
compose                                             the film's drive
"""

from .drive import RenderedWindow, measure, render_window
from .filters import DriveFilters, drive_filters, needed_audio, preroll
from .heard import HeardWindow, hear_window
from .made_of import choose_made_of, is_lacking
from .mix import compose
from .renderable import require_renderable
from .windows import PlannedWindow, plan_windows, window_between, with_gains

__all__ = [
    "DriveFilters",
    "HeardWindow",
    "PlannedWindow",
    "RenderedWindow",
    "choose_made_of",
    "compose",
    "drive_filters",
    "hear_window",
    "is_lacking",
    "measure",
    "needed_audio",
    "plan_windows",
    "preroll",
    "render_window",
    "require_renderable",
    "window_between",
    "with_gains",
]
