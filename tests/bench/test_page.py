"""Pages stand alone, and plain text in them stays plain text."""

from __future__ import annotations

import base64
import io
from string import Template

import numpy as np
from PIL import Image

from harmonicface.bench.page import HERE, definitions, encoded, image, page, table

SLY = '<b title="&">$'


def test_plain_texts_are_escaped() -> None:
    for text in (table([SLY], [[SLY]]), definitions({SLY: SLY}), image(b"", SLY)):
        assert "<b" not in text
        assert "&lt;b title=&quot;&amp;&quot;&gt;$" in text


def test_a_page_has_a_title_and_names_that_programs_look_for() -> None:
    names = Template((HERE / "report.html.template").read_text(encoding="utf-8")).get_identifiers()
    text = page("report.html.template", SLY, dict.fromkeys(names, SLY), {"files": 'a "b"'})
    assert "<title>&lt;b" in text
    assert '<meta name="files" content="a &quot;b&quot;">' in text
    assert text.startswith("<!doctype html>") and text.endswith("</body>\n</html>\n")
    assert text.count(SLY) >= len(names)  # fields are HTML already


def test_a_row_stands_out() -> None:
    text = table(["method", "errors"], [["ours", "0"], ["theirs", "9"]], "ours")
    assert "<tr class=ours><td>ours</td>" in text
    assert text.count("class=ours") == 1


def decoded(png: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(png)))


def test_pictures_come_back_from_their_png() -> None:
    picture = np.random.default_rng(0).integers(0, 256, (9, 7, 3)) / 255
    np.testing.assert_array_equal(decoded(encoded(picture)), np.rint(255 * picture))
    np.testing.assert_array_equal(decoded(encoded(picture[..., 0], 9)), np.rint(255 * picture[..., 0]))
    text = image(encoded(picture), "noise")
    assert base64.b64decode(text.split("base64,")[1].split('"')[0]) == encoded(picture)


def test_large_pictures_become_smaller_by_averaging() -> None:
    board = np.indices((60, 40)).sum(axis=0) % 2 * 1.0
    small = decoded(encoded(board, 30))
    assert small.shape == (30, 20)
    assert np.abs(small.astype(int) - 127).max() <= 1
