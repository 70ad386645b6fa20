#include "sink/svg_axes.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "sink/html.h"

namespace vildar {

Ticks nice_ticks(double low, double high, int wanted) {
  const double rough = (high - low) / std::max(1, wanted);
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  const double fraction = rough / decade;
  Ticks ticks;
  ticks.step = decade * (fraction < 1.5 ? 1.0 : fraction < 3.5 ? 2.0 : fraction < 7.5 ? 5.0 : 10.0);
  ticks.digits = std::clamp(static_cast<int>(-std::floor(std::log10(ticks.step) + 1e-9)), 0, 9);
  const double first = std::ceil(low / ticks.step - 1e-9);
  const double last = std::floor(high / ticks.step + 1e-9);
  // Where the range is mere rounding of its ends, first + 1 may equal first: the count is an
  // integer.
  const int count = static_cast<int>(std::clamp(last - first + 1.0, 0.0, 2.0 * wanted + 2.0));
  for (int i = 0; i < count; ++i) {
    const double at = first + i;
    ticks.at.push_back(at == 0.0 ? 0.0 : at * ticks.step);
  }
  return ticks;
}

std::string svg_number(double value) {
  std::string text = fixed_text(value, 1);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text == "-0" ? "0" : text;
}

std::string svg_line(double x1, double y1, double x2, double y2, std::string_view css_class) {
  return "<line class=\"" + std::string(css_class) + "\" x1=\"" + svg_number(x1) + "\" y1=\"" +
         svg_number(y1) + "\" x2=\"" + svg_number(x2) + "\" y2=\"" + svg_number(y2) + "\"/>";
}

std::string svg_text(double x, double y, std::string_view anchor, std::string_view css_class,
                     std::string_view text) {
  return "<text class=\"" + std::string(css_class) + "\" x=\"" + svg_number(x) + "\" y=\"" +
         svg_number(y) + "\" text-anchor=\"" + std::string(anchor) + "\">" + escaped(text) +
         "</text>";
}

std::string svg_axes(const SvgArea& area, const Ticks& x_ticks, const Ticks& y_ticks,
                     std::string_view x_title, std::string_view y_title) {
  const double right = area.left + area.width, bottom = area.top + area.height;
  std::string svg;
  for (const double value : y_ticks.at) {
    svg += svg_line(area.left, area.y(value), right, area.y(value), "grid");
    svg += svg_text(area.left - 6, area.y(value) + 4, "end", "tick",
                    fixed_text(value, y_ticks.digits));
  }
  for (const double value : x_ticks.at) {
    svg += svg_line(area.x(value), bottom, area.x(value), bottom + 4, "axis");
    svg +=
        svg_text(area.x(value), bottom + 17, "middle", "tick", fixed_text(value, x_ticks.digits));
  }
  svg += svg_line(area.left, bottom, right, bottom, "axis");
  svg += svg_text(right, bottom + 34, "end", "title", x_title);
  svg += svg_text(4, area.top - 9, "start", "title", y_title);
  return svg;
}

}  // namespace vildar
