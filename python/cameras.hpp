// SPDX-License-Identifier: MIT
#pragma once

#include "python/bindings.hpp"

#include <maxlogdet/camera.hpp>
#include <maxlogdet/jacobian.hpp>

#include <vector>

namespace maxlogdet::python {

/// The argument `camera`: one camera, or those of a rig, which is a list of (camera, T_cb).
struct OwnCameras {
  std::vector<RigCamera> all;
  bool is_rig;

  Cameras view() const {
    if (is_rig) return Rig(all.data(), all.size());
    return all[0].camera;
  }
};

/// What becomes of a pose of the right shape that cannot be one: an exception, or a transform that the library refuses.
enum class WrongPose { raises, passes };

/// Throws TypeError unless it is one of these.
OwnCameras cameras_of(const py::object& camera, WrongPose wrong = WrongPose::raises);

/// A pose as 3 x 4, or as 4 x 4 with the last row 0, 0, 0, 1: nothing else reveals a transposed one. Throws ValueError,
/// and SelectionError if it is not finite; whether it is a rotation is left to the library.
RigidTransform pose_of(const py::handle& T, const char* name, WrongPose wrong = WrongPose::raises);

}  // namespace maxlogdet::python
