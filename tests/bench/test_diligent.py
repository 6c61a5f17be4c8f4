from __future__ import annotations

import json
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.io import savemat

from harmonicface import cli
from harmonicface.bench.diligent import METHODS, angular_errors, diligent_table, evaluate_diligent
from harmonicface.errors import HarmonicFaceError

KNOWN = ("least_squares", "robust", "semi_calibrated")


def write_ball(root: Path, count: int = 20, size: int = 40) -> Path:
    """A matte ball with attached shadows under lamps of unlike brightness, as the data set stores it."""
    root.mkdir()
    y, x = np.mgrid[1 : -1 : size * 1j, -1 : 1 : size * 1j]
    mask = x**2 + y**2 < 0.9
    normals = np.where(mask[..., None], np.dstack([x, y, np.sqrt(np.where(mask, 1 - x**2 - y**2, 0))]), 0)
    lamps = np.random.default_rng(0).normal(size=(count, 3)) * [0.5, 0.5, 0.1] + [0, 0, 1]
    lamps /= np.linalg.norm(lamps, axis=1, keepdims=True)
    brightness = np.linspace(0.5, 1, count)[:, None] * [0.9, 1.0, 0.8]
    for index in range(count):
        picture = 0.8 * np.maximum(normals @ lamps[index], 0)[..., None] * brightness[index]
        cv2.imwrite(str(root / f"{index + 1:03d}.png"), np.rint(65535 * picture[..., ::-1]).astype(np.uint16))
    np.savetxt(root / "light_directions.txt", lamps)
    np.savetxt(root / "light_intensities.txt", brightness)
    cv2.imwrite(str(root / "mask.png"), 255 * mask.astype(np.uint8))
    savemat(root / "Normal_gt.mat", {"Normal_gt": normals})
    return root


def test_a_made_up_ball(tmp_path: Path) -> None:
    folder = write_ball(tmp_path / "madePNG")
    picture = cv2.imread(str(folder / "005.png"), cv2.IMREAD_UNCHANGED)
    cv2.imwrite(str(folder / "005.png"), picture[::-1])
    result = evaluate_diligent(folder, KNOWN)
    assert (result.object, result.photographs) == ("madePNG", 20)
    assert list(result.left_out) == ["005.png"]
    assert result.methods["least_squares"].left_out == ()
    assert result.methods["robust"].left_out == (4,)
    assert result.methods["robust"].mean_deg < 0.2
    assert result.methods["semi_calibrated"].mean_deg < 1
    assert result.methods["least_squares"].mean_deg > 5 * result.methods["robust"].mean_deg
    heads, rows = diligent_table(result)
    assert [row[0] for row in rows] == list(KNOWN)
    assert all(len(row) == len(heads) for row in rows)


def test_a_method_that_refuses_is_told(tmp_path: Path) -> None:
    folder = write_ball(tmp_path / "madePNG", count=3)
    result = evaluate_diligent(folder, KNOWN)
    assert list(result.failed) == ["semi_calibrated"]
    assert "at least 4" in result.failed["semi_calibrated"]
    with pytest.raises(HarmonicFaceError, match="methods: expected names from least_squares"):
        evaluate_diligent(folder, ["nonsense"])


def test_angles_are_exact_and_a_normal_that_is_missing_errs_by_ninety() -> None:
    true = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    found = np.array([[0.0, 3.0, 3.0], [0.6, 1e-9, 0.8], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    assert_allclose(angular_errors(found, true), [45, np.degrees(1e-9), 90], rtol=1e-6)


def test_the_command_prints_one_object(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_ball(tmp_path / "madePNG")
    argv = ["harmonicface", "evaluate", "diligent", str(folder), "--methods", "least_squares, robust"]
    monkeypatch.setattr(sys, "argv", [*argv, "--json"])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert not ended.value.code
    printed = json.loads(capsys.readouterr().out)
    assert printed["object"] == "madePNG"
    assert set(printed["methods"]) == {"least_squares", "robust"}
    assert {"mean_deg", "median_deg", "seconds"} <= set(printed["methods"]["robust"])
    monkeypatch.setattr(sys, "argv", argv)
    with pytest.raises(SystemExit):
        cli.main()
    assert "robust" in capsys.readouterr().out


def test_the_rows_of_the_issue_are_there() -> None:
    assert {"least_squares", "robust", "unknown_directions", "unknown"} <= set(METHODS)


@pytest.mark.data
def test_a_real_object(data_dir: Path) -> None:
    result = evaluate_diligent(data_dir / "diligent" / "ballPNG", ("least_squares", "robust"))
    assert abs(result.methods["least_squares"].mean_deg - 4.10) < 0.6
    assert result.methods["robust"].mean_deg <= 1.7
    assert len(result.methods["robust"].left_out) <= 4
