"""Read-only arrays: how frozen values hold numbers."""

import numpy as np
from numpy.typing import ArrayLike, DTypeLike


def readonly(
    values: ArrayLike, shape: tuple[int, ...] | None = None, dtype: DTypeLike = float
) -> np.ndarray:
    """A read-only copy of `values`; `shape` may hold -1 for a free axis.

    Raises ValueError when the shape does not fit or a number is not finite.
    """
    try:
        array = np.array(values, dtype=dtype)
    except OverflowError as error:  # an integer of 400 digits
        raise ValueError(f'array holds a number that is too large: {error}') from error
    if shape is not None:
        fits = array.ndim == len(shape) and all(
            want in (-1, got) for want, got in zip(shape, array.shape)
        )
        if not fits:
            raise ValueError(f'array of shape {array.shape}; allowed: {shape} (-1 is any length)')
    if array.dtype.kind == 'f' and not np.isfinite(array).all():
        raise ValueError('array holds a number that is not finite')
    array.setflags(write=False)
    return array
