"""Equipment and effects that are common in the field but not supported by train files and scenarios."""

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

_FOREIGN: Final = "a plant from another tool may have it (`railgrip map`)"
_CLASS: Final = "a Modelica class of your own may use RailBraking."
UNSUPPORTED: Final[Mapping[str, tuple[str, str]]] = MappingProxyType(
    {
        r"ed(_?brakes?)?|electro_?dynamic.*|dynamic_brak.*|regenerat.*|recuperat.*|rheostat.*|blend.*": (
            "electrodynamic brakes and their blending are",
            f"give the friction brake alone; {_CLASS}Components.ElectrodynamicBrake and Blending",
        ),
        r"hydro_?dynamic.*|retarders?|engine_brakes?": ("hydrodynamic and engine brakes are", _FOREIGN),
        r".*eddy_?current.*|linear_brakes?|ecb": (
            "eddy-current brakes are",
            f"{_FOREIGN}, with its greatest force in [vehicle.formation] track_brakes",
        ),
        r".*tread_?brak.*|block_?brak.*|.*brake_?(blocks?|shoes?)|blocks|shoes": (
            "tread brakes are",
            "brakes are pads on discs; an equivalent disc brake has the same force at the rim",
        ),
        r"park(ing)?_?brak.*|spring_?(applied|loaded)?_brak.*|hand_?brak.*|holding_brak.*": (
            "parking, spring-applied and hand brakes are",
            f"leave them out: they do not act in a stop; {_CLASS}Pneumatics.ParkingUnit",
        ),
        r"(load_?)?weigh.*|load_?(proportional|dependent|sens).*|empty_load.*": (
            "brakes that follow the load are",
            f"write a file for each load, with its pressure_max; {_CLASS}Pneumatics.LoadValve",
        ),
        r"wind|head_?wind|cross_?wind|weather|tunnels?": (
            "wind, weather and tunnels are",
            "change the drag of the vehicle, and [adhesion] for wet or leaves",
        ),
    }
)
"""Pattern of a whole key → its meaning, and the alternative."""


def explain_unsupported(key: str) -> str:
    """Return a sentence on a key for unsupported equipment; empty for any other key."""
    name = re.sub(r"[\s.-]+", "_", key).casefold()
    found = next((words for pattern, words in UNSUPPORTED.items() if re.fullmatch(pattern, name)), None)
    return f"{found[0]} not supported in this file; {found[1]}" if found else ""
