"""``navtool export``."""

from pathlib import Path

import typer


def export(
    run: Path = typer.Argument(..., help="A finished training run.", show_default=False),
    out: Path = typer.Option(..., "--out", help="Folder of the artefact; must not exist.", show_default=False),
    overwrite: bool = typer.Option(False, "--overwrite", help="Replace an artefact that is there."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Turn a run into an artefact for the robot.

    A folder with the TorchScript model, a manifest with contract, lineage and hashes, and a golden input and output.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.compose import wrong_call
    from navtool.cli.console import console, print_json
    from navtool.export.torchscript import check_target, export_run

    require_there(run)
    with wrong_call():
        check_target(out, overwrite=overwrite)
    with console(error=True).status("exporting"):
        artefact = export_run(run, out, overwrite=overwrite)
    if as_json:
        print_json({"artefact": artefact.as_posix(), "run": run.as_posix()})
        return
    console().print(f"artefact: {artefact}\nverify it with: navtool verify {artefact}", markup=False)
