#pragma once

#include <optional>
#include <vector>

#include "core/quantity.h"
#include "optics/channel.h"

namespace vildar {

/// The paper's straight-road estimator over a window that slides sample by sample: the work per
/// sample does not depend on the window's length.
class SlidingPowerSlope {
 public:
  /// Throws std::domain_error unless K > 0, gamma > 0, d >= 0, std::invalid_argument unless the
  /// window has three samples or more.
  SlidingPowerSlope(const PowerLaw& law, Metres perpendicular, std::size_t window_samples);

  /// Adds a sample and drops the oldest of a full window. Times must not fall. Samples outside the
  /// model (as in fit_power_slope) keep their place in the window but are not used.
  void push(double time_s, double power_w);

  /// Speed over the window, positive: closing. Nothing before the window is full, or with fewer
  /// than three usable samples or no spread in time.
  std::optional<double> speed_mps() const;

 private:
  struct Entry {
    double time_s = 0.0;
    double range_m = 0.0;
    bool used = false;
  };
  void add(const Entry& entry, double sign);
  void rebase();

  double log_gain_, exponent_, perpendicular2_m2_;
  std::vector<Entry> ring_;
  std::size_t next_ = 0, filled_ = 0, since_rebase_ = 0;
  // Sums over the used entries, times and ranges relative to an origin inside the window.
  double origin_s_ = 0.0, origin_m_ = 0.0;
  double count_ = 0.0, t_ = 0.0, y_ = 0.0, tt_ = 0.0, ty_ = 0.0;
};

}  // namespace vildar
