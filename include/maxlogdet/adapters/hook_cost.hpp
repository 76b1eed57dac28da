// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <memory>

// The time that selection costs a tracker in a frame, and its log. Shared by the adapters.

namespace maxlogdet {

/// One frame's use of an adapter. All times but optimize_us are the hook's own.
struct HookCost {
  const char* status = "none";  ///< GoodFeatures::reason(), or "none" before the first frame
  std::size_t candidates = 0;   ///< how many there were to select from
  std::size_t selected = 0;     ///< how many the tracker continued with
  double gather_us = 0;         ///< reading the tracker's matches, us
  double select_us = 0;         ///< blocks and selection, us
  double optimize_us = 0;       ///< the tracker's own optimisation, where the adapter calls it, us
  double restore_us = 0;        ///< restoring what was not selected, with its outlier flags, us

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

  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::size_t frame_ = 0;
};

/// Measures microseconds since the last lap.
class HookTimer {
 public:
  /// Returns them, and starts the next lap.
  double lap() noexcept {
    const auto now = std::chrono::steady_clock::now();
    const double us = std::chrono::duration<double, std::micro>(now - last_).count();
    last_ = now;
    return us;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace maxlogdet
