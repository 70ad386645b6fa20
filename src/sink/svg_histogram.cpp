#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "core/text.h"
#include "sink/svg_axes.h"
#include "sink/svg_plots.h"

namespace vildar {
namespace {

constexpr double kWidth = 760.0;
constexpr double kBarsHeight = 190.0;
constexpr double kRowHeight = 9.0;
constexpr std::size_t kMostRows = 40;

struct Spread {
  double speed_kmh, std_kmh, lo95_kmh, hi95_kmh;
  Direction direction;
};

std::vector<Spread> measured(std::span<const VehicleResult> vehicles) {
  std::vector<Spread> found;
  for (const VehicleResult& vehicle : vehicles) {
    const SpeedEstimate& speed = vehicle.speed;
    if (vehicle.withheld || !std::isfinite(speed.speed_mps) || !std::isfinite(speed.std_mps) ||
        !std::isfinite(speed.lo95_mps) || !std::isfinite(speed.hi95_mps))
      continue;
    found.push_back({kmh_from_mps(speed.speed_mps), kmh_from_mps(speed.std_mps),
                     kmh_from_mps(speed.lo95_mps), kmh_from_mps(speed.hi95_mps),
                     vehicle.direction});
  }
  std::sort(found.begin(), found.end(),
            [](const Spread& a, const Spread& b) { return a.speed_kmh < b.speed_kmh; });
  return found;
}

/// Probability that the speed lies below `edge_kmh`.
double below(const Spread& spread, double edge_kmh) {
  if (!(spread.std_kmh > 0.0)) return spread.speed_kmh < edge_kmh ? 1.0 : 0.0;
  return 0.5 * std::erfc((spread.speed_kmh - edge_kmh) / (spread.std_kmh * std::sqrt(2.0)));
}

std::string rectangle(double x, double y, double width, double height, std::string_view css_class) {
  return "<rect class=\"" + std::string(css_class) + "\" x=\"" + svg_number(x) + "\" y=\"" +
         svg_number(y) + "\" width=\"" + svg_number(width) + "\" height=\"" + svg_number(height) +
         "\"/>";
}

std::string_view bar_class(Direction direction) {
  return direction == Direction::oncoming ? "oncoming" : "receding";
}

struct Bars {
  double first_kmh = 0.0, width_kmh = 1.0;
  std::vector<std::array<double, 2>> vehicles;  // [bar][direction]
  double tallest = 0.0;
};

Bars bars_for(const std::vector<Spread>& spreads) {
  double low = spreads.front().lo95_kmh, high = spreads.front().hi95_kmh;
  for (const Spread& spread : spreads) {
    low = std::min(low, spread.lo95_kmh);
    high = std::max(high, spread.hi95_kmh);
  }
  Bars bars;
  // Bars narrower than 1 km/h would show noise; fewer than about nine would hide the shape.
  bars.width_kmh = std::max(1.0, nice_ticks(low, std::max(high, low + 1e-6), 12).step);
  bars.first_kmh = std::max(0.0, (std::floor(low / bars.width_kmh) - 1.0) * bars.width_kmh);
  const double last_kmh = (std::ceil(high / bars.width_kmh) + 1.0) * bars.width_kmh;
  bars.vehicles.resize(
      static_cast<std::size_t>(std::lround((last_kmh - bars.first_kmh) / bars.width_kmh)));
  for (std::size_t i = 0; i < bars.vehicles.size(); ++i) {
    const double from_kmh = bars.first_kmh + static_cast<double>(i) * bars.width_kmh;
    for (const Spread& spread : spreads)
      bars.vehicles[i][static_cast<std::size_t>(spread.direction)] +=
          below(spread, from_kmh + bars.width_kmh) - below(spread, from_kmh);
    bars.tallest = std::max(bars.tallest, bars.vehicles[i][0] + bars.vehicles[i][1]);
  }
  return bars;
}

std::string drawn_bars(const SvgArea& area, const Bars& bars) {
  std::string svg;
  for (std::size_t i = 0; i < bars.vehicles.size(); ++i) {
    const double from_kmh = bars.first_kmh + static_cast<double>(i) * bars.width_kmh;
    const double left = area.x(from_kmh) + 1,
                 width = area.x(from_kmh + bars.width_kmh) - area.x(from_kmh) - 2;
    double foot = 0.0;
    for (const Direction direction : {Direction::oncoming, Direction::receding}) {
      const double count = bars.vehicles[i][static_cast<std::size_t>(direction)];
      if (count < 1e-3) continue;
      svg += rectangle(left, area.y(foot + count), width, area.y(foot) - area.y(foot + count),
                       bar_class(direction));
      foot += count;
    }
  }
  return svg;
}

std::string drawn_rows(const SvgArea& area, const std::vector<Spread>& spreads, double top) {
  std::string svg;
  double y = top + kRowHeight / 2;
  for (const Spread& spread : spreads) {
    const std::string css_class(bar_class(spread.direction));
    svg +=
        svg_line(area.x(spread.lo95_kmh), y, area.x(spread.hi95_kmh), y, "interval " + css_class);
    svg += "<circle class=\"" + css_class + "\" r=\"3\" cx=\"" +
           svg_number(area.x(spread.speed_kmh)) + "\" cy=\"" + svg_number(y) + "\"/>";
    y += kRowHeight;
  }
  return svg;
}

std::string drawn_limit(const SvgArea& area, double limit_kmh, double bottom) {
  if (limit_kmh < area.x_low || limit_kmh > area.x_high) return {};
  return svg_line(area.x(limit_kmh), area.top - 4, area.x(limit_kmh), bottom, "limit") +
         svg_text(area.x(limit_kmh) + 4, area.top + 4, "start", "tick",
                  "limit " + fixed_text(limit_kmh, 0));
}

}  // namespace

std::string svg_speed_histogram(std::span<const VehicleResult> vehicles,
                                std::optional<double> speed_limit_mps) {
  const std::vector<Spread> spreads = measured(vehicles);
  if (spreads.empty()) return {};
  const Bars bars = bars_for(spreads);
  SvgArea area{46.0,
               44.0,
               kWidth - 60.0,
               kBarsHeight,
               bars.first_kmh,
               bars.first_kmh + bars.width_kmh * static_cast<double>(bars.vehicles.size()),
               0.0,
               std::max(1.0, 1.08 * bars.tallest)};
  const bool rows_shown = spreads.size() <= kMostRows;
  const double rows_top = area.top + kBarsHeight + 46.0;
  const double height =
      rows_shown ? rows_top + kRowHeight * static_cast<double>(spreads.size()) + 4.0 : rows_top;
  Ticks counts = nice_ticks(0.0, area.y_high, 4);
  std::erase_if(counts.at, [](double count) { return count != std::floor(count); });
  counts.digits = 0;

  std::string svg = "<svg class=\"histogram\" viewBox=\"0 0 760 " + svg_number(height) +
                    "\" role=\"img\" aria-label=\"Distribution of the measured speeds\">";
  svg +=
      svg_axes(area, nice_ticks(area.x_low, area.x_high, 10), counts, "speed in km/h", "vehicles");
  svg += rectangle(560, 8, 12, 12, "oncoming") + svg_text(577, 18, "start", "tick", "oncoming");
  svg += rectangle(655, 8, 12, 12, "receding") + svg_text(672, 18, "start", "tick", "receding");
  svg += drawn_bars(area, bars);
  if (rows_shown) svg += drawn_rows(area, spreads, rows_top);
  if (speed_limit_mps)
    svg += drawn_limit(area, kmh_from_mps(*speed_limit_mps),
                       rows_shown ? height : area.top + kBarsHeight);
  return svg + "</svg>";
}

std::string svg_interval(const SpeedEstimate& speed, double low_kmh, double high_kmh,
                         bool reported) {
  const SvgArea area{6.0, 0.0, 168.0, 18.0, low_kmh, std::max(high_kmh, low_kmh + 1e-6), 0.0, 1.0};
  const auto held = [&](double value_mps) {
    return area.x(std::clamp(kmh_from_mps(value_mps), area.x_low, area.x_high));
  };
  return "<svg class=\"strip\" viewBox=\"0 0 180 18\" aria-hidden=\"true\">" +
         svg_line(held(speed.lo95_mps), 9, held(speed.hi95_mps), 9, "whisker") +
         "<circle class=\"" + (reported ? "mark" : "other-mark") + "\" r=\"4\" cx=\"" +
         svg_number(held(speed.speed_mps)) + "\" cy=\"9\"/></svg>";
}

}  // namespace vildar
