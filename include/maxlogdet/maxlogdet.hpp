// SPDX-License-Identifier: MIT
#pragma once

/// maxlogdet: selects the k feature matches that keep a camera-pose least-squares problem best conditioned.
///
///   maximise  log det( M0 + sum_{i in S} H_i^T H_i )   over  |S| = k,
///
/// where H_i are the rows that match i adds to the pose Jacobian and M0 is a prior information.
/// Y. Zhao, P. A. Vela: Good Feature Selection for Least Squares Pose Optimization in VO/VSLAM, IROS 2018.

#include <maxlogdet/block_store.hpp>
#include <maxlogdet/camera.hpp>
#include <maxlogdet/good_features.hpp>
#include <maxlogdet/inputs.hpp>
#include <maxlogdet/options.hpp>
#include <maxlogdet/point_covariance.hpp>
#include <maxlogdet/selection.hpp>
#include <maxlogdet/selector.hpp>
#include <maxlogdet/version.hpp>
