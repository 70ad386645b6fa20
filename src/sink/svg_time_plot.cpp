#include <algorithm>
#include <cmath>
#include <limits>

#include "sink/svg_axes.h"
#include "sink/svg_plots.h"

namespace vildar {
namespace {

constexpr double kWidth = 300.0;
constexpr double kHeight = 216.0;

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  /// Some air around the data, and a width above zero.
  void widen(double share) {
    const double span = high - low;
    const double rounding = 1e-9 * std::max(std::abs(low), std::abs(high));
    const double air = span > rounding ? share * span : std::max(0.05 * std::abs(low), 1e-3);
    low -= air;
    high += air;
  }
};

std::string curve(const SvgArea& area, const TimePlot& plot) {
  std::string path;
  bool pen_down = false;
  for (std::size_t i = 0; i < plot.t_s.size(); ++i) {
    if (!std::isfinite(plot.t_s[i]) || !std::isfinite(plot.values[i])) {
      pen_down = false;
      continue;
    }
    path += (pen_down ? 'L' : 'M') + svg_number(area.x(plot.t_s[i])) + ' ' +
            svg_number(area.y(plot.values[i]));
    pen_down = true;
  }
  return "<path class=\"curve\" d=\"" + path + "\"/>";
}

std::string drawn_mark(const SvgArea& area, const PlotMark& mark) {
  const double x = area.x(mark.t_s);
  std::string svg;
  if (mark.low && mark.high) {
    const double top = area.y(*mark.high), bottom = area.y(*mark.low);
    svg += svg_line(x, top, x, bottom, "whisker") + svg_line(x - 5, top, x + 5, top, "whisker") +
           svg_line(x - 5, bottom, x + 5, bottom, "whisker");
  }
  return svg + "<circle class=\"mark\" r=\"4\" cx=\"" + svg_number(x) + "\" cy=\"" +
         svg_number(area.y(mark.value)) + "\"/>";
}

std::string legend(const std::optional<PlotMark>& mark) {
  std::string svg = svg_line(46, kHeight - 7, 66, kHeight - 7, "curve") +
                    svg_text(71, kHeight - 3, "start", "tick", "per frame");
  if (mark) {
    svg += "<circle class=\"mark\" r=\"4\" cx=\"142\" cy=\"" + svg_number(kHeight - 7) + "\"/>";
    svg += svg_text(151, kHeight - 3, "start", "tick", mark->low ? "reported, 95 %" : "reported");
  }
  return svg;
}

}  // namespace

std::string svg_time_plot(const TimePlot& plot) {
  if (plot.values.size() != plot.t_s.size()) return {};
  Extent time, value;
  int finite = 0;
  for (std::size_t i = 0; i < plot.t_s.size(); ++i) {
    if (!std::isfinite(plot.t_s[i]) || !std::isfinite(plot.values[i])) continue;
    time.add(plot.t_s[i]);
    value.add(plot.values[i]);
    ++finite;
  }
  if (finite < 2) return {};
  const bool marked = plot.mark && std::isfinite(plot.mark->t_s) && std::isfinite(plot.mark->value);
  if (marked) {
    time.add(plot.mark->t_s);
    for (const double end : {plot.mark->value, plot.mark->low.value_or(plot.mark->value),
                             plot.mark->high.value_or(plot.mark->value)})
      if (std::isfinite(end)) value.add(end);
  }
  if (plot.from_zero) value.add(0.0);
  time.widen(0.02);
  value.widen(0.06);
  if (plot.from_zero && value.low > -0.1 * value.high) value.low = 0.0;

  const SvgArea area{46.0,     26.0,      kWidth - 58.0, kHeight - 84.0,
                     time.low, time.high, value.low,     value.high};
  const std::string label = plot.title + " over time";
  std::string svg = "<svg viewBox=\"0 0 300 216\" role=\"img\" aria-label=\"" + label + "\">";
  svg += svg_axes(area, nice_ticks(time.low, time.high, 5), nice_ticks(value.low, value.high, 5),
                  "time in s", plot.title);
  svg += curve(area, plot);
  if (marked) svg += drawn_mark(area, *plot.mark);
  return svg + legend(marked ? plot.mark : std::nullopt) + "</svg>";
}

}  // namespace vildar
