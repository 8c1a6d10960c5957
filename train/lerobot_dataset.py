"""LeRobot's data set with what lies beside the rows: each row's points, and its whole cloud.

This module needs ``lerobot``, which no other part of navtool does.
"""

from pathlib import Path
from typing import Any

import numpy as np
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from navtool.datasets.store.reader import NavDataset

POINTS = "lidar.points"
"""The key of a sample's points, float32 [10000, 3]; behind ``lidar.count`` of them they repeat."""
WHOLE = "lidar.whole."
"""Before ``xyz`` (float32 [n, 3], the sensor's frame) and what was recorded of ``intensity``, ``ring``, ``time_s``."""


class NavLeRobotDataset(LeRobotDataset):
    """A data set of navtool's in LeRobot's reader, with clouds in its samples."""

    def __init__(self, root: Path | str, *, whole_clouds: bool = False, **options: Any) -> None:
        """Open it.

        Args:
            root: The folder that ``navtool ingest --out`` wrote.
            whole_clouds: Whether samples hold the whole cloud too; its size differs from row to row, so that a batch
                needs a ``collate_fn`` of its own.
            options: LeRobotDataset's own: ``episodes``, ``delta_timestamps``, ``image_transforms`` and so on.

        Raises:
            DatasetsError: It is no data set of navtool's.
        """
        self._beside = NavDataset(root)
        self._whole_clouds = whole_clouds
        super().__init__(f"local/{Path(root).resolve().name}", root=root, **options)

    def __getitem__(self, idx: Any) -> Any:
        """A sample, or those of a slice, as LeRobot gives them, with their clouds."""
        found = super().__getitem__(idx)
        return [self._with_clouds(item) for item in found] if isinstance(found, list) else self._with_clouds(found)

    def _with_clouds(self, item: dict[str, Any]) -> dict[str, Any]:
        if not self._beside.description.contents.lidar:
            return item
        row = int(item["index"])
        item[POINTS] = torch.from_numpy(self._beside.points(row))
        cloud = self._beside.whole_cloud(row) if self._whole_clouds else None
        if self._whole_clouds:
            xyz = np.zeros((0, 3), np.float32) if cloud is None else np.ascontiguousarray(cloud.xyz)
            item[f"{WHOLE}xyz"] = torch.from_numpy(xyz)
        for name in ("intensity", "ring", "time_s"):
            values = getattr(cloud, name, None)
            if values is not None:
                item[f"{WHOLE}{name}"] = torch.from_numpy(values.copy())
        return item
