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


def require_extra(extra: str) -> None:
    """Do nothing where all libraries of an extra are installed.

    Raises:
        ModuleNotFoundError: One is not.
    """
    from importlib.util import find_spec

    for package in _EXTRAS[extra]:
        if find_spec(package) is None:
            raise ModuleNotFoundError(f"No module named {package!r}", name=package)


def missing_extra(error: ModuleNotFoundError) -> "NavtoolError | None":
    """The error that names the extra to install; None where the module belongs to none of them."""
    from navtool.base.errors import NavtoolError

    package = (error.name or "").partition(".")[0]
    for extra, packages in _EXTRAS.items():
        if package in packages:
            return NavtoolError(f"{package} is not installed", cure=f"pip install 'navtool[{extra}]'")
    return None
