"""matplotlib, made ready: it wants a folder for its fonts, and the account of a service may have none."""

import logging
import os
from importlib import import_module
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
            _import_with(fonts)
    finally:
        log.setLevel(level)


def _import_with(fonts: str) -> None:
    asked = os.environ.get(_SETTING)
    os.environ[_SETTING] = fonts
    try:
        _import()
    finally:
        del os.environ[_SETTING]
        if asked is not None:
            os.environ[_SETTING] = asked


def _import() -> None:
    import_module("matplotlib.font_manager")
