"""Random numbers as a function of (seed, epoch)."""

import numpy as np
import torch


def seed_torch(*key: int) -> None:
    """Set torch's global generators from a key such as (seed, epoch): dropout and initialisation follow from it.

    Distinct keys give independent streams, which consecutive plain seeds do not promise.
    """
    torch.manual_seed(int(np.random.SeedSequence(key).generate_state(1, np.uint64)[0] >> np.uint64(1)))
