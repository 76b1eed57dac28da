// SPDX-License-Identifier: MIT
// The robust alignment of GoodFeatures: against an oracle in long double, against wrong matches, and wherever it must
// change nothing.
#include "tests/core/feature_frame.hpp"
#include "tests/support/camera_oracle.hpp"
#include "tests/support/request.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace maxlogdet::test {
namespace {

// Of two and of three degrees of freedom.
constexpr long double medians[] = {1.3862943611198906L, 2.3659738843753377L};
constexpr long double hubers[] = {2.25L, 3.4701636117408556L};
constexpr long double tukeys[] = {22.09L, 24.930378113862496L};
constexpr long double gates[] = {9.210340371976184L, 11.344866730144373L};

// The lower one of those that are finite, rounded up to a float of 12 bits.
long double median(const std::vector<long double>& values) {
  std::vector<float> finite;
  for (const long double value : values) {
    if (std::isfinite(value)) finite.push_back(static_cast<float>(static_cast<double>(value)));
  }
  std::sort(finite.begin(), finite.end());
  std::uint32_t bits;
  std::memcpy(&bits, &finite[(finite.size() - 1) / 2], sizeof bits);
  bits |= 0x7FFU;
  float rounded;
  std::memcpy(&rounded, &bits, sizeof bits);
  return static_cast<long double>(rounded);
}

WideMatrix skew(const WideVector3& a) {
  WideMatrix matrix(3, 3);
  matrix << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return matrix;
}

// Cayley's (I - [a/2]x)^-1 (I + [a/2]x).
WideIsometry moved(const WideIsometry& T, const WideVector& xi) {
  const WideMatrix half = skew(xi.tail<3>()) / 2;
  const WideMatrix identity = WideMatrix::Identity(3, 3);
  WideIsometry by = WideIsometry::Identity();
  by.linear() = wide_product(wide_inverse(identity - half), identity + half);
  by.translation() = xi.head<3>();
  return by * T;
}

WideVector logarithm(const WideIsometry& D) {
  WideVector xi(6);
  const auto& R = D.linear();
  xi << D.translation(), (R(2, 1) - R(1, 2)) / 2, (R(0, 2) - R(2, 0)) / 2, (R(1, 0) - R(0, 1)) / 2;
  return xi;
}

// The robust alignment of docs/numerics.md a second time: in long double, one match after the other, by derivatives of
// differences and inverses instead of factors. Aligns the usable matches of a frame from its T_cw.
class AlignmentOracle {
 public:
  AlignmentOracle(const FeatureFrame& frame, const double* prior)
      : pose(frame.T_cw.cast<long double>()),
        frame_(frame),
        prior_(prior),
        start_(pose),
        omega_(frame.matches.size()),
        tells_(frame.matches.size(), true),
        is_inlier_(frame.matches.size()) {
    std::vector<long double> angles;
    for (std::size_t i = 0; i < omega_.size(); ++i) {
      angles.push_back(static_cast<long double>(frame.sigmas[i] / frame.cameras[frame.camera_of_match(i)].pinhole.fx));
    }
    radian_squared_ = 1 / (std::pow(median(angles), 2.0L) * medians[0]);
    whiten();
    for (std::size_t i = 0; i < omega_.size(); ++i)
      leverages_.push_back(has_image(i) && tells_[i] ? leverage(i) : infinity);
    leverage_limit_ = 100 * median(leverages_);
    measure();
    for (int i = 0; i < 10 && step(Weight::huber) >= 3; ++i) {
    }
    for (int i = 0; i < 10 && step(Weight::tukey) >= 2; ++i) {
    }
    whiten();
    measure();
    const std::vector<long double> errors_of_gate = errors;
    for (std::size_t i = 0; i < errors.size(); ++i) is_inlier_[i] = errors[i] <= gate(i);
    const long double scale_of_gate = scale_squared;
    for (int i = 0; i < 10 && step(Weight::inliers) >= 1e-3L; ++i) scale_squared = scale_of_gate;
    errors = errors_of_gate;
    scale_squared = scale_of_gate;
  }

  // Errors up to this are inliers'.
  long double gate(std::size_t i) const {
    const int kind = frame_.has_depth_cue[i];
    return gates[kind] / medians[kind] * scale_squared;
  }

