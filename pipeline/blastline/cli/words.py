"""Words that several commands say."""


def counted(number: int, noun: str) -> str:
    """Return so many of something in words.

    >>> counted(1, "film"), counted(0, "shot")
    ('1 film', '0 shots')
    """
    return f"{number} {noun}{'s' if number != 1 else ''}"
