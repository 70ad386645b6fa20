#pragma once

#include <optional>
#include <vector>

#include "types/power.h"
#include "types/site.h"

namespace vildar {

/// Samples of one channel that a speed may rest on, in the recording's own quantity.
struct CleanSamples {
  std::vector<double> time_s;  ///< strictly increasing
  std::vector<float> values;
  std::map<std::string, std::int64_t> rejected;
  std::vector<ClippedTime> clipped;  ///< as in PowerTraceFacts
  std::optional<StampFall> fall;     ///< the first
};

/// The rules are those of condition().
CleanSamples clean_samples(std::vector<double> time_s, std::vector<float> values,
                           PowerQuantity quantity, const PhotodiodeSite& photodiode);

}  // namespace vildar
