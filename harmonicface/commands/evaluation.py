"""Commands that measure how well people are recognized."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from harmonicface.bench.benchmark import checked_enrolments, run_benchmark
from harmonicface.bench.console import print_table, progress
from harmonicface.bench.contenders import EVERY_METHOD, METHODS
from harmonicface.bench.crowds import ICT_ALBEDOS, SYNTHETIC, ict_crowd
from harmonicface.bench.enrolment import ENROLMENTS
from harmonicface.bench.published import explained
from harmonicface.bench.report import results, write_report
from harmonicface.bench.table import cost_table, enrolment_table, error_table, margin_table, published_table, yale_table
from harmonicface.bench.yale_b import evaluate_yale_b
from harmonicface.bench.yale_contenders import YALE_METHODS
from harmonicface.bench.yale_protocols import PROTOCOLS, published_size
from harmonicface.bench.yale_report import write_yale_report
from harmonicface.bench.yale_result import YaleResult, as_json
from harmonicface.commands.options import AsJson, make_folder
from harmonicface.datasets.yale_b import parse_people
from harmonicface.errors import HarmonicFaceError

NAMES = "Comma-separated, of {}."
SyntheticMethods = Annotated[
    str | None, typer.Option(help=NAMES.format(", ".join(EVERY_METHOD)), show_default="all that need no cast shadows")
]
YaleMethods = Annotated[str | None, typer.Option(help=NAMES.format(", ".join(YALE_METHODS)), show_default="all")]


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
    enroll: Annotated[
        str,
        typer.Option(
            help=f"Comma-separated, of {', '.join(ENROLMENTS)}; or all: compares people enrolled by photographs with"
            " those by geometry."
        ),
    ] = "geometry",
    out: Annotated[Path, typer.Option(help="Folder for results.json and report.html.")] = Path("report"),
    as_json: AsJson = False,
) -> None:
    """Recognize people who do not exist under light that no gallery picture showed, by every method."""
    if albedo is not None and ict is None:
        raise HarmonicFaceError("albedo: expected it with --ict only, got it for the built-in people")
    ways = checked_enrolments(list(ENROLMENTS) if enroll == "all" else [way.strip() for way in enroll.split(",")])
    crowd = SYNTHETIC if ict is None else ict_crowd(ict, albedo or ICT_ALBEDOS[0])
    make_folder(out)  # before the work rather than after it
    with progress() as tell:
        result = run_benchmark(faces, size, seed, queries, _methods(methods, METHODS), tell, crowd, ways)
    page = write_report(result, out)
    if as_json:
        typer.echo(json.dumps(results(result)))
        return
    print_table("Wrong answers by kind of light, %; milliseconds a photograph; KiB a person", *error_table(result))
    if result.enrolments:
        print_table("People enrolled by a scanner or by photographs: wrong answers, %", *enrolment_table(result))
        print_table("What a camera costs: margin of the right person, all photographs", *cost_table(result))
    print_table("Nine harmonic images: margin of the right person; who is refused as unknown, %", *margin_table(result))
    typer.echo(f"\nReport: {page.resolve()}")


def evaluate_yale(
    folder: Annotated[Path, typer.Argument(help="Folder of yaleB01, yaleB02, ...", show_default=False)],
    people: Annotated[str | None, typer.Option(help="As 1-10 or 1,3,5.", show_default="all")] = None,
    train: Annotated[str, typer.Option(help=f"Learned from: one of {', '.join(PROTOCOLS)}.")] = "subset1",
    methods: YaleMethods = None,
    noise: Annotated[float, typer.Option(help="Deviation of noise added to queries, white being 1.")] = 0.0,
    jpeg: Annotated[int | None, typer.Option(help="JPEG quality of queries.", show_default="as they are")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for results.json and report.html.", show_default="none")
    ] = None,
    as_json_: AsJson = False,
) -> None:
    """Recognize real photographs: the Extended Yale Face Database B, by its published protocols."""
    numbers = None if people is None else parse_people(people)
    if out is not None:
        make_folder(out)  # before the work rather than after it
    with progress() as tell:
        result = evaluate_yale_b(folder, numbers, train, _methods(methods, YALE_METHODS), tell, noise, jpeg)
    page = None if out is None else write_yale_report(result, out)
    for name, reason in result.left_out.items():
        typer.echo(f"left out: {name}: {reason}", err=True)
    if as_json_:
        typer.echo(json.dumps(as_json(result)))
        return
    _print_yale(result)
    if page is not None:
        typer.echo(f"\nReport: {page.resolve()}")


def _print_yale(result: YaleResult) -> None:
    """Print our errors, and the published ones beside them."""
    print_table(f"Wrong answers by subset, %, trained on {result.train}; ms a photograph", *yale_table(result))
    heads, rows = published_table(result)
    if rows:
        size = "the same photographs" if published_size(result.people, result.n) else "other photographs than ours"
        print_table(f"Published beside ours, % with 95 % intervals ({size})", heads, rows)
        for name, reason in explained(result.train, rows).items():
            typer.echo(f"{name}: {reason}")


def _methods(text: str | None, usual: Sequence[str]) -> Sequence[str]:
    """Parse comma-separated names of methods; the usual ones by default."""
    return usual if text is None else [part.strip() for part in text.split(",")]
