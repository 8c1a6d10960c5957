"""The ground in the physics: a plane under each ball that may meet it, and plants that hold the legs."""

import math

import mujoco
import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.legged.body import IMPEDANCE, LEGS, PROBE_RADIUS_M, PROBES, STEP_S
from navtool.sim.legged.controller_config import CONTROL_S
from navtool.sim.legged.stems import bending_n
from navtool.sim.legged.terrain import Terrain

SOLE_NPM, SOLE_NSPM = 60_000.0, 400.0
"""Stiffness and damping of a foot's own sole, in series with the ground's. Chosen: the robot's whole weight on one
foot presses it in by 5 mm."""
_FEET, _BODY = slice(0, 4), slice(4, PROBES)
_BODY_EVERY, _NEAR_M = 5, 0.08
"""Knees and trunk, which meet the ground in falls alone, are looked after every fifth tick while they are further than
this above it: further than they can come down in that time."""
_STOPS_HZ = 0.9 / STEP_S
"""Damping that nearly stops a foot within a physics step; more would throw it back."""
_LIMB_M, _TRUNK_M = 0.33, 0.85
"""Lengths of a shank or thigh, and of the trunk."""
LIMB_WIDTHS_M = (*(0.044,) * 4, *(0.09,) * 4, 0.24)
"""How wide shanks, thighs and trunk are where they meet stems."""
_LOWEST_M = 0.1
"""Stems are met no lower than this: nearer to their roots they are pushed aside with the soil."""
_CREEP_MPS = 0.05
"""Slower limbs are held by stems in proportion to their speed: those bent already are not bent again."""
_STANDING_M = (0.0, 0.25, 0.41)
"""How high the lowest points of shanks, thighs and trunk are in a standing robot."""


def standing_length_m(cover_m: Float64[Array, " n"]) -> Float64[Array, " n"]:
    """Return how much of a standing robot's shanks, thighs and trunk is within a height above level ground, in m."""
    shank, thigh, trunk = (cover_m - low for low in _STANDING_M)
    legs = 4.0 * (np.clip(shank, 0.0, _LIMB_M) + np.clip(thigh, 0.0, _LIMB_M))
    return np.asarray(legs + _TRUNK_M * np.clip(trunk / (2.0 * PROBE_RADIUS_M[8]), 0.0, 1.0))


