"""results.json and report.html of a protocol on Yale B."""

from __future__ import annotations

import html
import json
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.bench.decision_plots import decision_section
from harmonicface.bench.measure import machine
from harmonicface.bench.page import definitions, encoded, image, page, table
from harmonicface.bench.published import explained, published
from harmonicface.bench.table import published_table, yale_table
from harmonicface.bench.yale_plots import OURS, by_error, overall, subsets_picture, time_picture
from harmonicface.bench.yale_protocols import CHOSEN_ON, published_size, yale_protocol
from harmonicface.bench.yale_result import Query, YaleResult, as_json
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing

MOST_MISSED = 16  # photographs shown
MOST_CURVES = 6  # methods in a plot of decisions
COUNTED = "Photographs that were learned from are asked for again, as in the published tables."
NOT_COUNTED = "Photographs that were learned from are not asked for."


def write_yale_report(result: YaleResult, folder: str | os.PathLike[str]) -> Path:
    """Write results.json and report.html, which needs no other file; each is replaced whole.

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
    found = {**as_json(result), "machine": machine()}
    texts = {"results.json": json.dumps(found, indent=2) + "\n", "report.html": _page(result)}
    for name, text in texts.items():
        with replacing(target / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return target / "report.html"


def _page(result: YaleResult) -> str:
    """Fill the page."""
    about, protocol = machine(), yale_protocol(result.train)
    fields = {
        "headline": html.escape(_headline(result)),
        "people": html.escape(_ranges(result.people)),
        "gallery": len(result.people),
        "about": html.escape(protocol.about),
        "queries": sum(result.n.values()),
        "spoiled": _spoiled(result),
        "examples": _examples(result),
        "unseen": html.escape(_unseen(result)),
        "counting": COUNTED if protocol.asks_training else NOT_COUNTED,
        "subsets": image(subsets_picture(result), "error by method and subset"),
        "errors": table(*yale_table(result), OURS),
        "left_out": _left_out(result),
        "times": image(time_picture(result), "error against time"),
        "published": _published(result),
        "decisions": _decisions(result),
        "missed": _missed(result),
        "machine": html.escape(f"{about['processor']}, {about['cores']} cores, Python {about['python']}"),
        "packages": html.escape(", ".join(f"{name} {number}" for name, number in dict(about["packages"]).items())),  # type: ignore[call-overload]
    }
    return page("yale.html.template", f"harmonicface evaluate yale-b: trained on {result.train}", fields)


def _headline(result: YaleResult) -> str:
    """Say in a sentence how our method did, or the best one where ours did not take part."""
    name = OURS if OURS in result.methods else by_error(result)[0][0]
    method = result.methods[name]
    return f"{name}: {overall(method):.2f} % of {sum(method.asked.values())} photographs given to the wrong person"


def _unseen(result: YaleResult) -> str:
    """Say how our method does on people on whom its settings were not chosen."""
    found = result.methods[OURS].unseen(result.people) if OURS in result.methods else None
    if found is None:
        return ""
    first, last = CHOSEN_ON[0], CHOSEN_ON[-1]
    return f"Settings of {OURS} were chosen on people {first} to {last}; on the others alone its error is {found}."


def _spoiled(result: YaleResult) -> str:
    """Say what was done to the photographs."""
    done = [f"noise of {100 * result.noise:g} % of white added"] if result.noise else []
    done += [] if result.jpeg is None else [f"through JPEG of quality {result.jpeg}"]
    return " and ".join(done) or "as they are"


def _examples(result: YaleResult) -> str:
    """Show a photograph of each subset, as it was asked for, and brightened."""
    queries = next((method.answers.queries for method in result.methods.values() if method.answers), ())
    shown: dict[int, Query] = {}
    for query in queries:
        shown[query.subset] = query  # the last one: far from the camera's axis
    captions = [(shown[subset], f"subset {subset}: {shown[subset].file}") for subset in sorted(shown)]
    return _row(captions)


def _decisions(result: YaleResult) -> str:
    """Show how well scores decide, for ours and the best others that tell how far everybody is."""
    ranked = [name for name, _ in by_error(result) if name != OURS]
    told: dict[str, NDArray[np.float64]] = {}
    people: list[int] = []
    for name in [OURS, *ranked] if OURS in result.methods else ranked:
        answers = result.methods[name].answers
        if answers is not None and answers.distances is not None and len(told) < MOST_CURVES:
            told[name] = answers.distances
            people = [query.person for query in answers.queries]  # the same for every method
    return decision_section(told, people) if told else ""


def _missed(result: YaleResult) -> str:
    """Show photographs that our method gave to the wrong person."""
    answers = result.methods[OURS].answers if OURS in result.methods else None
    if answers is None:
        return ""
    missed = answers.missed()
    if not missed:
        return f"<h2>What {OURS} misses</h2><p>Nothing.</p>"
    captions = [(query, f"{query.file}, taken for yaleB{result.people[named]:02d}") for query, named in missed]
    more = f", the first {MOST_MISSED} shown" if len(missed) > MOST_MISSED else ""
    text = f"<h2>What {OURS} misses</h2><p>{len(missed)} photographs{more}, as asked for and brightened.</p>"
    return text + _row(captions[:MOST_MISSED])


def _row(captions: list[tuple[Query, str]]) -> str:
    """Show photographs twice in a row of figures: as they are, and as bright as their brightest part allows."""
    figures = []
    for query, caption in captions:
        brightest = max(float(np.percentile(query.photo, 99)), 1 / 255)
        pair = np.concatenate([query.photo, np.clip(query.photo / brightest, 0, 1) ** 0.45], axis=1)
        shown = image(encoded(pair, 240), caption)
        figures.append(f"<figure>{shown}<figcaption>{html.escape(caption)}</figcaption></figure>")
    return f'<div class="row">{"".join(figures)}</div>'


def _left_out(result: YaleResult) -> str:
    """Name the methods that could not take part."""
    if not result.left_out:
        return ""
    return f"<p>Left out, because they cannot learn from these photographs:</p>{definitions(result.left_out)}"


def _published(result: YaleResult) -> str:
    """Show the published table beside ours."""
    heads, rows = published_table(result)
    if not rows:
        return ""
    same = "on the same photographs" if published_size(result.people, result.n) else "on other photographs than ours"
    sources: dict[str, list[str]] = {}
    for row in published(result.train):
        sources.setdefault(row.source, []).append(row.name)
    alone = len(sources) == 1
    told = " ".join(f"{source}." if alone else f"{'; '.join(names)}: {source}." for source, names in sources.items())
    return (
        "<h2>Published beside ours</h2>"
        f"<p>In %, with 95 % intervals of Clopper &amp; Pearson; the published ones {same}. "
        "“as many”: ours lies in the interval of the published error. Ours is the same method; beside methods that "
        f"the package does not have, it is {OURS}.</p>"
        f"{table(heads, rows)}{_differences(result.train, rows)}<p>{html.escape(told)}</p>"
    )


def _differences(train: str, rows: list[list[str]]) -> str:
    """Say why errors differ from the published ones, if they do."""
    found = explained(train, rows)
    return f"<p>Why some differ:</p>{definitions(found)}" if found else ""


def _ranges(people: list[int]) -> str:
    """Spell numbers of people."""
    whole = len(people) > 2 and people == list(range(people[0], people[-1] + 1))
    return f"{people[0]} to {people[-1]}" if whole else ", ".join(map(str, people))
