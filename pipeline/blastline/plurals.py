"""How many of something there are, and how often it happened, in words: for lines and tables that people read."""


def counted(number: int, noun: str) -> str:
    """Return a number with the noun that it counts, which takes an s but for one.

    >>> counted(1, "film"), counted(0, "shot"), counted(2, "more shot")
    ('1 film', '0 shots', '2 more shots')
    """
    return f"{number} {noun}{'s' if number != 1 else ''}"


def times(number: int) -> str:
    """Return how often something happened.

    >>> times(1), times(2)
    ('once', '2 times')
    """
    return "once" if number == 1 else f"{number} times"
