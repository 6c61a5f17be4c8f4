"""What the README and the guide show must run as it stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import harmonicface as hf
from harmonicface.bench.yale_b import evaluate_yale_b

PROJECT = Path(__file__).parents[1]
PAGES = (PROJECT / "README.md", PROJECT / "docs" / "guide.md", PROJECT / "docs" / "theory.md")
ABOUT_GALLERIES = (PROJECT / "docs" / "galleries.md", PROJECT / "docs" / "scale.md")


def blocks() -> list[tuple[str, str]]:
    found = [
        (page, block)
        for page in PAGES
        for block in re.findall(r"```python\n(.*?)```", page.read_text("utf-8"), re.DOTALL)
    ]
    return [(f"{page.name} {block.splitlines()[-1][:40]}", block) for page, block in found]


def test_there_are_examples() -> None:
    assert len(blocks()) >= 6


@pytest.mark.parametrize("block", [block for _, block in blocks()], ids=[name for name, _ in blocks()])
def test_example_runs(
    block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "example", "exec"), {})
    printed = capsys.readouterr().out
    assert printed
    if "gallery.save" in block:
        assert printed.startswith("emmy ")
        assert hf.Gallery.open(tmp_path / "people.gallery").names == ("ada", "emmy")
    if "enroll_many" in block:
        assert printed.startswith("person 7 ")
    if "factor_light_field" in block:
        assert printed == "True\n"


@pytest.mark.parametrize("page", (*PAGES, *ABOUT_GALLERIES), ids=lambda page: page.name)
def test_pictures_and_pages_are_there(page: Path) -> None:
    for name in re.findall(r"\]\(([^):]*?)\)", page.read_text(encoding="utf-8")):
        assert (page.parent / name).is_file(), name


def test_the_guide_names_what_there_is() -> None:
    rooms = re.split(r"^## .*`harmonicface\.(\w+)`$", PAGES[1].read_text("utf-8"), flags=re.MULTILINE)[1:]
    for room, text in zip(rooms[::2], rooms[1::2], strict=True):
        names = re.findall(r"`((?:\w+\.)*\w+)\.(\w+)`", text)
        for module, name in names:
            if module.partition(".")[0] != "hf":
                file = (PROJECT / "harmonicface" / room).joinpath(*module.split(".")).with_suffix(".py")
                assert re.search(rf"^(def|class) {name}\b", file.read_text("utf-8"), re.MULTILINE), (
                    f"{room}.{module}.{name}"
                )


def test_the_guide_names_what_a_match_has() -> None:
    row = next(line for line in PAGES[1].read_text("utf-8").splitlines() if "`hf.Match`:" in line)
    names = re.findall(r"`(\w+)`", row)
    assert len(names) > 4
    assert not [name for name in names if name not in hf.Match.__dataclass_fields__ and not hasattr(hf.Match, name)]


@pytest.mark.data
def test_errors_on_real_photographs_are_those_of_the_command(data_dir: Path) -> None:
    rows = {}
    for line in PAGES[0].read_text("utf-8").partition("\nReal photographs, ")[2].partition("\n\n**")[0].splitlines():
        names, *errors = line.replace("*", "").strip("| ").split(" | ")
        if len(errors) == 6:
            rows |= dict.fromkeys(names.split(", "), errors[:5])
    quick = [
        "correlation",
        "eigenfaces",
        "eigenfaces_minus3",
        "fisherfaces",
        "linear3",
        "ambient4",
        "pca3",
        "harmonic9",
    ]
    found = evaluate_yale_b(data_dir / "yaleb", range(1, 12), methods=quick).methods
    for name in quick:
        assert rows[name] == [f"{error:.1f}" if error else "0" for error in found[name].error_percent.values()], name
