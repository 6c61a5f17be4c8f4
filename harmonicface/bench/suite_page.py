"""The page and the Markdown of all benchmarks: contents, machine, and of each benchmark its plots and its table."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from harmonicface.bench.measure import machine
from harmonicface.bench.page import HERE, image, page, table
from harmonicface.bench.record_table import TEXTS, markdown, record_table
from harmonicface.bench.speed_plot import points_of, speed_error_picture
from harmonicface.bench.spelling import three_figures
from harmonicface.bench.suite import Ran
from harmonicface.io.files import replacing

TITLE = "harmonicface: speed against error"


@dataclass(frozen=True)
class Run:
    """A run of several benchmarks.

    Parameters
    ----------
    ran
        What became of each.
    when
        The time at which it began, in words.
    seconds
        How long all of it took.
    """

    ran: Sequence[Ran]
    when: str
    seconds: float

    @property
    def summary(self) -> str:
        """How many benchmarks were run, and how long they took."""
        counts = [(sum(one.state == state for one in self.ran), state) for state in ("done", "skipped", "failed")]
        parts = [f"{count} {state}" for count, state in counts if count]
        records = sum(len(one.records) for one in self.ran)
        return (
            f"{len(self.ran)} benchmarks ({', '.join(parts)}), {records} measurements, {spelled_minutes(self.seconds)}"
        )


def write_suite(run: Run, folder: str | os.PathLike[str]) -> Path:
    """Write results.md and index.html, each replaced whole, and return where the page is.

    Raises
    ------
    HarmonicFaceError
        The folder cannot be written to.
    """
    for name, text in (("results.md", suite_markdown(run)), ("index.html", suite_page(run))):
        with replacing(Path(folder) / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return Path(folder) / "index.html"


def suite_page(run: Run) -> str:
    """Return the page, which needs no other file."""
    fields: dict[str, object] = {
        "summary": html.escape(run.summary),
        "when": html.escape(run.when),
        "machine": html.escape(_machine()),
        "packages": html.escape(_packages(run.ran)),
        "contents": "".join(_entry(one) for one in run.ran),
        "sections": "".join(_section(one) for one in run.ran),
    }
    style = (HERE / "suite.css").read_text(encoding="utf-8")
    return page("suite.html.template", TITLE, fields, style=style)


def suite_markdown(run: Run) -> str:
    """Return all tables in Markdown."""
    parts = [f"# {TITLE}", f"{run.summary}, {run.when}. {_machine()}. {_packages(run.ran)}."]
    heads = ["benchmark", "what", "state", "records", "time", "ratio"]
    parts.append(markdown(heads, [[f"[{one.name}](#{one.name})", one.question, *_figures(one)] for one in run.ran]))
    for one in run.ran:
        parts += [f"## {one.name}", one.question, *_paragraphs(one), f"{_how(one)}: `{_command(one)}`"]
        if one.said:
            parts.append("\n".join(f"    {line}" for line in one.said.splitlines()))
        if one.records:
            parts.append(markdown(*record_table(one.records)))
    return "\n\n".join(part for part in parts if part) + "\n"


def spelled_minutes(seconds: float) -> str:
    """Return a time in minutes and seconds.

    Examples
    --------
    >>> spelled_minutes(754.2), spelled_minutes(3.4)
    ('12 min 34 s', '3 s')
    """
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def _figures(one: Ran) -> list[str]:
    """Return the state, how many records, the time, and the range of ratios to peers."""
    ratios = sorted(record.ratio for record in one.records if record.ratio is not None)
    ends = dict.fromkeys(three_figures(float(f"{ratio:.2g}")) for ratio in (*ratios[:1], *ratios[-1:]))
    return [one.state, str(len(one.records) or ""), spelled_minutes(one.seconds), " to ".join(ends)]


def _entry(one: Ran) -> str:
    """Return a line of the contents."""
    state, records, time, ratios = _figures(one)
    link = f'<a href="#{html.escape(one.name)}">{html.escape(one.name)}</a>'
    cells = [html.escape(one.question), records or state, time, ratios]
    inside = "".join(f"<td{' class=text' if number == 0 else ''}>{cell}</td>" for number, cell in enumerate(cells))
    return f"<tr class={state}><td>{link}</td>{inside}</tr>"


def _section(one: Ran) -> str:
    """Return everything about one benchmark."""
    name = html.escape(one.name)
    about = "".join(f"<p>{_prose(text)}</p>" for text in _paragraphs(one))
    said = f"<pre class={one.state}>{html.escape(one.said)}</pre>" if one.said else ""
    plots = ""
    for number, ((question, unit), points) in enumerate(points_of(one.records).items(), start=1):
        title = ": ".join(part for part in (question, unit) if part) or one.name
        picture = image(speed_error_picture(points, unit), f"{one.name}, plot {number}: {title}")
        plots += f"<figure>{picture}<figcaption>{html.escape(title)}</figcaption></figure>"
    plots = f'<div class="plots">{plots}</div>' if plots else ""
    heads, rows = record_table(one.records)
    shown = f'<div class="scroll">{table(heads, rows, texts=TEXTS)}</div>' if rows else ""
    how = f"<p class=how>{_how(one)}: <code>{html.escape(_command(one))}</code></p>"
    lead = f'<p class="lead">{_prose(one.question)}</p>'
    return f'<section id="{name}"><h2>{name}</h2>{lead}{about}{said}{how}{plots}{shown}</section>'


def _paragraphs(one: Ran) -> list[str]:
    """Return what else is said of a benchmark, without how it is called, which stands there anyway."""
    found = [" ".join(text.split()) for text in re.split(r"\n\s*\n", one.about)]
    return [text for text in found if text and not text.startswith("python benchmarks/")]


def _how(one: Ran) -> str:
    return f"{one.state}, {'quick' if one.quick else 'in full'}, {spelled_minutes(one.seconds)}"


def _command(one: Ran) -> str:
    return f"python benchmarks/{one.name}.py" + (" --quick" if one.quick else "")


def _prose(text: str) -> str:
    """Return words of a docstring as HTML: code between backticks."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", html.escape(text))


def _machine() -> str:
    about = machine()
    return f"{about['processor']}, {about['cores']} cores, {about['system']}, Python {about['python']}"


def _packages(ran: Sequence[Ran]) -> str:
    """Return the versions of all packages that were timed, and of the usual ones."""
    found = {str(name): str(number) for name, number in dict(machine()["packages"]).items()}  # type: ignore[call-overload]
    for one in ran:
        for record in one.records:
            found.update(record.versions)
    return ", ".join(f"{name} {number}" for name, number in sorted(found.items()))
