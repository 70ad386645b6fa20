#include "optics/response.h"

#include <algorithm>
#include <cmath>

namespace vildar {
namespace {

double interpolated(const std::vector<double>& table, double fraction) {
  const double last = static_cast<double>(table.size() - 1);
  const double position = std::clamp(fraction * last, 0.0, last);
  const auto below = static_cast<std::size_t>(std::min(position, last - 1.0));
  const double share = position - static_cast<double>(below);
  return (1.0 - share) * table[below] + share * table[below + 1];
}

}  // namespace

Response::Response(const CameraSite& site)
    : kind_(site.response), exponent_(site.response_exponent), table_(site.response_table) {}

double Response::linear_from_fraction(double fraction) const {
  if (!(fraction > 0.0)) return 0.0;
  switch (kind_) {
    case ResponseKind::linear: return fraction;
    case ResponseKind::gamma: return std::pow(fraction, exponent_);
    case ResponseKind::srgb:  // IEC 61966-2-1
      return fraction <= 0.04045 ? fraction / 12.92 : std::pow((fraction + 0.055) / 1.055, 2.4);
    case ResponseKind::bt709:  // ITU-R BT.709-6, inverse of the camera curve
      return fraction < 0.081 ? fraction / 4.5 : std::pow((fraction + 0.099) / 1.099, 1.0 / 0.45);
    case ResponseKind::table: return interpolated(table_, fraction);
  }
  return fraction;
}

double Response::fraction_from_linear(double linear) const {
  if (!(linear > 0.0)) return 0.0;
  switch (kind_) {
    case ResponseKind::linear: return linear;
    case ResponseKind::gamma: return std::pow(linear, 1.0 / exponent_);
    case ResponseKind::srgb:
      return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
    case ResponseKind::bt709:
      return linear < 0.018 ? 4.5 * linear : 1.099 * std::pow(linear, 0.45) - 0.099;
    case ResponseKind::table: {
      const auto above = std::lower_bound(table_.begin(), table_.end(), linear);
      const double last = static_cast<double>(table_.size() - 1);
      if (above == table_.end()) return 1.0;
      if (above == table_.begin()) return 0.0;
      const double high = *above, low = *(above - 1);
      const double index = static_cast<double>(above - table_.begin());
      return (index - (high > low ? (high - linear) / (high - low) : 0.0)) / last;
    }
  }
  return linear;
}

std::vector<float> Response::table_for(const LumaView& luma) const {
  std::vector<float> table(std::size_t{1} << luma.bit_depth);
  const double span = luma.white_code - luma.black_code;
  for (std::size_t code = 0; code < table.size(); ++code)
    table[code] = static_cast<float>(
        linear_from_fraction((static_cast<double>(code) - luma.black_code) / span));
  return table;
}

}  // namespace vildar