  WideIsometry pose;
  WideMatrix information;
  std::vector<long double> errors;  // of each match at the end of Tukey's weights, over its median; or infinite
  long double scale_squared = 0;

 private:
  enum class Weight { huber, tukey, inliers };

  WideVector residual(std::size_t i, const WideIsometry& T) const {
    return frame_.residuals(i, T).head(frame_.has_depth_cue[i] != 0 ? 3 : 2);
  }

  void whiten() {
    for (std::size_t i = 0; i < omega_.size(); ++i) {
      const Eigen::Index rows = frame_.has_depth_cue[i] != 0 ? 3 : 2;
      WideMatrix noise = WideMatrix::Identity(rows, rows) * std::pow(frame_.sigmas[i], 2);
      if (frame_.kind.depth_cue == DepthCue::depth && rows == 3) noise(2, 2) = std::pow(frame_.options.depth_sigma, 2);
      if (frame_.kind.covariances != FeatureKind::Covariances::none) {
        const WideMatrix J = differentiate(3, [&](const WideVector& by) {
          WideIsometry shifted = pose;
          shifted.translate(WideVector3(by));
          return residual(i, shifted);
        });
        const Eigen::Map<const Eigen::Matrix3d> covariance(&frame_.covariances[9 * i]);
        noise += wide_product(wide_product(J, covariance.cast<long double>()), J.transpose());
        const bool is_stereo = frame_.kind.depth_cue == DepthCue::stereo && rows == 3;
        const long double first = is_stereo ? (noise(0, 0) + noise(2, 2)) / 2 + noise(0, 2) : noise(0, 0);
        tells_[i] = first + noise(1, 1) <= std::pow(frame_.cameras[frame_.camera_of_match(i)].pinhole.fx, 2);
      }
      omega_[i] = wide_inverse(noise);
    }
  }

  void measure() {
    errors.clear();
    for (std::size_t i = 0; i < omega_.size(); ++i) {
      const WideVector e = residual(i, pose);
      errors.push_back(has_image(i) && tells_[i] ? e.dot(omega_[i] * e) / medians[frame_.has_depth_cue[i]] : infinity);
    }
    scale_squared = std::max(median(errors), 1e-12L * radian_squared_);
  }

  bool has_image(std::size_t i) const {
    const Eigen::Vector3d p_c = frame_.in_camera(i, pose).cast<double>();
    double uv[2];
    return project(frame_.cameras[frame_.camera_of_match(i)], p_c.data(), uv);
  }

  // |W J|^2 = tr J^T Omega J by the position.
  long double leverage(std::size_t i) const {
    const WideMatrix J = differentiate(3, [&](const WideVector& by) {
      WideIsometry moved = pose;
      moved.pretranslate(WideVector3(by));
      return residual(i, moved);
    });
    return wide_product(wide_product(J.transpose(), omega_[i]), J).trace();
  }

  long double weight_of(Weight weight, std::size_t i) const {
    if (weight == Weight::inliers) return is_inlier_[i] ? 1 : 0;
    const int kind = frame_.has_depth_cue[i];
    const long double squared = errors[i] * medians[kind] / scale_squared;
    const long double of_leverage = std::min(1.0L, leverage_limit_ / leverages_[i]);
    if (weight == Weight::tukey) return of_leverage * std::pow(std::max(0.0L, 1 - squared / tukeys[kind]), 2.0L);
    if (squared > 400 / 2.25L * hubers[kind]) return 0;
    return of_leverage * std::min(1.0L, std::sqrt(hubers[kind] / squared));
  }

  // Returns the length in standard deviations of the pose.
  long double step(Weight weight) {
    information = WideMatrix::Zero(6, 6);
    WideVector b = WideVector::Zero(6);
    for (std::size_t i = 0; i < omega_.size(); ++i) {
      if (std::isinf(errors[i])) continue;
      const WideMatrix H = -differentiate(6, [&](const WideVector& by) { return residual(i, exp_of_one(by) * pose); });
      const WideMatrix weighted = weight_of(weight, i) / scale_squared * wide_product(H.transpose(), omega_[i]);
      information += wide_product(weighted, H);
      b += weighted * residual(i, pose);
    }
    if (prior_ != nullptr) {
      const auto xi_of = [&](const WideIsometry& T) { return logarithm(T * start_.inverse()); };
      const WideMatrix G =
          differentiate(6, [&](const WideVector& by) -> WideVector { return xi_of(exp_of_one(by) * pose); });
      const Eigen::Map<const Matrix6> M0(prior_);
      const WideMatrix weighted = wide_product(G.transpose(), M0.cast<long double>());
      information += wide_product(weighted, G);
      b -= weighted * xi_of(pose);
    }
    const WideVector x = wide_inverse(information) * b;
    pose = moved(pose, x);
    measure();
    return std::sqrt(x.dot(b));
  }

