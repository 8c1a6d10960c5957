"""The table of methods: what the command line needs of each to walk it along a recording."""

from dataclasses import dataclass

from navtool.base.errors import DatasetsError


@dataclass(frozen=True, slots=True)
class MethodRow:
    """A method, as it is looked up by its name."""

    method: str
    """``module:class``, imported when it is walked; it is made of the settings alone."""
    inputs: str
    """What a user is asked for where no input was named."""
    several: bool = False
    """Whether it takes several inputs."""


METHODS: dict[str, MethodRow] = {
    "intensity_map": MethodRow(
        method="navtool.methods.intensity_map.maps:IntensityMaps",
        inputs="name one recording, or one data set",
    ),
    "intensity_threshold": MethodRow(
        method="navtool.methods.intensity_map.threshold:IntensityThreshold",
        inputs="name recordings, or one data set",
        several=True,
    ),
}
"""The methods by the names of their configurations."""


def method_row(name: str) -> MethodRow:
    """The row of a method.

    Raises:
        DatasetsError: There is none of this name; those that there are, are listed.
    """
    if name not in METHODS:
        raise DatasetsError(f"no method is called {name!r}", cure=f"known are {', '.join(METHODS)}")
    return METHODS[name]
