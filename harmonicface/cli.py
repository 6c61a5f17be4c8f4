"""The command line: its commands, and one line with exit code 2 for whatever they cannot do."""

from __future__ import annotations

import sys
import warnings
from typing import Any, NoReturn, cast

import typer

from harmonicface.commands.diligent import evaluate_diligent_object
from harmonicface.commands.environment import light
from harmonicface.commands.evaluation import bench, evaluate_yale
from harmonicface.commands.gallery import app as gallery
from harmonicface.commands.pictures import images
from harmonicface.commands.recognition import enroll, match
from harmonicface.commands.relighting import relight
from harmonicface.commands.stereo import stereo
from harmonicface.errors import HarmonicFaceError

# What typer raises for a wrong option; it has no public name.
USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[1]

app = typer.Typer(
    help="Recognize faces under any lighting with harmonic subspaces.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (bench, enroll, match, images, relight, light, stereo):
    app.command()(command)
evaluate = typer.Typer(help="Published protocols on data that you have.", no_args_is_help=True)
evaluate.command("yale-b")(evaluate_yale)
evaluate.command("diligent")(evaluate_diligent_object)
app.add_typer(evaluate, name="evaluate")
app.add_typer(gallery, name="gallery")


def main() -> None:
    """Run the command line; bad input ends in one line on standard error and exit code 2."""
    warnings.showwarning = _warn
    try:
        sys.exit(app(standalone_mode=False))
    except HarmonicFaceError as error:
        _refuse(str(error))
    except USAGE_ERROR as error:
        reason = cast(Any, error).format_message()
        if reason:
            _refuse(reason)
        sys.exit(2)  # a group without a command has printed its help
    except (typer.Abort, KeyboardInterrupt):
        sys.exit(130)


def _warn(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
    """Print a warning to people as one line; those to programmers are for them."""
    if issubclass(category, UserWarning):
        print(f"harmonicface: {' '.join(str(message).split())}", file=sys.stderr)


def _refuse(reason: str) -> NoReturn:
    print(f"harmonicface: {' '.join(reason.split())}", file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
