// SPDX-License-Identifier: MIT
#pragma once

#include "tests/support/differences.hpp"
#include "tests/support/support.hpp"

#include <maxlogdet/camera.hpp>

// Camera models a second time, in long double and apart from the library, and random cameras, poses and points.

namespace maxlogdet::test {

using WideVector2 = Eigen::Matrix<long double, 2, 1>;

/// (u, v) of a point that has an image, as the model's paper writes it.
WideVector2 image_of(const Camera& camera, const WideVector3& p);

Camera random_camera(Random& random, CameraModel model);

/// Any of `camera_models`.
CameraModel random_model(Random& random);

WideVector3 random_direction(Random& random);
/// Up to 3 rad and 2 m.
WideIsometry random_isometry(Random& random);

/// Of what the camera sees, up to a right angle to its axis and more where its model can; often close to the axis.
WideVector3 random_point(Random& random, const Camera& camera, bool is_in_front);

}  // namespace maxlogdet::test
