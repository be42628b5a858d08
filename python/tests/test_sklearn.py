"""Conventions of scikit-learn over records."""

from __future__ import annotations

import itertools

import hysteron_models as hy
import numpy as np
import pytest
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, LeaveOneOut, cross_val_score


def _parts(record: hy.Record, count: int) -> list[hy.Record]:
    cut = np.linspace(0, len(record), count + 1).astype(int)
    return [
        hy.Record(record.u[a:b], record.y[a:b], fs=record.fs, name=f"part {k}")
        for k, (a, b) in enumerate(itertools.pairwise(cut))
    ]


def test_estimators_are_cloned_and_searched(loops: hy.Record) -> None:
    stage = hy.Hammerstein("prandtl-ishlinskii", "none", elements=4)
    assert clone(stage).get_params() == stage.get_params()
    assert stage.set_params(elements=6).elements == 6
    with pytest.raises(hy.OptionError, match="no option"):
        stage.set_params(plays=3)
    records = _parts(loops, 3)
    scores = cross_val_score(stage, records, cv=LeaveOneOut(), scoring=hy.scorers.neg_rmse)
    assert scores.shape == (3,) and np.all(scores < 0)
    search = GridSearchCV(stage, {"elements": [2, 6]}, cv=LeaveOneOut(), scoring=hy.scorers.fit_percent)
    search.fit(records)
    assert search.best_params_["elements"] in (2, 6) and search.best_estimator_.model_.kind == "hammerstein"
    assert 0.5 < search.best_estimator_.score(records) <= 1.0
    assert hy.scorers.neg_max_error(search.best_estimator_, records) < 0


#: Reasons why a check of scikit-learn cannot hold.
ARRAYS = "fit takes a list of records, and the check feeds an array"
SPARSE = (
    "sparse matrices are not records: they are refused as any array is, in other words than the check wants"
)
WORDS = "refused, as any array is, in other words than the check wants"

#: Checks of scikit-learn that fail, each with the reason.
KNOWN = {
    "check_complex_data": WORDS,
    "check_dict_unchanged": ARRAYS,
    "check_dont_overwrite_parameters": ARRAYS,
    "check_dtype_object": ARRAYS,
    "check_estimator_sparse_array": SPARSE,
    "check_estimator_sparse_matrix": SPARSE,
    "check_estimator_sparse_tag": SPARSE,
    "check_estimators_dtypes": ARRAYS,
    "check_estimators_empty_data_messages": WORDS,
    "check_estimators_fit_returns_self": ARRAYS,
    "check_estimators_nan_inf": WORDS,
    "check_estimators_overwrite_params": ARRAYS,
    "check_estimators_pickle": ARRAYS,
    "check_f_contiguous_array_estimator": ARRAYS,
    "check_fit2d_1feature": WORDS,
    "check_fit2d_1sample": WORDS,
    "check_fit2d_predict1d": ARRAYS,
    "check_fit_check_is_fitted": ARRAYS,
    "check_fit_idempotent": ARRAYS,
    "check_fit_score_takes_y": ARRAYS,
    "check_methods_sample_order_invariance": ARRAYS,
    "check_methods_subset_invariance": ARRAYS,
    "check_n_features_in": ARRAYS,
    "check_n_features_in_after_fitting": ARRAYS,
    "check_pipeline_consistency": ARRAYS,
    "check_positive_only_tag_during_fit": WORDS,
    "check_readonly_memmap_input": ARRAYS,
    "check_regressor_data_not_an_array": ARRAYS,
    "check_regressors_int": ARRAYS,
    "check_regressors_no_decision_function": ARRAYS,
    "check_regressors_train": ARRAYS,
    "check_supervised_y_2d": ARRAYS,
}


def test_checks_of_scikit_learn_that_fail_are_those_that_feed_arrays() -> None:
    from sklearn.utils.estimator_checks import check_estimator

    class Arrays(hy.Hammerstein):
        """Says that it takes arrays, so that the checks are not skipped."""

        def __sklearn_tags__(self) -> object:
            tags = super().__sklearn_tags__()
            tags.input_tags.two_d_array = True
            return tags

    told = check_estimator(Arrays(), on_fail=None, on_skip=None)
    failed = {check["check_name"]: str(check["exception"]) for check in told if check["status"] == "failed"}
    passed = {check["check_name"] for check in told if check["status"] == "passed"}
    expected = {"check_estimator_cloneable", "check_get_params_invariance", "check_set_params"}
    assert expected <= passed, sorted(passed)
    assert set(failed) == set(KNOWN), (sorted(set(failed) ^ set(KNOWN)), failed)
