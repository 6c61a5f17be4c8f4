"""Many small non-negative least squares problems at once, from their normal equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError

Doubles = NDArray[np.float64]
Integers = NDArray[np.intp]

TOLERANCE = 1e-8  # of the largest target: slopes below it count as none
RIDGE = 1e-12  # of the mean diagonal: rays that depend on each other stay solvable
ROUNDS_PER_VARIABLE = 5
ROOM = 8  # positive variables to begin with


def nonnegative_solutions(
    grams: Doubles, targets: Doubles, tolerance: float = TOLERANCE, rounds: int | None = None
) -> Doubles:
    r"""Minimize x^T G x - 2 x^T b over x >= 0, for every b with its G.

    With G = R R^T and b = R y that is |R^T x - y|^2. The active set method of Lawson & Hanson (1974) from the normal
    equations (Bro & de Jong, A fast non-negativity-constrained least squares algorithm, 1997), all problems side by
    side: in each round every problem that is open solves for its positive variables, by one batched call, and then
    takes a variable in or lets some go. Only the positive variables of a problem are kept, so that the work depends on
    how many these are; k counts in one product a round.

    Parameters
    ----------
    grams
        (m, k, k) symmetric positive semidefinite.
    targets
        (n, m, k): n right sides for each of the m.
    tolerance
        A variable is taken in while its slope is above this share of the problem's largest target.
    rounds
        At most so many; by default five for each variable, which is many times what is needed.

    Returns
    -------
    array
        (n, m, k) of at least 0.

    Raises
    ------
    HarmonicFaceError
        Some problems are still open after the rounds.

    Examples
    --------
    >>> rays = np.array([[1.0, 0.0], [1.0, 1.0]])
    >>> nonnegative_solutions((rays @ rays.T)[None], (rays @ [1.0, -1.0])[None, None])
    array([[[1., 0.]]])
    """
    people, k = grams.shape[:2]
    padded = np.zeros((people, k + 1, k + 1))  # variable k stands for none
    padded[:, :k, :k] = grams
    flat = np.zeros((targets.size // k, k + 1))
    flat[:, :k] = targets.reshape(-1, k)
    ridge = RIDGE * np.trace(grams, axis1=1, axis2=2) / k
    result = np.zeros(flat.shape)
    state = _Problems.of(padded, ridge, flat, tolerance * np.abs(flat).max(axis=1, initial=0))
    most = ROUNDS_PER_VARIABLE * (k + 1) if rounds is None else rounds
    for _ in range(most):
        done = state.take_in()
        if done.any():
            result[state.number[done, None], state.places[done]] = state.values[done]
            state = state.without(done)
        if not len(state.number):
            return result[:, :k].reshape(targets.shape)
        state.step()
    raise HarmonicFaceError(
        f"grams: expected problems that settle in {most} rounds, got {len(state.number)} that do not"
    )


@dataclass
class _Problems:
    """The open problems: p of them, s places for positive variables, of which `count` are taken."""

    grams: Doubles  # (m, k + 1, k + 1)
    ridge: Doubles  # (m,)
    number: Integers  # (p,) of the problem among all
    owner: Integers  # (p,) whose matrix it has
    targets: Doubles  # (p, k + 1)
    limit: Doubles  # (p,) slopes up to it count as none
    places: Integers  # (p, s) positive variables, k where there is none
    values: Doubles  # (p, s), of at least 0
    count: Integers  # (p,)
    ready: NDArray[np.bool_]  # (p,) at the minimum over their positive variables

    @classmethod
    def of(cls, grams: Doubles, ridge: Doubles, targets: Doubles, limit: Doubles) -> _Problems:
        """Begin at 0."""
        size, none = len(targets), grams.shape[1] - 1
        number = np.arange(size)
        places, values = np.full((size, ROOM), none), np.zeros((size, ROOM))
        count, ready = np.zeros(size, np.intp), np.ones(size, bool)
        return cls(grams, ridge, number, number % len(grams), targets, limit, places, values, count, ready)

    def without(self, done: NDArray[np.bool_]) -> _Problems:
        """Return the problems that are still open."""
        keep = np.flatnonzero(~done)
        return _Problems(
            self.grams,
            self.ridge,
            self.number[keep],
            self.owner[keep],
            self.targets[keep],
            self.limit[keep],
            self.places[keep],
            self.values[keep],
            self.count[keep],
            self.ready[keep],
        )

    def take_in(self) -> NDArray[np.bool_]:
        """Give each problem that is ready its steepest variable; return which have none left."""
        rows = self.grams[self.owner[:, None], self.places]
        slopes = self.targets - np.matmul(self.values[:, None, :], rows)[:, 0]
        np.put_along_axis(slopes, self.places, 0, axis=1)
        steepest = slopes.argmax(axis=1)
        more = slopes[np.arange(len(slopes)), steepest] > self.limit
        taking = np.flatnonzero(self.ready & more)
        if len(taking) and self.count[taking].max() == self.places.shape[1]:
            self.places = np.pad(self.places, ((0, 0), (0, ROOM)), constant_values=self.grams.shape[1] - 1)
            self.values = np.pad(self.values, ((0, 0), (0, ROOM)))
        self.places[taking, self.count[taking]] = steepest[taking]
        self.count[taking] += 1
        return np.asarray(self.ready & ~more)

    def step(self) -> None:
        """Go to the minimum over the positive variables, or towards it until some are 0, which are let go."""
        slots = np.arange(self.places.shape[1])
        inside = slots < self.count[:, None]
        aim = self._minimum(inside)
        falls = inside & (aim <= 0)
        arrived = np.asarray(~falls.any(axis=1))
        if arrived.all():
            self.values, self.ready = aim, arrived
            return
        size = np.arange(len(self.count))
        vain = self.ready & falls[size, self.count - 1]  # a slope of rounding took the last one in
        self.limit[vain] = np.inf
        drop = np.where(falls, self.values - aim, 1)
        share = np.where(falls, self.values / np.where(drop > 0, drop, 1), np.inf)
        part = np.minimum(share.min(axis=1, keepdims=True), 1)
        part[vain] = 0
        leaves = falls & (share <= part)
        self.values += part * (aim - self.values)
        stays = inside & ~leaves
        order = np.argsort(~stays, axis=1, kind="stable")
        kept = np.take_along_axis(stays, order, 1)
        self.values = np.where(kept, np.take_along_axis(self.values, order, 1), 0)
        self.places = np.where(kept, np.take_along_axis(self.places, order, 1), self.grams.shape[1] - 1)
        self.count = stays.sum(axis=1)
        self.ready = arrived | vain

    def _minimum(self, inside: NDArray[np.bool_]) -> Doubles:
        """Return the unconstrained minimum over the positive variables, 0 in empty places."""
        matrix = self.grams[self.owner[:, None, None], self.places[:, :, None], self.places[:, None, :]]
        slots = np.arange(self.places.shape[1])
        matrix[:, slots, slots] += np.where(inside, self.ridge[self.owner, None], 1)
        right = np.take_along_axis(self.targets, self.places, 1)
        return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
