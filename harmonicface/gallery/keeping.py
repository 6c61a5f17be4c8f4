"""Keeping: a gallery in a folder, in which everything is durable, and as one portable file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Self

from numpy.typing import ArrayLike

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk import storage
from harmonicface.gallery.disk.layout import DTYPES
from harmonicface.gallery.disk.paths import PathLike, is_file, is_folder, is_free, is_same
from harmonicface.gallery.disk.saving import checked_dtype, save_file, save_folder
from harmonicface.gallery.disk.staging import is_url, refuse_writing, staged
from harmonicface.gallery.disk.storage import DEFAULT_MODEL, DEFAULT_SHORTLIST
from harmonicface.gallery.enrolled.enrolment import Model
from harmonicface.gallery.enrolled.people_in_folder import PeopleInFolder
from harmonicface.gallery.enrolled.people_in_memory import PeopleInMemory
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.roll import Roll
from harmonicface.gallery.rule import DEFAULT_MARGIN, Rule
from harmonicface.recognition.models import SUBSPACE_MODELS, WITH_DEPTH, harmonic9
from harmonicface.store.part import Damage

if TYPE_CHECKING:
    from distributed import Client

PORTABLE = ".safetensors"  # ending of a gallery that is one file


class Keeping(Rule, Roll):
    """A gallery as it is kept: in memory, or in a folder; the parameters are those of `Gallery`."""

    def __init__(
        self,
        model: str = DEFAULT_MODEL,
        mask: ArrayLike | None = None,
        threshold: float | None = None,
        margin: float = DEFAULT_MARGIN,
        shortlist: int = DEFAULT_SHORTLIST,
    ) -> None:
        Rule.__init__(self, model, threshold, margin, shortlist)
        projection = None if self.by_score else Model(SUBSPACE_MODELS[model], depth=model in WITH_DEPTH)
        people = PeopleInMemory(None if mask is None else Frame.of(mask))
        Roll.__init__(self, projection or Model(harmonic9, fewest=1, templates=True), people)

    @property
    def path(self) -> Path | None:
        """The folder in which everything is durable; None for a gallery in memory."""
        return self._people.path if isinstance(self._people, PeopleInFolder) else None

    @property
    def damaged(self) -> tuple[Damage, ...]:
        """The files of the folder that were left out when it was opened, because they are damaged; see `verify`."""
        return self._people.damaged if isinstance(self._people, PeopleInFolder) else ()

    @classmethod
    def create(
        cls,
        path: PathLike,
        model: str = DEFAULT_MODEL,
        mask: ArrayLike | None = None,
        threshold: float | None = None,
        margin: float = DEFAULT_MARGIN,
        shortlist: int = DEFAULT_SHORTLIST,
        dtype: str = DTYPES[0],
    ) -> Self:
        """Begin a gallery in a folder, in which everything is durable when the method that does it returns.

        Parameters
        ----------
        path
            A new or empty folder, in one that is there. With a mask it is made now, otherwise with the first person,
            who brings the pixels that are compared.
        model, mask, threshold, margin, shortlist
            As of `Gallery`.
        dtype
            Of the rows on the disk: "float32", or "float16", which takes half the space. Distances are those of the
            rows as they are kept.

        Raises
        ------
        HarmonicFaceError
            Something is there already, no folder can be made, or a setting that no gallery has.

        Examples
        --------
        >>> import tempfile
        >>> import harmonicface as hf
        >>> place = tempfile.TemporaryDirectory()
        >>> gallery = hf.Gallery.create(place.name + "/people")
        >>> gallery.enroll("ada", hf.synthetic_person(1, 24))
        >>> hf.Gallery.open(place.name + "/people").names
        ('ada',)
        >>> place.cleanup()
        """
        gallery = cls(model, mask, threshold, margin, shortlist)
        refuse_writing(path)
        if not is_free(path):
            raise HarmonicFaceError(f"create: expected a new or an empty folder, got {path!s:.300}, which is there")
        if not is_folder(Path(path).parent):
            raise HarmonicFaceError(f"expected a folder {Path(path).parent!s:.300}, got none")
        people = PeopleInFolder(Path(path), gallery, checked_dtype(dtype), gallery._people.known_frame)
        gallery._people = people
        if people.known_frame is not None:
            people.make(people.frame)
        return gallery

    @classmethod
    def open(cls, path: PathLike, client: Client | None = None) -> Self:
        """Open a gallery: a folder, or one portable file.

        Of a folder the manifest is read and the shards are mapped, no more: names, rows and templates are read, and
        checked, when they are asked for. What is enrolled, removed or renamed from then on is durable; what others
        write is seen after `refresh`. Shards that are damaged are left out with a warning (`damaged`). A file is read
        and checked as a whole, into memory.

        Parameters
        ----------
        path
            Of the folder or the file; or a path of fsspec's, as "s3://bucket/people", whose folder is copied to this
            machine's disk (`staging`) and only read.
        client
            Of a Dask cluster (`dask.distributed.Client`), whose workers see the folder under the same path: each keeps
            its share of the people, searches it, and enrols (`enroll_many`).

        Raises
        ------
        HarmonicFaceError
            Nothing is there, or what is damaged, of another kind or of a version that this one does not know; a client
            for a file.
        """
        if is_url(path):
            return cls._of_folder(staged(str(path)), client, str(path))
        if is_folder(path):
            return cls._of_folder(Path(path), client)
        if not is_file(path):
            raise HarmonicFaceError(f"expected a gallery at {path!s:.300}, got none")
        if client is not None:
            raise HarmonicFaceError(f"client: expected a gallery in a folder, got {path!s:.300}")
        return cls._of_file(path)

    @classmethod
    def _of_folder(cls, path: Path, client: Client | None, url: str | None = None) -> Self:
        people = PeopleInFolder.opened(path, client, url)
        rule = people.about.rule()
        gallery = cls(rule.model, None, rule.threshold, rule.margin, rule.shortlist)
        gallery._people = people
        people.rule = gallery
        return gallery

    @classmethod
    def _of_file(cls, path: PathLike) -> Self:
        contents = storage.read(path)
        gallery = cls(contents.model, contents.mask, contents.threshold, contents.margin, contents.shortlist)
        people = PeopleInMemory(Frame.of(contents.mask))
        people.restore(contents.rows, contents.sources, contents.templates)
        gallery._people = people
        return gallery

    def save(self, path: PathLike | None = None, dtype: str | None = None, among: Sequence[str] | None = None) -> None:
        """Write the gallery to a new folder, or to one portable file, whole or not at all.

        Parameters
        ----------
        path
            A folder, new or of a gallery, which is replaced. A name that ends in ".safetensors", or a gallery's file
            that is there already, becomes one file. None, or the gallery's own folder, keeps its threshold, margin and
            shortlist as they are now; its people are there already.
        dtype
            Of the rows in a folder: "float32" or "float16"; as they are by default. A file has float32.
        among
            Names of whom to write; everybody by default.

        Raises
        ------
        HarmonicFaceError
            Nobody is in it, something else than a gallery is there, or it cannot be written.
        """
        if path is None or (self.path is not None and is_same(path, self.path)):
            self._save_rule(dtype, among)
            return
        refuse_writing(path)
        places = range(len(self)) if among is None else [self._people.place(name) for name in among]
        if not len(places):
            raise HarmonicFaceError("save: expected a gallery with somebody in it, got an empty one")
        if len(set(places)) < len(places):
            raise HarmonicFaceError(f"among: expected each name once, got {len(places)} of {len(set(places))} people")
        if Path(path).suffix == PORTABLE or is_file(path):
            save_file(path, self._people, self, places, dtype)
        else:
            save_folder(Path(path), self._people, self, places, dtype)

    def refresh(self) -> None:
        """See what others have written to the folder since it was opened or written to; in memory nothing changes.

        Threshold, margin and shortlist become those that are kept there. What is in object storage is copied again if
        it is another there than the copy.

        Raises
        ------
        HarmonicFaceError
            The folder is damaged, another gallery has taken its place, or object storage cannot be read.
        """
        if isinstance(self._people, PeopleInFolder):
            self._people.refresh()
            rule = self._people.about.rule()
            self.threshold, self.margin, self.shortlist = rule.threshold, rule.margin, rule.shortlist

    def verify(self) -> tuple[Damage, ...]:
        """Read every byte of the folder and compare it with its checksum, and check everybody as a search would.

        Returns
        -------
        tuple
            What is damaged: the file, the reason, and the names of the people in it who are lost; empty if all is
            well.

        Raises
        ------
        HarmonicFaceError
            A gallery in memory, or a damaged manifest.
        """
        return self._in_folder("verify").verify()

    def compact(self) -> int:
        """Write the folder's files anew without the bytes of people who were removed; return how many bytes less.

        Raises
        ------
        HarmonicFaceError
            A gallery in memory, a damaged shard, or a full disk.
        """
        return self._in_folder("compact").compact()

    def _in_folder(self, what: str) -> PeopleInFolder:
        """Return the people, who are in a folder."""
        if not isinstance(self._people, PeopleInFolder):
            raise HarmonicFaceError(f"{what}: expected a gallery in a folder, got one in memory: save it to a folder")
        return self._people

    def _save_rule(self, dtype: str | None, among: Sequence[str] | None) -> None:
        """Keep threshold, margin and shortlist."""
        people = self._in_folder("save without a path")
        if dtype not in (None, people.about.dtype) or among is not None:
            raise HarmonicFaceError("save: expected another path for other rows or for some of the people, got its own")
        people.describe()
