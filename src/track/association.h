#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "track/lamp.h"

namespace vildar {

using Lamps = std::vector<std::unique_ptr<Lamp>>;

/// Movement of the whole image (hand-held camera, bumps) since the prediction. Zero where the lamps
/// do not agree on one.
struct CommonShift {
  Eigen::Vector2d by_px = Eigen::Vector2d::Zero();
  bool of_all = false;  ///< all lamps, three at least, went that way to what is nearest to each;
                        ///< else most of them, four at least
};
CommonShift common_shift(const Lamps& lamps, const std::vector<Spot>& spots, double reach_px);

/// Which spot each lamp is seen as, all lamps together at least total cost.
struct Association {
  std::vector<std::optional<int>> spot_of_lamp;
  std::vector<char> spot_taken;
  /// Lamps for which giving the spots to others would be nearly as good.
  std::vector<char> doubtful;
};
/// What moves in a finer picture spreads over more pixels, and new lights are as much rarer in
/// each. Before a camera that stands no lamp that was hidden comes out behind where it was seen
/// last.
Association associate(const Lamps& lamps, const std::vector<Spot>& spots, double gate_chi2,
                      const RoadView& view);

}  // namespace vildar
