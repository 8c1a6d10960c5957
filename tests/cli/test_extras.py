"""A command without the extra that it needs says in one line which one that is."""

import subprocess
import sys
from pathlib import Path

import pytest

from navtool.cli.extras import missing_extra

CALLS = {
    "train": ["train", "--data", "{there}", "--out", "{there}/run"],
    "train --resume": ["train", "--resume", "{there}"],
    "evaluate": ["evaluate", "{there}"],
    "export": ["export", "{there}", "--out", "{there}/artefact"],
    "verify": ["verify", "{there}"],
}


@pytest.mark.parametrize("call", CALLS)
def test_without_the_extra_train_one_line_names_it(call: str, tmp_path: Path) -> None:
    arguments = ["navtool", *(argument.format(there=tmp_path) for argument in CALLS[call])]
    hidden = ("torch", "torchvision", "lightning", "safetensors", "tensorboard", "matplotlib")
    code = f"import sys; sys.modules |= dict.fromkeys({hidden}); sys.argv = {arguments!r}\n"
    code += "from navtool.cli.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)  # noqa: S603
    error, cure = [line for line in done.stderr.splitlines() if line.strip()]
    assert done.returncode == 1
    assert error.startswith("error: ")
    assert error.endswith(" is not installed")
    assert cure == "  cure: pip install 'navtool[train]'"
    assert list(tmp_path.rglob("*.pt")) == []


def test_the_simulators_extra_is_named_before_anything_is_made(tmp_path: Path) -> None:
    arguments = ["navtool", "simulate", "--out", str(tmp_path / "bags"), "--episodes", "2"]
    code = "import importlib.util as u, sys; found = u.find_spec\n"
    code += "u.find_spec = lambda name, *rest: None if name == 'embreex' else found(name, *rest)\n"
    code += f"sys.argv = {arguments!r}\nfrom navtool.cli.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)  # noqa: S603
    assert done.returncode == 1
    error, cure = [line for line in done.stderr.splitlines() if line.strip()]
    assert (error, cure) == ("error: embreex is not installed", "  cure: pip install 'navtool[sim]'")
    assert not (tmp_path / "bags").exists()


def test_a_module_of_no_extra_is_a_fault_of_ours() -> None:
    assert missing_extra(ModuleNotFoundError(name="navtool.nothing")) is None
    found = missing_extra(ModuleNotFoundError(name="mujoco.viewer"))
    assert found is not None
    assert "navtool[sim]" in str(found)
