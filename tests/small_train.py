"""A train file that is compiled quickly: one car on one bogie, from the file of `railgrip new train`.

An FMU takes two seconds to build, and half a second more for each wheelset: a test for which one car is enough uses it.
"""

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from synthetic import MOTOR

from railgrip import cli

BEGINNING = (Path(cli.__file__).parent / "templates" / "train.toml").read_text(encoding="utf-8")


COUPLED = BEGINNING.replace("coupled = false", "coupled = true")
"""The same with coupled axles, which halve the build time of a plant and have no effect on its air."""


def one_bogie(name: str = "small") -> str:
    """Return the text of the file: the first car of the beginning on its first bogie, with half of its mass."""
    text = halved(BEGINNING[: BEGINNING.rindex("[[cars]]")].replace("NAME", name))
    return re.sub(r'^coupler = "bar".*\n', "", text, flags=re.MULTILINE)


def halved(text: str) -> str:
    """Return the text with its cars on their first bogies, with half of their mass."""
    return text.replace('mass = "44 t"', 'mass = "22 t"').replace(', { kind = "trailer", at = "20.5 m" }', "")


def without_command(text: str) -> str:
    """Return the text without [command]: the demand is in the cylinders at once."""
    return text[: text.index("[command]")] + text[text.index("[resistance]") :]


def with_constant_friction(text: str) -> str:
    """Return the text with pads whose friction does not depend on anything."""
    return re.sub(r"^((?:speed|force|temperature)_effect) = [\d.]+", r"\1 = 0.0", text, flags=re.MULTILINE)


def dynamic_brake(name: str, keys: Mapping[str, object]) -> str:
    """Return the table of a dynamic brake."""
    return f"[dynamic_brakes.{name}]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())


def electric_tables(**motor: object) -> dict[str, Any]:
    """Return the tables of the beginning with a motor under each car and pads of constant friction.

    Keys of the motor differ from those of `MOTOR` where they are given.
    """
    tables = tomllib.loads(BEGINNING.replace("NAME", "electric"))
    for effect in ("speed_effect", "force_effect", "temperature_effect"):
        tables["pads"]["organic"][effect] = 0.0
    tables["bogies"]["motor"] = tables["bogies"]["trailer"] | {"dynamic_brake": "motor"}
    tables["dynamic_brakes"] = {"motor": MOTOR | motor}
    for car in tables["cars"]:
        car["bogies"][0]["kind"] = "motor"
    return tables
