from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import apply_transform, transform_from_xyz_rpy
from navtool.sim import lidar
from navtool.sim.ground import RELIEF_M, Terrain
from navtool.sim.scene import BRICK, BUSH, METAL, STONE, Scene, Thing
from navtool.sim.shapes import Box, Cylinder, Ellipsoid

HEIGHT_M = 0.7


def standing(x: float = 0.0, y: float = 0.0, yaw: float = 0.0, pitch: float = 0.0) -> Array:
    pose = transform_from_xyz_rpy(np.array([x, y, HEIGHT_M]), np.array([0.0, pitch, yaw]))
    return np.broadcast_to(pose, (lidar.COLUMNS, 4, 4))


def scan(scene: Scene, poses: Array, seed: int = 0) -> lidar.Scan:
    return lidar.scan(scene, poses, np.random.default_rng(seed))


def azimuth(cloud: lidar.Scan) -> Array:
    return np.arctan2(cloud.xyz[:, 1], cloud.xyz[:, 0])


def test_the_ground_lies_at_the_analytic_range_of_each_ring(flat_scene: Callable[..., Scene]) -> None:
    cloud = scan(flat_scene(), standing())
    for ring, elevation in enumerate(lidar.ring_elevation_rad()):
        found = np.linalg.norm(cloud.xyz[cloud.ring == ring], axis=1)
        if elevation > 0:
            assert found.size == 0, "nothing in the sky returns a beam"
        else:
            assert found.size == lidar.COLUMNS
            noise = lidar.RANGE_NOISE_M + RELIEF_M[Terrain.PATH] / max(np.sin(-elevation), 0.05)
            assert found.mean() == pytest.approx(
                HEIGHT_M / np.sin(-elevation), abs=5 * noise / np.sqrt(found.size) + 1e-3
            )
            assert found.std() < 1.5 * noise


def test_a_cylinder_ahead_is_met_at_its_front(flat_scene: Callable[..., Scene]) -> None:
    cloud = scan(flat_scene(Thing(Cylinder(5.0, 0.0, 0.3, 3.0), METAL)), standing())
    ring = 8
    angle = azimuth(cloud)[cloud.ring == ring]
    found = np.linalg.norm(cloud.xyz[cloud.ring == ring], axis=1) * np.cos(lidar.ring_elevation_rad()[ring])
    expected = 5 * np.cos(angle) - np.sqrt(0.09 - (5 * np.sin(angle)) ** 2)
    assert angle.size == pytest.approx(2 * np.arcsin(0.3 / 5) / (2 * np.pi) * lidar.COLUMNS, abs=2)
    assert found == pytest.approx(expected, abs=5 * lidar.RANGE_NOISE_M)


def test_a_wall_to_the_left_is_flat(flat_scene: Callable[..., Scene]) -> None:
    cloud = scan(flat_scene(Thing(Box(0.0, 4.0, 3.0, 0.2, 2.0, 0.0), BRICK)), standing())
    wall = cloud.xyz[(cloud.ring >= 8) & (np.abs(azimuth(cloud) - np.pi / 2) < 0.6)]
    assert len(wall) > 500
    assert wall[:, 1] == pytest.approx(np.full(len(wall), 3.8), abs=6 * lidar.RANGE_NOISE_M)


def test_leaves_return_from_inside_a_bush_and_let_beams_through(flat_scene: Callable[..., Scene]) -> None:
    bush = Ellipsoid(4.0, 0.0, 0.5, 1.0, 0.8)
    wall = Thing(Box(8.0, 0.0, 0.2, 4.0, 3.0, 0.0), BRICK)
    cloud = scan(flat_scene(Thing(bush, BUSH), wall), standing())
    rays = (cloud.ring == 8) & (np.abs(azimuth(cloud)) < 0.15)
    depth = np.linalg.norm(cloud.xyz[rays], axis=1)
    leaves = depth < 6
    assert 0.8 < leaves.mean() < 1.0
    assert np.ptp(depth[leaves]) > 0.8, "spread over the depth of the bush"
    inside = bush.clearance(cloud.xyz[rays][leaves].T[:2].astype(np.float64))
    assert (inside < 5 * lidar.RANGE_NOISE_M).all()


