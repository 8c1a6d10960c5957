"""The predicted trajectory as the camera of an episode sees it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.trajectory_image import TrajectoryImageConfig, trajectory_image
from navtool.train.errors import TrainError
from navtool.train.source import NavSource
from navtool.train.success.windows import DataConfig


@dataclass(frozen=True, slots=True)
class TrajectoryPainter:
    """Draws trajectories into images of one episode's camera."""

    camera: CameraModel
    """At the size of the stored images."""
    base_camera: NDArray[np.float64]
    """Pose of the camera's optical frame in base."""
    base_height_m: float
    """Height of base above the ground."""
    trajectory: TrajectoryImageConfig
    """Horizon, step and width."""

    def draw(self, velocity: NDArray[np.float32]) -> NDArray[np.uint8]:
        """The swath of [v_mps, omega_radps], (h, w) of 0 and 255."""
        return trajectory_image(
            velocity,
            self.camera,
            self.base_camera,
            self.trajectory,
            height=self.camera.height,
            width=self.camera.width,
            base_height_m=self.base_height_m,
        )


def painter_of(source: NavSource, episode: int, config: DataConfig) -> TrajectoryPainter:
    """The painter of an episode; its time step is one row of the data set.

    Raises:
        TrainError: The episode has no calibrated camera.
    """
    calibration = source.calibration(episode)
    if calibration.camera is None or calibration.base_camera is None:
        raise TrainError(
            f"episode {episode} has no calibrated camera, so no trajectory can be drawn",
            where=source.episodes[episode].source,
            cure="ingest it with a robot configuration that has a camera and its mounting",
        )
    width_m = calibration.robot_width_m if config.robot_width_m is None else config.robot_width_m
    trajectory = TrajectoryImageConfig(robot_width_m=width_m, horizon=config.horizon_steps, dt_s=1.0 / source.fps)
    return TrajectoryPainter(calibration.camera, calibration.base_camera, calibration.base_height_m, trajectory)
