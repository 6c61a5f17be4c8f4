"""results.json and a report.html that needs no other file."""

from __future__ import annotations

import html
import json
import os
from dataclasses import asdict
from pathlib import Path

from harmonicface.bench import pictures
from harmonicface.bench.benchmark import MARGIN_METHOD, BenchmarkResult
from harmonicface.bench.enrolment import ENROLMENTS
from harmonicface.bench.measure import machine
from harmonicface.bench.page import definitions, image, page, table
from harmonicface.bench.table import (
    cost_table,
    enrolment_table,
    error_table,
    margin_table,
    method_records,
    model_records,
    model_table,
)
from harmonicface.bench.tiers import TIERS
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing


def write_report(result: BenchmarkResult, folder: str | os.PathLike[str]) -> Path:
    """Write results.json and report.html; each is replaced whole.

    Returns
    -------
    Path
        Where report.html is.

    Raises
    ------
    HarmonicFaceError
        The folder cannot be made or written to.
    """
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HarmonicFaceError(f"cannot make the folder {target}: {error.strerror}") from None
    texts = {"results.json": _json(result), "report.html": _page(result)}  # both before either is written
    for name, text in texts.items():
        with replacing(target / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return target / "report.html"


def results(result: BenchmarkResult) -> dict[str, object]:
    """Return what results.json holds: everything measured, and on what."""
    return {
        "people": result.crowd,
        "faces": result.faces,
        "size": result.size,
        "seed": result.seed,
        "queries": result.queries,
        "methods": {
            method.method: {
                "errors": method.errors,
                "error_percent": {tier: 100 * method.errors[tier] / n for tier, n in result.queries.items()},
                "ms_per_query": method.milliseconds,
                "enrolment_seconds": method.enrolment_seconds,
                "bytes_per_person": method.bytes_per_person,
            }
            for method in result.methods
        },
        "margins": {tier: asdict(margin) for tier, margin in result.margins.items()},
        "open_set": {tier: asdict(rates) for tier, rates in result.open_set.items()},
        "enrolments": {
            way.kind: {
                "normals_deg": way.degrees if way.degrees == way.degrees else None,
                "seconds_per_person": way.seconds,
                "refused": way.refused,
                "median_margin": way.margin if way.margin == way.margin else None,
                "error_percent": {
                    method.method: {tier: 100 * method.errors[tier] / n for tier, n in result.queries.items()}
                    for method in way.methods
                },
            }
            for way in result.enrolments
        },
        "threshold": result.gallery.threshold,
        "margin": result.gallery.margin,
        "missed_by_shortlist": None if result.missed is None else asdict(result.missed),
        "records": [record.as_dict() for record in method_records(result)],
        "machine": machine(),
    }


def _json(result: BenchmarkResult) -> str:
    return json.dumps(results(result), indent=2) + "\n"


def _page(result: BenchmarkResult) -> str:
    """Fill the page."""
    about = machine()
    queries = sum(result.queries.values())
    fields = {
        "headline": html.escape(_headline(result)),
        "crowd": html.escape(result.crowd),
        "faces": result.faces,
        "size": result.size,
        "seed": result.seed,
        "queries": queries,
        "each": queries // len(result.queries),
        "threshold": result.gallery.threshold,
        "margin": f"{result.gallery.margin:.2f}",
        "tiers": definitions({tier.name: tier.about for tier in TIERS}),
        "errors": table(*error_table(result), MARGIN_METHOD),
        "enrolments": _enrolments(result),
        "models": _models(result),
        "recall": _recall(result),
        "margins": table(*margin_table(result)),
        "explanations": image(pictures.explanations_picture(result), "photographs explained by right and wrong people"),
        "harmonics": image(pictures.harmonics_picture(result.people[0].surface), "nine harmonic images of one person"),
        "lights": image(pictures.lights_picture(result), "balls and faces under the lights of each tier"),
        "tradeoff": image(pictures.tradeoff_picture(method_records(result)), "error against time"),
        "machine": html.escape(f"{about['processor']}, {about['cores']} cores, Python {about['python']}"),
        "packages": html.escape(", ".join(f"{name} {number}" for name, number in dict(about["packages"]).items())),  # type: ignore[call-overload]
    }
    return page("report.html.template", f"harmonicface bench: {result.faces} people, seed {result.seed}", fields)


def _enrolments(result: BenchmarkResult) -> str:
    """Compare people enrolled by a scanner and by photographs, if that was asked for."""
    if not result.enrolments:
        return ""
    ways = definitions({way.kind: ENROLMENTS[way.kind] for way in result.enrolments})
    return (
        "<h2>What a camera costs against a scanner</h2><p>The same photographs asked for, people enrolled in different"
        " ways. Margin: distance of the nearest wrong person over that of the right one, by nine harmonic images, over"
        " all photographs; below 1 is an error. Normals: mean angle to the true ones. Whom photometric stereo refused"
        f" is never found.</p>{table(*cost_table(result))}<p>Wrong answers in %:</p>"
        f"{table(*enrolment_table(result))}{ways}"
    )


def _recall(result: BenchmarkResult) -> str:
    """Say what the default loses by looking again at a shortlist only."""
    if result.missed is None:
        return ""
    return (
        "<p>The default model looks again at a shortlist of the nearest people by projection. In the photographs asked"
        f" for, whom it would name among everybody is missing there in {result.missed} ({result.missed.trials} of them,"
        " 95 % interval).</p>"
    )


def _models(result: BenchmarkResult) -> str:
    """Compare how many pictures a person needs under natural light, if several models were asked."""
    heads, rows = model_table(result)
    if not rows:
        return ""
    plot = pictures.tradeoff_picture(model_records(result))
    return (
        "<h2>Only what natural light takes</h2><p>Galleries that keep fewer pictures a person, the smallest first, in"
        " the photographs under natural light alone. auto chooses the pictures of each person from her Surface"
        f" (<code>choose_model</code>).</p>{table(heads, rows, 'auto')}"
        f"{image(plot, 'error under natural light against time, by the pictures of a person')}"
    )


def _headline(result: BenchmarkResult) -> str:
    """Say in a sentence how the nine images did beside the best method that learns from pictures."""
    total = sum(result.queries.values())
    wrong = {method.method: sum(method.errors.values()) for method in result.methods}
    if MARGIN_METHOD not in wrong:
        return f"{len(wrong)} methods, {total} photographs"
    return f"Nine harmonic images rank the right person first in {total - wrong[MARGIN_METHOD]} of {total} photographs"
