#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <locale>
#include <sstream>

#include "core/text.h"
#include "simulate/figure.h"

namespace vildar::simulate {
namespace {

constexpr double kWidth = 860.0, kHeight = 470.0;
constexpr double kLeft = 70.0, kTop = 46.0, kPlotWidth = 540.0, kPlotHeight = 360.0;
constexpr std::array<const char*, 8> kColours{"#0b6fb8", "#d1495b", "#2e8b57", "#b8860b",
                                              "#7b4fa3", "#444444", "#17a2a2", "#a0522d"};

std::string number(double value) { return fixed_text(value, 1); }

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text)
    safe += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return safe;
}

std::string text_at(double x, double y, const char* anchor, const char* extra,
                    const std::string& text) {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" text-anchor=\"" + anchor + "\" " +
         extra + ">" + escaped(text) + "</text>\n";
}

std::string line_at(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1=\"" + number(x1) + "\" y1=\"" + number(y1) + "\" x2=\"" + number(x2) +
         "\" y2=\"" + number(y2) + "\" " + style + "/>\n";
}

// One axis: data range, and how it maps to the drawing.
struct Axis {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  bool log = false;

  double scaled(double value) const { return log ? std::log10(value) : value; }
  double share(double value) const {
    return (scaled(value) - scaled(low)) / (scaled(high) - scaled(low));
  }
  bool shows(double value) const { return std::isfinite(value) && (!log || value > 0.0); }

  void settle() {
    if (!(high - low > 1e-9 * std::max(std::abs(low), std::abs(high)))) {
      if (!std::isfinite(low)) low = high = log ? 1.0 : 0.0;
      low = log ? low / 2.0 : low - 0.5;
      high = log ? high * 2.0 : high + 0.5;
    }
  }

  std::vector<double> ticks() const {
    std::vector<double> at;
    if (log) {
      for (double decade = std::pow(10.0, std::floor(std::log10(low) + 1e-9));
           decade <= high * 1.0001; decade *= 10.0)
        for (const double step : {1.0, 2.0, 5.0})
          if (decade * step >= low * 0.9999 && decade * step <= high * 1.0001)
            at.push_back(decade * step);
      return at;
    }
    const double rough = (high - low) / 7.0;
    const double decade = std::pow(10.0, std::floor(std::log10(rough)));
    const double share = rough / decade;
    const double step = decade * (share < 1.5 ? 1.0 : share < 3.5 ? 2.0 : share < 7.5 ? 5.0 : 10.0);
    for (double i = std::ceil(low / step - 1e-9); i <= std::floor(high / step + 1e-9); i += 1.0)
      at.push_back(i == 0.0 ? 0.0 : i * step);
    return at;
  }

  // Nine digits hide the rounding of the steps.
  static std::string label(double value) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << std::setprecision(9) << value;
    return text.str();
  }
};

std::string curve(const Series& series, const Axis& x, const Axis& y) {
  const std::string colour = kColours[static_cast<std::size_t>(series.colour) % kColours.size()];
  std::string path, dots;
  bool down = false;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!x.shows(series.x[i]) || !y.shows(series.y[i])) {
      down = false;
      continue;
    }
    // Far outside the frame a point is drawn at its edge's far side: the clip cuts it off.
    const double px = kLeft + x.share(series.x[i]) * kPlotWidth;
    const double py = kTop + (1.0 - std::clamp(y.share(series.y[i]), -2.0, 3.0)) * kPlotHeight;
    if (series.dots)
      dots += "<circle cx=\"" + number(px) + "\" cy=\"" + number(py) + "\" r=\"" +
              (series.x.size() > 100 ? "1.4" : "3") + "\"/>";
    else
      path += (down ? "L" : "M") + number(px) + " " + number(py);
    down = true;
  }
  if (series.dots) return "<g fill=\"" + colour + "\" fill-opacity=\"0.5\">" + dots + "</g>\n";
  return "<path d=\"" + path + "\" fill=\"none\" stroke=\"" + colour + "\" stroke-width=\"1.8\"" +
         (series.dashed ? " stroke-dasharray=\"6 4\"" : "") + "/>\n";
}

}  // namespace

std::string svg_of(const Figure& figure) {
  Axis x, y;
  y.log = figure.log_y;
  for (const Series& series : figure.series)
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!x.shows(series.x[i]) || !y.shows(series.y[i])) continue;
      x.low = std::min(x.low, series.x[i]);
      x.high = std::max(x.high, series.x[i]);
      y.low = std::min(y.low, series.y[i]);
      y.high = std::max(y.high, series.y[i]);
    }
  y.low = figure.y_low.value_or(y.low);
  y.high = figure.y_high.value_or(y.high);
  x.settle();
  y.settle();

  const double right = kLeft + kPlotWidth, bottom = kTop + kPlotHeight;
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(kWidth) +
                    " " + number(kHeight) +
                    "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\">\n"
                    "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  svg += text_at(kLeft, 24, "start", "font-size=\"15\" font-weight=\"bold\"", figure.title);
  for (const double value : y.ticks()) {
    const double at = kTop + (1.0 - y.share(value)) * kPlotHeight;
    svg += line_at(kLeft, at, right, at, "stroke=\"#dddddd\"");
    svg += text_at(kLeft - 7, at + 4, "end", "", Axis::label(value));
  }
  for (const double value : x.ticks()) {
    const double at = kLeft + x.share(value) * kPlotWidth;
    svg += line_at(at, kTop, at, bottom, "stroke=\"#eeeeee\"");
    svg += text_at(at, bottom + 18, "middle", "", Axis::label(value));
  }
  svg += "<clipPath id=\"" + figure.name + "\"><rect x=\"" + number(kLeft) + "\" y=\"" +
         number(kTop) + "\" width=\"" + number(kPlotWidth) + "\" height=\"" + number(kPlotHeight) +
         "\"/></clipPath>\n<g clip-path=\"url(#" + figure.name + ")\">\n";
  for (const Series& series : figure.series) svg += curve(series, x, y);
  svg += "</g>\n<rect x=\"" + number(kLeft) + "\" y=\"" + number(kTop) + "\" width=\"" +
         number(kPlotWidth) + "\" height=\"" + number(kPlotHeight) +
         "\" fill=\"none\" stroke=\"#555555\"/>\n";
  svg += text_at(kLeft + kPlotWidth / 2, bottom + 42, "middle", "", figure.x_title);
  svg += text_at(
      0, 0, "middle",
      ("transform=\"translate(20 " + number(kTop + kPlotHeight / 2) + ") rotate(-90)\"").c_str(),
      figure.y_title);
  double at = kTop + 8;
  for (const Series& series : figure.series) {
    const std::string colour = kColours[static_cast<std::size_t>(series.colour) % kColours.size()];
    if (series.dots)
      svg += "<circle cx=\"" + number(right + 30) + "\" cy=\"" + number(at) + "\" r=\"3\" fill=\"" +
             colour + "\"/>\n";
    else
      svg += line_at(right + 16, at, right + 44, at,
                     "stroke=\"" + colour + "\" stroke-width=\"2\"" +
                         (series.dashed ? " stroke-dasharray=\"6 4\"" : ""));
    svg += text_at(right + 50, at + 4, "start", "", series.label);
    at += 19;
  }
  return svg + "</svg>\n";
}

}  // namespace vildar::simulate