class Ground:
    """Gives each foot, knee and corner of the trunk one contact with the ground: that of the place where it is.

    A height field of MuJoCo's would give a foot as many contacts as there are triangles under it, each with the whole
    stiffness: the softness of a place would depend on where the grid's lines run.

    Args:
        terrain: The ground.
        model: The robot's model, whose contact parameters are set.

    Attributes:
        probes: MuJoCo's numbers of the balls that may meet the ground: feet, knees, corners of the trunk.
        limbs: MuJoCo's numbers of the bodies that plants hold: shanks, thighs, trunk.
    """

    def __init__(self, terrain: Terrain, model: mujoco.MjModel) -> None:
        self._terrain = terrain
        self._model = model
        self.probes = [model.geom(f"probe_{i}").id for i in range(PROBES)]
        self._trunk = model.body("trunk").id
        # in the order of the probes at their lower ends
        self.limbs = [model.body(f"{leg}_{part}").id for part in ("shank", "thigh") for leg in LEGS] + [self._trunk]
        bodies = model.geom_bodyid[self.probes]
        self._per_kg = (1 - IMPEDANCE) * model.body_invweight0[bodies, 0]
        self._limb_per_kg: list[float] = model.body_invweight0[:, 0].tolist()
        self._jacobian = np.zeros((3, model.nv))
        self._grip, self._ticks = np.zeros((PROBES, 6)), 0
        self._cover_top_m, self._low_m, self._depth_m = np.zeros((3, PROBES))

    def reset(self, data: mujoco.MjData) -> None:
        """Lay all planes anew."""
        self._ticks = 0
        self.lay(data)

    def lay(self, data: mujoco.MjData) -> None:
        """Put each plane where the ball above it will meet the ground, as grippy and as soft as the ground is there."""
        if self._ticks > 0:
            self._lay(data, _FEET)
        else:
            self._lay(data, slice(0, PROBES))
            self._ticks = 1 if self._depth_m[_BODY].max() > -_NEAR_M else _BODY_EVERY
        self._ticks -= 1

    def _lay(self, data: mujoco.MjData, part: slice) -> None:
        """Lay some of the planes.

        MuJoCo's contact force is -(K r + C v + M a): K = -solref[0] / ((1 - d) w), C likewise from solref[1], and M =
        d / ((1 - d) w) a mass that moves with the foot, where d is the impedance and w the body's inverse weight.
        """
        centre, radius = data.geom_xpos[self.probes[part]], PROBE_RADIUS_M[part]
        point, normal, grip = self._terrain.contact(centre, radius)
        data.mocap_pos[part] = point
        quaternion = data.mocap_quat[part]
        quaternion[:, 0] = 1.0 + normal[:, 2]
        quaternion[:, 1] = -normal[:, 1]
        quaternion[:, 2] = normal[:, 0]
        quaternion /= np.sqrt(2.0 * quaternion[:, :1])
        model, per_kg = self._model, self._per_kg[part]
        stiffness = 1.0 / (1.0 / grip[:, 1] + 1.0 / SOLE_NPM)
        model.pair_friction[part, :2] = grip[:, :1]
        model.pair_solref[part, 0] = -per_kg * stiffness
        model.pair_solref[part, 1] = -np.minimum(per_kg * (grip[:, 2] + SOLE_NSPM / SOLE_NPM * stiffness), _STOPS_HZ)
        self._grip[part], self._cover_top_m[part] = grip, point[:, 2] + grip[:, 4]
        self._low_m[part] = centre[:, 2] - radius
        self._depth_m[part] = radius - ((centre - point) * normal).sum(axis=1)

    def reaches(self, probes: slice) -> bool:
        """Return whether some of the balls touch the ground, as of the last `lay`."""
        return bool((self._depth_m[probes] > 0.0).any())

    def hold(self, data: mujoco.MjData, *, freed: bool = False) -> float:
        """Let plants and mud hold each part of the body as it moves through them, and return how hard, in N.

        Shanks, thighs and the trunk are rods; what of a rod's length is below the plants' tops is held in its middle:
        by drag that grows with its speed, and by the stems that it bends past. It is never held harder than stops it
        within a tick: however dense the plants, they give it no push.

        Args:
            data: The robot's state.
            freed: Whether they let go of it.
        """
        cover = self._grip[:, 4]
        data.xfrc_applied[self.limbs, :3] = 0.0
        if freed or not cover.any():
            return 0.0
        depth = self._cover_top_m - self._low_m
        total = 0.0
        drag, height_m, stems = self._grip[:9, 3:].T.tolist()
        for i, (limb, deep) in enumerate(zip(self.limbs, depth[:9].tolist(), strict=True)):
            length, height = (_TRUNK_M, 2.0 * PROBE_RADIUS_M[8]) if limb == self._trunk else (_LIMB_M, _LIMB_M)
            inside = length * min(max(deep / height, 0.0), 1.0)
            if inside > 0.0:
                mujoco.mj_jac(self._model, data, self._jacobian, None, data.xipos[limb], limb)
                velocity = self._jacobian @ data.qvel
                held = inside * drag[i]
                if stems[i] > 0.0:
                    middle = max(_LOWEST_M, height_m[i] - deep + 0.5 * min(deep, height))
                    bends = bending_n(stems[i], LIMB_WIDTHS_M[i], middle) * inside / length
                    held += bends / max(math.hypot(*velocity.tolist()), _CREEP_MPS)
                force = -held / (1.0 + held * self._limb_per_kg[limb] * CONTROL_S) * velocity
                data.xfrc_applied[limb, :3] = force
                total += math.hypot(*force.tolist())
        return total
