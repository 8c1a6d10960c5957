"""The usual checks of settings; each gives what it found wrong, for `refuse`."""

import math

from navtool.base.setting_error import Fault


def outside(
    settings: object,
    low: float,
    high: float,
    *names: str,
    unit: str = "",
    above: bool = False,
    below: bool = False,
    cure: str | None = None,
) -> list[Fault]:
    """Faults of the settings that are not within ``[low, high]``, or are no number; None passes, as no value.

    Args:
        settings: The dataclass.
        low: The least value.
        high: The largest value; infinity for none.
        names: Fields of the dataclass that are numbers.
        unit: Of the values.
        above: Whether they have to be above ``low``, not only at it.
        below: Whether they have to be below ``high``; with infinity, whether they have to be finite.
        cure: What the user can do about it.
    """
    faults = []
    for name in names:
        value = getattr(settings, name)
        if value is None:
            continue
        high_enough = value > low if above else value >= low
        low_enough = value < high if below else value <= high
        if not (high_enough and low_enough):
            faults.append(
                Fault(name, f"{_with(value, unit)} is {_not(low, high, unit, above=above, below=below)}", cure)
            )
    return faults


def fault(key: str, what: str, cure: str | None = None, *, when: bool) -> list[Fault]:
    """The one fault, where there is one."""
    return [Fault(key, what, cure)] if when else []


def _not(low: float, high: float, unit: str, *, above: bool, below: bool) -> str:
    if math.isinf(high):
        finite = " and finite" if below else ""
        return f"not above {low:g}{finite}" if above else f"not {low:g} or more{finite}"
    return f"outside {_with(f'{"(" if above else "["}{low:g}, {high:g}{")" if below else "]"}', unit)}"


def _with(value: object, unit: str) -> str:
    said = f"{value:g}" if isinstance(value, float) and float(f"{value:g}") == value else str(value)
    return f"{said} {unit}" if unit else said
