"""What can go wrong, as exceptions with one line for the user.

    BlastlineError
      RuleError        a rule file, profile or option       (also a ValueError)
      SoundtrackError  audio that cannot be read            (also an OSError)
      OutputError      a result that cannot be written      (also an OSError)
      TimelineError    a timeline file that cannot be used  (also a ValueError)

The message holds the file, the key or time, the value, and what was expected. The command line prints it and
exits with 2. A *finding* (a rejected candidate, a failed alignment check) is data, never an exception.
"""


class BlastlineError(Exception):
    """Base of every error that a user can cause and mend."""


class RuleError(BlastlineError, ValueError):
    """A rule file, an actuator profile or an option is unusable."""


class SoundtrackError(BlastlineError, OSError):
    """A soundtrack cannot be opened or decoded."""


class OutputError(BlastlineError, OSError):
    """A result cannot be written."""


class TimelineError(BlastlineError, ValueError):
    """A timeline file cannot be used."""
