"""The page of all benchmarks holds every table and plot: as text, and as a real browser shows it."""

from __future__ import annotations

import html
import io
import json
import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import harmonicface as hf
from harmonicface.bench.measure import Record
from harmonicface.bench.record_table import record_table
from harmonicface.bench.speed_plot import points_of
from harmonicface.bench.suite import Ran
from harmonicface.bench.suite_page import Run, suite_markdown, suite_page, write_suite
from harmonicface.bench.timing import Call, best, record

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
LOOK = """<script>addEventListener("load", () => {
  const box = one => { const b = one.getBoundingClientRect(); return [b.width, b.height]; };
  const seen = {
    tables: [...document.querySelectorAll("table")].map(t => ({
      section: t.closest("section")?.id ?? "", box: box(t),
      rows: [...t.rows].map(r => [...r.cells].map(c => c.textContent)) })),
    images: [...document.images].map(i => ({
      section: i.closest("section").id, alt: i.alt, width: i.naturalWidth, complete: i.complete, box: box(i) })),
    links: [...document.links].map(a => [a.getAttribute("href"), document.querySelector(a.getAttribute("href"))?.id]),
    wide: document.documentElement.scrollWidth - innerWidth,
  };
  document.body.innerHTML = "<pre id=seen></pre>";
  document.getElementById("seen").textContent = JSON.stringify(seen);
});</script>"""


@pytest.fixture(scope="module")
def run() -> Run:
    """Three benchmarks: one with two plots, one without any, one that has failed."""
    ones = np.ones(20_000)
    timings = [best(Call(ones[:size].sum), 2) for size in (200, 2_000, 20_000)]
    drawn = [
        record(
            f"add up, to {size} numbers",
            "20000 numbers",
            timing,
            timings[2],
            error=1 - size / 20_000,
            peer_error=0.0,
            unit=f"share left out, {kind}",
            bytes=8 * size,
            seed=0,
            question="add up",
            note="<b>not bold</b> & a very long note " + "that goes on and on " * 9,
        )
        for kind in ("once", "twice")
        for size, timing in zip((200, 2_000, 20_000), timings, strict=True)
    ]
    sums = "How fast are sums? Beside `numpy`.", "More.\n\npython benchmarks/sums.py"
    alone = (Record("b", "c", 2e-5),)
    ran = [
        Ran("sums", *sums, "done", True, 1.5, tuple(drawn)),
        Ran("speed", "How fast is it?", "", "done", False, 75.0, alone, "skipped: the other half"),
        Ran("bad", "What is wrong?", "", "failed", False, 3.0, (), "Traceback\nValueError: <&>"),
    ]
    return Run(ran, "2000-01-01 12:00 UTC", 80.4)


class Tags(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))


def test_the_page_needs_nothing_else(run: Run) -> None:
    text = suite_page(run)
    page = Tags(text)
    assert not {"script", "link", "iframe", "object"} & {tag for tag, _ in page.tags}
    assert all(
        (found.get("src") or "data:").startswith("data:image/png;base64,") for _, found in page.tags if "src" in found
    )
    assert all((found["href"] or "").startswith("#") for _, found in page.tags if "href" in found)
    assert "url(" not in text
    assert "<b>" not in text
    assert "$" not in text


def test_the_page_tells_when_where_and_how_long(run: Run) -> None:
    text = suite_page(run)
    assert "3 benchmarks (2 done, 1 failed), 7 measurements, 1 min 20 s; begun 2000-01-01 12:00 UTC." in text
    assert "ValueError: &lt;&amp;&gt;" in text
    assert "skipped: the other half" in text
    assert f"numpy {np.__version__}" in text
    assert f"harmonicface {hf.__version__}" in text
    assert "python benchmarks/sums.py --quick" in text


def test_markdown_holds_the_same_tables(run: Run, tmp_path: Path) -> None:
    assert write_suite(run, tmp_path) == tmp_path / "index.html"
    text = (tmp_path / "results.md").read_text(encoding="utf-8")
    assert text == suite_markdown(run)
    assert "| add up, to 200 numbers |" in text
    assert "## bad" in text
    assert "    ValueError: <&>" in text
    assert text.count("\n|") == 2 + 3 + 2 + 6 + 2 + 1  # heads, rules and rows of three tables
    with pytest.raises(hf.HarmonicFaceError, match="cannot write"):
        write_suite(run, tmp_path / "none")


def browser(*arguments: str, profile: Path) -> str:
    """Run a browser without a window, and return what it prints."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip(f"none of {', '.join(BROWSERS)} is installed")
    quiet = "headless no-sandbox disable-gpu disable-quic no-first-run disable-background-networking"
    quiet += " disable-component-update disable-sync disable-dev-shm-usage hide-scrollbars"
    command = [found, *(f"--{flag}" for flag in quiet.split()), f"--user-data-dir={profile}", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=180, check=True).stdout


def test_a_browser_shows_every_table_and_plot(run: Run, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text(suite_page(run).replace("</body>", f"{LOOK}</body>"), encoding="utf-8")
    dom = browser("--window-size=1280,900", "--dump-dom", page.as_uri(), profile=tmp_path / "profile")
    match = re.search(r'<pre id="seen">(.*?)</pre>', dom, re.DOTALL)
    assert match is not None, dom[-2000:]
    seen = json.loads(html.unescape(match[1]))

    tables = {table["section"]: table for table in seen["tables"]}
    assert list(tables) == ["", "sums", "speed"]
    for one in run.ran[:2]:
        heads, rows = record_table(one.records)
        assert tables[one.name]["rows"] == [heads, *rows]
    assert [row[0] for row in tables[""]["rows"]] == ["benchmark", "sums", "speed", "bad"]
    assert all(min(table["box"]) > 20 for table in tables.values())

    drawn = [(one.name, f"{one.name}, plot {number}: {': '.join(which)}")
             for one in run.ran for number, which in enumerate(points_of(one.records), start=1)]  # fmt: skip
    assert [(image["section"], image["alt"]) for image in seen["images"]] == drawn
    assert len(drawn) == 2
    for image in seen["images"]:
        assert image["complete"]
        assert image["width"] > 800
        assert image["box"][0] > 400
        assert image["box"][1] > 200
    assert seen["links"] == [[f"#{one.name}", one.name] for one in run.ran]
    assert seen["wide"] <= 0  # nothing sticks out to the right


def test_a_browser_paints_the_page(run: Run, tmp_path: Path) -> None:
    page, shot = write_suite(replace(run, ran=run.ran[:1]), tmp_path), tmp_path / "shot.png"
    browser("--window-size=1280,1400", f"--screenshot={shot}", page.as_uri(), profile=tmp_path / "profile")
    painted = np.asarray(Image.open(io.BytesIO(shot.read_bytes())).convert("RGB"))
    accent = (painted == [0xC8, 0x55, 0x3D]).all(axis=2)
    assert painted.shape[1] == 1280
    assert accent.sum() > 100  # the points of the plots
