"""Which extra of navtool brings a library that is not installed."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from navtool.base.errors import NavtoolError

_EXTRAS = {
    "train": ("lightning", "matplotlib", "safetensors", "tensorboard", "torch", "torchvision"),
    "draco": ("DracoPy",),
    "sim": ("embreex", "mujoco"),
    "lerobot": ("lerobot",),
    "sweep": ("hydra_plugins", "joblib", "optuna"),
}


def missing_extra(error: ModuleNotFoundError) -> "NavtoolError | None":
    """The error that names the extra to install; None where the module belongs to none of them."""
    from navtool.base.errors import NavtoolError

    package = (error.name or "").partition(".")[0]
    for extra, packages in _EXTRAS.items():
        if package in packages:
            return NavtoolError(f"{package} is not installed", cure=f"pip install 'navtool[{extra}]'")
    return None
