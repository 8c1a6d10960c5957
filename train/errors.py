"""The error of the train package."""

from navtool.base.errors import NavtoolError


class TrainError(NavtoolError):
    """A run, a checkpoint or a split cannot be used as it is."""
