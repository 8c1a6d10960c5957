"""What an exported GrASPE network takes and gives."""

from navtool.datasets.store.schema import CLOUD_SIZE
from navtool.train.contract import Contract, TensorSpec
from navtool.train.graspe.config import GraspeConfig

METHODS = ("forward", "encode_sensors", "score_candidates")
"""``forward(inputs...)`` judges one trajectory. ``encode_sensors(image, points, count, velocity)`` and
``score_candidates(features, trajectory [batch, candidates, 1, h, w], reliability)`` judge many on one encoding."""


def graspe_contract(config: GraspeConfig) -> Contract:
    """The arguments of forward in the order of `navtool.train.success.samples.Sample.inputs`, and what it returns."""
    height, width = config.image_height, config.image_width
    inputs = (
        TensorSpec("image", ("batch", 3, height, width), "uint8", "1", (0, 255), "front camera, RGB; black if missing"),
        TensorSpec(
            "points", ("batch", CLOUD_SIZE, 3), "float32", "m", None, "[x, y, z] in base (REP-103), front half plane"
        ),
        TensorSpec("count", ("batch",), "int64", "1", (0, CLOUD_SIZE), "points in use, from the first"),
        TensorSpec(
            "velocity",
            ("batch", config.history, 2),
            "float32",
            "m/s, rad/s",
            None,
            "[v, omega] of base, one a row of the data set, oldest first, the current one last",
        ),
        TensorSpec(
            "trajectory", ("batch", 1, height, width), "uint8", "1", (0, 255), "front camera; 255 on the swath, else 0"
        ),
        TensorSpec("reliability", ("batch", 2), "float32", "1", (0, 1), "[r_img, r_point]; 0 for a missing sensor"),
    )
    frame = "success at the row itself and those that follow"
    outputs = (TensorSpec("success", ("batch", config.horizon), "float32", "1", (0, 1), frame),)
    return Contract(inputs, outputs, METHODS)
