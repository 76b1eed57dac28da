// SPDX-License-Identifier: MIT
#include "tests/fuzz/c_api_frames.hpp"

#include "tests/api/c_api.hpp"
#include "tests/fuzz/c_api_given.hpp"
#include "tests/fuzz/c_api_matches.hpp"
#include "tests/fuzz/c_api_same.hpp"
#include "tests/fuzz/problem.hpp"
#include "tests/support/numbers.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

namespace maxlogdet::fuzz {
namespace {

using test::same_value;

constexpr int refused = MAXLOGDET_ERROR_INVALID_ARGUMENT;
constexpr double T_cb[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0.1};
constexpr double entries[9] = {0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.3};

FeatureMatch in_cpp(const maxlogdet_match& match) {
  FeatureMatch made;
  std::copy(std::begin(match.point), std::end(match.point), made.point);
  std::copy(std::begin(match.measured), std::end(match.measured), made.measured);
  made.u_right = match.u_right;
  made.depth = match.depth;
  made.sigma = match.sigma;
  made.covariance = match.covariance;
  made.jacobian = match.jacobian;
  made.id = match.id;
  made.camera_id = match.camera_id;
  made.is_required = match.is_required != 0;
  made.point_id = match.point_id;
  made.keyframe = match.keyframe;
  return made;
}

maxlogdet_match any_match(Bytes& bytes) {
  auto match = defaults_of(maxlogdet_match_init);
  for (double& coordinate : match.point)
    coordinate = bytes.chance(8) ? bytes.number() : bytes.raw<std::int8_t>() / 16.0;
  for (double& coordinate : match.measured) coordinate = bytes.chance(16) ? bytes.number() : bytes.byte();
  if (bytes.chance(64)) match.u_right = bytes.number();
  if (bytes.chance(16)) match.depth = bytes.number();
  if (bytes.chance(32)) match.sigma = bytes.number();
  if (bytes.chance(32)) match.covariance = entries;
  if (bytes.chance(8)) match.jacobian = entries;
  match.id = bytes.byte();
  match.camera_id = bytes.chance(64) ? bytes.byte() % 3 : 0;
  match.is_required = bytes.chance(16) ? bytes.byte() : 0;
  if (bytes.chance(4)) match.reserved = bytes.byte();
  match.point_id = 5 + match.id;
  match.keyframe = match.id % 7;
  return match;
}

// Finds every point but some, by its number, and spoils the structs of a few.
struct Finder {
  std::size_t step;
  bool spoils;
  int calls = 0;

