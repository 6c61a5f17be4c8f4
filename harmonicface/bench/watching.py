"""Which function is called: its name, as it is found in its package, and whether a call of it is seen."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, partial
from importlib.metadata import packages_distributions
from pathlib import Path
from types import BuiltinFunctionType, FrameType, MethodDescriptorType
from typing import Any, TypeVar

from harmonicface.bench.measure import version_of
from harmonicface.errors import HarmonicFaceError

Result = TypeVar("Result")
Function = Callable[..., Any]


class Watch:
    """Functions that are to be called, and the name that they give to what calls them."""

    def __init__(self, *named: Function, about: str = "") -> None:
        self._named, self._about = named, about

    @property
    def name(self) -> str:
        """The functions, then what else is to be known."""
        functions = " + ".join(name_of(function) for function in self._named)
        return f"{functions}, {self._about}" if self._about and functions else functions

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the packages that the functions are from."""
        packages = {_package_of(function) for function in self._named} - {""}
        return {package: version_of(package) for package in sorted(packages)}

    def first(self, run: Callable[[], Result]) -> Result:
        """Call, and see that all functions are called."""
        if self._named == (inner_of(run),):
            return run()
        wanted = {_seen_as(function): name_of(function) for function in self._named}
        with _watching(set(wanted)) as missed:
            result = run()
        if missed:
            missing = ", ".join(sorted(wanted[one] for one in missed))
            raise HarmonicFaceError(f"{self.name}: expected a call of {missing}, got none")
        return result


def name_of(function: Function) -> str:
    """Return where a function is found: the shortest public way to it, or the modules that are not private.

    A function of a script is named with the script's file.

    Examples
    --------
    >>> import numpy as np
    >>> name_of(np.linalg.svd), name_of(np.ones(3).sum), name_of(name_of)
    ('numpy.linalg.svd', 'numpy.ndarray.sum', 'harmonicface.bench.watching.name_of')
    """
    kind = _class_of(function)
    name = str(getattr(function, "__name__", repr(function)))
    whole = str(getattr(kind or function, "__qualname__", name))
    found = name if "<locals>" in whole else whole
    module = _module_of(function)
    file = getattr(sys.modules.get(module), "__file__", None)
    if module == "__main__" and file:
        return f"{found if kind is None else f'{found}.{name}'} of {Path(file).name}"
    parts = module.split(".")
    public = [part for part in parts if not part.startswith("_")]
    for end in range(1, len(parts) + 1):
        if _attribute(sys.modules.get(".".join(parts[:end])), found) is (kind or function):
            public = parts[:end]
            break
    return ".".join([*public, found, *([] if kind is None else [name])])


def _attribute(owner: object, path: str) -> object:
    """Return what lies at a path of names, None if nothing does."""
    for name in path.split("."):
        owner = getattr(owner, name, None)
    return owner


def _class_of(function: Function) -> type | None:
    """Return the class of a method that is bound, or of a built-in type; None for a function."""
    owner = getattr(function, "__self__", getattr(function, "__objclass__", None))
    if owner is None or inspect.ismodule(owner):
        return None
    return owner if inspect.isclass(owner) else type(owner)


def _module_of(function: Function) -> str:
    """Return the module that a function, or the class of its object, is defined in."""
    return str(getattr(_class_of(function) or function, "__module__", None) or "")


def _package_of(function: Function) -> str:
    """Return the distribution that a function comes with, "" if none is known."""
    return next(iter(_distributions().get(_module_of(function).partition(".")[0], [])), "")


@cache
def _distributions() -> Mapping[str, list[str]]:
    return packages_distributions()


def inner_of(run: Function) -> Function:
    """Return the function that a partial is of."""
    while isinstance(run, partial):
        run = run.func
    return run


def _seen_as(function: Function) -> object:
    """Return what a profiler sees of a function: its code, or the class or module and the name of a built-in one.

    Raises
    ------
    HarmonicFaceError
        It is compiled in a way that no profiler sees.
    """
    plain = inspect.unwrap(getattr(function, "__func__", function))
    plain = getattr(plain, "_implementation", plain)
    code = getattr(plain, "__code__", None)
    if code is not None:
        for cell in getattr(plain, "__closure__", None) or ():  # a decorator that does not say what it wraps
            inside = cell.cell_contents
            if inspect.isfunction(inside) and inside.__name__ == plain.__name__ != code.co_name:
                return inside.__code__
        return code
    if plain is function and isinstance(plain, BuiltinFunctionType | MethodDescriptorType):
        return _class_of(plain) or _module_of(plain), plain.__name__
    raise HarmonicFaceError(f"{name_of(function)}: expected a function whose calls can be seen; time it by itself")


@contextmanager
def _watching(wanted: set[object]) -> Iterator[set[object]]:
    """Take out of a set what is called; watching ends with the last of them, for it costs time."""
    missed, before = set(wanted), sys.getprofile()

    def look(frame: FrameType, event: str, argument: Any) -> None:
        if event == "call":
            missed.discard(frame.f_code)
        elif event == "c_call":
            owners = (_class_of(argument) or type(None)).__mro__
            missed.difference_update((owner, argument.__name__) for owner in (*owners, _module_of(argument)))
        if not missed:
            sys.setprofile(before)

    if missed:
        sys.setprofile(look)
    try:
        yield missed
    finally:
        sys.setprofile(before)
