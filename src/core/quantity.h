#pragma once

#include <compare>

namespace vildar {

/// A number that knows its dimension. Only the functions that take several scalars of different
/// dimension need it; inside formulas take `.value()` and carry the unit in the name.
template <class Unit>
class Quantity {
 public:
  constexpr explicit Quantity(double value) : value_(value) {}
  constexpr double value() const { return value_; }
  friend constexpr auto operator<=>(Quantity, Quantity) = default;

 private:
  double value_;
};

using Metres = Quantity<struct MetreUnit>;
using Seconds = Quantity<struct SecondUnit>;
using Radians = Quantity<struct RadianUnit>;
using Watts = Quantity<struct WattUnit>;
using MetresPerSecond = Quantity<struct MetrePerSecondUnit>;

inline constexpr double kPi = 3.14159265358979323846;
constexpr double radians_from_degrees(double angle_deg) { return angle_deg * (kPi / 180.0); }
constexpr double degrees_from_radians(double angle_rad) { return angle_rad * (180.0 / kPi); }
constexpr double kmh_from_mps(double speed_mps) { return speed_mps * 3.6; }

}  // namespace vildar
