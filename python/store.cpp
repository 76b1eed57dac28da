// SPDX-License-Identifier: MIT
#include "python/store.hpp"

#include "python/arrays.hpp"
#include "python/blocks_from_points.hpp"
#include "python/pickling.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::python {
namespace {

Array<double> block_of(const py::handle& object, const char* name) {
  return block_array(object, name, " (n candidates of one row: a[:, None, :] is (n, 1, 6))");
}

void append_array(Store& store, const py::handle& object) {
  const Array<double> blocks = real_array(object, "blocks", {any_n, any_r, state_dimension});
  const py::ssize_t rows = blocks.shape(1);
  if (rows < 1 || rows > max_block_rows) {
    throw py::value_error("blocks: expected shape (n, r, 6) with r in {1, 2, 3}, got " +
                          std::string(py::str(blocks.attr("shape"))));
  }
  BlockStore& to = store.changeable_with_room_for(static_cast<std::size_t>(blocks.shape(0)));
  const double* block = blocks.data();
  for (py::ssize_t i = 0; i < blocks.shape(0); ++i, block += rows * state_dimension) {
    to.push_back(block, static_cast<int>(rows));
  }
}

// Checks all blocks before it appends the first one: a mistake leaves the store unchanged.
void append_list(Store& store, const py::sequence& list) {
  std::vector<Array<double>> blocks;
  blocks.reserve(list.size());
  for (const py::handle& item : list) {
    const std::string name = "blocks[" + std::to_string(blocks.size()) + "]";
    blocks.push_back(item.is_none() ? Array<double>() : block_of(item, name.c_str()));
  }
  BlockStore& to = store.changeable_with_room_for(blocks.size());
  for (const Array<double>& block : blocks) {
    if (block.size() == 0) {
      to.push_back_invalid();
    } else {
      to.push_back(block.data(), static_cast<int>(block.shape(0)));
    }
  }
}

void extend(Store& store, const py::object& blocks) {
  if (py::isinstance<py::list>(blocks) || py::isinstance<py::tuple>(blocks)) {
    append_list(store, py::reinterpret_borrow<py::sequence>(blocks));
  } else {
    append_array(store, blocks);
  }
}

std::size_t append(Store& store, const py::object& object) {
  if (object.is_none()) return store.changeable_with_room_for(1).push_back_invalid();
  const Array<double> block = block_of(object, "block");
  return store.changeable_with_room_for(1).push_back(block.data(), static_cast<int>(block.shape(0)));
}

// The blocks of the valid candidates, (stored, rows, 6).
py::array_t<float> blocks_of(const Store& store) {
  const BlockStore& blocks = store.blocks();
  py::array_t<float> array({static_cast<py::ssize_t>(blocks.stored()), static_cast<py::ssize_t>(blocks.rows()),
                            static_cast<py::ssize_t>(state_dimension)});
  float* to = array.mutable_data();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    double entries[max_block_rows * state_dimension];
    const int rows = blocks.block(i, entries);
    to = std::transform(entries, entries + rows * state_dimension, to, [](double e) { return static_cast<float>(e); });
  }
  return array;
}

py::object planes(const Store& store) { return blocks_of(store).attr("transpose")(1, 2, 0); }

py::array_t<std::uint32_t> indices(const Store& store) {
  const BlockStore& blocks = store.blocks();
  py::array_t<std::uint32_t> array(static_cast<py::ssize_t>(blocks.stored()));
  std::uint32_t* to = array.mutable_data();
  for (std::uint32_t i = 0; i < blocks.size(); ++i) {
    if (blocks.is_valid(i)) *to++ = i;
  }
  return array;
}

py::array_t<bool> validity(const Store& store) {
  const BlockStore& blocks = store.blocks();
  py::array_t<bool> array(static_cast<py::ssize_t>(blocks.size()));
  bool* const to = array.mutable_data();
  for (std::size_t i = 0; i < blocks.size(); ++i) to[i] = blocks.is_valid(i);
  return array;
}

// Whether it is a Python or NumPy integer.
bool is_count(const py::object& object) {
  return PyIndex_Check(object.ptr()) != 0 && !py::isinstance<py::array>(object);
}

std::shared_ptr<Store> make(const py::object& blocks, const py::object& capacity) {
  if (is_count(blocks)) {  // BlockStore(1000) is a capacity, as Selector(1000)
    if (count_from(capacity, "capacity") != 0) {
      throw py::type_error("blocks: expected an array of floats, got the integer " + std::string(py::str(blocks)) +
                           ", and capacity as well");
    }
    return std::make_shared<Store>(count_from(blocks, "capacity"));
  }
  auto store = std::make_shared<Store>(count_from(capacity, "capacity"));
  if (!blocks.is_none()) extend(*store, blocks);
  return store;
}

std::shared_ptr<Store> copy(const Store& store) {
  auto result = std::make_shared<Store>(store.blocks().size());
  result->changeable() = store.blocks();
  return result;
}

// The blocks of the stored candidates, and which candidates these are.
py::tuple state_of(const Store& store) { return py::make_tuple(blocks_of(store), validity(store)); }

