"""Commands that measure how well people are recognized."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from harmonicface.bench.benchmark import run_benchmark
from harmonicface.bench.console import print_table, progress
from harmonicface.bench.contenders import EVERY_METHOD, METHODS
from harmonicface.bench.crowds import ICT_ALBEDOS, SYNTHETIC, ict_crowd
from harmonicface.bench.report import results, write_report
from harmonicface.bench.table import error_table, margin_table, yale_table
from harmonicface.bench.yale_b import TRAINING, evaluate_yale_b
from harmonicface.commands.options import AsJson, make_folder
from harmonicface.datasets.yale_b import parse_people
from harmonicface.errors import HarmonicFaceError

NAMES = f"Comma-separated, of {', '.join(EVERY_METHOD)}."
SyntheticMethods = Annotated[str | None, typer.Option(help=NAMES, show_default="all that need no cast shadows")]
Methods = Annotated[str | None, typer.Option(help=NAMES, show_default="all")]


def bench(
    faces: Annotated[int, typer.Option(help="How many people.")] = 100,
    size: Annotated[int, typer.Option(help="Height and width of a photograph in pixels.")] = 64,
    seed: Annotated[int, typer.Option(help="The same seed gives the same errors.")] = 0,
    queries: Annotated[int, typer.Option(help="Photographs of each person in each kind of light.")] = 2,
    methods: SyntheticMethods = None,
    ict: Annotated[
        Path | None, typer.Option(help="FaceXModel of ICT-FaceKit: its people in place of the built-in ones.")
    ] = None,
    albedo: Annotated[
        str | None, typer.Option(help=f"Of ICT people: {' or '.join(ICT_ALBEDOS)} (shape alone).", show_default="grey")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for results.json and report.html.")] = Path("report"),
    as_json: AsJson = False,
) -> None:
    """Recognize people who do not exist under light that no gallery picture showed, by every method."""
    if albedo is not None and ict is None:
        raise HarmonicFaceError("albedo: expected it with --ict only, got it for the built-in people")
    crowd = SYNTHETIC if ict is None else ict_crowd(ict, albedo or ICT_ALBEDOS[0])
    make_folder(out)  # before the work rather than after it
    with progress() as tell:
        result = run_benchmark(faces, size, seed, queries, _methods(methods, METHODS), tell, crowd)
    page = write_report(result, out)
    if as_json:
        typer.echo(json.dumps(results(result)))
        return
    print_table("Wrong answers by kind of light, %; milliseconds a photograph; KiB a person", *error_table(result))
    print_table("Nine harmonic images: margin of the right person; who is refused as unknown, %", *margin_table(result))
    typer.echo(f"\nReport: {page.resolve()}")


def evaluate_yale(
    folder: Annotated[Path, typer.Argument(help="Folder of yaleB01, yaleB02, ...", show_default=False)],
    people: Annotated[str | None, typer.Option(help="As 1-10 or 1,3,5.", show_default="all")] = None,
    train: Annotated[str, typer.Option(help=f"One of {', '.join(TRAINING)}.")] = "subset1",
    methods: Methods = None,
    as_json: AsJson = False,
) -> None:
    """Recognize real photographs: the Extended Yale Face Database B, trained on frontal light."""
    numbers = None if people is None else parse_people(people)
    with progress() as tell:
        result = evaluate_yale_b(folder, numbers, train, _methods(methods, EVERY_METHOD), tell)
    if as_json:
        typer.echo(json.dumps(asdict(result)))
        return
    print_table(f"Wrong answers by subset, %, trained on {train}; milliseconds a photograph", *yale_table(result))


def _methods(text: str | None, usual: Sequence[str]) -> Sequence[str]:
    """Parse comma-separated names of methods; the usual ones by default."""
    return usual if text is None else [part.strip() for part in text.split(",")]
