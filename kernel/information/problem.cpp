// SPDX-License-Identifier: MIT
#include "kernel/information/problem.hpp"

#include "kernel/blocks/stored_rows.hpp"

#include <algorithm>

namespace maxlogdet {

double add_rows(const Problem& problem, Candidate candidate, InformationFactor& to) noexcept {
  double rows[max_block_rows][state_dimension];
  read_rows(problem.candidates, candidate, rows);
  return to.add_block(*problem.candidates.kernel, rows, problem.candidates.rows);
}

double sum_up(const Problem& problem, const unsigned char* counted, double* sum) noexcept {
  const std::size_t count = problem.candidates.count;
  if (count == 0) {
    std::fill_n(sum, state_dimension * state_dimension, 0.0);
    return 0;
  }
  problem.candidates.exact().sum_information(problem.candidates.planes, counted, count, sum);
  return simd::sum_roundings(count, problem.candidates.rows);
}

}  // namespace maxlogdet
