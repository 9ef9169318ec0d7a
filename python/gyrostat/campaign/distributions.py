# SPDX-License-Identifier: MIT
"""Distributions as exact maps of uniform numbers: every draw is an inverse distribution function, none is rejected.

A distribution takes a fixed number of uniform numbers, whatever comes out, and maps each row of them by itself: one
run drawn alone gives the same bits as among others.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, PlainSerializer, PlainValidator, model_validator
from scipy import special

from gyrostat.campaign.streams import Array
from gyrostat.errors import InputError, input_errors, suggestion
from gyrostat.model import Model
from gyrostat.text import shown

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Deviation = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Weights = list[Annotated[float, Field(ge=0.0, allow_inf_nan=False)]]


class Distribution(Model):
    """What all of them have."""

    dist: str

    size: ClassVar[int] = 1
    """Numbers a draw."""

    @property
    def words(self) -> int:
        """Uniform numbers a draw."""
        return 1

    def table(self) -> dict[str, Any]:
        """As it stands in a file."""
        return {"dist": self.dist} | self.model_dump(exclude_none=True, exclude_defaults=True)


class Scalar(Distribution):
    """A distribution of one number; `each` draws independent ones for the elements of a vector."""

    each: Annotated[int, Field(ge=1, le=100)] | None = None

    @abstractmethod
    def draw(self, u: Array) -> Array:
        """Draws, shape (n, 1), of uniform numbers, shape (n, words)."""

    @property
    def median(self) -> float:
        """The number of the middle of all uniform numbers."""
        return float(self.draw(np.full((1, self.words), 0.5))[0, 0])


class Inverse(Scalar):
    """One uniform number, through the inverse distribution function."""

    @abstractmethod
    def quantile(self, u: Array) -> Array:
        """The inverse distribution function, elementwise."""

    def draw(self, u: Array) -> Array:
        """A number a row."""
        return self.quantile(np.ascontiguousarray(u[:, 0]))[:, None]


class _Between(Inverse):
    low: Number
    high: Number

    @model_validator(mode="after")
    def _ordered(self) -> _Between:
        if not self.low < self.high:
            raise InputError(f"low = {self.low:g} must lie below high = {self.high:g}")
        return self


class Normal(Inverse):
    """Normal, of mean and standard deviation."""

    dist: Literal["normal"] = "normal"
    mean: Number
    std: Deviation

    def quantile(self, u: Array) -> Array:
        """Elementwise."""
        return np.asarray(self.mean + self.std * special.ndtri(u))


class TruncNormal(_Between):
    """Normal of `mean` and `std` before it is cut off at both ends."""

    dist: Literal["truncnormal"] = "truncnormal"
    mean: Number
    std: Positive

    def quantile(self, u: Array) -> Array:
        """Elementwise; in a tail by its logarithm, on the side where it is small."""
        a, b = (self.low - self.mean) / self.std, (self.high - self.mean) / self.std
        if a > 0.0:  # both ends above the mean: from the upper tail
            z = -_log_tail(-a, -b, u)
        elif b < 0.0:
            z = _log_tail(b, a, 1.0 - u)
        else:
            z = special.ndtri(special.ndtr(a) * (1.0 - u) + special.ndtr(b) * u)
        return np.clip(self.mean + self.std * z, self.low, self.high)


def _log_tail(inner: float, outer: float, u: Array) -> Array:
    """The z, from `inner` at u = 0 to `outer` at u = 1, both negative, between whose tails u divides."""
    near = special.log_ndtr(inner) + np.log1p(-u)
    far = special.log_ndtr(outer) + np.log(u)
    return np.asarray(special.ndtri_exp(np.logaddexp(near, far)))


class LogNormal(Inverse):
    """The exponential of a normal number of mean `mu` and standard deviation `sigma`."""

    dist: Literal["lognormal"] = "lognormal"
    mu: Number
    sigma: Deviation

    def quantile(self, u: Array) -> Array:
        """Elementwise."""
        return np.asarray(np.exp(self.mu + self.sigma * special.ndtri(u)))


class Uniform(_Between):
    """Uniform between two ends."""

    dist: Literal["uniform"] = "uniform"

    def quantile(self, u: Array) -> Array:
        """Elementwise."""
        return self.low + (self.high - self.low) * u


class LogUniform(_Between):
    """The logarithm is uniform between those of two positive ends."""

    dist: Literal["loguniform"] = "loguniform"
    low: Positive
    high: Positive

    def quantile(self, u: Array) -> Array:
        """Elementwise."""
        low, high = math.log(self.low), math.log(self.high)
        return np.clip(np.exp(low + (high - low) * u), self.low, self.high)


class Exponential(Inverse):
    """Exponential, of a mean."""

    dist: Literal["exponential"] = "exponential"
    mean: Positive

    def quantile(self, u: Array) -> Array:
        """Elementwise."""
        return np.asarray(-self.mean * np.log1p(-u))


class Beta(Inverse):
    """Beta of shapes `a` and `b`, between 0 and 1 if no other ends are given."""

    dist: Literal["beta"] = "beta"
    a: Positive
    b: Positive
    low: Number = 0.0
    high: Number = 1.0

    @model_validator(mode="after")
    def _ordered(self) -> Beta:
        if not self.low < self.high:
            raise InputError(f"low = {self.low:g} must lie below high = {self.high:g}")
        return self

    def quantile(self, u: Array) -> Array:
        """Elementwise."""
        return np.asarray(self.low + (self.high - self.low) * special.betaincinv(self.a, self.b, u))


class Triangular(_Between):
    """Triangular with its top at `mode`."""

    dist: Literal["triangular"] = "triangular"
    mode: Number

    @model_validator(mode="after")
    def _inside(self) -> Triangular:
        if not self.low <= self.mode <= self.high:
            raise InputError(f"mode = {self.mode:g} must lie from low = {self.low:g} to high = {self.high:g}")
        return self

    def quantile(self, u: Array) -> Array:
        """Elementwise."""
        width, rise, fall = self.high - self.low, self.mode - self.low, self.high - self.mode
        return np.where(
            u * width < rise,
            self.low + np.sqrt(u * width * rise),
            self.high - np.sqrt((1.0 - u) * width * fall),
        )


class Choice(Inverse):
    """One of several numbers, as likely as each other if no weights are given."""

    dist: Literal["choice"] = "choice"
    of: Annotated[list[Number], Field(min_length=1)]
    weights: Weights | None = None

    @model_validator(mode="after")
    def _weighed(self) -> Choice:
        if self.weights is not None:
            checked_weights(self.weights, len(self.of), "of")
        return self

    @property
    def shares(self) -> Array:
        """How likely each is."""
        n = len(self.of)
        return np.full(n, 1.0 / n) if self.weights is None else np.array(self.weights, dtype=float)

    def quantile(self, u: Array) -> Array:
        """Elementwise: thresholds at the sums of the weights, in the order of `of`."""
        return np.asarray(np.array(self.of, dtype=float)[chosen(self.shares, u)])


class Poisson(Inverse):
    """A count of a mean; what lies above `most` is `most`."""

    dist: Literal["poisson"] = "poisson"
    mean: Annotated[float, Field(ge=0.0, le=1e6, allow_inf_nan=False)]
    most: Annotated[int, Field(ge=0, le=10**9)] | None = None

    def quantile(self, u: Array) -> Array:
        """Elementwise: the smallest count whose distribution function is not below u."""
        end = int(self.mean + 12.0 * math.sqrt(self.mean) + 40.0)
        if self.most is not None:
            end = min(end, self.most)
        count = np.searchsorted(special.pdtr(np.arange(end), self.mean), u, side="left")
        return np.asarray(count, dtype=float)


class Quantiles(Inverse):
    """A fixed table: `values` at `probabilities` from 0 to 1 (evenly spaced if absent), straight lines between them."""

    dist: Literal["table"] = "table"
    values: Annotated[list[Number], Field(min_length=2)]
    probabilities: list[Number] | None = None

    @model_validator(mode="after")
    def _rising(self) -> Quantiles:
        if np.any(np.diff(self.values) < 0.0):
            raise InputError("values must not fall")
        if (p := self.probabilities) is not None:
            if len(p) != len(self.values):
                raise InputError(f"{len(p)} probabilities and {len(self.values)} values; as many belong there")
            if p[0] != 0.0 or p[-1] != 1.0 or not np.all(np.diff(p) > 0.0):
                raise InputError("probabilities must rise from 0 to 1")
        return self

    def quantile(self, u: Array) -> Array:
        """Elementwise."""
        p = np.linspace(0.0, 1.0, len(self.values)) if self.probabilities is None else np.array(self.probabilities)
        return np.interp(u, p, self.values)


class Share(Model):
    """A part of a mixture: how likely it is, and a number or a distribution."""

    weight: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
    of: Annotated[float | Inverse, PlainValidator(lambda value: value)]

    @classmethod
    def read(cls, table: Any) -> Share:
        """Of ``{ weight, value }`` or ``{ weight, dist, ... }``."""
        if isinstance(table, Share):
            return table
        if not isinstance(table, Mapping) or "weight" not in table or ("value" in table) == ("dist" in table):
            raise InputError(f"{shown(table)}: write {{ weight = 0.5, value = 1.0 }} or {{ weight = 0.5, dist = ... }}")
        rest = {key: value for key, value in table.items() if key != "weight"}
        of = rest["value"] if set(rest) == {"value"} else distribution(rest)
        if isinstance(of, Distribution):
            if not isinstance(of, Inverse) or of.each is not None:
                raise InputError(f"a part of a mixture takes one uniform number; '{of.dist}' does not here")
        elif isinstance(of, bool) or not isinstance(of, int | float) or not math.isfinite(of):
            raise InputError(f"value = {shown(of)}: a finite number belongs here")
        return cls(weight=table["weight"], of=of)

    def table(self) -> dict[str, Any]:
        """As it stands in a file."""
        return {"weight": self.weight} | (self.of.table() if isinstance(self.of, Inverse) else {"value": self.of})


def _shares(given: Any) -> list[Share]:
    if not isinstance(given, list | tuple) or not given:
        raise InputError(f"{shown(given)} is no list of parts")
    return [Share.read(part) for part in given]


class Mixture(Scalar):
    """One of several distributions: one uniform number chooses, one draws."""

    dist: Literal["mixture"] = "mixture"
    of: Annotated[list[Share], PlainValidator(_shares), PlainSerializer(lambda parts: [part.table() for part in parts])]

    @model_validator(mode="after")
    def _weighed(self) -> Mixture:
        checked_weights([part.weight for part in self.of], len(self.of), "of")
        return self

    @property
    def words(self) -> int:
        """Of the choice and of the draw."""
        return 2

    def draw(self, u: Array) -> Array:
        """A number a row."""
        which = chosen(np.array([part.weight for part in self.of]), np.ascontiguousarray(u[:, 0]))
        within = np.ascontiguousarray(u[:, 1])
        drawn = [p.of.quantile(within) if isinstance(p.of, Inverse) else np.full(len(u), float(p.of)) for p in self.of]
        return np.asarray(np.stack(drawn)[which, np.arange(len(u))][:, None])


class Attitude(Distribution):
    """A rotation: uniform over all of them, or about a random axis by an angle of a distribution, rad.

    References
    ----------
    K. Shoemake, "Uniform random rotations", Graphics Gems III (1992)
    """

    dist: Literal["attitude"] = "attitude"
    angle: Annotated[Scalar | None, PlainValidator(lambda a: None if a is None else scalar(a))] = None

    size: ClassVar[int] = 4

    @property
    def words(self) -> int:
        """Three, of which the last is the angle's, where there is one."""
        return 3 if self.angle is None else 2 + self.angle.words

    def draw(self, u: Array) -> Array:
        """Quaternions, scalar first, a row each."""
        a, b, c = (np.ascontiguousarray(u[:, i]) for i in range(3))
        if self.angle is None:
            r, s, t = np.sqrt(1.0 - a), 2.0 * math.pi * b, 2.0 * math.pi * c
            R = np.sqrt(a)
            return np.column_stack([R * np.cos(t), r * np.sin(s), r * np.cos(s), R * np.sin(t)])
        z, azimuth = 2.0 * a - 1.0, 2.0 * math.pi * b
        r = np.sqrt((1.0 - z) * (1.0 + z))
        half = 0.5 * self.angle.draw(np.ascontiguousarray(u[:, 2:]))[:, 0]
        sine = np.sin(half)
        return np.column_stack([np.cos(half), sine * r * np.cos(azimuth), sine * r * np.sin(azimuth), sine * z])

    def table(self) -> dict[str, Any]:
        """As it stands in a file."""
        return {"dist": self.dist} | ({} if self.angle is None else {"angle": self.angle.table()})


