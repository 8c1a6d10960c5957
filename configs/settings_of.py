"""The settings of a job alone."""

from dataclasses import Field, fields
from typing import Any, ClassVar, Protocol


class _Settings(Protocol):
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]


def settings_of[S: _Settings](job: S, settings: type[S]) -> S:
    """The part of a job that its library function takes.

    Args:
        job: A dataclass that adds to the settings what else a command needs.
        settings: The dataclass of the settings, from which the job's is derived.
    """
    return settings(**{entry.name: getattr(job, entry.name) for entry in fields(settings)})
