"""Integrability: of all frames in which normals could be given, the one in which they are those of a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from harmonicface.stereo.depth.curl import SCALE, curl_terms

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

SAMPLE = 5000  # pixels
TURNS, FINALISTS = 300, 8  # rotations that are tried, and those of them that are refined
LINEAR_STARTS = 40
ROUNDS = 40
FLATTEST = 0.01  # sine between the rows of the cofactor matrix: below, the frame would make anything a plane

_GENERATORS = np.array(
    [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]], float
)


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame for scaled normals, and how well they are integrable in it.

    Parameters
    ----------
    matrix
        (3, 3), `scaled @ matrix.T` are the scaled normals in it.
    cost
        Mean Cauchy loss of the curl.
    gap
        How much curl the least determined direction of the frame would add, over what is there (mean squares,
        weighted): below 1, the surface's shape leaves its frame open (a plane, a cylinder, a surface of revolution).
    """

    matrix: Doubles
    cost: float
    gap: float


def integrable_rotation(scaled: Doubles, mask: Mask, seed: int = 0) -> Frame:
    """Return the rotation after which scaled normals are integrable; concave or convex is left open.

    The Cauchy loss of the curl over all rotations: a wide net of them first, the best ones refined.

    Parameters
    ----------
    scaled
        (p, 3) scaled normals, right up to a rotation.
    mask
        (h, w) booleans.
    seed
        Of the sample of pixels and the net of rotations.
    """
    terms, loss_scale = _sampled(curl_terms(scaled, mask), seed)
    net = Rotation.random(TURNS, random_state=seed).as_matrix()
    losses = _loss(terms @ net[:, :2].reshape(-1, 6).T, 5 * loss_scale).mean(axis=0)
    found = []
    for index in np.argsort(losses)[:FINALISTS]:
        wide = _refined_rotation(terms, net[index], 5 * loss_scale)
        found.append(_refined_rotation(terms, wide, loss_scale))
    costs = [float(_loss(terms @ one[:2].ravel(), loss_scale).mean()) for one in found]
    best = found[int(np.argmin(costs))]
    tangent = np.stack([terms @ (generator @ best)[:2].ravel() for generator in _GENERATORS], axis=1)
    return Frame(best, min(costs), _gap(tangent, terms @ best[:2].ravel(), loss_scale))


def integrable_frame(scaled: Doubles, mask: Mask, seed: int = 0) -> Frame:
    """Return a frame in which scaled normals are integrable: what a bas-relief transformation makes of the true one.

    The Cauchy loss of the curl over all (P_1, P_2) of length 1, by reweighting from many starts (the loss is that of a
    linear form, Yuille & Snow 1997). Length depends on the frame, so the search is repeated from the frame it found,
    turned and stretched such that the normals look at the camera evenly.

    Parameters
    ----------
    scaled
        (p, 3) scaled normals in any frame.
    mask
        (h, w) booleans.
    seed
        Of the sample of pixels and the starts.
    """
    frame = _whitening(scaled)
    random = np.random.default_rng(seed)
    cost, gap = 0.0, np.inf
    for starts in (LINEAR_STARTS, 6, 6):
        terms, loss_scale = _sampled(curl_terms(scaled @ frame.T, mask), seed)
        form, cost = _least_form(terms, loss_scale, random.normal(size=(starts, 6)))
        basis = np.linalg.svd(form[None])[2][1:]
        gap = min(gap, _gap(terms @ basis.T, terms @ form, loss_scale))
        if _sine(form[:3], form[3:]) < FLATTEST:
            return Frame(_upright(frame, scaled), cost, 0.0)
        frame = _upright(_of_cofactors(form) @ frame, scaled)
    return Frame(frame, cost, gap)


def _sine(first: Doubles, second: Doubles) -> float:
    """Return the sine of the angle between two vectors, 0 where one of them vanishes."""
    lengths = np.linalg.norm(first) * np.linalg.norm(second)
    return float(np.linalg.norm(np.cross(first, second)) / lengths) if lengths > 1e-12 else 0.0


