"""GrASPE in the table of models."""

from navtool.train.contract import forward
from navtool.train.errors import TrainError
from navtool.train.graspe.candidates import CANDIDATES, SAME_AS_ALONE, tick
from navtool.train.graspe.config import GraspeConfig
from navtool.train.graspe.contract import graspe_contract
from navtool.train.graspe.graspe import Graspe
from navtool.train.graspe.onboard import OnboardGraspe
from navtool.train.model_kind import ModelKind
from navtool.train.source import NavSource
from navtool.train.success.samples import Sample
from navtool.train.success.task import SUCCESS
from navtool.train.synthetic import SyntheticConfig, SyntheticSource


def check_image_size(source: NavSource, episode: int, config: GraspeConfig) -> None:
    """Do nothing where an episode's images have the network's size.

    Raises:
        TrainError: They have another one.
    """
    camera = source.calibration(episode).camera
    wanted = (config.image_width, config.image_height)
    if camera is not None and (camera.width, camera.height) != wanted:
        raise TrainError(
            f"the data set's images are {camera.width}x{camera.height} pixels, the network's {wanted[0]}x{wanted[1]}",
            where="model.image_width",
            cure=f"set model.image_width={camera.width} and model.image_height={camera.height}",
        )


def _stand_in(config: GraspeConfig) -> SyntheticSource:
    size = SyntheticConfig(rows=30, image_height=config.image_height, image_width=config.image_width)
    return SyntheticSource(size)


GRASPE = ModelKind(
    task=SUCCESS,
    config=GraspeConfig,
    build=Graspe,
    inputs=Sample.inputs,
    begin=Graspe.load_pretrained_image_weights,
    check_source=check_image_size,
    stand_in=_stand_in,
    contract=graspe_contract,
    onboard=OnboardGraspe,
    laws={"candidates": SAME_AS_ALONE},
    timed={"one trajectory": forward, f"{CANDIDATES} candidates": tick},
)
"""Success along a candidate trajectory from camera, LiDAR, velocities and their reliability."""
