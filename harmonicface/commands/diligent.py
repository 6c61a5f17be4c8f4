"""The command that measures photometric stereo on DiLiGenT."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from harmonicface.bench.console import print_table, progress
from harmonicface.bench.diligent import METHODS, diligent_json, diligent_table, evaluate_diligent
from harmonicface.commands.options import AsJson


def evaluate_diligent_object(
    folder: Annotated[Path, typer.Argument(help="Folder of one object, as ballPNG.", show_default=False)],
    methods: Annotated[
        str | None, typer.Option(help=f"Comma-separated, of {', '.join(METHODS)}.", show_default="all")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find the normals of an object of DiLiGenT, lamps known or not, and compare them with the measured ones."""
    names = tuple(METHODS) if methods is None else tuple(part.strip() for part in methods.split(","))
    with progress() as tell:
        result = evaluate_diligent(folder, names, tell)
    for name, reason in {**result.left_out, **result.failed}.items():
        typer.echo(f"left out: {name}: {reason}", err=True)
    if as_json:
        typer.echo(json.dumps(diligent_json(result)))
        return
    print_table(
        f"{result.object}: angles to the measured normals, {result.photographs} photographs", *diligent_table(result)
    )
