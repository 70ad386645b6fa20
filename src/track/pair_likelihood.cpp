#include "track/pair_likelihood.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace vildar {
namespace {

struct Term {
  double chi2, log_odds;
};

// A difference that is zero but for `sigma` on one vehicle, and is spread by `wide` as well between
// strangers.
Term difference(double miss, double sigma, double wide) {
  const double stranger = std::hypot(sigma, wide);
  const double chi2 = std::pow(miss / sigma, 2);
  const double log_odds =
      0.5 * std::pow(miss / stranger, 2) - 0.5 * chi2 + std::log(stranger / sigma);
  return {chi2, log_odds};
}

// Two lamps on one rigid body keep their vector but for the looming they share.
Term motion(const Lamp& a, const Lamp& b, const RoadView& view) {
  constexpr double kGive_per_s = 0.06, kRateShare = 0.3;
  // Where the sensor itself moves, bends and steering shift the point that lamps come from.
  const double give_per_s = view.moving_sensor() ? 0.5 : 0.3;
  constexpr double kStranger_pxps = 8.0, kStrangerShare = 0.3;
  const Eigen::Vector2d apart_px = b.at_px() - a.at_px();
  const double length_px = apart_px.norm();
  if (!(length_px > 0.0)) return {0.0, 0.0};
  const Eigen::Vector2d along = apart_px / length_px;
  const Eigen::Vector2d speed_pxps = b.velocity_pxps() - a.velocity_pxps();
  const double rate_per_s = 0.5 * (a.depth_rate_per_s() + b.depth_rate_per_s());
  const double sigma =
      std::hypot(a.velocity_sigma_pxps(), b.velocity_sigma_pxps(), kGive_per_s * length_px);
  const double sideways = (speed_pxps - along * along.dot(speed_pxps)).norm();
  const double rate_sigma = give_per_s + kRateShare * std::abs(rate_per_s);
  const double stretch = along.dot(speed_pxps) + rate_per_s * length_px;
  const double stranger_pxps =
      kStranger_pxps + kStrangerShare * 0.5 * (a.velocity_pxps().norm() + b.velocity_pxps().norm());
  const Term across = difference(sideways, sigma, stranger_pxps);
  const Term out = difference(stretch, std::hypot(sigma, rate_sigma * length_px), stranger_pxps);
  return {across.chi2 + out.chi2, across.log_odds + out.log_odds};
}

}  // namespace

PairLook look_at_pair(const Lamp& a, const Lamp& b, const RoadView& view) {
  constexpr double kSigmaShare = 0.7, kLeastSigma_px = 0.6;
  constexpr double kStrangerLevel_px = 2.0, kStrangerLevelShare = 0.2;
  // Beams, dirt, the angle at which each is seen, and what clipping hides.
  constexpr double kFluxSigmaLn = 0.8, kFluxSigmaClippedLn = 1.2;
  constexpr double kStrangerFluxLn = 2.0, kMostFluxChi2 = 14.0;
  constexpr double kStrangerWidthLn = 3.0;  // e-folds over which a chance separation may fall
  constexpr double kLaneSigma_m = 0.9, kLaneShare = 0.15, kMostLane = 4.0;
  constexpr double kUnknownKind = 2.0;

  PairLook look;
  const double sigma_px = std::hypot(kLeastSigma_px, a.position_sigma_px(), b.position_sigma_px());
  look.fit = view.fit_pair(a.at_px(), b.at_px(), kSigmaShare * sigma_px);
  const double length_px = (b.at_px() - a.at_px()).norm();
  if (!std::isfinite(look.fit.chi2)) {
    look.chi2 = look.fit.chi2;
    look.log_odds = -look.fit.chi2;
    return look;
  }
  const Term level = difference(look.fit.off_level_px, look.fit.level_sigma_px,
                                kStrangerLevel_px + kStrangerLevelShare * length_px);
  look.chi2 = level.chi2 + look.fit.depth_chi2;
  const double density = std::sqrt(2.0 * M_PI) * look.fit.depth_sigma_ln / kStrangerWidthLn;
  look.log_odds = level.log_odds - 0.5 * look.fit.depth_chi2 - std::min(0.0, std::log(density));
  const Term moving = motion(a, b, view);
  look.chi2 += moving.chi2;
  look.log_odds += moving.log_odds;

  const bool clipped =
      a.records.back().sighting.saturated_px > 0 && b.records.back().sighting.saturated_px > 0;
  const Term flux = difference(a.log_flux() - b.log_flux(),
                               clipped ? kFluxSigmaClippedLn : kFluxSigmaLn, kStrangerFluxLn);
  look.chi2 += std::min(kMostFluxChi2, flux.chi2);
  look.log_odds += flux.log_odds;
  double penalty = a.kind() != b.kind() ? kUnknownKind : 0.0;
  const Eigen::Vector2d middle_px = 0.5 * (a.at_px() + b.at_px());
  const double lateral_m = view.road_at(middle_px, look.fit.inverse_depth_per_m).lateral_m;
  if (const auto off_m = view.off_lane_centre_m(lateral_m))
    penalty +=
        std::min(kMostLane, std::pow(*off_m / std::hypot(kLaneSigma_m, kLaneShare * lateral_m), 2));
  look.chi2 += penalty;
  look.log_odds -= 0.5 * penalty;
  return look;
}

bool stands_between(const Lamp& third, const Lamp& a, const Lamp& b) {
  constexpr double kMargin = 0.15, kLevelShare = 0.12, kLevel_px = 2.0, kFainterLn = 1.2;
  if (third.log_flux() < std::min(a.log_flux(), b.log_flux()) - kFainterLn) return false;
  const Eigen::Vector2d apart_px = b.at_px() - a.at_px();
  const double length_px = apart_px.norm();
  const Eigen::Vector2d off_px = third.at_px() - a.at_px();
  const double along = off_px.dot(apart_px) / (length_px * length_px);
  if (along < kMargin || along > 1.0 - kMargin) return false;
  return (off_px - along * apart_px).norm() < kLevel_px + kLevelShare * length_px;
}

}  // namespace vildar
