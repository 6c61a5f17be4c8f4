"""The .npz files of saved Surfaces: read with every checksum verified, nothing unpickled."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io._reasons import reason_of


def read_archive(file: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of an .npz file, each with its checksum verified; nothing is unpickled."""
    found = {}
    try:
        with file.open("rb") as stream, zipfile.ZipFile(stream) as archive:
            for name in archive.namelist():
                content = io.BytesIO(archive.read(name))
                found[name.removesuffix(".npy")] = np.lib.format.read_array(content, allow_pickle=False)
    except FileNotFoundError:
        raise HarmonicFaceError(f"expected a saved Surface, got no file {file}") from None
    except Exception as error:  # of a broken archive zipfile and numpy raise nearly anything
        reason = f": {error}" if isinstance(error, zipfile.BadZipFile) else reason_of(error)
        raise HarmonicFaceError(f"{file}: expected a saved Surface, got a file that is none{reason}") from None
    return found
