// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/camera.hpp>

#include <cstddef>

namespace maxlogdet {

/// What sees a frame, a camera alone or a rig, and the pose that it is linearised at.
struct FrameCameras {
  FrameCameras(const Camera& camera, const RigidTransform& T_cw) noexcept : only(camera), T(T_cw) {}
  FrameCameras(const Rig& of_frame, const RigidTransform& T_bw) noexcept : rig(of_frame), is_rig(true), T(T_bw) {}

  /// The camera of that number; a camera alone has all numbers. nullptr: the rig has no such camera.
  const RigCamera* find(std::size_t id) const noexcept {
    if (!is_rig) return &only;
    return id < rig.size && rig.cameras != nullptr ? rig.cameras + id : nullptr;
  }

  /// Calls `use` with the camera or the rig.
  template <class Use>
  auto visit(const Use& use) const {
    return is_rig ? use(rig) : use(only.camera);
  }

  RigCamera only;  ///< the single camera, as its own body
  Rig rig;         ///< instead of it, if is_rig
  bool is_rig = false;
  RigidTransform T;  ///< world to camera, on a rig to its body
};

}  // namespace maxlogdet
