// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>
#include <maxlogdet/good_features.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/jacobian.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/selection.hpp>

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <vector>

namespace maxlogdet {

/// A Selection that owns its numbers.
struct SelectedMatches {
  Status status = Status::all_selected;  ///< how the selection ended
  Error error = Error::none;             ///< what is wrong; none if status is not error
  std::vector<std::uint32_t> indices;    ///< of the matches, in order of selection; all usable ones after an error
  std::vector<double> gains;             ///< of each, nats; NaN where it is unknown
  double log_det = std::numeric_limits<double>::quiet_NaN();      ///< see Selection
  double upper_bound = std::numeric_limits<double>::quiet_NaN();  ///< see Selection

  /// The name of the error, or if there is none, of the status.
  const char* reason() const noexcept { return status == Status::error ? to_string(error) : to_string(status); }
  /// How many are selected.
  std::size_t size() const noexcept { return indices.size(); }
  /// The first.
  std::vector<std::uint32_t>::const_iterator begin() const noexcept { return indices.begin(); }
  /// One past the last.
  std::vector<std::uint32_t>::const_iterator end() const noexcept { return indices.end(); }
};

/// GoodFeatures in one call, for scripts and tests: `matches` is a container of FeatureMatch, or of points. It
/// allocates: a tracker keeps a GoodFeatures. Throws std::bad_alloc.
template <class Container>
SelectedMatches select(const Cameras& cameras, const RigidTransform& T_cw, const Container& matches,
                       const Options& options = Options(), const BlockOptions& block_options = BlockOptions()) {
  GoodFeatures good(static_cast<std::size_t>(std::distance(std::begin(matches), std::end(matches))));
  good.block_options = block_options;
  good.start(cameras, T_cw);
  for (const auto& match : matches) good.add(match);
  const Selection selection = good.select(options);
  SelectedMatches selected;
  selected.status = selection.status;
  selected.error = selection.error;
  selected.indices.assign(selection.begin(), selection.end());
  selected.gains.assign(selection.gains, selection.gains + selection.size);
  selected.log_det = selection.log_det;
  selected.upper_bound = selection.upper_bound;
  return selected;
}

}  // namespace maxlogdet
