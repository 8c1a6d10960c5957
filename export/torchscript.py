"""From a training run to an artefact folder."""

from pathlib import Path

import torch

from navtool.base.files import write_json
from navtool.base.lineage import code_version, file_sha256
from navtool.base.output_folder import OutputFolder
from navtool.base.plain import plain_fields
from navtool.export.artefact import MODEL
from navtool.export.errors import ExportError
from navtool.export.golden import GOLDEN, TOLERANCE, golden_bytes, golden_inputs
from navtool.export.manifest import MANIFEST, FileEntry, Manifest
from navtool.export.outputs import largest_gap, outputs_of
from navtool.export.scripted import save_scripted, script
from navtool.train.checkpoint import load_run
from navtool.train.models import kind_of, name_of
from navtool.train.run_folder import RunFolder


def export_run(run: Path, out: Path, *, overwrite: bool = False, checkpoint: str = "best") -> Path:
    """Write the artefact of a run: ``model.ts``, ``golden.safetensors`` and ``manifest.json``.

    The folder appears in one step, whole. The compiled network has been compared with the trained one on the golden
    inputs before it is there.

    Args:
        run: Folder of the run.
        out: The artefact's folder; must not exist, or be empty.
        overwrite: Replace an artefact that is there already; anything else is never replaced.
        checkpoint: ``best`` or ``last``.

    Returns:
        The artefact's folder.

    Raises:
        TrainError: The run cannot be loaded.
        DatasetsError: The folder holds something else, or another process writes to it.
        OutputError: The folder cannot be written.
        ExportError: There is an artefact already, or the compiled network gives other results.
    """
    check_target(out, overwrite=overwrite)
    folder = RunFolder(run)
    loaded, weights = load_run(run, checkpoint), folder.checkpoints / f"{checkpoint}.ckpt"
    kind, config = kind_of(loaded.config.model), loaded.config.model
    contract, golden = kind.contract(config), golden_inputs(loaded, folder.lineage)
    onboard = kind.onboard(loaded.model, config).eval()
    scripted = script(onboard, contract.methods)
    arguments = tuple(golden.tensors.values())
    with torch.inference_mode():
        expected = outputs_of(onboard, arguments)
        gap = largest_gap(outputs_of(scripted, arguments), expected)
    if not gap <= TOLERANCE:
        raise ExportError(
            f"the compiled network differs from the trained one by {gap:.2g}, more than {TOLERANCE:g}",
            where=run,
            cure="report it with the versions of torch and navtool",
        )
    outputs = {spec.name: tensor for spec, tensor in zip(contract.outputs, expected, strict=True)}
    with _folder(out).staged(replace=overwrite) as staged:
        save_scripted(scripted, staged / MODEL)
        (staged / GOLDEN).write_bytes(golden_bytes(golden.tensors, outputs))
        lineage = {key: value for key, value in loaded.lineage.items() if key != "dataset_path"}
        manifest = Manifest(
            kind=name_of(config),
            created_by=f"navtool {code_version()}, torch {torch.__version__}",
            inputs=contract.inputs,
            outputs=contract.outputs,
            methods=contract.methods,
            golden_source=golden.source,
            golden_tolerance=TOLERANCE,
            config=plain_fields(loaded.config),
            lineage=lineage | {"checkpoint": {"name": checkpoint, "sha256": file_sha256(weights)}},
            metrics=folder.read_metrics(),
            files={name: _entry(staged / name) for name in (MODEL, GOLDEN)},
        )
        write_json(staged / MANIFEST, manifest.to_json())
    return out


def check_target(out: Path, *, overwrite: bool) -> None:
    """Do nothing where an artefact may be written.

    Raises:
        DatasetsError: There is something else.
        ExportError: There is an artefact that is not to be replaced.
    """
    _folder(out).refuse_other()
    if (out / MANIFEST).is_file() and not overwrite:
        raise ExportError("holds an artefact already", where=out, cure="choose a new folder, or pass --overwrite")


def _folder(out: Path) -> OutputFolder:
    return OutputFolder(out, record=MANIFEST)


def _entry(path: Path) -> FileEntry:
    return FileEntry(sha256=file_sha256(path), size=path.stat().st_size)
