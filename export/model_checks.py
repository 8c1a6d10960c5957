"""The checks that run an artefact's model: what it takes, what it gives, and how fast."""

import statistics
import time
from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor

from navtool.export.golden import TOLERANCE
from navtool.export.manifest import Manifest, TensorSpec
from navtool.export.scripted import SCRIPT_ERRORS

CANDIDATES = 50
"""Candidate trajectories a tick whose latency is reported."""


class CheckFailed(Exception):  # noqa: N818 (a verdict, not an error)
    """The check does not hold; the message says what was seen."""


class Subject(NamedTuple):
    """An artefact's model with its golden tensors, in the order of the manifest."""

    manifest: Manifest
    model: torch.jit.ScriptModule
    inputs: tuple[Tensor, ...]
    expected: Tensor

    def run(self, *inputs: Tensor) -> Tensor:
        """The model's output."""
        return _tensor(self.model(*inputs))


def check_contract(subject: Subject) -> str:
    """The output has the declared type, shape and range."""
    spec = subject.manifest.outputs[0]
    fault = spec_fault(spec, subject.run(*subject.inputs), len(subject.inputs[0]))
    if fault:
        raise CheckFailed(fault)
    return f"{spec.name} {spec.dtype} {list(spec.shape)} in {spec.range}"


def check_refusals(subject: Subject) -> str:
    """Inputs of another type or shape are refused, each by itself."""
    for place, (spec, tensor) in enumerate(zip(subject.manifest.inputs, subject.inputs, strict=True)):
        for what, wrong in (("float64", tensor.double()), (f"shape {list(tensor[..., :-1].shape)}", tensor[..., :-1])):
            changed = (*subject.inputs[:place], wrong, *subject.inputs[place + 1 :])
            try:
                subject.model(*changed)
            except SCRIPT_ERRORS:
                continue
            raise CheckFailed(f"{spec.name} as {what} is accepted")
    return f"{2 * len(subject.inputs)} wrong inputs refused"


def check_parity(subject: Subject) -> str:
    """The output is the golden one."""
    gap = _gap(subject.run(*subject.inputs), subject.expected)
    return _within(gap, min(subject.manifest.golden_tolerance, TOLERANCE), "from the golden output")


def check_determinism(subject: Subject) -> str:
    """The same inputs give the same bits."""
    first = subject.run(*subject.inputs)
    for _ in range(2):
        if not torch.equal(first, subject.run(*subject.inputs)):
            raise CheckFailed("two runs on the same inputs differ")
    return "3 runs give the same bits"


def check_batches(subject: Subject) -> str:
    """A sample's output does not depend on what is batched with it."""
    together = subject.run(*subject.inputs)
    alone = torch.cat([subject.run(*(tensor[i : i + 1] for tensor in subject.inputs)) for i in range(len(together))])
    many = subject.run(*(tensor.repeat(2, *[1] * (tensor.dim() - 1)) for tensor in subject.inputs))
    gap = max(_gap(alone, together), _gap(many, together.repeat(2, 1)))
    return _within(gap, TOLERANCE, f"between batches of 1, {len(together)} and {len(many)}")


def check_candidates(subject: Subject) -> str:
    """Many trajectories on one encoding get what each gets by itself."""
    image, points, count, velocity, trajectory, reliability = subject.inputs
    features = subject.model.encode_sensors(image, points, count, velocity)
    turned = [trajectory.roll(shift, dims=0) for shift in range(3)]
    scores = subject.model.score_candidates(features, torch.stack(turned, dim=1), reliability)
    gaps = [
        _gap(scores[:, k], subject.run(image, points, count, velocity, candidate, reliability))
        for k, candidate in enumerate(turned)
    ]
    return _within(max(gaps), TOLERANCE, "between candidates together and alone")


def check_extremes(subject: Subject) -> str:
    """Blank sensors, no points, far points, fast motion: the output stays a probability."""
    image, points, count, velocity, trajectory, reliability = subject.inputs
    cases = {
        "nothing seen": tuple(torch.zeros_like(tensor) for tensor in subject.inputs),
        "white": (torch.full_like(image, 255), points, count, velocity, torch.full_like(trajectory, 255), reliability),
        "no points": (image, points, torch.zeros_like(count), velocity, trajectory, reliability),
        "far points": (image, points * 1e4, count, velocity, trajectory, reliability),
        "fast": (image, points, count, velocity * 1e3 + 1e3, trajectory, torch.ones_like(reliability)),
    }
    for name, inputs in cases.items():
        fault = spec_fault(subject.manifest.outputs[0], subject.run(*inputs), len(image))
        if fault:
            raise CheckFailed(f"{name}: {fault}")
    return f"finite and in range for {', '.join(cases)}"


def latency_ms(subject: Subject, runs: int) -> float:
    """Median time of one trajectory from raw inputs."""
    inputs = tuple(tensor[:1] for tensor in subject.inputs)
    return _median_ms(lambda: subject.run(*inputs), runs)


def candidates_latency_ms(subject: Subject, runs: int) -> float:
    """Median time of 50 trajectories on one encoding, encoding included."""
    image, points, count, velocity, trajectory, reliability = (tensor[:1] for tensor in subject.inputs)
    candidates = trajectory[:, None].repeat(1, CANDIDATES, 1, 1, 1)

    def tick() -> Tensor:
        features = subject.model.encode_sensors(image, points, count, velocity)
        return _tensor(subject.model.score_candidates(features, candidates, reliability))

    return _median_ms(tick, runs)


def spec_fault(spec: TensorSpec, tensor: Tensor, batch: int) -> str | None:
    """How a tensor breaks its declaration; None where it does not."""
    shape = tuple(batch if isinstance(size, str) else size for size in spec.shape)
    if str(tensor.dtype) != f"torch.{spec.dtype}":
        return f"{spec.name} is {str(tensor.dtype).removeprefix('torch.')}, declared {spec.dtype}"
    if tuple(tensor.shape) != shape:
        return f"{spec.name} has shape {list(tensor.shape)}, declared {list(spec.shape)}"
    if not bool(torch.isfinite(tensor).all()):
        return f"{spec.name} has values that are not finite"
    if spec.range is not None:
        low, high = float(tensor.min()), float(tensor.max())
        if low < spec.range[0] or high > spec.range[1]:
            return f"{spec.name} spans {low:g} to {high:g}, declared {spec.range[0]:g} to {spec.range[1]:g}"
    return None


def _within(gap: float, tolerance: float, where: str) -> str:
    seen = f"largest difference {gap:.2g} {where}, allowed {tolerance:g}"
    if not gap <= tolerance:
        raise CheckFailed(seen)
    return seen


def _gap(one: Tensor, other: Tensor) -> float:
    if one.shape != other.shape:
        raise CheckFailed(f"the output has shape {list(one.shape)}, wanted {list(other.shape)}")
    return float((one - other).abs().max())


def _tensor(output: object) -> Tensor:
    if not isinstance(output, Tensor):
        raise CheckFailed(f"the model returns a {type(output).__name__}, not a tensor")
    return output


def _median_ms(call: Callable[[], Tensor], runs: int) -> float:
    for _ in range(2):  # TorchScript optimises during the first runs
        call()
    times: list[float] = []
    for _ in range(runs):
        begin = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - begin))
    return statistics.median(times)
