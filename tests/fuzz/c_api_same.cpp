// SPDX-License-Identifier: MIT
#include "tests/fuzz/c_api_same.hpp"

#include "tests/fuzz/c_api_given.hpp"
#include "tests/support/numbers.hpp"

#include <algorithm>
#include <string>

namespace maxlogdet::fuzz {

using test::same_value;

Options in_cpp(const maxlogdet_options& options) {
  Options made;
  made.budget = options.budget;
  made.prior = options.prior;
  made.time_limit = options.time_limit;
  made.strategy = static_cast<Strategy>(options.strategy);
  made.threads = options.threads;
  made.required = options.required;
  made.excluded = options.excluded;
  made.target.efficiency = options.target_efficiency;
  made.target.translation_sigma = options.target_translation_sigma;
  made.target.rotation_sigma = options.target_rotation_sigma;
  made.groups.ids = options.group_ids;
  made.groups.count = options.group_count;
  made.groups.maximum = options.group_maximum;
  made.groups.maxima = options.group_maxima;
  made.certificate.compute = options.certificate_compute != 0;
  made.certificate.passes = options.certificate_passes;
  made.stochastic.epsilon = options.stochastic_epsilon;
  made.stochastic.seed = options.stochastic_seed;
  made.exchange.sweeps = options.exchange_sweeps;
  return made;
}

void check_same(const maxlogdet_selection* in_c, const Selection& in_cpp) {
  require(in_c != nullptr, "a selection is never null");
  require_error(in_c->error, static_cast<int>(in_cpp.error), "errors are those of C++");
  require(in_c->status == static_cast<int>(in_cpp.status), "statuses are those of C++", in_cpp.reason());
  require(in_c->size == in_cpp.size && in_c->searched == in_cpp.searched, "sizes are those of C++", in_c->size,
          in_cpp.size);
  require(std::equal(in_cpp.begin(), in_cpp.end(), in_c->indices), "indices are those of C++");
  for (std::size_t j = 0; j < in_c->size; ++j) {
    require(same_value(in_c->gains[j], in_cpp.gains[j]), "gains are those of C++", in_c->gains[j], in_cpp.gains[j]);
  }
  require(same_value(in_c->log_det, in_cpp.log_det), "log det is that of C++", in_c->log_det, in_cpp.log_det);
  require(same_value(in_c->upper_bound, in_cpp.upper_bound), "bounds are those of C++", in_c->upper_bound);
  require(same_value(maxlogdet_selection_certified_efficiency(in_c), in_cpp.certified_efficiency()),
          "efficiency is that of C++");
  require(same_value(in_c->efficiency, in_cpp.efficiency) &&
              same_value(in_c->translation_sigma, in_cpp.translation_sigma) &&
              same_value(in_c->rotation_sigma, in_cpp.rotation_sigma),
          "what targets are about is that of C++");
  require(in_c->evaluations == in_cpp.evaluations && in_c->float64_decisions == in_cpp.float64_decisions,
          "the work reported is that of C++", in_c->evaluations, in_cpp.evaluations);
  require(in_c->invalid_candidates == in_cpp.invalid_candidates, "invalid candidates are those of C++");
  require(in_c->strategy == static_cast<int>(in_cpp.strategy), "the strategy reported is that of C++", in_c->strategy);
  require(in_c->threads == in_cpp.threads, "threads are those of C++", in_c->threads);
  require(maxlogdet_selection_reason(in_c) == std::string(in_cpp.reason()), "reasons are those of C++");
  require((maxlogdet_selection_has_answer(in_c) != 0) == in_cpp.has_answer(), "an answer is one in C and C++");
}

void check_same(const maxlogdet_block_report& in_c, const BlockReport& in_cpp) {
  require_error(in_c.error, static_cast<int>(in_cpp.error), "errors of blocks are those of C++");
  require(in_c.appended == in_cpp.appended && in_c.invalid == in_cpp.invalid && in_c.unusable == in_cpp.unusable &&
              in_c.behind_camera == in_cpp.behind_camera && in_c.too_near == in_cpp.too_near &&
              in_c.singular_rays == in_cpp.singular_rays && in_c.invalid_covariances == in_cpp.invalid_covariances &&
              in_c.invalid_jacobians == in_cpp.invalid_jacobians,
          "block reports are those of C++", in_c.appended, in_c.invalid);
}

}  // namespace maxlogdet::fuzz
