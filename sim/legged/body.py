"""The quadruped's body: dimensions, joints, torque limits, and the MuJoCo model made from them.

Where the figures come from (all public; the model below is written from them, no file of others is used):

- Spot SDK documentation, "About Spot": 1.1 m x 0.5 m, net weight 32.5 kg, 12 joints; hip x +-45 degrees, hip y 91
  degrees to either side of a bias of 50 degrees from the vertical, knee 14 to 160 degrees from straight.
- Spot SDK documentation, "Joint control, supplemental data": gear ratio 51 and 0.88 N m of motor torque at both hip
  joints, 1.50 N m and a ratio that varies with the angle at the knee (a ball screw and push rod); the maximum at the
  knee by angle is the table that Boston Dynamics' AI Institute measured and published.
- The URDF published with Spot's ROS 2 driver: joint names, hips at (+-0.29785, +-0.055) m, 0.110945 m from hip x to
  hip y, knee at (0.025, -0.3205) m, foot 0.3365 m below the knee; 1.68, 2.34 and 0.35 kg of hip, thigh and shank.

Not published and chosen here: the trunk has the rest of the net weight, spread over a box of 0.62 x 0.20 x 0.16 m (its
moments of inertia then have the URDF's proportions); thigh and shank are even rods; rotor inertia, as felt at the
joint, 0.02 kg m2; foot radius 0.03 m; damping in the gears 0.4 N m s.
"""

from collections.abc import Sequence

import mujoco
import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.legged.obstacle import Obstacle, obstacle_xml

LEGS = ("front_left", "front_right", "rear_left", "rear_right")
"""The order of legs in every array."""
JOINT_NAMES = tuple(f"{leg}_{joint}" for leg in LEGS for joint in ("hip_x", "hip_y", "knee"))
"""The order of joints in every array; Spot's driver names them so in joint_states."""

HIPS_M = np.array([(x, y, 0.0) for x in (0.29785, -0.29785) for y in (0.055, -0.055)])
"""Positions of the hip x axes in the body frame, by leg."""
SIDES = np.array([1.0, -1.0, 1.0, -1.0])
"""+1 for a left leg, -1 for a right one."""
HIP_OFFSET_M = 0.110945
KNEE_X_M, KNEE_Z_M, SHANK_M = 0.025, -0.3205, 0.3365
FOOT_RADIUS_M = 0.03

MASS_KG = 32.5
HIP_KG, THIGH_KG, SHANK_KG = 1.68, 2.34, 0.35
LEG_KG = HIP_KG + THIGH_KG + SHANK_KG
TRUNK_KG = MASS_KG - 4 * LEG_KG
TRUNK_BOX_M = (0.62, 0.20, 0.16)
ARMATURE_KGM2 = 0.02
JOINT_DAMPING_NMS = 0.4

JOINT_LOW_RAD = np.tile([-np.pi / 4, np.radians(50 - 91) - 0.183, np.radians(-160)], 4)
JOINT_HIGH_RAD = np.tile([np.pi / 4, np.radians(50 + 91) - 0.166, np.radians(-14)], 4)
"""Hip y as in the URDF, which has another bias in each direction: -0.899 and 2.295 rad."""

HIP_TORQUE_NM = 51 * 0.88
_KNEE_ANGLE_RAD = (-2.793, -2.512, -2.258, -2.004, -1.749, -1.444, -1.189, -0.909, -0.654, -0.399, -0.247)
_KNEE_TORQUE_NM = (37.2, 61.2, 80.6, 96.5, 107.8, 113.2, 109.7, 96.4, 76.1, 49.2, 30.6)

STEP_S = 0.002
"""Time step of the physics."""
_PROBE_RADII_M = (*(FOOT_RADIUS_M,) * 4, *(0.045,) * 4, *(0.09,) * 4)
PROBES = len(_PROBE_RADII_M)
"""Spheres that meet the ground: four feet, four knees, four lower corners of the trunk."""
PROBE_RADIUS_M = np.array(_PROBE_RADII_M)
TRUNK_PROBES = slice(8, 12)
IMPEDANCE = 0.7
"""MuJoCo's contact impedance d, constant: a contact then is a spring and a damper whose stiffness we can state."""


def knee_torque_limit(angle_rad: Float64[Array, "*any"]) -> Float64[Array, "*any"]:
    """Return the largest torque in N m that the knee's linkage passes on at an angle."""
    return np.asarray(np.interp(angle_rad, _KNEE_ANGLE_RAD, _KNEE_TORQUE_NM))


def torque_limit(angle_rad: Float64[Array, "12"]) -> Float64[Array, "12"]:
    """Return the largest torque in N m of each joint at its angle."""
    limit = np.full(12, HIP_TORQUE_NM)
    limit[2::3] = knee_torque_limit(angle_rad[2::3])
    return limit


def build(obstacles: Sequence[Obstacle] = ()) -> mujoco.MjModel:
    """Return the model of one robot above a ground of its own, among solid obstacles.

    The ground is one plane for each probe, moved under it as the terrain demands: a foot has exactly one contact with
    the ground, with the normal, stiffness, damping and friction of the place where it stands.
    """
    return mujoco.MjModel.from_xml_string(model_xml(obstacles))


