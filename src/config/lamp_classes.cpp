#include "config/lamp_classes.h"

#include <algorithm>
#include <cmath>

namespace vildar {
namespace {

struct Pool {
  double weight = 0.0, sum = 0.0, square = 0.0;

  void add(double share, const Uncertain& value) {
    weight += share;
    sum += share * value.mean;
    square += share * (value.mean * value.mean + value.std * value.std);
  }
  std::optional<Uncertain> pooled() const {
    if (!(weight > 0.0)) return std::nullopt;
    const double mean = sum / weight;
    return Uncertain{mean, std::sqrt(std::max(0.0, square / weight - mean * mean))};
  }
};

}  // namespace

void pool_classes(LampsSite& lamps) {
  Pool height_m, separation_m;
  for (const LampClass& kind : lamps.classes) {
    height_m.add(kind.share, kind.height_m);
    if (kind.separation_m) separation_m.add(kind.share, *kind.separation_m);
  }
  lamps.height_m = height_m.pooled();
  lamps.separation_m = separation_m.pooled();
}

}  // namespace vildar
