# SPDX-License-Identifier: MIT
"""The store: its contents, copies of them, and when it may change."""
import tracemalloc

import numpy as np
import pytest

import maxlogdet


def test_planes_hold_the_blocks_rounded_to_float32(rng):
    blocks = rng.normal(size=(37, 3, 6))
    store = maxlogdet.BlockStore(blocks)
    assert (len(store), store.rows, store.invalid_count) == (37, 3, 0)
    assert store.planes.dtype == np.float32 and store.planes.shape == (3, 6, 37)
    assert np.array_equal(store.planes.transpose(2, 0, 1), blocks.astype(np.float32))


def test_shorter_blocks_are_padded_with_zeros(rng):
    blocks = [rng.normal(size=(r, 6)) for r in (1, 3, 2)]
    store = maxlogdet.BlockStore(blocks)
    planes = store.planes
    for i, block in enumerate(blocks):
        assert np.array_equal(planes[:len(block), :, i], block.astype(np.float32))
        assert not planes[len(block):, :, i].any()


def test_candidates_without_a_block_have_no_column(rng):
    blocks = [rng.normal(size=(2, 6)) if rng.random() < 0.5 else None for _ in range(200)]
    blocks[7] = np.full((3, 6), np.inf)
    store = maxlogdet.BlockStore(blocks)
    expected = [i for i, block in enumerate(blocks) if block is not None and i != 7]
    assert (len(store), store.stored, store.invalid_count) == (200, len(expected), 200 - len(expected))
    assert store.indices.dtype == np.uint32
    assert store.indices.tolist() == expected == np.flatnonzero(store.valid).tolist()
    assert store.planes.shape == (2, 6, store.stored)
    for column, i in enumerate(store.indices):
        assert np.array_equal(store.planes[:, :, column], blocks[i].astype(np.float32))
        assert np.searchsorted(store.indices, i) == column


@pytest.mark.parametrize("blocks", [[], [None] * 20])
def test_without_a_block_there_is_no_column(blocks):
    store = maxlogdet.BlockStore(blocks)
    assert (store.stored, store.rows) == (0, 0)
    assert store.planes.shape == (0, 6, 0) and store.indices.shape == (0,)
    assert store.valid.shape == (len(blocks),) and not store.valid.any()
    store.append(np.ones((2, 6)))
    assert store.indices.tolist() == [len(blocks)]


def test_append_returns_the_index(rng):
    store = maxlogdet.BlockStore(rng.normal(size=(4, 2, 6)))
    assert store.append(rng.normal(size=(3, 6))) == 4
    assert store.append(None) == 5
    assert store.append(np.full((2, 6), np.nan)) == 6
    store.extend(rng.normal(size=(70, 1, 6)))
    store.extend([None, rng.normal(size=(2, 6))])
    store.extend(tuple())
    assert len(store) == 79 and store.invalid_count == 3
    assert np.flatnonzero(~store.valid).tolist() == [5, 6, 77]


def test_a_mistake_in_a_list_leaves_the_store_unchanged(rng):
    store = maxlogdet.BlockStore(rng.normal(size=(4, 2, 6)))
    with pytest.raises(ValueError, match=r"blocks\[1\]"):
        store.extend([rng.normal(size=(2, 6)), rng.normal(size=(4, 6))])
    with pytest.raises(TypeError, match=r"blocks\[0\]"):
        store.extend(["abc"])
    assert len(store) == 4


CHANGES = {
    "append": lambda store: store.append(np.ones((2, 6))),
    "append None": lambda store: store.append(None),
    "extend": lambda store: store.extend(np.ones((3, 2, 6))),
    "extend by nothing": lambda store: store.extend([]),
    "clear": lambda store: store.clear(),
    "reserve": lambda store: store.reserve(10000),
    "append_blocks": lambda store: store.append_blocks(maxlogdet.PinholeCamera(1, 1), np.eye(4), np.ones((3, 3))),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES.keys())
def test_a_store_cannot_change_while_a_selection_uses_it(rng, change):
    store = maxlogdet.BlockStore(rng.normal(size=(20, 2, 6)))
    active = maxlogdet.ActiveSelection(20)
    active.start(store, budget=5)
    before = store.planes
    with pytest.raises(BufferError, match="store.copy"):
        change(store)
    assert np.array_equal(store.planes, before)
    store.copy().append(None)
    active.stop()
    change(store)


def test_arrays_are_copies(rng):
    store = maxlogdet.BlockStore([rng.normal(size=(2, 6)), None])
    for look in (lambda: store.planes, lambda: store.indices, lambda: store.valid):
        array = look()
        before = array.copy()
        array[...] = 1 - array
        assert np.array_equal(look(), before)
    planes, other = store.planes, store.copy()
    store.extend(store.planes.transpose(2, 0, 1))
    assert np.array_equal(store.planes[:, :, 1:], planes) and np.array_equal(other.planes, planes)
    assert (len(store), len(other)) == (3, 2)


def test_clear_keeps_the_memory(rng):
    store = maxlogdet.BlockStore(capacity=100)
    assert store.capacity >= 100 and len(store) == 0
    capacity = store.capacity
    for _ in range(3):
        store.clear()
        store.extend(rng.normal(size=(100, 2, 6)))
        assert store.capacity == capacity


def test_an_array_is_read_in_place(rng):
    n = 100000
    store = maxlogdet.BlockStore(capacity=n)

    def bytes_for(blocks):
        store.clear()
        tracemalloc.start()
        store.extend(blocks)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak

    blocks = rng.normal(size=(n, 2, 6))
    assert bytes_for(blocks) < 10000
    assert bytes_for(blocks.astype(np.float32)) >= blocks.nbytes  # a conversion would show in the line above


def test_one_row_candidates_are_distinguished_from_one_block():
    with pytest.raises(ValueError, match=r"expected shape \(n, r, 6\)"):
        maxlogdet.BlockStore(np.zeros((500, 6)))
    with pytest.raises(ValueError, match=r"a\[:, None, :\]"):
        maxlogdet.BlockStore().append(np.zeros((500, 6)))
    assert len(maxlogdet.BlockStore(np.zeros((500, 6))[:, None, :])) == 500


def test_a_store_accepts_a_capacity_like_a_selector():
    for number in (1000, np.int64(1000), np.uint16(1000)):
        for make in (maxlogdet.BlockStore, maxlogdet.Selector, maxlogdet.ActiveSelection):
            assert make(number).capacity >= 1000
            assert make(capacity=number).capacity >= 1000
        assert len(maxlogdet.BlockStore(number)) == 0
        assert maxlogdet.BlockStore(None, number).capacity >= 1000
    blocks = np.ones((3, 2, 6))
    assert len(maxlogdet.BlockStore(blocks, 1000)) == 3 and maxlogdet.BlockStore(blocks, 1000).capacity >= 1000
    with pytest.raises(TypeError, match="got the integer 5, and capacity as well"):
        maxlogdet.BlockStore(5, capacity=10)
    for make in (maxlogdet.BlockStore, maxlogdet.Selector, maxlogdet.ActiveSelection):
        with pytest.raises(ValueError, match="capacity: expected an integer in "):
            make(-1)
    for wrong in (2.5, np.array(3.5), "1000"):
        with pytest.raises((TypeError, ValueError), match="blocks: expected"):
            maxlogdet.BlockStore(wrong)


def test_repr_describes_the_contents():
    store = maxlogdet.BlockStore([np.ones((3, 6)), None])
    assert repr(store) == "<maxlogdet.BlockStore: 2 candidates, 1 invalid, 3 rows>"
