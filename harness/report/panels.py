"""Which figures a report has; apart from `report`, so that a command line can offer the choice without drawing."""

from enum import StrEnum


class Panels(StrEnum):
    """Of which stops of a campaign the panels are drawn, about a second each."""

    ALL = "all"
    ABC = "abc"
    NONE = "none"
