// SPDX-License-Identifier: MIT
#pragma once

// The guide's lines for Basalt where they belong.

#include <maxlogdet/adapters/basalt.hpp>

#include "tests/api/integration/basalt_stand_in.hpp"

namespace basalt {

/// Simplified: which observations are entered, and how many landmarks count as connected.
template <class Scalar>
void SqrtKeypointVioEstimator<Scalar>::measure(const std::shared_ptr<OpticalFlowResult>& opt_flow_meas) {
#include "basalt_ask.inc"
  for (std::size_t i = 0; i < opt_flow_meas->observations.size(); ++i) {
    const TimeCamId tcid_target{opt_flow_meas->t_ns, i};
    for (const auto& kv_obs : opt_flow_meas->observations[i]) {
      const int kpt_id = static_cast<int>(kv_obs.first);
      if (!lmdb.landmarkExists(kpt_id)) continue;
      KeypointObservation<Scalar> kobs;
      kobs.kpt_id = kpt_id;
      kobs.pos = kv_obs.second.template cast<Scalar>();
#include "basalt_hook.inc"
      if (i == 0) ++connected0;
    }
  }
}

template class SqrtKeypointVioEstimator<double>;
template class SqrtKeypointVioEstimator<float>;

}  // namespace basalt
