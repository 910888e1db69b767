"""Certificates: the Clopper–Pearson bound against the binomial distribution it comes from."""

import pytest
from scipy.stats import binom

from wholearm_ros.model.certificate import CONFIDENCE, Certificate, certificate, lower_bound


@pytest.mark.parametrize('samples, survived', [(59, 59), (59, 50), (10, 1), (200, 180), (3, 3)])
def test_at_the_bound_as_many_survivors_are_as_unlikely_as_the_confidence_says(samples, survived):
    bound = lower_bound(samples, survived)
    assert binom.sf(survived - 1, samples, bound) == pytest.approx(1.0 - CONFIDENCE, abs=1e-9)
    assert bound < survived / samples


def test_fifty_nine_of_fifty_nine_are_what_it_takes_for_ninety_five_percent():
    assert lower_bound(58, 58) < 0.95 <= lower_bound(59, 59)


def test_the_bound_grows_with_survivors_and_is_zero_without_any():
    bounds = [lower_bound(20, k) for k in range(21)]
    assert bounds[0] == 0.0 == lower_bound(0, 0) and bounds == sorted(bounds)


def test_a_certificate_is_read_back_as_it_was_written():
    made = certificate(1.0, 59, 57)
    assert Certificate(**made.to_dict()) == made and '57 of 59' in str(made)
