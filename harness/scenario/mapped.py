"""A mapping table: our name → variable of a foreign FMU."""

from typing import Annotated, Any

from pydantic import PlainValidator

from railgrip.scenario.table import broken


def _map_entry(entry: Any) -> Any:
    """Return a mapping entry as it stands; what it may say in detail is checked against the FMU, which knows more."""
    if isinstance(entry, str | dict) or (
        isinstance(entry, list | tuple) and all(isinstance(element, str | dict) for element in entry)
    ):
        return entry
    raise broken(
        f"is {entry!r}, but the name of an FMU variable is wanted, a list of them, "
        'or { variable = "…", unit = "…", scale = … }'
    )


MapEntry = Annotated[Any, PlainValidator(_map_entry)]
