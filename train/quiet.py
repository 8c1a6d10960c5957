"""A trainer that says only what a user can act on."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

_LOGGERS = ("lightning.pytorch", "lightning.fabric", "lightning.pytorch.utilities.rank_zero")
_KNOWN = (
    r".*does not have many workers.*",  # trainer.workers is the user's choice; perf/data_wait_s shows its price
    r".*is smaller than the logging interval.*",  # figures are per epoch
    r".*LeafSpec.* is deprecated.*",  # Lightning 2.6 on torch 2.11, inside its own loaders
)


@contextmanager
def quiet_lightning() -> Iterator[None]:
    """Hold back Lightning's hints and its known warnings; other warnings and all errors pass."""
    loggers = [logging.getLogger(name) for name in _LOGGERS]
    levels = [logger.level for logger in loggers]
    with warnings.catch_warnings():
        for message in _KNOWN:
            warnings.filterwarnings("ignore", message=message)
        try:
            for logger in loggers:
                logger.setLevel(logging.ERROR)
            yield
        finally:
            for logger, level in zip(loggers, levels, strict=True):
                logger.setLevel(level)
