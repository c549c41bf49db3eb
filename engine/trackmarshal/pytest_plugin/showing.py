"""A test that verifies something passes only where what it did can show that: it was called, to its end, and nothing failed beside it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from functools import wraps
from inspect import isawaitable, iscoroutinefunction, isgenerator
from typing import Any
from unittest import TestCase

import pytest

from trackmarshal.pytest_plugin.ids import names_ids


@contextmanager
def _threads_hold(item: pytest.Item) -> Iterator[None]:
    """What fails in a thread meanwhile fails a test that is to verify something: pytest passes it with a warning, which a filter may ignore."""
    if not names_ids(item):
        yield
        return
    before, failed = threading.excepthook, list[str]()

    def noted(args: threading.ExceptHookArgs) -> None:
        # With `sys.exit()` a thread ends as it is to; with a status or a word, it says that something is wrong.
        if not (isinstance(args.exc_value, SystemExit) and args.exc_value.code in (None, 0)):
            failed.append(f"{args.exc_type.__name__}: {args.exc_value}")
        before(args)

    threading.excepthook = noted
    try:
        yield
    finally:
        threading.excepthook = before
    if failed:
        said = f"this test is to verify a requirement, and a thread failed in it: {failed[0]}"
        pytest.fail(said, pytrace=False)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None]:
    with _threads_hold(item):
        return (yield)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None]:
    with _threads_hold(item):
        return (yield)


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, object, object]:
    """A function that returns something has failed: what was to be asserted is handed to pytest, which passes it with a warning. So has one that
    a hook took for itself and did not call, as for a dry run."""
    called, said = pyfuncitem.obj, _Said("nothing called it in this process, so that its body never began")
    if not names_ids(pyfuncitem):
        return (yield)
    pyfuncitem.obj = said.of(called)
    try:
        result = yield
    finally:
        pyfuncitem.obj = called
    said.hold()
    return result


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None]:
    """So has what a thread fails, a method of a `unittest.TestCase` that returns something, and one that is a coroutine of which the class knows nothing:
    its body never began."""
    case = getattr(item, "instance", None)
    with _threads_hold(item):
        # Another `run`, as that of Twisted's trial, makes of what it is given what it likes.
        if not (
            isinstance(case, TestCase)
            and names_ids(item)
            and type(case).run.__module__.startswith("unittest.")
        ):
            return (yield)
        assert isinstance(item, pytest.Function)
        called, said = item.obj, _Said()
        item.obj = said.of(called)
        setattr(case, item.name, item.obj)  # where a method is a coroutine, pytest leaves it to the class
        try:
            yield
        finally:
            item.obj = called
        said.hold()


class _Said:
    """What came of calling the function of a test, noted in passing. uncalled: what is wrong where nothing does."""

    def __init__(self, uncalled: str = "") -> None:
        self._uncalled = uncalled
        self._wrong = ""

    def of(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function as one of its own kind: whoever runs it asks whether it is a coroutine."""
        if iscoroutinefunction(function):
            self._wrong = self._uncalled or (
                "nothing awaited it, so that its body never began: `unittest.IsolatedAsyncioTestCase` does"
            )

            @wraps(function)
            async def awaited(*args: object, **named: object) -> object:
                self._wrong = self._uncalled = ""
                return self._seen(await function(*args, **named))

            return awaited

        @wraps(function)
        def called(*args: object, **named: object) -> object:
            self._uncalled = ""
            return self._seen(function(*args, **named))

        return called

    def _seen(self, returned: object) -> object:
        if returned is not None:
            self._wrong = f"it returned something ({type(returned).__name__})"
            begun = not (isgenerator(returned) or isawaitable(returned))
            self._wrong += ", which asserts nothing: `assert` it" if begun else " whose body never began"
        return returned

    def hold(self) -> None:
        """Fail the test where what it did shows nothing."""
        wrong = self._wrong or self._uncalled
        if wrong:
            pytest.fail(f"this test is to verify a requirement, and {wrong}", pytrace=False)
