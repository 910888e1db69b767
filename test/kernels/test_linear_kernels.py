"""Tiny linear algebra against numpy and scipy."""

import numpy as np
import pytest
from scipy.linalg import null_space

from wholearm_ros.kernels.linear import determinant4, null_vector, solve_in_place

RNG = np.random.default_rng(7)


@pytest.mark.parametrize('n', [1, 2, 4, 5])
def test_elimination_solves_as_numpy_does(n):
    for _ in range(100):
        a, b = RNG.normal(size=(n, n)), RNG.normal(size=(n, 3))
        x = b.copy()
        ratio = solve_in_place(a.copy(), x)
        np.testing.assert_allclose(a @ x, b, atol=1e-12 * np.linalg.cond(a))
        assert 0.0 < ratio <= 1.0


def test_elimination_says_when_a_matrix_is_singular():
    """The pivot ratio is (nearly) nothing where two rows are the same, and where a row is zero."""
    a = RNG.normal(size=(4, 4))
    a[2] = a[0]
    assert solve_in_place(a.copy(), np.ones((4, 1))) < 1e-12
    a[2] = 0.0
    assert solve_in_place(a.copy(), np.ones((4, 1))) == 0.0


def test_elimination_needs_its_pivoting():
    """A zero in the corner is no obstacle."""
    x = np.array([[1.0], [2.0]])
    assert solve_in_place(np.array([[0.0, 1.0], [1.0, 0.0]]), x) == 1.0
    np.testing.assert_array_equal(x, [[2.0], [1.0]])


def test_determinant_is_numpys():
    for _ in range(100):
        a = RNG.normal(size=(4, 4))
        assert determinant4(a) == pytest.approx(np.linalg.det(a), abs=1e-12)


def test_null_vector_spans_the_kernel_and_has_unit_length_in_scaled_coordinates():
    scale = np.array([0.1, 0.1, 1.0, 1.0, 1.0])
    for _ in range(100):
        rows, t = RNG.normal(size=(4, 5)), np.empty(5)
        assert null_vector(rows, scale, t) > 0.0
        assert np.linalg.norm(t / scale) == pytest.approx(1.0, abs=1e-12)
        np.testing.assert_allclose(rows @ t, 0.0, atol=1e-12)
        assert abs((t / scale) @ null_space(rows * scale)[:, 0]) == pytest.approx(1.0, abs=1e-9)


def test_null_vector_of_dependent_rows_is_refused_by_its_norm():
    rows = RNG.normal(size=(4, 5))
    rows[3] = rows[0] - 2.0 * rows[1]
    assert null_vector(rows, np.ones(5), np.empty(5)) < 1e-12
