#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vildar {

/// Numbers 1, 2 or 5 times a power of ten apart that lie within [low, high]; about `wanted` of
/// them.
struct Ticks {
  double step = 1.0;
  int digits = 0;  ///< after the point, to print them
  std::vector<double> at;
};
Ticks nice_ticks(double low, double high, int wanted);

/// Maps data to the plotting area of an SVG drawing; y grows upward in data, downward in the
/// drawing.
struct SvgArea {
  double left = 0.0, top = 0.0, width = 1.0, height = 1.0;  ///< drawing units
  double x_low = 0.0, x_high = 1.0, y_low = 0.0, y_high = 1.0;

  double x(double value) const { return left + (value - x_low) / (x_high - x_low) * width; }
  double y(double value) const { return top + (y_high - value) / (y_high - y_low) * height; }
};

/// One decimal is a tenth of a screen pixel or less.
std::string svg_number(double value);
std::string svg_line(double x1, double y1, double x2, double y2, std::string_view css_class);
/// `anchor` is start, middle or end; the text is escaped.
std::string svg_text(double x, double y, std::string_view anchor, std::string_view css_class,
                     std::string_view text);
/// Grid lines, tick labels and axis titles of an area.
std::string svg_axes(const SvgArea& area, const Ticks& x_ticks, const Ticks& y_ticks,
                     std::string_view x_title, std::string_view y_title);

}  // namespace vildar
