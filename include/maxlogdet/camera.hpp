// SPDX-License-Identifier: MIT
#pragma once

#include <maxlogdet/inputs.hpp>

#include <cstddef>

// Cameras: x right, y down, z forward, points p_c = (X, Y, Z) in m, measurements in px. u and v are measured in the
// image as the model has it: distorted, unless the tracker has rectified it.
//
// A camera is valid if fx and fy are positive and finite, and cx, cy and the parameters of its model finite; for a
// stereo row, which pinholes alone have, also bf positive and finite, and shift_of_right finite. Any other is refused
// (Error::invalid_camera).
//
// A point has no image
//   - behind the camera: Z <= 0; of kannala_brandt only the axis behind it;
//   - where distortion folds the image back: radial_tangential where d (m_x, m_y) / d (X / Z, Y / Z), which is
//     symmetric, is not positive definite; kannala_brandt where d or its derivative by theta is not positive. Both test
//     the point alone: far outside the image, beyond a second fold, a polynomial may rise again, and points pass.

namespace maxlogdet {

/// What takes (X, Y, Z) to (m_x, m_y), where u = fx m_x + cx, v = fy m_y + cy.
enum class CameraModel {
  pinhole,            ///< (X / Z, Y / Z)
  radial_tangential,  ///< (x r + 2 p1 x y + p2 (rho + 2 x^2), y r + p1 (rho + 2 y^2) + 2 p2 x y), x = X / Z, y = Y / Z,
                      ///< rho = x^2 + y^2, r = 1 + k1 rho + k2 rho^2 + k3 rho^3: OpenCV's
  kannala_brandt,     ///< (X, Y) d / sqrt(X^2 + Y^2), theta = atan2(sqrt(X^2 + Y^2), Z), d = theta + k1 theta^3 + k2
                      ///< theta^5 + k3 theta^7 + k4 theta^9: OpenCV's fisheye, OpenVINS's equidistant, ORB-SLAM3's and
                      ///< Basalt's KannalaBrandt8
};

/// X(name) for each of them, in their order. Whatever goes by a list of models goes by this one: projections, kernels,
/// names, the Python module and the tests (CONTRIBUTING.md).
#define MAXLOGDET_CAMERA_MODELS(X) X(pinhole) X(radial_tangential) X(kannala_brandt)

#define MAXLOGDET_ENUMERATOR(name) CameraModel::name,
/// The same to loop over.
constexpr CameraModel camera_models[] = {MAXLOGDET_CAMERA_MODELS(MAXLOGDET_ENUMERATOR)};
#undef MAXLOGDET_ENUMERATOR

/// A rectified pinhole camera: u = fx X / Z + cx, v = fy Y / Z + cy.
struct PinholeCamera {
  double fx = 0;              ///< focal length, px
  double fy = 0;              ///< focal length, px
  double cx = 0;              ///< principal point, px
  double cy = 0;              ///< principal point, px
  double bf = 0;              ///< stereo baseline times fx, px m; 0: monocular
  double shift_of_right = 0;  ///< cx of the right image minus cx, px, if rectification left them different

  constexpr PinholeCamera() noexcept = default;
  /// Arguments are in the order of the members.
  constexpr PinholeCamera(double fx_, double fy_, double cx_, double cy_, double bf_ = 0) noexcept
      : fx(fx_), fy(fy_), cx(cx_), cy(cy_), bf(bf_) {}
  /// cx_right: cx of the right image, entry (0, 2) of its projection matrix.
  constexpr PinholeCamera(double fx_, double fy_, double cx_, double cy_, double bf_, double cx_right) noexcept
      : fx(fx_), fy(fy_), cx(cx_), cy(cy_), bf(bf_), shift_of_right(cx_right - cx_) {}
};

/// A camera of any model, alone or on the body of a rig. Of a camera alone the body is the camera, T_cb = I.
struct Camera {
  CameraModel model = CameraModel::pinhole;          ///< model of the parameters
  PinholeCamera pinhole;                             ///< fx, fy, cx, cy; bf of pinholes only
  double parameters[5] = {};                         ///< k1, k2, p1, p2, k3; or k1, k2, k3, k4
  RigidTransform T_cb = RigidTransform::identity();  ///< body to camera

  Camera() = default;
  /// Makes a pinhole.
  Camera(const PinholeCamera& rectified) noexcept : pinhole(rectified) {}  // NOLINT(google-explicit-constructor)
  /// Makes a pinhole from fx, fy, cx, cy and, for stereo rows, bf.
  Camera(double fx, double fy, double cx, double cy, double bf = 0) noexcept : pinhole{fx, fy, cx, cy, bf} {}
  /// The same of a pair whose right image has another cx.
  Camera(double fx, double fy, double cx, double cy, double bf, double cx_right) noexcept
      : pinhole{fx, fy, cx, cy, bf, cx_right} {}

  /// Takes parameters in OpenCV's order; pinhole.bf is ignored.
  static Camera radial_tangential(const PinholeCamera& pinhole, double k1, double k2, double p1, double p2,
                                  double k3 = 0) noexcept;
  /// Takes parameters in the order of OpenCV's fisheye model.
  static Camera kannala_brandt(const PinholeCamera& pinhole, double k1, double k2, double k3, double k4) noexcept;
};

/// Projects p_c, 3 entries, m, to u, v, px, and if `jacobian` is given writes d (u, v) / d p_c to it, 2 x 3 row-major,
/// px per m. Returns false, and writes nothing, for a camera that is not valid, for input that is not finite, and where
/// the model has no image of the point (see above).
bool project(const Camera& camera, const double* p_c, double* uv, double* jacobian = nullptr) noexcept;

/// The number of Camera::parameters that the model has; 0 for any other value.
std::size_t parameter_count(CameraModel model) noexcept;

/// Name of the enumerator; "unknown" for any other value.
const char* to_string(CameraModel model) noexcept;

}  // namespace maxlogdet
