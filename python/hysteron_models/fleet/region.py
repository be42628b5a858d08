"""The region of a fleet: robust distances of devices from its centre."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from .. import _native
from .._errors import OptionError
from ..record import Array, PathLike
from .registry import Registry, opened
from .rows import parameter_table

LEVEL = 0.99
# Devices for each parameter that a region needs.
DEVICES_A_PARAMETER = 5
# Share of the devices that must have a parameter.
COMMON = 0.9
# Devices of the normal fleets that set the radius.
SIMULATED = 20_000
# Median of |z| of a normal number.
MAD_OF_NORMAL = 0.6744897501960817
# Directions in which the fleet scatters by less than this share of the widest follow from the others.
RANK = 1e-6


def outside(
    registry: Registry | str | PathLike,
    *,
    level: float = LEVEL,
    block: str | None = "hysteresis",
    parameters: Sequence[str] | None = None,
) -> pd.DataFrame:
    """Devices whose parameters left the region that holds the share ``level`` of the fleet.

    Of the latest calibration of each device, with the options that most of them have. A parameter that is of
    one sign over the fleet is taken as its logarithm, since gains and thresholds scatter by factors. Centre
    and scatter are robust: the orthogonalised estimator of R. A. Maronna, R. H. Zamar, *Technometrics* 44
    (2002) 307, doi:10.1198/004017002188618509, with medians and median absolute deviations, two passes, so
    that outliers do not widen the region which they are to be seen against. The squared distance is χ²
    distributed over a normal fleet with as many degrees of freedom as there are parameters; its
    scale is that with which a share 1 − ``level`` of simulated normal fleets of the same size is listed.

    Args:
        registry: URL, path or open registry.
        level: share of the fleet within the region.
        block: block of the model whose parameters count; ``None`` for all.
        parameters: names of the parameters that count, instead of those of a block.

    Returns:
        A row a device outside, furthest first: ``distance``, ``p``, and ``parameters``, those that differ
        most, with their distance in robust standard deviations. ``.attrs`` has ``parameters``, ``devices``,
        ``radius``.

    Raises:
        OptionError: fewer than five devices for each parameter.
    """
    if not 0 < level < 1:
        raise OptionError(f"level: expected a share between 0 and 1, found {level}", code="level")
    wide = _wide(parameter_table(opened(registry), latest=True), block, parameters)
    names, z = _transformed(wide)
    if not names or len(wide) < DEVICES_A_PARAMETER * len(names):
        raise OptionError(
            f"a region of {len(names)} parameters needs {DEVICES_A_PARAMETER * max(1, len(names))} devices "
            f"that have all of them, found {len(wide)}: choose with parameters=…, of {', '.join(wide.columns)}",
            code="region",
        )
    squared, rank = robust_distances(z)
    squared = squared / _widening(len(wide), rank, level)
    p = np.array([_native.chi_square_tail(float(d), rank) for d in squared])
    scores = (z - np.median(z, axis=0)) / _scale(z)
    table = pd.DataFrame(
        {
            "device": wide.index,
            "distance": np.sqrt(squared),
            "p": p,
            "parameters": [_furthest(names, row) for row in scores],
        }
    )
    found = table[table["p"] < 1.0 - level].sort_values("distance", ascending=False, kind="stable")
    radius = float(np.sqrt(_native.chi_square_quantile(level, rank)))
    found = found.reset_index(drop=True)
    found.attrs = {"parameters": names, "devices": len(wide), "radius": radius, "level": level}
    return found


def _widening(devices: int, rank: int, level: float) -> float:
    """Quantile of the squared distances in normal fleets of this size over that of χ², by simulation: centre
    and scatter of few devices are uncertain, and more of them would lie outside."""
    fleets = max(10, SIMULATED // devices)
    rng = np.random.default_rng(0)
    distances = [robust_distances(rng.normal(size=(devices, rank)))[0] for _ in range(fleets)]
    quantile = float(np.quantile(np.concatenate(distances), level))
    return max(1.0, quantile / _native.chi_square_quantile(level, rank))


def _wide(table: pd.DataFrame, block: str | None, names: Sequence[str] | None) -> pd.DataFrame:
    """A row a device, a column a parameter; devices that have all parameters which nearly all have."""
    if table.empty:
        return pd.DataFrame()
    table = table[table["options"] == table.groupby("options")["device"].nunique().idxmax()]
    if names is not None:
        unknown = [name for name in names if name not in set(table["name"])]
        if unknown:
            raise OptionError(f"parameters: the fleet has no {', '.join(unknown)}", code="parameters")
        table = table[table["name"].isin(list(names))]
    elif block is not None:
        table = table[table["block"] == block]
    # Numbers that the record does not determine have no standard error.
    table = table[table["value"].notna() & table["std_error"].notna()]
    wide = table.pivot_table(index="device", columns="name", values="value", aggfunc="first", sort=False)
    wide = wide.loc[:, wide.notna().mean() >= COMMON]
    return wide.dropna()


def _transformed(wide: pd.DataFrame) -> tuple[list[str], Array]:
    """Parameters that scatter, as logarithms where they are of one sign."""
    names, columns = [], []
    for name in wide.columns:
        values = wide[name].to_numpy(dtype=float)
        one_sign = bool((values > 0).all() or (values < 0).all())
        column = np.log(np.abs(values)) if one_sign else values
        if len(column) and _scale(column[:, None])[0] > 0:
            names.append(str(name))
            columns.append(column)
    return names, np.column_stack(columns) if columns else np.empty((len(wide), 0))


def _scale(z: Array) -> Array:
    """Median absolute deviation of each column, in standard deviations of a normal fleet."""
    scale: Array = np.median(np.abs(z - np.median(z, axis=0)), axis=0) / MAD_OF_NORMAL
    return scale


def robust_distances(z: Array) -> tuple[Array, int]:
    """Squared distance of each row from the robust centre of all, and its degrees of freedom."""
    rows = _independent(z / _scale(z))
    for _ in range(2):
        rows = _orthogonalised(rows)
    rank = rows.shape[1]
    squared = np.square((rows - np.median(rows, axis=0)) / _scale(rows)).sum(axis=1)
    # One step of reweighting: mean and covariance of the nine tenths that are nearest.
    near = squared <= _native.chi_square_quantile(0.9, rank) * _median_ratio(squared, rank)
    centre = rows[near].mean(axis=0)
    scatter = np.atleast_2d(np.cov(rows[near], rowvar=False))
    from_centre = rows - centre
    squared = np.einsum("ij,ij->i", from_centre, np.linalg.solve(scatter, from_centre.T).T)
    return squared / _median_ratio(squared, rank), rank


def _independent(z: Array) -> Array:
    """``z`` without directions in which no row differs from another."""
    _, scale, directions = np.linalg.svd(z - z.mean(axis=0), full_matrices=False)
    kept = scale > RANK * scale[0]
    independent: Array = z if kept.all() else z @ directions[kept].T
    return independent


def _median_ratio(squared: Array, rank: int) -> float:
    return float(np.median(squared)) / _native.chi_square_quantile(0.5, rank)


def _orthogonalised(z: Array) -> Array:
    """Coordinates along the eigenvectors of the pairwise robust correlation (Gnanadesikan, Kettenring)."""
    scale = _scale(z)
    y = z / scale
    count = y.shape[1]
    correlation = np.eye(count)
    for j in range(count):
        for k in range(j):
            both = np.column_stack([y[:, j] + y[:, k], y[:, j] - y[:, k]])
            plus, minus = np.square(_scale(both))
            correlation[j, k] = correlation[k, j] = (plus - minus) / 4
    directions = np.linalg.eigh(correlation)[1]
    rotated: Array = y @ directions
    return rotated


def _furthest(names: list[str], scores: Array) -> str:
    order = np.argsort(-np.abs(scores), kind="stable")[:3]
    return ", ".join(f"{names[k]} {scores[k]:+.1f}" for k in order)
