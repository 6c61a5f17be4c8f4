"""Pages: HTML that needs no other file, in one style."""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Sequence
from pathlib import Path
from string import Template

import numpy as np
from PIL import Image

from harmonicface._validate import Floats

HERE = Path(__file__).parent


def page(
    template: str, title: str, fields: dict[str, object], meta: dict[str, str] | None = None, style: str = ""
) -> str:
    """Return a whole page.

    Parameters
    ----------
    template
        The name of the file beside this one that holds the page's body.
    title
        Plain text.
    fields
        What stands for each name in the template; texts are HTML already.
    meta
        Plain texts that a program may look for in the page, by name.
    style
        CSS of this page alone, after what all pages have.
    """
    body = _template(template).substitute(fields)
    lines = [
        f'<meta name="{html.escape(name)}" content="{html.escape(text)}">\n' for name, text in (meta or {}).items()
    ]
    return _template("page.html.template").substitute(
        title=html.escape(title), meta="".join(lines), style=style, body=body
    )


def table(heads: list[str], rows: list[list[str]], strong: str = "", texts: Sequence[str] = ()) -> str:
    """Return an HTML table of plain texts; the row that begins with `strong` stands out, columns of `texts` are broken.

    Examples
    --------
    >>> table(["a"], [["<1"]])
    '<table><thead><tr><th>a</th></tr></thead><tbody><tr><td>&lt;1</td></tr></tbody></table>'
    """
    kinds = [" class=text" if head in texts else "" for head in heads]
    head = "".join(f"<th{kind}>{html.escape(text)}</th>" for kind, text in zip(kinds, heads, strict=True))
    body = "".join(
        f"<tr{' class=ours' if row[0] == strong else ''}>"
        + "".join(f"<td{kind}>{_cell(cell, bool(kind))}</td>" for kind, cell in zip(kinds, row, strict=True))
        + "</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(text: str, broken: bool) -> str:
    """Return plain text as HTML; the names of functions in it may be broken behind their dots."""
    escaped = html.escape(text)
    return re.sub(r"(?<=\w)\.(?=[A-Za-z_])", ".<wbr>", escaped) if broken else escaped


def definitions(entries: dict[str, str]) -> str:
    """Return an HTML list of plain names and what they are.

    Examples
    --------
    >>> definitions({"pixels": "3 x 4"})
    '<dl><dt>pixels</dt><dd>3 x 4</dd></dl>'
    """
    inside = "".join(f"<dt>{html.escape(name)}</dt><dd>{html.escape(text)}</dd>" for name, text in entries.items())
    return f"<dl>{inside}</dl>"


def image(png: bytes, description: str) -> str:
    """Return a picture that stands inside the page.

    Examples
    --------
    >>> image(b"", "nothing")
    '<img alt="nothing" src="data:image/png;base64,">'
    """
    data = base64.b64encode(png).decode("ascii")
    return f'<img alt="{html.escape(description)}" src="data:image/png;base64,{data}">'


def encoded(picture: Floats, most: int = 0) -> bytes:
    r"""Return the PNG of a picture.

    Parameters
    ----------
    picture
        (h, w) or (h, w, 3) display values, 0 to 1.
    most
        Pixels a side beyond which the picture is made smaller; 0 leaves it as it is.

    Examples
    --------
    >>> encoded(np.zeros((2, 2)))[:4]
    b'\x89PNG'
    """
    shown = Image.fromarray(np.rint(picture * 255).astype(np.uint8))
    if most and max(shown.size) > most:
        shown.thumbnail((most, most), Image.Resampling.BOX)
    buffer = io.BytesIO()
    shown.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def _template(name: str) -> Template:
    return Template((HERE / name).read_text(encoding="utf-8"))
