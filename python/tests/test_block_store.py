# SPDX-License-Identifier: MIT
"""The store: its contents, views of its memory, and when it may change."""
import gc
import resource
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
    assert not store.indices.flags.writeable
    store.append(np.ones((2, 6)))  # an empty view holds no lease
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


def test_views_are_the_same_memory_every_time(rng):
    store = maxlogdet.BlockStore(rng.normal(size=(50, 2, 6)))
    first, second = store.planes, store.planes
    assert np.shares_memory(first, second)
    assert first.ctypes.data == second.ctypes.data
    assert first.ctypes.data % 64 == 0
    for look in (lambda: store.valid, lambda: store.indices):
        assert not look().flags.owndata and look().ctypes.data == look().ctypes.data
    assert not first.flags.owndata


def test_views_cannot_be_written_to(rng):
    store = maxlogdet.BlockStore(rng.normal(size=(5, 2, 6)))
    for array in (store.planes, store.valid, store.indices, store.planes[0], np.asarray(memoryview(store.planes))):
        with pytest.raises(ValueError):
            array[...] = 0
        with pytest.raises(ValueError):
            array.flags.writeable = True
    for array in (maxlogdet.BlockStore().planes, maxlogdet.BlockStore().valid):
        assert not array.flags.writeable


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
@pytest.mark.parametrize("look", [lambda s: s.planes, lambda s: s.valid, lambda s: s.indices,
                                  lambda s: s.planes[1, 2, ::3], lambda s: memoryview(s.planes)],
                         ids=["planes", "valid", "indices", "slice", "memoryview"])
def test_a_store_cannot_change_while_a_view_exists(rng, change, look):
    store = maxlogdet.BlockStore(rng.normal(size=(20, 2, 6)))
    view = look(store)
    before = np.array(view)
    with pytest.raises(BufferError, match="store.copy"):
        change(store)
    assert len(store) == 20
    assert np.array_equal(np.array(view), before)
    del view
    gc.collect()
    change(store)  # no view exists any more


def test_a_copy_may_change_while_views_of_the_store_exist(rng):
    store = maxlogdet.BlockStore(rng.normal(size=(20, 2, 6)))
    view = store.planes
    other = store.copy()
    assert np.array_equal(other.planes, view) and not np.shares_memory(other.planes, view)
    assert np.array_equal(other.indices, store.indices) and not np.shares_memory(other.indices, store.indices)
    other.append(None)
    assert (len(store), len(other)) == (20, 21)


def test_a_view_keeps_the_memory_alive(rng):
    blocks = rng.normal(size=(1000, 2, 6))
    store = maxlogdet.BlockStore(blocks)
    part = store.planes[1, :, 10:]
    del store
    gc.collect()
    churn = [np.full((1000, 12), np.nan, np.float32) for _ in range(100)]  # would reuse freed memory
    assert np.array_equal(part, blocks.astype(np.float32)[10:, 1, :].T)
    del churn


def test_a_store_is_freed_with_its_last_view():
    def peak():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # MB

    blocks = np.ones((100000, 3, 6), np.float32)
    views = [maxlogdet.BlockStore(blocks).planes]  # 7 MB, and more while it is made
    before = peak()
    for _ in range(100):
        views = [maxlogdet.BlockStore(blocks).planes]
    assert views[0].all()
    assert peak() < before + 100  # not 700


def test_a_store_refuses_to_append_its_own_view(rng):
    store = maxlogdet.BlockStore(rng.normal(size=(10, 2, 6)))
    with pytest.raises(BufferError):
        store.extend(store.planes.transpose(2, 0, 1))
    store.extend(np.array(store.planes.transpose(2, 0, 1)))
    assert len(store) == 20


def test_clear_keeps_the_memory(rng):
    store = maxlogdet.BlockStore(capacity=100)
    assert store.capacity >= 100 and len(store) == 0
    where = []
    for _ in range(3):
        store.clear()
        store.extend(rng.normal(size=(100, 2, 6)))
        where.append(store.planes.ctypes.data)
    assert len(set(where)) == 1


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
