"""Commands that look after a gallery: what is in it, whether it is whole, who is taken out, what is copied."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from harmonicface.bench.console import progress
from harmonicface.bench.spelling import spelled_bytes
from harmonicface.commands.options import AsJson
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.checkup import checkup, discard
from harmonicface.gallery.disk.inventory import Inventory, inventory
from harmonicface.gallery.disk.paths import is_folder
from harmonicface.gallery.disk.storage import DEFAULT_MODEL
from harmonicface.gallery.gallery import Gallery
from harmonicface.gallery.names import checked_name
from harmonicface.io.files import alone_in
from harmonicface.store.part import Damage

PATH_HELP = "The gallery: its folder, or one file."
GalleryPath = Annotated[Path, typer.Argument(metavar="PATH", help=PATH_HELP, show_default=False)]
MOST_NAMES = 20  # that are printed of a damaged file; --json has all

app = typer.Typer(help="Look after a gallery on disk.", no_args_is_help=True)


@app.command()
def info(path: GalleryPath, as_json: AsJson = False) -> None:
    """Say what is in a gallery and what it takes."""
    found = inventory(path)
    if as_json:
        said = asdict(found)
        sizes = {"bytes": said.pop("nbytes"), "bytes_per_person": found.bytes_per_person}
        typer.echo(json.dumps({"gallery": str(path), **said, **sizes}))
    else:
        typer.echo("\n".join(_said(path, found)))


def _said(path: Path, found: Inventory) -> Iterator[str]:
    """Say it in a few lines."""
    height, width = found.shape
    kept = "one file" if found.shards == 0 else _counted(found.shards, "shard")
    yield f"{path}: {_people(found.people)}, format {found.version}, {kept}, {spelled_bytes(found.nbytes)}"
    yield f"  {found.rows} rows of {found.pixels} pixels of {height} x {width}, {found.dtype}; " + (
        f"{spelled_bytes(round(found.bytes_per_person))} a person"
    )
    margin = "infinite" if found.margin is None else f"{found.margin:.4g}"
    decides = f"shortlist {found.shortlist}" if found.model == DEFAULT_MODEL else f"margin {margin}"
    yield f"  model {found.model}, threshold {found.threshold:.4g}, {decides}"
    index = found.index
    yield (
        "  no index: a search reads everybody"
        if index is None
        else (
            f"  index: {index.rows} rows learned from {_people(index.sample)}, looked at in stages of "
            f"{', '.join(map(str, index.stages))}; {index.sketched} of {found.people} are sketched"
        )
    )
    if found.removed_bytes:
        yield f"  {spelled_bytes(found.removed_bytes)} of removed people: `harmonicface gallery compact` frees them"
    if found.damaged:
        yield f"  {_counted(found.damaged, 'damaged shard')} left out: see `harmonicface gallery verify`"


@app.command()
def verify(
    path: GalleryPath,
    throw_out: Annotated[
        bool, typer.Option("--discard", help="Take what is damaged out, with the people who are lost by it.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Read every byte of a gallery; say what is damaged and who is in it. Exit code 1 if anything is."""
    with progress() as tell:
        damages = (discard if throw_out else checkup)(path, tell)
    if as_json:
        found = [
            {"file": one.file, "reason": one.reason, "entries": one.entries, "people": list(one.keys)}
            for one in damages
        ]
        typer.echo(json.dumps({"gallery": str(path), "well": not damages, "damaged": found}))
    elif damages:
        typer.echo("\n".join(line for damage in damages for line in _told(damage)))
    else:
        typer.echo(f"{path}: all well")
    if damages:
        raise typer.Exit(1)


def _told(damage: Damage) -> Iterator[str]:
    """Say what is damaged and who is lost."""
    yield f"damaged: {damage.reason}"
    names = ", ".join(map(_printable, damage.keys[:MOST_NAMES])) + (", ..." if len(damage.keys) > MOST_NAMES else "")
    if names:
        yield f"    {len(damage.keys)} of {_people(damage.entries)} lost: {names}"
    elif damage.entries:
        yield f"    of {_people(damage.entries)} in it nobody is lost by name"


def _printable(name: str) -> str:
    """Return a name as people have them, and of any other the beginning as Python writes it."""
    try:
        return checked_name(name)
    except HarmonicFaceError:
        return f"{ascii(name)!s:.80}"


@app.command()
def compact(path: GalleryPath) -> None:
    """Write files anew without those who were removed, so that no file has their bytes any more."""
    freed = Gallery.open(path).compact()
    typer.echo(f"{path}: {spelled_bytes(freed)} freed; it takes {spelled_bytes(inventory(path).nbytes)}")


@app.command()
def export(
    path: GalleryPath,
    out: Annotated[
        Path,
        typer.Argument(help="A new folder; or a name that ends in .safetensors: one file.", show_default=False),
    ],
    dtype: Annotated[
        str | None, typer.Option(help="Of the rows: float32 or float16.", show_default="as they are")
    ] = None,
    people: Annotated[str | None, typer.Option(help="Comma-separated names.", show_default="everybody")] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Take the place of a gallery that is there.")] = False,
) -> None:
    """Copy a gallery, or some of its people, to a new one; old files become folders."""
    if not replace and os.path.lexists(out):
        raise HarmonicFaceError(f"export: expected a new path or --replace, got {out}, which is there")
    gallery = Gallery.open(path)
    among = None if people is None else [name.strip() for name in people.split(",")]
    gallery.save(out, dtype, among)
    typer.echo(
        f"{out}: {_people(len(gallery) if among is None else len(among))}, {spelled_bytes(inventory(out).nbytes)}"
    )


@app.command()
def rename(
    path: GalleryPath,
    old: Annotated[str, typer.Argument(help="Who.", show_default=False)],
    new: Annotated[str, typer.Argument(help="Her new name.", show_default=False)],
) -> None:
    """Give a person another name."""
    with _changed(path) as gallery:
        gallery.rename(old, new)
    typer.echo(f"{old} is {new} in {path}")


@app.command()
def remove(
    path: GalleryPath,
    names: Annotated[list[str], typer.Argument(metavar="NAME...", help="Who.", show_default=False)],
) -> None:
    """Take people out, all or none; `compact` then removes their bytes."""
    with _changed(path) as gallery:
        gallery.remove(names)
    typer.echo(f"{_people(len(names))} removed; {path} holds {_people(len(gallery))}")


@contextmanager
def _changed(path: Path) -> Iterator[Gallery]:
    """Yield a gallery that is to be changed; one that is a file is written anew, alone."""
    if is_folder(path):
        yield Gallery.open(path)
        return
    with alone_in(path.parent):
        gallery = Gallery.open(path)
        yield gallery
        gallery.save(path)


def _people(count: int) -> str:
    """Return a number of people in words."""
    return f"{count} {'person' if count == 1 else 'people'}"


def _counted(count: int, what: str) -> str:
    """Return a number of things in words."""
    return f"{count} {what}{'' if count == 1 else 's'}"
