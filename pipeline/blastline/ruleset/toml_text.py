"""Tables as the text of a TOML file, as they are or explained."""

import inspect
from collections.abc import Iterator

import msgspec


def toml_lines(table: msgspec.Struct, *, explained: bool = False) -> Iterator[str]:
    """Yield a table as the lines of a TOML file: first the keys of the top level, then its tables.

    Explained, each begins with comments that say what its keys do: the docstring of its type.
    """
    if explained:
        yield from (f"# {line}".rstrip() for line in (inspect.getdoc(type(table)) or "").splitlines())
    values = {name: getattr(table, name) for name in table.__struct_fields__}
    for name, value in values.items():
        if value is not None and not isinstance(value, msgspec.Struct):  # TOML has no word for None
            # JSON's numbers, lists and strings are TOML's, but for a delete character, which has to be escaped
            yield f"{name} = {msgspec.json.encode(value).decode()}".replace("\x7f", "\\u007F")
    for name, value in values.items():
        if isinstance(value, msgspec.Struct):
            yield f"\n[{name}]"
            yield from toml_lines(value, explained=explained)
