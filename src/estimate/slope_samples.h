#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace vildar {

/// Where the power law puts a vehicle at each time, for the samples that it holds for.
struct SlopeSamples {
  std::vector<double> time_s;
  std::vector<double> along_m;  ///< sqrt((P/K)^(-2/gamma) - d^2), as long as time_s
  std::size_t lit = 0;          ///< samples of positive, finite power at a finite time
};

/// For all samples at once with the widest vectors that the processor has. Samples that are not
/// lit, or whose power stands for a distance of less than d or beyond all numbers, are left out. K
/// in W m^gamma and gamma positive, d in m and not negative; spans of the same length.
SlopeSamples slope_samples(std::span<const double> time_s, std::span<const double> power_w,
                           double gain_w, double path_loss_exponent, double perpendicular_m);

}  // namespace vildar
