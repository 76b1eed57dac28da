// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/good_features.hpp>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <vector>

// Shared by the adapters: selection among what a tracker has in a frame, what it costs, and its log.

namespace maxlogdet {

/// One frame's use of an adapter. All times but optimize_us are the hook's own.
struct HookCost {
  const char* status = "none";  ///< GoodFeatures::reason(), or "none" before the first frame
  std::size_t candidates = 0;   ///< how many there were to select from
  std::size_t selected = 0;     ///< how many the tracker continued with
  double gather_us = 0;         ///< reading the tracker's matches, us
  double select_us = 0;         ///< blocks and selection, us
  double optimize_us = 0;       ///< the tracker's own optimisation, where the adapter calls it, us
  double restore_us = 0;        ///< leaving out and restoring what was not selected, with its outlier flags, us

  /// The time of the hook, us.
  double hook_us() const noexcept { return gather_us + select_us + restore_us; }
};

/// Writes a CSV line per frame, once it is open.
class HookLog {
 public:
  /// Creates the file, with a header. Returns false, without a log, if it cannot be written.
  bool open(const char* path) {
    file_.reset(std::fopen(path, "w"));
    frame_ = 0;
    const char* const header = "frame,status,candidates,selected,gather_ns,select_ns,optimize_ns,restore_ns\n";
    if (file_ && std::fputs(header, file_.get()) < 0) file_.reset();
    return file_ != nullptr;
  }
  /// Writes a line, if the log is open.
  void write(const HookCost& cost) {
    if (!file_) return;
    std::fprintf(file_.get(), "%zu,%s,%zu,%zu,%lld,%lld,%lld,%lld\n", frame_++, cost.status, cost.candidates,
                 cost.selected, ns(cost.gather_us), ns(cost.select_us), ns(cost.optimize_us), ns(cost.restore_us));
  }

 private:
  // Integers, because a locale may have a comma for the decimal point.
  static long long ns(double us) noexcept { return static_cast<long long>(1000 * us); }

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_{nullptr, &std::fclose};
  std::size_t frame_ = 0;
};

/// What all adapters have. Whatever happens in a frame, the tracker can continue: after an error with all that it has,
/// at a deadline with a full budget (GoodFeatures::select); cost().status says which it was.
class TrackerHook {
 public:
  GoodFeatures features;  ///< of the last frame; its block_options may be changed
  Options options;        ///< of the selection: budget, prior, time_limit, ...
  HookLog log;            ///< open() it for a line per frame

  /// The cost of the last frame.
  const HookCost& cost() const noexcept { return cost_; }
  /// From the next frame on, writes each into the folder, for `maxlogdet evaluate FOLDER`. Call it once; see
  /// GoodFeatures::record(). It counts as cost().select_us.
  bool record(const char* folder) noexcept { return features.record(folder); }

 protected:
  /// `budget`: how many to continue with. `capacity`: the maximum of a frame; what is beyond it is not left out.
  TrackerHook(std::size_t budget, std::size_t capacity) : features(capacity), options(budget) {
    left_out_.reserve(capacity);
  }

  /// `gather` starts the features and adds matches. Lists in left_out_, in their order, the ids of those that are not
  /// selected; with `are_blocks_needed` only those that have a block, or do not fit the aligned pose.
  template <class Gather>
  void select(const Gather& gather, bool are_blocks_needed) {
    cost_ = HookCost();
    lap();
    gather();
    cost_.gather_us = lap();
    features.select(options);
    cost_.select_us = lap();
    left_out_.clear();
    const BlockStore& blocks = features.blocks();
    const bool is_aligned = features.alignment().is_aligned();
    for (std::size_t i = 0; i < features.size(); ++i) {
      const std::uint32_t id = features.id(i);
      const bool is_rejected = is_aligned && !features.is_inlier(i);
      const bool may_go = !are_blocks_needed || blocks.is_valid(i) || is_rejected;
      if (id != no_id && may_go && !features.is_selected(i)) left_out_.push_back(id);
    }
    cost_.status = features.reason();
    cost_.candidates = features.size();
    cost_.selected = features.size() - left_out_.size();
  }

  /// Microseconds since the last lap.
  double lap() noexcept {
    const auto now = std::chrono::steady_clock::now();
    const double us = std::chrono::duration<double, std::micro>(now - last_lap_).count();
    last_lap_ = now;
    return us;
  }

  HookCost cost_;                        ///< of the last frame
  std::vector<std::uint32_t> left_out_;  ///< see select()

 private:
  std::chrono::steady_clock::time_point last_lap_;
};

}  // namespace maxlogdet