std::shared_ptr<Store> unpickled(const py::tuple& state) {
  check_state(state, 2);
  const Array<double> blocks = real_array(state[0], "blocks", {any_n, any_r, state_dimension});
  const auto size = py::len(state[1]);
  const Array<bool> valid = optional_mask(state[1], "valid", size);
  const bool* const flags = valid.data();
  if (std::count(flags, flags + size, true) != blocks.shape(0))
    throw py::value_error("blocks: expected one per true flag");
  auto store = std::make_shared<Store>(size);
  BlockStore& to = store->changeable();
  const double* block = blocks.data();
  for (std::size_t i = 0; i < size; ++i) {
    if (!flags[i]) {
      to.push_back_invalid();
      continue;
    }
    to.push_back(block, static_cast<int>(blocks.shape(1)));
    block += blocks.shape(1) * state_dimension;
  }
  return store;
}

std::string text_of(const Store& store) {
  const BlockStore& blocks = store.blocks();
  return "<maxlogdet.BlockStore: " + std::to_string(blocks.size()) + " candidates, " +
         std::to_string(blocks.invalid_count()) + " invalid, " + std::to_string(blocks.rows()) + " rows>";
}

}  // namespace

BlockStore& Store::changeable() {
  if (leases_ > 0) {
    throw py::buffer_error("the store cannot change while a selection uses it (" + std::to_string(leases_) +
                           " of them): stop them, or change store.copy()");
  }
  return blocks_;
}

BlockStore& Store::changeable_with_room_for(std::size_t count) {
  BlockStore& blocks = changeable();
  const std::size_t needed = blocks.size() + count;
  if (needed > blocks.capacity()) blocks.reserve(std::max(needed, 2 * blocks.capacity()));
  return blocks;
}

Lease::Lease(std::shared_ptr<Store> store) noexcept : store_(std::move(store)) { ++store_->leases_; }

Lease::~Lease() {
  if (store_ != nullptr) --store_->leases_;
}

std::shared_ptr<Store> store_of(const py::handle& blocks) {
  if (py::isinstance<Store>(blocks)) return blocks.cast<Store&>().shared_from_this();
  auto store = std::make_shared<Store>(0);
  extend(*store, py::reinterpret_borrow<py::object>(blocks));
  return store;
}

void bind_store(py::module_& module) {
  py::class_<Store, std::shared_ptr<Store>> store(module, "BlockStore", R"(BlockStore(blocks=None, capacity=0)

Candidate blocks H_i, r x 6 with r in {1, 2, 3}, columns (translation, rotation), rounded to float32. `blocks` is an
(n, r, 6) array of floats, or a list of (r, 6) arrays with any mix of r; shorter blocks are padded with zero rows. A
None in the list, and a block that float32 cannot hold (NaN, infinity, overflow), is kept as an invalid candidate: it
takes an index and is never selected. `capacity` candidates fit without allocating; BlockStore(1000) is empty and has
a capacity of 1000.

While a selection uses the store, changing it raises BufferError.)");
  store.def(py::init(&make), py::arg("blocks") = py::none(), py::arg("capacity") = 0)
      .def("append", &append, py::arg("block"), R"(append(self, block)
--

Appends one candidate, an (r, 6) array, or None for an invalid one; returns its index.)")
      .def("extend", &extend, py::arg("blocks"), R"(extend(self, blocks)
--

Appends candidates, as BlockStore() takes them; none of them if the array or list has an error.)")
      .def(
          "clear", [](Store& self) { self.changeable().clear(); }, R"(clear(self)
--

Removes all candidates; keeps the memory.)")
      .def(
          "reserve",
          [](Store& self, const py::object& capacity) { self.changeable().reserve(count_from(capacity, "capacity")); },
          py::arg("capacity"), R"(reserve(self, capacity)
--

Makes room for `capacity` candidates, and keeps those stored.)")
      .def("copy", &copy, R"(copy(self)
--

Returns an independent store with the same candidates.)")
      .def("__copy__", &copy)
      .def("__deepcopy__", [](const Store& self, const py::object&) { return copy(self); })
      .def(py::pickle(&state_of, &unpickled))
      .def("__len__", [](const Store& self) { return self.blocks().size(); })
      .def("__repr__", &text_of)
      .def_property_readonly(
          "capacity", [](const Store& self) { return self.blocks().capacity(); },
          "The number of candidates that fit without allocating.")
      .def_property_readonly(
          "rows", [](const Store& self) { return self.blocks().rows(); },
          "The maximum number of rows of a block; 0 while none is valid.")
      .def_property_readonly(
          "invalid_count", [](const Store& self) { return self.blocks().invalid_count(); },
          "The number of invalid candidates.")
      .def_property_readonly(
          "stored", [](const Store& self) { return self.blocks().stored(); },
          "The number of candidates with a block: len(store) - invalid_count.")
      .def_property_readonly(
          "planes", &planes,
          "(rows, 6, stored) float32, a copy. Column j is candidate indices[j]: invalid ones have none. "
          "planes.transpose(2, 0, 1) is (stored, rows, 6).")
      .def_property_readonly("indices", &indices,
                             "(stored,) uint32, a copy: which candidates have a block, in ascending order. "
                             "numpy.searchsorted(indices, i) is the column of candidate i.")
      .def_property_readonly("valid", &validity, "(n,) bool, a copy: whether each candidate has a block.");
  bind_append_blocks(store);
}

}  // namespace maxlogdet::python
