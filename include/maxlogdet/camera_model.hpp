// SPDX-License-Identifier: MIT
#pragma once

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

}  // namespace maxlogdet
