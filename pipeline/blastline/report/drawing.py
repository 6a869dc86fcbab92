"""matplotlib, made ready: it wants a folder for its fonts, and the account of a service may have none."""

import logging
import os
from pathlib import Path
from tempfile import TemporaryDirectory

_SETTING = "MPLCONFIGDIR"


def ready_to_draw(folder: Path) -> None:
    """Import matplotlib, and keep what it says of its own folders from standard error.

    Where neither the home nor a temporary folder can be written it would refuse, after all the work: then its fonts
    are in `folder`, until it knows them.
    """
    log = logging.getLogger("matplotlib")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        _import()
    except OSError:
        with TemporaryDirectory(dir=folder) as fonts:
            os.environ[_SETTING] = fonts
            _import()
        del os.environ[_SETTING]
    finally:
        log.setLevel(level)


def _import() -> None:
    import matplotlib.font_manager  # noqa: F401