class Inertia(Distribution):
    """An inertia near the nominal one that always belongs to a body.

    The second moments ``S = tr(J)/2 I - J = L L'`` are positive definite exactly for bodies; drawn is
    ``S' = L exp(E) L'`` with a symmetric normal E of standard deviation `spread` on and ``spread / sqrt 2`` off the
    diagonal.
    """

    dist: Literal["inertia"] = "inertia"
    spread: Annotated[float, Field(ge=0.0, le=3.0, allow_inf_nan=False)]

    size: ClassVar[int] = 9

    @property
    def words(self) -> int:
        """Diagonal of E, then elements 01, 02, 12."""
        return 6

    def draw_about(self, u: Array, J: Array) -> Array:
        """Inertias, shape (n, 3, 3), about a nominal one, shape (3, 3), kg m^2."""
        S = 0.5 * np.trace(J) * np.eye(3) - J
        try:
            L = np.linalg.cholesky(S)
        except np.linalg.LinAlgError:
            raise InputError(
                "the nominal inertia belongs to no body: a principal moment exceeds the others' sum"
            ) from None
        z = self.spread * special.ndtri(np.ascontiguousarray(u))
        E = np.empty((len(u), 3, 3))
        for k, (i, j) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]):
            E[:, i, j] = E[:, j, i] = z[:, k] if i == j else z[:, k] * math.sqrt(0.5)
        values, vectors = np.linalg.eigh(E)
        root = _product(np.broadcast_to(L, E.shape), vectors * np.exp(0.5 * values)[:, None, :])
        moments = _product(root, root.transpose(0, 2, 1))
        trace = moments[:, 0, 0] + moments[:, 1, 1] + moments[:, 2, 2]
        return np.asarray(trace[:, None, None] * np.eye(3) - moments)


