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
from harmonicface.bench.contenders import METHODS
from harmonicface.bench.report import results, write_report
from harmonicface.bench.table import error_table, margin_table, yale_table
from harmonicface.bench.yale_b import TRAINING, evaluate_yale_b
from harmonicface.commands.options import AsJson, make_folder
from harmonicface.datasets.yale_b import parse_people

Methods = Annotated[str | None, typer.Option(help=f"Comma-separated, of {', '.join(METHODS)}.", show_default="all")]


def bench(
    faces: Annotated[int, typer.Option(help="How many people.")] = 100,
    size: Annotated[int, typer.Option(help="Height and width of a photograph in pixels.")] = 64,
    seed: Annotated[int, typer.Option(help="The same seed gives the same errors.")] = 0,
    queries: Annotated[int, typer.Option(help="Photographs of each person in each kind of light.")] = 2,
    methods: Methods = None,
    out: Annotated[Path, typer.Option(help="Folder for results.json and report.html.")] = Path("report"),
    as_json: AsJson = False,
) -> None:
    """Recognize synthetic people under light that no gallery picture showed, by every method."""
    make_folder(out)  # before the work rather than after it
    with progress() as tell:
        result = run_benchmark(faces, size, seed, queries, _methods(methods), tell)
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
        result = evaluate_yale_b(folder, numbers, train, _methods(methods), tell)
    if as_json:
        typer.echo(json.dumps(asdict(result)))
        return
    print_table(f"Wrong answers by subset, %, trained on {train}; milliseconds a photograph", *yale_table(result))


def _methods(text: str | None) -> Sequence[str]:
    """Parse comma-separated names of methods; all of them by default."""
    return METHODS if text is None else [part.strip() for part in text.split(",")]
