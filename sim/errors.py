"""The error of the sim package."""

from navtool.base.errors import NavtoolError


class SimError(NavtoolError):
    """A scenario cannot be simulated, or its recording cannot be written where it was asked for."""
