// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace maxlogdet::sim {

/// Returns P(|x| <= length) for x ~ N(0, C) in three dimensions, from the eigenvalues of C, ascending. With x = r D u,
/// D the square roots of the eigenvalues, u uniform on the sphere and r chi-distributed with three degrees of freedom,
///
///   P = E_u[F(length / |D u|)],   F(r) = erf(r / sqrt 2) - sqrt(2 / pi) r exp(-r^2 / 2),
///
/// by a product rule over an octant, since the signs of u do not matter. Off by at most 0.002 where P is 0.4 or more;
/// by up to 0.04 below, where a single variance counts: medians and higher quantiles need no more.
double probability_within(const Eigen::Vector3d& variances, double length);

/// Returns the length below which a share q of the |x| is expected, x drawn in turn from each of these Gaussians, each
/// ascending; 0 if there is none.
double predicted_quantile(const std::vector<Eigen::Vector3d>& variances, double q);

}  // namespace maxlogdet::sim