  const FeatureFrame& frame_;
  const double* prior_;
  WideIsometry start_;
  std::vector<WideMatrix> omega_;
  std::vector<bool> tells_;  // whether a point is known to better than a radian
  std::vector<long double> leverages_;
  long double radian_squared_ = 0, leverage_limit_ = 0;
  std::vector<bool> is_inlier_;
};

// Squared deviation in units of the covariance of the aligned pose: chi-squared with six degrees of freedom.
double squared_error(const GoodFeatures& good, const Isometry& T_true) {
  const Isometry D = pose_of(good) * T_true.inverse();
  const Eigen::AngleAxisd rotation(D.linear());
  Vector6 xi;
  xi << D.translation(), rotation.angle() * rotation.axis();
  return xi.dot(information_of(good) * xi);
}

TEST(Alignment, agrees_with_the_oracle_on_frames_of_all_kinds) {
  GoodFeatures good(120);
  int aligned = 0;
  for_frames_of_all_kinds(trials(120), 120, [&](Random& random, FeatureFrame frame) {
    frame.rejects_outliers = true;
    frame.T_cw = random_isometry(random, 0.1, 0.02) * frame.T_cw;
    const Matrix6 prior = random_prior(random) * std::pow(10, random.uniform(-3, 5));
    const double* const given = random.chance(0.5) ? prior.data() : nullptr;
    frame.gather(good);
    const Alignment found = good.align(given);
    if (!found.is_aligned()) return;
    ++aligned;
    EXPECT_EQ(found.warning, found.scale > 3 ? Warning::large_errors : Warning::none);
    const AlignmentOracle oracle(frame, given);
    for (std::size_t i = 0; i < frame.matches.size(); ++i) {
      const long double gate = oracle.gate(i);
      if (std::abs(oracle.errors[i] - gate) < 1e-6L * gate) continue;
      EXPECT_EQ(good.is_inlier(i), oracle.errors[i] < gate) << i;
    }
    EXPECT_NEAR(found.scale * found.scale, static_cast<double>(oracle.scale_squared), 1e-9 * found.scale * found.scale);
    const Isometry expected(oracle.pose.matrix().cast<double>());
    EXPECT_LT(relative_difference(pose_of(good).matrix(), expected.matrix()), 1e-9);
    EXPECT_LT(relative_difference(information_of(good), oracle.information.cast<double>()), 1e-7);
  });
  EXPECT_GT(aligned, 0);
}

TEST(Alignment, rejects_wrong_matches_and_finds_the_pose_within_its_own_uncertainty) {
  GoodFeatures good(400);
  double deviation = 0, wrong_left = 0, right_lost = 0, wrong = 0, right = 0;
  std::size_t frames = 0;
  for_frames_of_all_kinds(30 + trials(170), 1, [&](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, 400, of_kind.kind, 1, 0.3, 0.05);
    scene.spoil(random, random.uniform(0, 0.3));
    scene.frame.gather(good);
    ASSERT_EQ(good.align().status, AlignmentStatus::aligned);
    // The median of all is a higher quantile of those that are not wrong.
    const auto spoilt = static_cast<double>(std::count(scene.is_wrong.begin(), scene.is_wrong.end(), true));
    const double quantile = -2 * std::log(1 - 0.5 / (1 - spoilt / 400));  // of chi-squared with two degrees of freedom
    EXPECT_NEAR(good.alignment().scale, std::sqrt(quantile / (2 * std::log(2.0))), 0.3);
    EXPECT_LT(squared_error(good, scene.T_true), 60);
    deviation += squared_error(good, scene.T_true);
    ++frames;
    for (std::size_t i = 0; i < 400; ++i) {
      if (!scene.is_in_front(i)) continue;
      (scene.is_wrong[i] ? wrong : right) += 1;
      if (scene.is_wrong[i] && good.is_inlier(i)) ++wrong_left;
      if (!scene.is_wrong[i] && !good.is_inlier(i)) ++right_lost;
    }
  });
  EXPECT_LT(deviation / static_cast<double>(frames), 9) << "6 if all were normal";
  EXPECT_LT(wrong_left, 0.1 * wrong) << "some are within the covariance of a near point";
  EXPECT_LT(right_lost, 0.015 * right);
}

