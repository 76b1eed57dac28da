# SPDX-License-Identifier: MIT
"""Objects whose __init__ never ran: whatever uses them raises an error."""
import copy
import pickle

import numpy as np
import pytest

import maxlogdet

CLASSES = [it for it in vars(maxlogdet).values() if isinstance(it, type) and not issubclass(it, Exception)]
EXEMPT = {"__new__", "__init__", "__setstate__", "__enter__", "__iter__"}  # they make an object, or return it
CAMERA = maxlogdet.PinholeCamera(458, 457)
ARGUMENTS = {
    "__deepcopy__": [{}], "__exit__": [None, None, None], "append": [None], "extend": [[]], "reserve": [1],
    "next_batch": [1], "answer": [[True]], "project": [np.ones((1, 3))], "start": [[]], "select": [[]],
    "append_blocks": [CAMERA, np.eye(4), np.ones((1, 3))], "add": [np.ones((1, 3))], "match": [bool],
    "outliers": [np.eye(4)], "record": [""],
}
ARGUMENTS_OF = {maxlogdet.GoodFeatures: {"start": [CAMERA, np.eye(4)], "select": []}}


def raw(kind):
    return kind.__new__(kind)


def derived(kind):
    class Derived(kind):
        def __init__(self):
            pass

    return Derived


@pytest.mark.parametrize("kind", CLASSES)
def test_every_member_refuses(kind):
    refused = pytest.raises(TypeError, match="the object is not initialised")
    arguments = {**ARGUMENTS, **ARGUMENTS_OF.get(kind, {})}
    for it in (raw(kind), raw(derived(kind))):
        for name, member in vars(kind).items():
            if isinstance(member, property):
                with refused:
                    getattr(it, name)
            elif callable(member) and not isinstance(member, staticmethod) and name not in EXEMPT:
                with refused:
                    member(it, *arguments.get(name, []))


@pytest.mark.parametrize("use", [
    lambda: maxlogdet.select_blocks(raw(maxlogdet.BlockStore), 1),
    lambda: maxlogdet.Selector(3).select(raw(maxlogdet.BlockStore)),
    lambda: maxlogdet.ActiveSelection(3).start(raw(maxlogdet.BlockStore)),
    lambda: maxlogdet.select(raw(maxlogdet.PinholeCamera), np.eye(4), np.ones((1, 3))),
    lambda: maxlogdet.GoodFeatures(3).start(raw(maxlogdet.Camera), np.eye(4)),
    lambda: next(raw(maxlogdet.ActiveSelection)),
    lambda: list(raw(maxlogdet.Selection)),
    lambda: maxlogdet.Camera(raw(maxlogdet.PinholeCamera)),
    lambda: maxlogdet.match_information(raw(maxlogdet.Camera), np.eye(4), np.ones((1, 3))),
    lambda: maxlogdet.match_whitening([(raw(maxlogdet.PinholeCamera), np.eye(4))], np.eye(4), np.ones((1, 3))),
])
def test_every_function_refuses(use):
    with pytest.raises(TypeError, match="the object is not initialised"):
        use()


@pytest.mark.parametrize("kind", CLASSES)
def test_what_cannot_be_read_is_neither_copied_nor_pickled(kind):
    ways = [copy.copy, copy.deepcopy] + [lambda it, p=protocol: pickle.dumps(it, p) for protocol in range(6)]
    for way in ways + [lambda it: it.__reduce__()]:
        for it in (raw(kind), raw(derived(kind))):
            with pytest.raises(TypeError):
                way(it)


@pytest.mark.parametrize("kind", CLASSES)
def test_a_subclass_calls_init(kind):
    with pytest.raises(TypeError, match="__init__|No constructor"):
        derived(kind)()


def test_an_object_whose_init_failed_can_be_initialised():
    selector = raw(maxlogdet.Selector)
    with pytest.raises(ValueError):
        selector.__init__(-1)
    with pytest.raises(TypeError, match="the object is not initialised"):
        selector.capacity
    selector.__init__(4)
    assert selector.capacity == 4
