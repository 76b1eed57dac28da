// SPDX-License-Identifier: MIT
#include <maxlogdet/good_features.hpp>

#include "kernel/base/deadline.hpp"
#include "kernel/frame_answer.hpp"
#include "kernel/frame_judge.hpp"
#include "kernel/frame_matcher.hpp"
#include "kernel/frame_matches.hpp"
#include "kernel/frame_recording.hpp"
#include "kernel/frame_selector.hpp"

namespace maxlogdet {

struct GoodFeatures::State {
  State(std::size_t max_matches, Executor* executor)
      : capacity(max_matches),
        matches(max_matches, executor),
        answer(max_matches),
        selector(max_matches, executor),
        judge(max_matches) {}

  bool are_all_kept() const noexcept { return matches.added() == matches.size(); }

  std::size_t capacity;
  FrameMatches matches;
  FrameAnswer answer;
  FrameSelector selector;
  std::unique_ptr<FrameMatcher> matcher;  // from the first match() on
  FrameJudge judge;
  FrameRecording recording;
};

GoodFeatures::GoodFeatures(std::size_t capacity, Executor* executor) : state_(new State(capacity, executor)) {}
void GoodFeatures::Destroy::operator()(State* state) const noexcept { delete state; }

void GoodFeatures::start(const Cameras& cameras, const RigidTransform& T_cw) noexcept {
  state_->matches.start({cameras, T_cw});
  state_->answer.start(nullptr);
  state_->judge.start();
  state_->recording.start();
}

void GoodFeatures::add(const FeatureMatch& match) noexcept { state_->matches.add(match); }
std::size_t GoodFeatures::size() const noexcept { return state_->matches.added(); }
std::uint32_t GoodFeatures::id(std::size_t i) const noexcept {
  return i < state_->matches.size() ? state_->matches[i].id : no_id;
}

Selection GoodFeatures::select(const Options& options) noexcept {
  const Deadline time(options.time_limit);
  State& s = *state_;
  const Error error = s.matches.make_blocks(block_options);
  if (error == Error::none) {
    s.selector.select(s.matches, options, spread, time, s.answer);
  } else {
    select_usable(s.matches, error, options.excluded, s.answer);
  }
  s.recording.write(s.matches, s.answer, block_options.depth_sigma);
  return selection();
}

Selection GoodFeatures::match_by(const Options& options, MatchFunction function, void* context) {
  const Deadline time(options.time_limit);
  State& s = *state_;
  if (!s.matcher) s.matcher = std::make_unique<FrameMatcher>(s.capacity);
  s.matcher->match(s.matches, options, block_options, time, {function, context}, s.answer);
  s.recording.write(s.matches, s.answer, block_options.depth_sigma);
  return selection();
}

Selection GoodFeatures::selection() const noexcept { return state_->answer.selection(); }
const char* GoodFeatures::reason() const noexcept {
  const Selection answer = selection();
  return state_->are_all_kept() || !answer.has_answer() ? answer.reason() : to_string(Error::capacity_exceeded);
}
const BlockReport& GoodFeatures::block_report() const noexcept { return state_->matches.report(); }
const BlockStore& GoodFeatures::blocks() const noexcept { return state_->matches.blocks(); }
bool GoodFeatures::is_selected(std::size_t i) const noexcept {
  return i < state_->matches.size() && state_->answer.contains(i);
}
double efficiency(GoodFeatures& good) noexcept {
  GoodFeatures::State& s = *good.state_;
  return s.selector.efficiency(s.matches.blocks(), s.answer);
}

bool match_information(const GoodFeatures& good, std::size_t i, double* omega) noexcept {
  return write_information(good.state_->matches, i, good.block_options, omega);
}
bool match_whitening(const GoodFeatures& good, std::size_t i, double* W) noexcept {
  return write_whitening(good.state_->matches, i, good.block_options, W);
}

IndexRange GoodFeatures::outliers(const RigidTransform& T_cw) noexcept {
  return state_->judge.judge(state_->matches, state_->answer, T_cw, block_options, is_weighted);
}
double GoodFeatures::chi2(std::size_t i) const noexcept { return state_->judge.chi2(i); }
bool GoodFeatures::is_outlier(std::size_t i) const noexcept { return state_->judge.is_outlier(state_->matches, i); }

bool GoodFeatures::record(const char* folder) noexcept { return state_->recording.open(folder); }

}  // namespace maxlogdet
