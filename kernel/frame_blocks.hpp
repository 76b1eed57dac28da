// SPDX-License-Identifier: MIT
#pragma once

#include "kernel/frame_matches.hpp"

namespace maxlogdet {

/// The blocks of a frame, and what was made of its matches.
struct FrameBlocks {
  FrameBlocks(std::size_t capacity, Executor* helpers) : store(capacity), executor(helpers) {}

  void clear() noexcept {
    store.clear();
    report = BlockReport();
  }

  Error make(FrameMatches& matches, const BlockOptions& options) noexcept {
    store.clear();
    report = matches.append_blocks_to(store, options, executor);
    return report.error;
  }

  BlockStore store;  ///< candidate i is match i
  BlockReport report;
  Executor* executor;
};

}  // namespace maxlogdet
