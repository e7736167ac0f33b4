"""A train whose parts deviate from their data, by which draws of a dispersion are checked."""

from railgrip.rolling_stock.schema import Train, train_of

KEYS = {
    "pad_friction": ("brakes", "pad_friction"),
    "pressure": ("brakes", "pressure_max"),
    "efficiency": ("brakes", "efficiency"),
    "friction_radius": ("brakes", "friction_radius"),
    "wheel_radius": ("bogies", "wheel_radius"),
    "track_brake": ("track_brakes", "attraction"),
    "mass": ("cars", "mass"),
}
"""Quantity of a dispersion → table and key of a train file."""


def deviating(train: Train, quantity: str, value: float) -> Train:
    """Return the train with another datum in all parts, larger by a share of it or by a pressure [Pa].

    Its running resistance is that of the train.
    """
    tables = train.model_dump(exclude={"dispersion"}, exclude_none=True)
    table, key = KEYS[quantity]
    friction = {bogie.data.brake: bogie.pad_friction for bogie in train.bogies_in_train}
    for name, part in tables[table].items() if isinstance(tables[table], dict) else enumerate(tables[table]):
        nominal = part.get(key, friction.get(name))  # that of the law of blocks
        part[key] = nominal + value if quantity == "pressure" else nominal * (1 + value)
        if "axle_masses" in part:
            part["axle_masses"] = [mass * (1 + value) for mass in part["axle_masses"]]
    return train_of(tables, "deviating.toml")
