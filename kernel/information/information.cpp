// SPDX-License-Identifier: MIT
#include "kernel/information/information.hpp"

#include "kernel/blocks/stored_rows.hpp"
#include "kernel/information/information_factor.hpp"

namespace maxlogdet {
namespace {

constexpr int n = state_dimension;

}  // namespace

Information prior_information(const double* prior) noexcept {
  Information result;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double by_default = i == j ? default_prior_information : 0;
      result.entry[i][j] = prior == nullptr ? by_default : prior[n * i + j] / 2 + prior[n * j + i] / 2;
    }
  }
  return result;
}

Information plus_blocks(const Candidates& candidates, const Candidate* list, std::size_t count,
                        Information information) noexcept {
  for (std::size_t k = 0; k < count; ++k) {
    double rows[max_block_rows][state_dimension];
    read_rows(candidates, list[k], rows);
    for (int row = 0; row < candidates.rows; ++row) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) information.entry[i][j] += rows[row][i] * rows[row][j];
      }
    }
  }
  return information;
}

void add_block(const Candidates& candidates, Candidate candidate, double scale, Information& information) noexcept {
  add_scaled(scale, plus_blocks(candidates, &candidate, 1, Information{}), information);
}

Information difference(const Information& a, const Information& b) noexcept {
  Information result;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) result.entry[i][j] = a.entry[i][j] - b.entry[i][j];
  }
  return result;
}

void add_scaled(double scale, const Information& a, Information& sum) noexcept {
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) sum.entry[i][j] += scale * a.entry[i][j];
  }
}

}  // namespace maxlogdet
