"""Whether and where a run may begin, or go on."""

from navtool.base.plain import flatten
from navtool.train.checkpoint import check_stamp, read_checkpoint
from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.run_folder import RunFolder

_MAY_CHANGE = {"trainer.epochs", "trainer.device", "trainer.workers", "trainer.figure_samples", "data.cache_mib"}
"""Settings that a resumed run may have otherwise: they do not change what an epoch computes."""


def first_epoch(folder: RunFolder, config: TrainConfig, *, resume: bool) -> int:
    """The epoch that training begins with: 0, or the one after the last whole epoch of the run in the folder.

    Raises:
        TrainError: The folder holds something else, holds a run that is not to be resumed, or one with other settings
            or a damaged checkpoint.
    """
    if resume and folder.last.is_file():
        _check_same_settings(folder.read_config(), config)
        content = read_checkpoint(folder.last)
        check_stamp(content, folder.last, config)
        epoch = content.get("epoch")
        if not isinstance(epoch, int):
            raise TrainError("does not say its epoch", where=folder.last, cure="begin a new run in another folder")
        return epoch + 1
    if folder.last.is_file():
        raise TrainError("holds a run already", where=folder.path, cure="resume it, or choose another folder")
    if folder.path.exists() and not folder.path.is_dir():
        raise TrainError("is a file", where=folder.path, cure="choose a folder")
    foreign = [] if folder.exists() or not folder.path.is_dir() else _visible(folder)
    if foreign:
        raise TrainError(f"holds other files ({', '.join(foreign[:3])})", where=folder.path, cure="choose a new folder")
    return 0


def _visible(folder: RunFolder) -> list[str]:
    return sorted(
        path.name for path in folder.path.iterdir() if not path.name.startswith(".") and path.suffix != ".log"
    )


def _check_same_settings(old: TrainConfig, new: TrainConfig) -> None:
    before, now = flatten(old), flatten(new)
    changed = sorted(key for key in before | now if before.get(key) != now.get(key) and key not in _MAY_CHANGE)
    if changed:
        listed = ", ".join(f"{key} ({before.get(key)} before, {now.get(key)} now)" for key in changed)
        raise TrainError(
            f"a resumed run keeps its settings, but these differ: {listed}",
            where="config.json",
            cure="leave them out, or begin a new run in another folder",
        )
