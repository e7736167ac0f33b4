"""The column of time of a table as seconds: numbers, times of day as hhmmss, dates; and why a clock runs backwards."""

import re
from typing import Any, Final

import numpy as np
import pandas as pd

from railgrip.base.arrays import Vector
from railgrip.base.errors import EstimationError
from railgrip.base.units import cut, short

DAY: Final = 86400.0
HOUR: Final = 3600.0
_NUMERIC_DATE = re.compile(r"(?<!\d)(\d{1,2})([./-])(\d{1,2})[./-](\d{2,4})\b")
"""A date that ends with its year; whether its day or its month is first is a custom."""
_COUNTERS: Final = {f"{bits} bits": float(2**bits) for bits in (16, 24, 31, 32)}
_TICKS: Final = (1.0, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
"""Seconds of a count."""
_STEPS: Final = 5.0
"""Number of periods within which a jump of a clock is one of its usual sizes."""


def seconds_of_stamps(file: str, name: str, values: Any, order: str | None) -> Vector:
    """Return time stamps in seconds from the first, NaN where missing.

    Args:
        file: Name of the file, for messages.
        name: Name of the column.
        values: Texts or datetimes, shape (k,).
        order: "day first" or "month first" of dates that end with their year; None to recognise it.

    Raises:
        EstimationError: A text is not a time stamp, or the order of day and month is ambiguous.
    """
    column: Any = pd.Series(values)
    if np.asarray(values).dtype.kind not in "mM":
        texts = column.dropna().astype(str)
        # "12:00:01,250" has a decimal comma.
        column = column.astype("string").str.replace(r",(\d+)\s*$", r".\1", regex=True)
        is_day_first = _is_day_first(file, name, texts, order)
    else:
        is_day_first = False
    try:
        try:
            stamps: Any = pd.to_datetime(column, utc=True, dayfirst=is_day_first)
        except ValueError:  # some have fractions of a second, others none
            stamps = pd.to_datetime(column, utc=True, dayfirst=is_day_first, format="mixed")
    except (ValueError, TypeError, OverflowError) as problem:
        raise EstimationError(f"{file}: column '{name}' has no time stamps: {cut(str(problem))}") from None
    if stamps.isna().all():
        return np.full(len(stamps), np.nan)
    seconds = (stamps - stamps.dropna().iloc[0]).dt.total_seconds()
    return np.asarray(seconds, dtype=np.float64)


def _is_day_first(file: str, name: str, texts: Any, order: str | None) -> bool:
    """Return whether the day is first in dates that end with their year.

    Dates with dots are day first. Otherwise a number above 12 decides, or a single date, whose order does not matter.
    """
    dates: Any = texts.str.extract(_NUMERIC_DATE).dropna()
    if dates.empty:  # years first: pandas would exchange their months and days
        return False
    if order is not None:
        return order == "day first"
    if (dates[1] == ".").all():
        return True
    first, second = (dates[k].astype(int) for k in (0, 2))
    if (first > 12).any() or (second > 12).any():
        return bool((first > 12).any())
    if len(dates[[0, 2, 3]].drop_duplicates()) == 1 or (first == second).all():
        return True
    raise EstimationError(
        f"{file}: column '{name}' has dates such as {short(texts.iloc[0])}, whose day or month may be first; write "
        "order = 'day first' or order = 'month first' in time of [data] (inspect: --order)."
    )


def seconds_of_day(values: Vector) -> Vector:
    """Return the seconds of the day of numbers hhmmss.ss, shape (k,)."""
    hours, rest = np.divmod(values, 1e4)
    minutes, seconds = np.divmod(rest, 100.0)
    return HOUR * hours + 60.0 * minutes + seconds


def is_hhmmss(values: Vector) -> bool:
    """Return whether numbers are times of day as hhmmss.ss: minutes and seconds below 60, and a jump over 60 to 99."""
    numbers = values[np.isfinite(values)]
    if numbers.size < 3 or numbers.min() < 0.0 or numbers.max() >= 240000.0:
        return False
    if (numbers % 100.0 >= 60.0).any() or (numbers // 100.0 % 100.0 >= 60.0).any():
        return False
    steps = np.diff(numbers)
    usual = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    crosses = np.diff(numbers // 100.0) > 0.0
    jumps = np.where(np.diff(numbers // 1e4) > 0.0, steps - 4040.0, steps - 40.0)
    return bool(crosses.any() and (np.abs(jumps[crosses] - usual) <= _STEPS * usual + 1e-3).mean() > 0.5)


def cause_of_step_back(before: float, after: float, period: float) -> str:
    """Return the probable cause of a clock that runs backwards, and the remedy.

    Args:
        before: Last instant before the step [s].
        after: First instant after it [s].
        period: Usual time between samples [s].
    """
    lost, tolerance = before - after + period, _STEPS * period + 1e-6
    if abs(lost - DAY) <= max(tolerance, 1.0):
        return "A time of day passes midnight: add 86400 s to the instants after it"
    if abs(lost - HOUR) <= max(tolerance, 1.0):
        return "By one hour: daylight saving time ends, or the time zone changes; add 3600 s to the instants after it"
    for counter, count in _COUNTERS.items():
        for tick in _TICKS:
            if count * tick > 10.0 * period and abs(lost - count * tick) <= min(tolerance, 1e-3 * count * tick):
                return f"A counter of {counter} overflows: add {count * tick:.10g} s to the instants after it"
    if after < 10.0 * period + 1e-9 and before > 10.0 * period:
        return "The clock is set anew, as at the start of another recording: cut the file there"
    return "The clock is set back, or the rows are in another order: cut the file there, or restore their order"
