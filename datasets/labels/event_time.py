"""The times of an events file."""

from datetime import datetime
from decimal import Decimal, InvalidOperation

_UNIX_S = Decimal(100_000_000)
"""Numbers from here on are seconds since 1970: the year 1973, or a recording of three years."""
_UNIX_TOO_LATE_S = Decimal(100_000_000_000)
_UNIX_NS = Decimal(100_000_000_000_000_000)
_UNIX_TOO_LATE_NS = Decimal(10_000_000_000_000_000_000)


def time_ns(value: object, zero_ns: int) -> int:
    """A time of an events file in nanoseconds since 1970.

    Args:
        value: A number, as text or not: seconds since ``zero_ns`` below 1e8, seconds since 1970 below 1e11, whole
            nanoseconds since 1970 from 1e17 on. Or ISO 8601 text with a time zone, such as 2015-05-21T17:02:11.5Z.
        zero_ns: What small numbers are counted from.

    Raises:
        ValueError: If it is none of these.
    """
    number = _number(value)
    if number is None:
        return _moment_ns(value)
    if 0 <= number < _UNIX_S:
        return zero_ns + round(number * 1_000_000_000)
    if _UNIX_S <= number < _UNIX_TOO_LATE_S:
        return round(number * 1_000_000_000)
    if _UNIX_NS <= number < _UNIX_TOO_LATE_NS and number == number.to_integral_value():
        return int(number)
    raise ValueError(f"{value!r} is neither seconds from 0 on nor nanoseconds since 1970")


def _number(value: object) -> Decimal | None:
    if isinstance(value, bool) or not isinstance(value, str | int | Decimal):
        return None
    try:
        number = Decimal(value)
    except InvalidOperation:
        return None
    return number if number.is_finite() else None


def _moment_ns(value: object) -> int:
    try:
        moment = datetime.fromisoformat(str(value))
    except ValueError:
        raise ValueError(f"{value!r} is neither a number nor a time such as 2015-05-21T17:02:11Z") from None
    if moment.tzinfo is None:
        raise ValueError(f"{value!r} has no time zone; write Z behind it for UTC")
    return int(moment.replace(microsecond=0).timestamp()) * 1_000_000_000 + moment.microsecond * 1000
