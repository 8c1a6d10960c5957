"""TorchScript: named in one file, and refusing what an artefact does not declare."""

import pytest
import torch
from torch import Tensor, nn

from navtool.configs.schema import config_folder
from navtool.export.scripted import SCRIPT_ERRORS, script, told_by_script
from navtool.train.layers.checked_input import check_input


class Picky(nn.Module):
    """Takes pictures of 4 columns in batches of any size."""

    def forward(self, image: Tensor) -> Tensor:
        check_input(image, "image", "uint8", [-1, 3, -1, 4])
        return image.float()


def test_one_file_of_export_names_torchscript() -> None:
    folder = config_folder().parent / "export"
    naming = [path.name for path in sorted(folder.rglob("*.py")) if "torch.jit" in path.read_text(encoding="utf-8")]
    assert naming == ["scripted.py"]


@pytest.mark.parametrize("scripted", [False, True])
@pytest.mark.parametrize("shape", [(1, 3, 1, 4), (7, 3, 9, 4)])
def test_what_is_declared_is_taken(shape: tuple[int, ...], scripted: bool) -> None:
    module = script(Picky(), ["forward"]) if scripted else Picky()
    assert module(torch.ones(shape, dtype=torch.uint8)).sum() == torch.ones(shape).sum()


@pytest.mark.parametrize("scripted", [False, True])
@pytest.mark.parametrize(
    "tensor",
    [
        torch.ones(1, 3, 1, 4),
        torch.ones(1, 3, 1, 4, dtype=torch.int64),
        torch.ones(1, 3, 4, dtype=torch.uint8),
        torch.ones(1, 3, 1, 5, dtype=torch.uint8),
        torch.ones(1, 1, 1, 4, dtype=torch.uint8),
    ],
)
def test_anything_else_is_refused_with_a_message(tensor: Tensor, scripted: bool) -> None:
    module = script(Picky(), ["forward"]) if scripted else Picky()
    with pytest.raises((*SCRIPT_ERRORS, ValueError)) as caught:
        module(tensor)
    assert "image must be uint8 [-1, 3, -1, 4]" in told_by_script(caught.value)