def model_xml(obstacles: Sequence[Obstacle] = ()) -> str:
    """Return the model as MJCF."""
    planes = "".join(
        f'<body name="ground_{i}" mocap="true"><geom name="ground_{i}" type="plane" size="1 1 1" contype="0"'
        f' conaffinity="0"/></body>'
        for i in range(PROBES)
    )
    pairs = "".join(
        f'<pair geom1="ground_{i}" geom2="probe_{i}" condim="3" solimp="{IMPEDANCE} {IMPEDANCE} 0.001"/>'
        for i in range(PROBES)
    )
    motors = "".join(
        f'<general name="{name}" joint="{name}" gainprm="1" biastype="affine" biasprm="0 0 0"/>' for name in JOINT_NAMES
    )
    touch = "".join(f'<touch name="{leg}_force" site="{leg}_foot"/>' for leg in LEGS)
    corners = "".join(
        f'<geom name="probe_{8 + i}" type="sphere" size="0.09" pos="{x} {y} 0" class="probe"/>'
        for i, (x, y) in enumerate((x, y) for x in (0.36, -0.36) for y in (0.05, -0.05))
    )
    legs = "".join(_leg_xml(i) for i in range(4))
    return f"""
<mujoco model="quadruped">
  <compiler angle="radian" autolimits="true" inertiafromgeom="false"/>
  <option timestep="{STEP_S}" integrator="implicitfast" cone="elliptic" impratio="10" iterations="20" tolerance="1e-7"/>
  <default>
    <default class="probe"><geom contype="0" conaffinity="0"/></default>
    <default class="shell"><geom contype="0" conaffinity="1" friction="0.6"/></default>
    <default class="joint"><joint type="hinge" damping="{JOINT_DAMPING_NMS}" armature="{ARMATURE_KGM2}"/></default>
  </default>
  <worldbody>
    {planes}
    {"".join(obstacle_xml(i, obstacle) for i, obstacle in enumerate(obstacles))}
    <body name="trunk" pos="0 0 0.55">
      <freejoint name="root"/>
      <inertial pos="0 0 -0.005" mass="{TRUNK_KG}" diaginertia="{_box_inertia(TRUNK_KG, TRUNK_BOX_M)}"/>
      <geom name="trunk" type="box" size="0.425 0.12 0.09" class="shell"/>
      <site name="imu" pos="0 0 0"/>
      {corners}
      {legs}
    </body>
  </worldbody>
  <contact>{pairs}</contact>
  <actuator>{motors}</actuator>
  <sensor>
    <accelerometer name="specific_force" site="imu"/><gyro name="rates" site="imu"/>{touch}
  </sensor>
</mujoco>"""


def _leg_xml(leg: int) -> str:
    name, side = LEGS[leg], SIDES[leg]
    x, y, _ = HIPS_M[leg]
    low, high = JOINT_LOW_RAD, JOINT_HIGH_RAD
    # the knee's torque limit is set anew with its angle; a range has to be there for it to count
    ranges = [f'range="{low[i]} {high[i]}" actuatorfrcrange="{-HIP_TORQUE_NM} {HIP_TORQUE_NM}"' for i in range(3)]
    return f"""
      <body name="{name}_hip" pos="{x} {y} 0">
        <joint name="{name}_hip_x" class="joint" axis="1 0 0" {ranges[0]}/>
        <inertial pos="{-0.005 * np.sign(x)} {0.013 * side} 0" mass="{HIP_KG}" diaginertia="0.0021 0.0018 0.0023"/>
        <body name="{name}_thigh" pos="0 {HIP_OFFSET_M * side} 0">
          <joint name="{name}_hip_y" class="joint" axis="0 1 0" {ranges[1]}/>
          <inertial pos="0.005 {-0.002 * side} -0.121" mass="{THIGH_KG}" diaginertia="{_rod_inertia(THIGH_KG, 0.36)}"/>
          <geom type="capsule" fromto="0 0 0 {KNEE_X_M} 0 {KNEE_Z_M}" size="0.045" class="shell"/>
          <geom name="probe_{4 + leg}" type="sphere" size="0.045" pos="{KNEE_X_M} 0 {KNEE_Z_M}" class="probe"/>
          <body name="{name}_shank" pos="{KNEE_X_M} 0 {KNEE_Z_M}">
            <joint name="{name}_knee" class="joint" axis="0 1 0" {ranges[2]}/>
            <inertial pos="0.002 0 -0.18" mass="{SHANK_KG}" diaginertia="{_rod_inertia(SHANK_KG, 0.36)}"/>
            <geom type="capsule" fromto="0 0 -0.03 0 0 {-SHANK_M}" size="0.022" class="shell"/>
            <geom name="probe_{leg}" type="sphere" size="{FOOT_RADIUS_M}" pos="0 0 {-SHANK_M}" class="probe"/>
            <site name="{name}_foot" type="sphere" size="{1.6 * FOOT_RADIUS_M}" pos="0 0 {-SHANK_M}"/>
          </body>
        </body>
      </body>"""


def _box_inertia(mass_kg: float, size_m: tuple[float, float, float]) -> str:
    x, y, z = (side * side for side in size_m)
    return f"{mass_kg / 12 * (y + z)} {mass_kg / 12 * (x + z)} {mass_kg / 12 * (x + y)}"


def _rod_inertia(mass_kg: float, length_m: float) -> str:
    across = mass_kg / 12 * length_m**2
    return f"{across} {across} {mass_kg * 0.03**2}"