def _product(a: Array, b: Array) -> Array:
    """Products of 3 x 3 matrices, in one order of adding for every row."""
    c = np.empty((len(a), 3, 3))
    for i in range(3):
        for j in range(3):
            c[:, i, j] = a[:, i, 0] * b[:, 0, j] + a[:, i, 1] * b[:, 1, j] + a[:, i, 2] * b[:, 2, j]
    return c


_all: tuple[type[Distribution], ...] = (
    Normal,
    TruncNormal,
    LogNormal,
    Uniform,
    LogUniform,
    Exponential,
    Beta,
    Triangular,
    Choice,
    Poisson,
    Quantiles,
    Mixture,
    Attitude,
    Inertia,
)
BY_NAME: dict[str, type[Distribution]] = {str(kind.model_fields["dist"].default): kind for kind in _all}
"""Every distribution by the name that it has in a file."""


def distribution(given: Any) -> Distribution:
    """A distribution of ``{ dist = "normal", mean = 0.0, std = 1.0 }``.

    Raises
    ------
    InputError
        An unknown one, or parameters that make none.
    """
    if isinstance(given, Distribution):
        return given
    if not isinstance(given, Mapping):
        raise InputError(f"{shown(given)} is no distribution: write {{ dist = 'normal', mean = 0.0, std = 1.0 }}")
    name = given.get("dist")
    if not isinstance(name, str):
        raise InputError(f"{shown(dict(given))}: dist is missing{suggestion('', BY_NAME)}")
    if name not in BY_NAME:
        raise InputError(f"no distribution '{name}'{suggestion(name, BY_NAME)}")
    with input_errors(name):
        return BY_NAME[name](**given)


def scalar(given: Any) -> Scalar:
    """A distribution of one number, without `each`."""
    made = distribution(given)
    if not isinstance(made, Scalar) or made.each is not None:
        raise InputError(f"{shown(made.table())}: a distribution of one number belongs here")
    return made


def checked_weights(weights: Sequence[float], count: int, what: str) -> None:
    """Refuse weights that do not fit or do not sum to one."""
    if len(weights) != count:
        raise InputError(f"{len(weights)} weights for {count} in '{what}'; as many belong there")
    if not math.isclose(math.fsum(weights), 1.0, abs_tol=1e-9):
        raise InputError(f"the weights sum to {math.fsum(weights):.12g}; they must sum to 1")


def chosen(shares: Array, u: Array) -> Any:
    """Positions, shape of u: the first whose sum of shares exceeds u. One without a share is never chosen."""
    sums = np.cumsum(shares)
    last = int(np.flatnonzero(shares)[-1])
    return np.minimum(np.searchsorted(sums, u, side="right"), last)


__all__ = ["BY_NAME", "Distribution", "Inverse", "Scalar", "checked_weights", "chosen", "distribution", "scalar"]