def _least_form(terms: Doubles, loss_scale: float, starts: Doubles) -> tuple[Doubles, float]:
    """Return the unit 6-vector with the least Cauchy loss, and that loss."""
    first = np.linalg.eigh(terms.T @ terms)[1][:, 0]
    best, least = first, np.inf
    for start in (first, *starts):
        form = start / np.linalg.norm(start)
        for scale, rounds in ((5 * loss_scale, 10), (loss_scale, ROUNDS)):
            for _ in range(rounds):
                weights = 1 / (scale**2 + (terms @ form) ** 2)
                again = np.linalg.eigh(terms.T @ (weights[:, None] * terms))[1][:, 0]
                still = abs(again @ form) > 1 - 1e-11
                form = again
                if still:
                    break
        cost = float(_loss(terms @ form, loss_scale).mean())
        if cost < least:
            best, least = form, cost
    return best, least


def _refined_rotation(terms: Doubles, start: Doubles, scale: float) -> Doubles:
    """Return the rotation of least Cauchy loss near the start, by damped reweighted Gauss-Newton steps."""
    turn, damping = start, 1e-3
    cost = float(_loss(terms @ turn[:2].ravel(), scale).mean())
    for _ in range(ROUNDS):
        curl = terms @ turn[:2].ravel()
        tangent = np.stack([terms @ (generator @ turn)[:2].ravel() for generator in _GENERATORS], axis=1)
        weighted = tangent / (scale**2 + curl**2)[:, None]
        matrix, right = weighted.T @ tangent, weighted.T @ curl
        matrix += 1e-12 * np.trace(matrix) * np.eye(3)
        gain = 0.0
        while damping < 1e6:
            step = np.linalg.solve(matrix + damping * np.diag(np.diag(matrix)), -right)
            trial = Rotation.from_rotvec(step).as_matrix() @ turn
            now = float(_loss(terms @ trial[:2].ravel(), scale).mean())
            if now < cost:
                gain, turn, cost, damping = cost - now, trial, now, max(damping / 10, 1e-9)
                break
            damping *= 10
        if gain <= 1e-8 * cost:
            break
    return turn


def _of_cofactors(form: Doubles) -> Doubles:
    """Return a frame whose cofactor matrix has these first two rows; its third one is across, of their mean length."""
    first, second = form[:3], form[3:]
    across = np.cross(first, second)
    lengths = np.linalg.norm(first) * np.linalg.norm(second)
    third = across / max(float(np.linalg.norm(across)), 1e-300) * np.sqrt(lengths)
    return np.stack([np.cross(second, third), np.cross(third, first), across])


def _upright(frame: Doubles, scaled: Doubles) -> Doubles:
    """Apply the bas-relief transformation that gives normals no slope in the median, and a middling one in size."""
    seen = scaled @ frame.T
    if np.median(seen[:, 2]) < 0:
        seen, frame = -seen, -frame
    heights = np.where(np.abs(seen[:, 2]) > 0, seen[:, 2], 1e-300)
    slopes = seen[:, :2] / heights[:, None]
    middle = np.median(slopes, axis=0)
    stretch = 0.6 / max(float(np.median(np.linalg.norm(slopes - middle, axis=1))), 1e-12)
    relief = np.array([[stretch, 0, -stretch * middle[0]], [0, stretch, -stretch * middle[1]], [0, 0, 1]])
    return np.asarray(relief @ frame)


def _whitening(scaled: Doubles) -> Doubles:
    """Return the frame in which directions of the normals have the same spread to all sides."""
    lengths = np.linalg.norm(scaled, axis=1)
    units = scaled[lengths > 0] / lengths[lengths > 0][:, None]
    values, vectors = np.linalg.eigh(units.T @ units / len(units))
    return np.asarray((vectors / np.sqrt(np.maximum(values, 1e-12 * values[-1]))) @ vectors.T)


def _sampled(terms: Doubles, seed: int) -> tuple[Doubles, float]:
    """Return some of the terms, and the scale of the loss for them."""
    if len(terms) > SAMPLE:
        terms = terms[np.random.default_rng(seed).choice(len(terms), SAMPLE, replace=False)]
    return terms, SCALE * float(np.median(np.linalg.norm(terms, axis=1))) + 1e-300


def _loss(curl: Doubles, scale: float) -> Doubles:
    return np.asarray(np.log1p((curl / scale) ** 2))


def _gap(tangent: Doubles, curl: Doubles, scale: float) -> float:
    """Return the least mean square that one of the directions would add to the weighted curl, over what it has."""
    weights = 1 / (scale**2 + curl**2)
    values = np.linalg.eigvalsh(tangent.T @ (weights[:, None] * tangent))
    return float(max(values[0], 0.0) / max(float((weights * curl**2).sum()), 1e-300))
