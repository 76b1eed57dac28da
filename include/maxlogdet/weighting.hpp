// SPDX-License-Identifier: MIT
#pragma once

namespace maxlogdet {

/// Which linearised problem a block describes (the equations are in jacobian.hpp). sigma is the standard deviation of
/// the match's measurement. map_bias and map_bias_world do not depend on the camera's model, and always require Z > 0
/// and Z >= min_depth.
enum class Weighting {
  map_bias,  ///< the paper's H_c = H_p^n^-1 H_x^n (section II), H_p with respect to the point in the *camera* frame.
             ///< Monocular: [I - p_c e_3^T / Z] [I | -[p_c]x], whose third row is zero: 2 x 6, m per unit of xi. With a
             ///< depth cue H_p is square: H_c = [I | -[p_c]x], 3 x 6. No sigma.
  map_bias_world,       ///< the same with the point in the *world* frame: H_p^n = [J R; 0 0 1], 3 x 6, as in the paper.
                        ///< Singular where the viewing ray is orthogonal to the world's z axis: see singular_rays.
  measurement,          ///< Q H_x / sigma: measurement noise alone.
  measurement_and_map,  ///< Q C^-1 H_x with C C^T = Sigma_z + H_p Sigma_p H_p^T, Sigma_z = sigma^2 I: both noises
                        ///< whitened.
};

/// What a third row measures, for the matches that have one.
enum class DepthCue {
  none,    ///< all matches are monocular, whatever has_depth_cue says
  stereo,  ///< u_right, px; of pinholes with bf > 0; its standard deviation is
           ///< the match's sigma
  depth,   ///< depth, m; its standard deviation is BlockOptions::depth_sigma
};

}  // namespace maxlogdet