// All that aligned matches give.
std::vector<double> aligned(GoodFeatures& good, const double* prior) {
  std::vector<double> numbers = {static_cast<double>(good.align(prior).status)};
  numbers.insert(numbers.end(), good.pose().data(), good.pose().data() + 12);
  numbers.insert(numbers.end(), good.pose_information(), good.pose_information() + 36);
  for (std::size_t i = 0; i < good.size(); ++i) numbers.push_back(good.is_inlier(i) ? 1 : 0);
  return numbers;
}

TEST(Alignment, has_the_same_bits_on_every_isa_and_with_denormals_flushed) {
  for_frames_of_all_kinds(trials(60), 1, [](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, static_cast<std::size_t>(random.integer(10, 300)), of_kind.kind);
    scene.spoil(random, 0.2);
    const Matrix6 prior = random_prior(random);
    const double* const given = random.chance(0.3) ? prior.data() : nullptr;
    const auto bits = [&] {
      GoodFeatures good(300);
      scene.frame.gather(good);
      return aligned(good, given);
    };
    const std::vector<double> expected = same_on_every_isa(bits);
    const FlushedDenormals flushed;
    EXPECT_EQ(bits(), expected);
  });
}

// Whatever unit the deviations have; a power of two changes no digit.
TEST(Alignment, does_not_depend_on_a_common_factor_of_the_sigmas) {
  TracedRandom random;
  Scene scene(random, 300, FeatureKind());
  scene.spoil(random, 0.15);
  GoodFeatures good(300), scaled(300);
  scene.frame.gather(good);
  ASSERT_TRUE(good.align().is_aligned());
  for (const double factor : {0x1p-20, 0.25, 16.0, 0x1p20}) {
    for (FeatureMatch& match : scene.frame.matches) match.sigma *= factor;
    scene.frame.gather(scaled);
    ASSERT_TRUE(scaled.align().is_aligned()) << factor;
    EXPECT_EQ(pose_of(scaled).matrix(), pose_of(good).matrix());
    EXPECT_EQ(scaled.alignment().inliers, good.alignment().inliers);
    EXPECT_EQ(scaled.alignment().scale, good.alignment().scale / factor);
    for (FeatureMatch& match : scene.frame.matches) match.sigma /= factor;
  }
}

// Of the precision of float64 and of float32.
TEST(Alignment, loses_nothing_of_data_without_noise) {
  for_frames_of_all_kinds(trials(120), 1, [&](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, 200, of_kind.kind, 0);
    const bool is_float = random.chance(0.5);
    for (FeatureMatch& match : scene.frame.matches) {
      for (double& entry : match.measured) entry = is_float ? static_cast<double>(static_cast<float>(entry)) : entry;
    }
    GoodFeatures good(200);
    scene.frame.gather(good);
    ASSERT_TRUE(good.align().is_aligned());
    for (std::size_t i = 0; i < 200; ++i) EXPECT_TRUE(good.is_inlier(i) || !scene.is_in_front(i)) << i;
    EXPECT_LT(relative_difference(pose_of(good).matrix(), scene.T_true.matrix()), 1e-5);
  });
}

// As if it had not been asked for. `why`: or none for any reason.
void expect_no_difference(FeatureFrame frame, AlignmentStatus why) {
  GoodFeatures with(400), without(400);
  frame.gather(with);
  frame.rejects_outliers = false;
  frame.gather(without);
  for (const std::size_t k : {std::size_t{5}, std::size_t{30}, std::size_t{1000}}) {
    Answer answer(with.select(k));
    const Answer expected(without.select(k));
    EXPECT_EQ(answer.reason, with.alignment().measured >= 10 ? "not_aligned" : expected.reason) << k;
    answer.reason = expected.reason;
    EXPECT_EQ(answer, expected) << k;
    EXPECT_FALSE(with.alignment().is_aligned());
    EXPECT_TRUE(why == AlignmentStatus::none || with.alignment().status == why);
  }
  EXPECT_EQ(without.alignment().status, AlignmentStatus::none);
  for (const GoodFeatures* good : {&with, &without}) {
    EXPECT_EQ(pose_of(*good).matrix(), frame.T_cw.matrix());
    EXPECT_EQ(information_of(*good), Matrix6::Zero());
  }
  for (std::size_t i = 0; i < with.size(); ++i) EXPECT_TRUE(with.is_inlier(i)) << i;
}

