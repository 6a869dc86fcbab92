"""How many of something there are, in words: for the lines and tables that people read."""


def counted(number: int, noun: str) -> str:
    """Return a number with the noun that it counts, which takes an s but for one.

    >>> counted(1, "film"), counted(0, "shot"), counted(2, "more shot")
    ('1 film', '0 shots', '2 more shots')
    """
    return f"{number} {noun}{'s' if number != 1 else ''}"
