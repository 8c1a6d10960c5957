"""The checks that run an artefact's model: what it takes, what it gives, and how fast."""

import statistics
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import torch
from torch import Tensor

from navtool.export.golden import TOLERANCE
from navtool.export.manifest import Manifest
from navtool.export.outputs import largest_gap, outputs_of
from navtool.export.scripted import SCRIPT_ERRORS, Scripted
from navtool.train.contract import Law, TensorSpec, Timed

_FAR = 1e4
"""What inputs without a bound are multiplied by, to look at extremes."""


class CheckFailed(Exception):  # noqa: N818 (a verdict, not an error)
    """The check does not hold; the message says what was seen."""


class Subject(NamedTuple):
    """An artefact's model with its golden tensors, in the order of the manifest."""

    manifest: Manifest
    model: Scripted
    inputs: tuple[Tensor, ...]
    expected: tuple[Tensor, ...]

    @property
    def batch(self) -> int:
        """Number of golden samples."""
        return len(self.inputs[0])

    def run(self, inputs: tuple[Tensor, ...]) -> tuple[Tensor, ...]:
        """The model's outputs."""
        return outputs_of(self.model, inputs)

    def with_input(self, place: int, tensor: Tensor) -> tuple[Tensor, ...]:
        """The golden inputs, one of them exchanged."""
        return (*self.inputs[:place], tensor, *self.inputs[place + 1 :])


def check_contract(subject: Subject) -> str:
    """The outputs have the declared types, shapes and ranges."""
    _check_outputs(subject, subject.inputs)
    return ", ".join(
        f"{spec.name} {spec.dtype} {list(spec.shape)} in {spec.range}" for spec in subject.manifest.outputs
    )


def check_refusals(subject: Subject) -> str:
    """Inputs of another type or shape are refused, each by itself."""
    for place, (spec, tensor) in enumerate(zip(subject.manifest.inputs, subject.inputs, strict=True)):
        cut = tensor[..., :-1] if isinstance(spec.shape[-1], int) else tensor[..., 0]
        for what, wrong in (("float64", tensor.double()), (f"shape {list(cut.shape)}", cut)):
            try:
                subject.model(*subject.with_input(place, wrong))
            except SCRIPT_ERRORS:
                continue
            raise CheckFailed(f"{spec.name} as {what} is accepted")
    return f"{2 * len(subject.inputs)} wrong inputs refused"


def check_parity(subject: Subject) -> str:
    """The outputs are the golden ones."""
    gap = largest_gap(subject.run(subject.inputs), subject.expected)
    return within(gap, "from the golden output", min(subject.manifest.golden_tolerance, TOLERANCE))


def check_determinism(subject: Subject) -> str:
    """The same inputs give the same bits."""
    first = subject.run(subject.inputs)
    for _ in range(2):
        if not all(map(torch.equal, first, subject.run(subject.inputs))):
            raise CheckFailed("two runs on the same inputs differ")
    return "3 runs give the same bits"


def check_batches(subject: Subject) -> str:
    """A sample's output does not depend on what is batched with it."""
    together, count = subject.run(subject.inputs), subject.batch
    parts = [subject.run(tuple(tensor[i : i + 1] for tensor in subject.inputs)) for i in range(count)]
    alone = [torch.cat(outputs) for outputs in zip(*parts, strict=True)]
    twice = subject.run(tuple(torch.cat([tensor, tensor]) for tensor in subject.inputs))
    gap = max(largest_gap(alone, together), largest_gap(twice, [torch.cat([tensor, tensor]) for tensor in together]))
    return within(gap, f"between batches of 1, {count} and {2 * count}")


def check_law(subject: Subject, law: Law) -> str:
    """A law of this kind of model holds."""
    return within(law.gap(subject.model, subject.inputs), law.between)


def check_extremes(subject: Subject) -> str:
    """At the bounds of each input, and far beyond where there are none, the outputs stay finite and in range."""
    cases = dict(_extremes(subject))
    for name, inputs in cases.items():
        try:
            _check_outputs(subject, inputs)
        except CheckFailed as failed:
            raise CheckFailed(f"{name}: {failed}") from failed
    return f"finite and in range for {', '.join(cases)}"


def _extremes(subject: Subject) -> Iterator[tuple[str, tuple[Tensor, ...]]]:
    """Inputs with the name of what is extreme in them."""
    yield "all zero", tuple(torch.zeros_like(tensor) for tensor in subject.inputs)
    for place, (spec, tensor) in enumerate(zip(subject.manifest.inputs, subject.inputs, strict=True)):
        if spec.range is None:
            yield f"{spec.name} x {_FAR:g}", subject.with_input(place, tensor * _FAR)
            continue
        for bound in spec.range:
            yield f"{spec.name} = {bound:g}", subject.with_input(place, torch.full_like(tensor, bound))


def latency_ms(subject: Subject, timed: Timed, runs: int) -> float:
    """Median time on the first golden sample."""
    inputs = tuple(tensor[:1] for tensor in subject.inputs)
    return _median_ms(lambda: timed(subject.model, inputs), runs)


def spec_fault(spec: TensorSpec, tensor: Tensor, batch: int) -> str | None:
    """How a tensor breaks its declaration; None where it does not."""
    if str(tensor.dtype) != f"torch.{spec.dtype}":
        return f"{spec.name} is {str(tensor.dtype).removeprefix('torch.')}, declared {spec.dtype}"
    sizes = {"batch": batch}
    wanted = [size if isinstance(size, int) else sizes.get(size) for size in spec.shape]
    if len(wanted) != tensor.dim() or any(
        size not in (None, own) for size, own in zip(wanted, tensor.shape, strict=True)
    ):
        return f"{spec.name} has shape {list(tensor.shape)}, declared {list(spec.shape)}"
    if not bool(torch.isfinite(tensor).all()):
        return f"{spec.name} has values that are not finite"
    if spec.range is not None and tensor.numel():
        low, high = float(tensor.min()), float(tensor.max())
        if low < spec.range[0] or high > spec.range[1]:
            return f"{spec.name} spans {low:g} to {high:g}, declared {spec.range[0]:g} to {spec.range[1]:g}"
    return None


def within(gap: float, where: str, tolerance: float = TOLERANCE) -> str:
    """What was seen, where it is allowed.

    Raises:
        CheckFailed: The gap is larger than the tolerance, or not a number.
    """
    seen = f"largest difference {gap:.2g} {where}, allowed {tolerance:g}"
    if not gap <= tolerance:
        raise CheckFailed(seen)
    return seen


def _check_outputs(subject: Subject, inputs: tuple[Tensor, ...]) -> None:
    outputs = subject.run(inputs)
    if len(outputs) != len(subject.manifest.outputs):
        raise CheckFailed(f"the model returns {len(outputs)} tensors, declared are {len(subject.manifest.outputs)}")
    for spec, tensor in zip(subject.manifest.outputs, outputs, strict=True):
        if fault := spec_fault(spec, tensor, subject.batch):
            raise CheckFailed(fault)


def _median_ms(call: Callable[[], object], runs: int) -> float:
    for _ in range(2):  # TorchScript optimises during the first runs
        call()
    times: list[float] = []
    for _ in range(runs):
        begin = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - begin))
    return statistics.median(times)