TEST(Alignment, that_finds_no_pose_changes_nothing) {
  TracedRandom random;
  const Scene few(random, 9);
  expect_no_difference(few.frame, AlignmentStatus::few_matches);

  Scene all_wrong(random, 300);
  for (FeatureMatch& match : all_wrong.frame.matches) {
    match.measured[0] = random.uniform(0, 1200);
    match.measured[1] = random.uniform(0, 400);
  }
  expect_no_difference(all_wrong.frame, AlignmentStatus::none);  // no consensus, or singular far away

  Scene one_point(random, 50);
  for (std::size_t i = 0; i < 50; ++i) {
    std::copy_n(one_point.frame.points.begin(), 3, one_point.frame.matches[i].point);
    std::copy_n(one_point.frame.matches[0].measured, 2, one_point.frame.matches[i].measured);
  }
  expect_no_difference(one_point.frame, AlignmentStatus::singular);

  Scene unmeasured_ones(random, 100);
  for (FeatureMatch& match : unmeasured_ones.frame.matches) match.measured[0] = match.measured[1] = unmeasured;
  expect_no_difference(unmeasured_ones.frame, AlignmentStatus::few_matches);
}

// Of points that are moved along the optical axis.
double median_distance(const std::vector<Eigen::Vector3d>& points, double moved) {
  std::vector<double> distances;
  for (const Eigen::Vector3d& p : points) distances.push_back((p + moved * Eigen::Vector3d::UnitZ()).norm());
  std::sort(distances.begin(), distances.end());
  return distances[distances.size() / 2];
}

// Pixels without noise, of a camera that is turned in its body in any way.
TEST(Alignment, finds_no_consensus_where_points_are_more_than_four_times_as_far_as_predicted) {
  for_each_trial(100, [](Random& random) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 56; ++i)
      points.emplace_back(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(9, 11));
    const double growth = random.chance(0.5) ? random.uniform(3.8, 3.99) : random.uniform(4.01, 4.2);
    double near = 0, far = 100;
    for (int i = 0; i < 60; ++i) {
      const double middle = (near + far) / 2;
      (median_distance(points, middle) < growth * median_distance(points, 0) ? near : far) = middle;
    }
    Camera camera(500, 500, 320, 240);
    const Isometry T_cb = random_isometry(random, 0, 2);
    camera.T_cb = T_cb;
    GoodFeatures good(56);
    good.start(&camera, 1, RigidTransform::identity());
    for (const Eigen::Vector3d& p_c : points) {
      const double z = p_c.z() + near;
      good.add(Eigen::Vector3d(T_cb.inverse() * p_c),
               Eigen::Vector2d(320 + 500 * p_c.x() / z, 240 + 500 * p_c.y() / z));
    }
    EXPECT_EQ(good.align().status, growth < 4 ? AlignmentStatus::aligned : AlignmentStatus::no_consensus) << growth;
  });
}

// A quarter of them is nearly half that is off on one side, with what is so by chance: enough for a doubt alone.
TEST(Alignment, keeps_right_columns_of_which_a_quarter_is_wrong) {
  for_each_trial(10, [](Random& random) {
    FeatureKind kind;
    kind.depth_cue = DepthCue::stereo;
    Scene scene(random, 2000, kind);
    for (FeatureMatch& match : scene.frame.matches) {
      if (match.u_right >= 0 && random.chance(0.25)) match.u_right += 14 * match.sigma;
    }
    GoodFeatures good(2000);
    scene.frame.gather(good);
    EXPECT_EQ(good.align().status, AlignmentStatus::aligned);
    EXPECT_EQ(good.alignment().warning, Warning::none);
  });
}

