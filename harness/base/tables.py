"""Contents of files of text as they are read or written, whose keys no class declares."""

from typing import Any

TomlTable = dict[str, Any]
"""A table of a TOML file, and the tables in it, before validation; layers of a scenario are overlaid in this form.

Code behind the validation gets a class that declares the keys. Results are never in this form.
"""

JsonObject = dict[str, Any]
"""An object of a JSON file as it is read, or as a class that declares its keys writes it."""
