import re
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array

ROOT = Path(__file__).parents[2]


def test_the_array_type_is_a_class_as_jaxtyping_wants_it() -> None:
    assert issubclass(Array, np.ndarray)
    points: Any = Float32[Array, "n 3"]
    assert isinstance(np.zeros((2, 3), np.float32), points)
    assert not isinstance(np.zeros((2, 4), np.float32), points)


def test_shapes_stand_around_a_class() -> None:
    """``NDArray[...]`` is none from NumPy 2.5 on: a module that wraps it in a shape cannot be imported there."""
    folders = [folder.parent for folder in ROOT.glob("*/*.py") if folder.parent.name not in ("build", "tests")]
    sources = [source for folder in dict.fromkeys(folders) for source in folder.rglob("*.py")]
    assert len(sources) > 300
    wrapped = re.compile(r"\b(Float|Int|UInt|Bool|Shaped|Num|Real)[0-9]*\[NDArray")
    assert [file.name for file in sources if wrapped.search(file.read_text(encoding="utf-8"))] == []
