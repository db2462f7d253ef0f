"""Errors of the face: with the messages that the command line shows."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from fenics_nnm.errors import NonlinearModeError

Given = ParamSpec("Given")
Found = TypeVar("Found")


def in_words_of_study(function: Callable[Given, Found]) -> Callable[Given, Found]:
    """The function with the keys of the study file in the messages of its errors."""

    @wraps(function)
    def call(*given: Given.args, **named: Given.kwargs) -> Found:
        try:
            return function(*given, **named)
        except NonlinearModeError as error:
            from fenics_nnm.study.error_keys import in_keys

            error.args, error.code = (in_keys(error),), None
            raise

    return call