def test_rings_times_and_azimuths_belong_together(flat_scene: Callable[..., Scene]) -> None:
    cloud = scan(flat_scene(Thing(Box(3.0, 3.0, 2.0, 0.2, 2.0, 0.4), BRICK)), standing(yaw=1.0))
    elevation = np.arctan2(cloud.xyz[:, 2], np.hypot(cloud.xyz[:, 0], cloud.xyz[:, 1]))
    assert elevation == pytest.approx(lidar.ring_elevation_rad()[cloud.ring], abs=1e-4)
    assert (cloud.time_s > -lidar.SWEEP_S).all()
    assert cloud.time_s.max() == 0.0
    assert (np.diff(cloud.time_s) >= 0).all(), "in the order of firing"
    turned = -2 * np.pi * (cloud.time_s / lidar.SWEEP_S + 1 - 1 / lidar.COLUMNS)
    error = np.angle(np.exp(1j * (azimuth(cloud) - turned)))
    assert np.abs(error).max() < 1e-3, "clockwise from straight ahead"
    assert cloud.intensity.min() >= 1
    assert cloud.intensity.max() <= 100, "diffuse surfaces stay in the diffuse half of the scale"


def test_a_moving_sensor_distorts_its_cloud_as_the_time_of_each_point_says(flat_scene: Callable[..., Scene]) -> None:
    scene = flat_scene(Thing(Box(6.0, 0.0, 0.2, 5.0, 3.0, 0.0), BRICK))
    moments = lidar.column_time_s()
    xyz = np.stack([1.0 * moments, np.zeros_like(moments), np.full_like(moments, HEIGHT_M)], axis=-1)
    poses = transform_from_xyz_rpy(xyz, np.stack([0 * moments, 0 * moments, 0.8 * moments], axis=-1))
    cloud = scan(scene, poses)
    wall = (cloud.ring >= 9) & (np.abs(azimuth(cloud)) < 0.5)
    column = np.rint(cloud.time_s[wall] / lidar.SWEEP_S * lidar.COLUMNS).astype(int) - 1
    world = apply_transform(poses[column], cloud.xyz[wall][:, None, :].astype(np.float64))[:, 0]
    assert world[:, 0] == pytest.approx(np.full(len(world), 5.8), abs=6 * lidar.RANGE_NOISE_M)
    assert np.abs(cloud.xyz[wall][:, 0] - 5.8).max() > 0.15, "the raw cloud is bent"


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6))
def test_no_culled_body_hides_a_return(flat_scene: Callable[..., Scene], seed: int) -> None:
    rng = np.random.default_rng(seed)
    xy = rng.uniform(-6, 6, (12, 2))
    shapes = [Ellipsoid(x, y, 0.3, 0.5, 0.6) for x, y in xy[:4]] + [Cylinder(x, y, 0.2, 2.5) for x, y in xy[4:8]]
    walls = [Box(x, y, 1.5, 0.2, 1.5, float(rng.uniform(0, 3))) for x, y in xy[8:]]
    things = tuple(Thing(shape, STONE) for shape in (*shapes, *walls) if shape.clearance(np.zeros((2, 1)))[0] > 0.5)
    poses = standing(yaw=float(rng.uniform(-3, 3)), pitch=0.05)
    cloud = scan(flat_scene(*things), poses, seed)
    found = np.full((lidar.RINGS, lidar.COLUMNS), np.inf)
    column = np.rint(cloud.time_s / lidar.SWEEP_S * lidar.COLUMNS).astype(int) - 1
    found[cloud.ring, column] = np.linalg.norm(cloud.xyz, axis=1)
    elevation, turn = lidar.ring_elevation_rad()[:, None], lidar.column_azimuth_rad()[None, :]
    rays = np.stack([np.cos(elevation) * np.cos(turn), np.cos(elevation) * np.sin(turn), np.sin(elevation) + 0 * turn])
    world = np.einsum("ij,jrc->irc", poses[0, :3, :3], rays).astype(np.float32)
    origin = poses[0, :3, 3].astype(np.float32).reshape(3, 1, 1)
    expected: Array = np.full(found.shape, np.inf)
    with np.errstate(all="ignore"):
        for thing in things:
            span = thing.shape.span(origin, world)
            expected = np.where(
                (span.enter < span.leave) & (span.enter > 0), np.minimum(expected, span.enter), expected
            )
    met = np.isfinite(expected)
    assert (found[met] < expected[met] + 6 * lidar.RANGE_NOISE_M).all(), "each body within reach of a beam returns it"


def test_equal_generators_give_equal_clouds(place: Scene) -> None:
    first, second, other = (scan(place, standing(), seed) for seed in (4, 4, 5))
    assert all((a == b).all() for a, b in zip(first, second, strict=True))
    assert first.xyz.shape != other.xyz.shape or (first.xyz != other.xyz).any()
