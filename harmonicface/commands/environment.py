"""The command that prints the harmonic coefficients of an environment map."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from harmonicface.bench.console import print_table
from harmonicface.commands.options import AsJson
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.layouts import LAYOUTS


def light(
    map_: Annotated[
        Path,
        typer.Argument(
            metavar="MAP", help="HDR, EXR, PFM, TIFF, NPY, PNG, JPEG; of a cube also its folder.", show_default=False
        ),
    ],
    layout: Annotated[str, typer.Option(help=f"One of {', '.join(LAYOUTS)}.")] = "latlong",
    order: Annotated[int, typer.Option(help="Highest degree: 2 gives nine coefficients a colour.")] = 2,
    as_json: AsJson = False,
) -> None:
    """Print the harmonic coefficients of an environment map, red, green, blue."""
    environment = EnvironmentMap.load(map_, layout=layout)
    found = environment.coefficients(order)
    colours = np.broadcast_to(found.reshape(len(found), -1), (len(found), 3))  # grey is the same in all colours
    if as_json:
        typer.echo(json.dumps({"order": order, "coefficients": colours.tolist()}))
        return
    rows = [
        [
            f"{degree}",
            f"{mode:+d}" if mode else "0",
            *(f"{value:.5g}" for value in colours[degree * (degree + 1) + mode]),
        ]
        for degree in range(order + 1)
        for mode in range(-degree, degree + 1)
    ]
    print_table(f"{map_} ({layout})", ["l", "m", "red", "green", "blue"], rows)