  template <class Match>
  bool find(std::size_t i, Match& match) {
    ++calls;
    match.measured[0] = static_cast<double>(i);
    match.sigma += 1;
    return i % step != 1;
  }
  bool is_spoilt(std::size_t i) const { return spoils && i % 5 == 2; }
};

std::int32_t find_in_c(void* context, std::size_t i, maxlogdet_match* match) {
  Finder& finder = *static_cast<Finder*>(context);
  const bool is_found = finder.find(i, *match);
  if (finder.is_spoilt(i)) match->struct_size = 7;
  return is_found ? 1 : 0;
}

}  // namespace

Frames::Frames(Bytes& bytes, std::size_t capacity)
    : bytes_(bytes),
      owned_(test::c_good_features(capacity)),
      good_(owned_.get()),
      expected_(capacity),
      capacity_(capacity) {}

void Frames::record(const std::string& in_c, const std::string& in_cpp) {
  require(maxlogdet_good_features_record(good_, in_c.c_str()) == 1 && expected_.record(in_cpp.c_str()),
          "frames are recorded");
}

void Frames::run() {
  set_options();
  start();
  add_matches();
  select();
  check_judgement();
}

void Frames::set_options() {
  expected_.spread = bytes_.chance(64) ? bytes_.number() : 0;
  expected_.is_weighted = bytes_.chance(64);
  require_error(maxlogdet_good_features_set_spread(good_, expected_.spread), MAXLOGDET_ERROR_NONE, "it is set");
  require_error(maxlogdet_good_features_set_weighted(good_, expected_.is_weighted ? 3 : 0), MAXLOGDET_ERROR_NONE,
                "it is set");
  const Given<maxlogdet_block_options> options(bytes_, any_block_options(bytes_),
                                               defaults_of(maxlogdet_block_options_init));
  const bool is_understood = options.is_good() && options.seen().reserved == 0;
  require_error(maxlogdet_good_features_set_block_options(good_, options.get()),
                is_understood ? MAXLOGDET_ERROR_NONE : refused, "they are set, or refused");
  if (is_understood) expected_.block_options = in_cpp(options.seen());
}

void Frames::start() {
  const Given<maxlogdet_camera> camera(bytes_, any_camera(bytes_), defaults_of(maxlogdet_camera_init));
  const std::vector<double> any = any_pose(bytes_);
  const double* const pose = bytes_.chance(8) ? nullptr : any.data();
  const bool is_rig = bytes_.chance(64);
  is_start_understood_ = camera.is_good() && camera.seen().reserved == 0 && pose != nullptr;
  const maxlogdet_camera* const cameras[2] = {camera.get(), camera.get()};
  require_error(is_rig ? maxlogdet_good_features_start_rig(good_, cameras, T_cb, 2, pose)
                       : maxlogdet_good_features_start(good_, camera.get(), pose),
                is_start_understood_ ? MAXLOGDET_ERROR_NONE : refused, "it starts, and says what is refused");
  for (std::size_t c = 0; c < 2; ++c) {
    rig_[c] = RigCamera(in_cpp(camera.seen()), RigidTransform::row_major(T_cb + 12 * c));
  }
  const RigidTransform T = RigidTransform::row_major(pose);
  if (is_rig) {
    expected_.start(is_start_understood_ ? Rig(rig_, 2) : Rig(), T);
  } else {
    expected_.start(is_start_understood_ ? rig_[0].camera : Camera(), T);
  }
  check_answer(maxlogdet_good_features_selection(good_), true);
}

void Frames::add_matches() {
  const std::size_t count = bytes_.below(40);
  for (std::size_t i = 0; i < count; ++i) add(any_match(bytes_));
}

void Frames::add(const maxlogdet_match& match) {
  const Given<maxlogdet_match> given(bytes_, match, defaults_of(maxlogdet_match_init));
  const bool is_understood = given.is_good() && given.seen().reserved == 0;
  FeatureMatch in_cpp_too;
  if (is_understood) {
    in_cpp_too = in_cpp(given.seen());
  } else {
    in_cpp_too.sigma = 0;  // not usable
  }
  expected_.add(in_cpp_too);
  const int none = expected_.size() > capacity_ ? MAXLOGDET_ERROR_CAPACITY_EXCEEDED : MAXLOGDET_ERROR_NONE;
  require_error(maxlogdet_good_features_add(good_, given.get()), is_understood ? none : refused,
                "a match is added, or said why not");
}

void Frames::select() {
  BlockStore of_size;  // for as many flags as there are matches
  for (std::size_t i = 0; i < expected_.size(); ++i) of_size.push_back_invalid();
  const Request request(bytes_, of_size);
  maxlogdet_options whole = test::options_in_c(request.options);
  if (whole.time_limit > 0) whole.time_limit = whole.time_limit < 1e-3 ? 1e-9 : 1e6;
  const Given<maxlogdet_options> given(bytes_, whole, defaults_of(maxlogdet_options_init));
  const bool is_understood = given.is_good() && given.seen().reserved == 0;
  Options options;
  if (is_understood) {
    options = in_cpp(given.seen());
  } else {
    options.strategy = static_cast<Strategy>(99);
  }
  if (bytes_.chance(128)) {
    expected_.select(options);
    check_answer(maxlogdet_good_features_select(good_, given.get()), is_understood);
    return;
  }
  Finder in_c = {2 + bytes_.below(5), bytes_.chance(64)};
  Finder finder = in_c;
  expected_.match(options,
                  [&](std::size_t i, FeatureMatch& match) { return finder.find(i, match) && !finder.is_spoilt(i); });
  check_answer(maxlogdet_good_features_match(good_, given.get(), find_in_c, &in_c), is_understood);
  require(in_c.calls == finder.calls, "as many points are tried as in C++", in_c.calls, finder.calls);
}

void Frames::check_answer(const maxlogdet_selection* selection, bool is_understood) const {
  require(selection == maxlogdet_good_features_selection(good_), "the answer is kept");
  Selection wanted = expected_.selection();
  if (is_understood && is_start_understood_) {
    check_same(selection, wanted);
    require(std::string(maxlogdet_good_features_reason(good_)) == expected_.reason(), "reasons are those of C++");
    return;
  }
  require_error(selection->error, refused, "what is refused is told");
  require(selection->status == MAXLOGDET_STATUS_ERROR && selection->size == wanted.size &&
              std::equal(wanted.begin(), wanted.end(), selection->indices),
          "and all usable matches are selected", selection->size, wanted.size);
}

void Frames::check_judgement() {
  require(same_value(maxlogdet_good_features_efficiency(good_), efficiency(expected_)), "efficiency is that of C++");
  check_same(*maxlogdet_good_features_block_report(good_), expected_.block_report());
  const std::vector<double> pose = any_pose(bytes_);
  const std::uint32_t* outliers = nullptr;
  const std::size_t count = maxlogdet_good_features_outliers(good_, pose.data(), &outliers);
  const IndexRange wanted = expected_.outliers(RigidTransform::row_major(pose.data()));
  require(count == wanted.count && std::equal(wanted.begin(), wanted.end(), outliers), "outliers are those of C++");
  require(maxlogdet_good_features_size(good_) == expected_.size(), "as many matches as in C++");
  for (std::size_t i = 0; i <= expected_.size(); ++i) check_match(i);
}

void Frames::check_match(std::size_t i) const {
  require(maxlogdet_good_features_id(good_, i) == expected_.id(i), "ids are those of C++", i);
  require((maxlogdet_good_features_is_selected(good_, i) != 0) == expected_.is_selected(i), "what is selected", i);
  require((maxlogdet_good_features_is_outlier(good_, i) != 0) == expected_.is_outlier(i), "what is an outlier", i);
  require(same_value(maxlogdet_good_features_chi2(good_, i), expected_.chi2(i)), "chi2 is that of C++", i);
  double in_c[9] = {}, in_cpp[9] = {};
  require((maxlogdet_good_features_information(good_, i, in_c) != 0) == match_information(expected_, i, in_cpp) &&
              std::equal(in_c, in_c + 9, in_cpp, same_value),
          "weights are those of C++", i);
  require((maxlogdet_good_features_whitening(good_, i, in_c) != 0) == match_whitening(expected_, i, in_cpp) &&
              std::equal(in_c, in_c + 9, in_cpp, same_value),
          "and their roots", i);
}

}  // namespace maxlogdet::fuzz
