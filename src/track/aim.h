#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include "track/pairing.h"
#include "types/site.h"

namespace vildar {

/// Where a camera that stands looks, as the ways of pairs of lamps tell it. As a pair comes nearer,
/// its middle leaves the place in the picture where its way began infinitely far off, in proportion
/// to the distance of its lamps from one another: there the road's direction meets the horizon. On
/// a bend that tells the pitch alone. Ways that disagree tell nothing. Learns only angles that the
/// site knows to worse than 1.5 degrees; tracking goes by them, speeds are told by each vehicle's
/// own fit.
class Aim {
 public:
  explicit Aim(const Site& site);

  /// Looks at the pairs of a frame. The site with its camera as it is known by now, where that is
  /// much better than it was.
  std::optional<Site> learn(const Vehicles& vehicles, std::int64_t frame);

 private:
  // Least squares of the middle on the lamps' distance.
  struct Way {
    double count = 0.0, width_px = 0.0, width2_px2 = 0.0, least_px = 0.0, most_px = 0.0;
    std::int64_t last_frame = 0;
    Eigen::Array2d middle_px = Eigen::Array2d::Zero();  // sums
    Eigen::Array2d by_width_px2 = Eigen::Array2d::Zero();
    Eigen::Array2d square_px2 = Eigen::Array2d::Zero();
  };
  // Where the way began, undistorted pixels from the principal point.
  struct End {
    Eigen::Array2d at_px, sigma_px;
    std::ptrdiff_t ways = 1;
  };
  void see(const Lamp& left, const Lamp& right, std::int64_t frame);
  std::optional<End> end_of(const Way& way) const;
  std::optional<End> common_end() const;
  std::optional<Site> news();

  Site site_;
  CameraSite stated_;
  double focal_px_ = 0.0;
  double drop_per_separation_ = 0.0;
  bool learns_yaw_ = false, learns_pitch_ = false;
  double told_sigma_px_ = 0.0;
  std::map<std::pair<std::uint64_t, std::uint64_t>, Way> ways_;  // by the ids of the lamps
};

}  // namespace vildar