TEST(Alignment, is_not_spoilt_by_matches_that_are_broken) {
  TracedRandom random;
  Scene scene(random, 200);
  GoodFeatures good(300);
  scene.frame.gather(good);
  ASSERT_TRUE(good.align().is_aligned());
  const Isometry expected = pose_of(good);
  const Eigen::Vector3d centre = scene.frame.T_cw.inverse().translation();
  for (const double offset : {0.0, 1e-300, 1e-40, 1e-9}) {
    for (const double sigma : {1e-300, 1e-49, 1.0, 1e49, 1e300}) {
      scene.frame.gather(good);
      good.add(FeatureMatch(Eigen::Vector3d(centre + Eigen::Vector3d::Constant(offset)), Eigen::Vector2d(1, 2), sigma));
      good.add(FeatureMatch(Eigen::Vector3d(1e200, 1e200, 1e300), Eigen::Vector2d(1e300, 2), sigma));
      good.add(FeatureMatch(Eigen::Vector3d(nan, 0, 0), Eigen::Vector2d(3, nan), sigma));
      ASSERT_EQ(good.align().status, AlignmentStatus::aligned) << offset << ' ' << sigma;
      EXPECT_LT(squared_error(good, expected), 0.5) << "of six expected: the scale differs a little";
    }
  }
}

TEST(Alignment, lets_select_take_inliers_alone_with_blocks_at_the_aligned_pose) {
  GoodFeatures good(300), at_pose(300);
  for_frames_of_all_kinds(trials(60), 1, [&](Random& random, const FeatureFrame& of_kind) {
    Scene scene(random, 300, of_kind.kind);
    scene.spoil(random, 0.3);
    scene.frame.gather(good);
    const Answer answer(good.select(60));
    ASSERT_EQ(answer.status, Status::ok);
    scene.frame.rejects_outliers = false;
    scene.frame.T_cw = pose_of(good);
    for (std::size_t i = 0; i < 300; ++i) {
      if (!good.is_inlier(i)) scene.frame.matches[i].sigma = nan;  // not usable
    }
    scene.frame.gather(at_pose);
    EXPECT_EQ(Answer(at_pose.select(60)).indices, answer.indices);
    EXPECT_EQ(Answer(at_pose.selection()).numbers, answer.numbers);
    for (const std::uint32_t i : answer.indices) EXPECT_TRUE(good.is_inlier(i)) << i;
  });
}

TEST(Alignment, leaves_exactly_the_inliers_where_they_are_fewer_than_the_budget) {
  TracedRandom random;
  Scene scene(random, 100);
  scene.spoil(random, 0.3);
  scene.frame.matches[7].is_required = true;
  scene.frame.matches[7].measured[0] += 500;
  GoodFeatures good(100);
  scene.frame.gather(good);
  const Selection selection = good.select(95);
  EXPECT_STREQ(good.reason(), "few_inliers");
  EXPECT_EQ(selection.size, good.alignment().inliers + 1) << "and the required one";
  EXPECT_TRUE(good.is_selected(7) && !good.is_inlier(7));
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(good.is_selected(i), good.is_inlier(i) || i == 7) << i;
  scene.frame.gather(good);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_TRUE(good.is_inlier(i)) << "of the frame before";
}

// Where nothing is selected, the log says how the frame was aligned.
TEST(Alignment, is_the_reason_of_a_frame_until_something_is_selected) {
  TracedRandom random;
  const Scene scene(random, 100);
  GoodFeatures good(100);
  scene.frame.gather(good);
  EXPECT_STREQ(good.reason(), "all_selected") << "nothing was asked for";
  good.align();
  EXPECT_STREQ(good.reason(), "aligned");
  const char* const of_selection = good.select(50).reason();
  EXPECT_STREQ(good.reason(), of_selection);
  EXPECT_STRNE(of_selection, "aligned");
  good.align();
  EXPECT_STREQ(good.reason(), of_selection) << "it stands";
  scene.frame.gather(good);
  good.block_options.depth_sigma = -1;
  good.align();
  EXPECT_STREQ(good.reason(), "invalid_block_options");
  good.start(Camera(458, 457, 367, 248), RigidTransform::identity());
  good.block_options.depth_sigma = 1;
  good.align();
  EXPECT_STREQ(good.reason(), "few_matches");
  GoodFeatures small(50);
  scene.frame.gather(small);
  EXPECT_TRUE(small.align().is_aligned());
  EXPECT_STREQ(small.reason(), "capacity_exceeded");
}

}  // namespace
}  // namespace maxlogdet::test
