#include <algorithm>
#include <cmath>

#include "optics/radar_limit.h"
#include "simulate/experiments.h"
#include "simulate/series.h"

namespace vildar::simulate {
namespace {

void add_figures(const std::string& name, const std::string& title, const std::string& caption,
                 const std::vector<Case>& cases, const std::vector<PassScores>& scores,
                 Report& report) {
  Figure accuracy = accuracy_figure(cases, scores, Against::time);
  accuracy.name = name;
  accuracy.title = title;
  accuracy.caption = caption;
  report.figures.push_back(accuracy);
  Figure error = error_figure(cases, scores, Against::time);
  error.name = name + "-error";
  error.title = title + ": error and bound";
  error.caption = "Root mean square error of the same runs beside the Cramer-Rao bound.";
  report.figures.push_back(error);
}

double end_s(const Options& options) {
  return radians_from_degrees(options.curve_start_deg) / options.angular_speed_rad_per_s;
}

Series radar(const Options& options, double lateral_m, const std::string& label) {
  Series series{label, {}, {}, 5, lateral_m != 0.0};
  for (int i = 0; i < 500; ++i) {
    const double t_s = end_s(options) * i / 500.0;
    const double beta_rad =
        radians_from_degrees(options.curve_start_deg) - options.angular_speed_rad_per_s * t_s;
    series.x.push_back(t_s);
    series.y.push_back(
        100.0 * radar_share_curved({options.curve_radius_m, 0.0, lateral_m}, Radians(beta_rad)));
  }
  return series;
}

}  // namespace

Report curved_duration(const Options& options) {
  Report report{"curved-duration", {}, {}, {}};
  for (const bool cosine : cosine_readings(options)) {
    std::vector<Case> cases;
    for (const double duration_s : options.durations_s) {
      cases.push_back({number_text(duration_s) + " s", curved_pass(options, cosine)});
      cases.back().pass.duration_s = duration_s;
    }
    const auto scores = score_cases(cases, options, cosine ? 9 : 10);
    add_figures("curved-duration-" + cosine_tag(cosine),
                "Curved road, estimation duration, and radar/lidar, " + cosine_title(cosine),
                "Speed estimation accuracy compared to radar/lidar for different estimation "
                "durations, curved road; " +
                    cosine_words(cosine) + ", SNR " + number_text(options.snr_db) +
                    " dB; the estimator knows the generator's law.",
                cases, scores, report);
    auto& figure = report.figures[report.figures.size() - 2];
    figure.y_low = 50.0;
    figure.y_high = 102.0;
    figure.series.push_back(radar(options, 0.0, "radar, d_o = 0"));
    figure.series.push_back(radar(options, options.curve_lateral_m,
                                  "radar, d_o = " + number_text(options.curve_lateral_m) + " m"));
    for (std::size_t i = 0; i < cases.size(); ++i)
      report.findings.push_back(
          {"accuracy of the first window, " + cases[i].label + ", " + cosine_tag(cosine),
           scores[i].accuracy_percent.front(), "%"});
  }
  report.findings.push_back(
      {"radar at the start, d_o = 0", radar(options, 0.0, "").y.front(), "%"});
  return report;
}

Report curved_snr(const Options& options) {
  Report report{"curved-snr", {}, {}, {}};
  for (const bool cosine : cosine_readings(options)) {
    std::vector<Case> cases;
    for (const double snr_db : options.snrs_db) {
      cases.push_back({number_text(snr_db) + " dB", curved_pass(options, cosine)});
      Pass& pass = cases.back().pass;
      pass.sigma_w = sigma_of(snr_db, options.snr_kind, power_at_start_w(pass));
    }
    const auto scores = score_cases(cases, options, cosine ? 11 : 12);
    add_figures(
        "curved-snr-" + cosine_tag(cosine), "Curved road, initial SNR, " + cosine_title(cosine),
        "Speed estimation accuracy versus time for different initial SNR values, curved "
        "road; " +
            cosine_words(cosine) + ", window " + number_text(options.curve_duration_s) + " s.",
        cases, scores, report);
    for (std::size_t i = 0; i < cases.size(); ++i)
      report.findings.push_back(
          {"accuracy of the first window, " + cases[i].label + ", " + cosine_tag(cosine),
           scores[i].accuracy_percent.front(), "%"});
  }
  return report;
}

Report geometry(const Options& options) {
  Report report{"geometry", {}, {}, {}};
  Figure figure;
  figure.name = "geometry";
  figure.title = "Incidence angle and range, straight road";
  figure.caption = "Incidence angle (degrees) and range (metres) as the vehicle approaches.";
  figure.x_title = "time in s";
  figure.x_column = "t_s";
  figure.y_title = "angle in degrees, range in m";
  figure.y_column = "degrees_or_metres";
  Series angle{"theta, degrees", {}, {}, 0}, range{"R, m", {}, {}, 1};
  for (double t_s = 0.0; options.start_range_m - options.speed_mps * t_s >= 0.0; t_s += 1e-3) {
    const PaperPlace place = straight_place(Metres(options.start_range_m - options.speed_mps * t_s),
                                            Metres(options.perpendicular_m));
    angle.x.push_back(t_s);
    angle.y.push_back(degrees_from_radians(place.incidence_rad));
    range.x.push_back(t_s);
    range.y.push_back(place.range_m);
  }
  figure.series = {angle, range};
  report.figures.push_back(figure);
  return report;
}

Report curved_geometry(const Options& options) {
  Report report{"curved-geometry", {}, {}, {}};
  Figure figure;
  figure.name = "curved-geometry";
  figure.title = "Incidence angle, range and offset, curved road";
  figure.caption =
      "Incidence angle (degrees), range and lateral offset (metres). With d_o = 0, as "
      "stated, the angle only falls; a fall and a rise to 90 degrees need d_o > 0.";
  figure.x_title = "time in s";
  figure.x_column = "t_s";
  figure.y_title = "angle in degrees, lengths in m";
  figure.y_column = "degrees_or_metres";
  int colour = 0;
  for (const double lateral_m : {0.0, options.curve_lateral_m}) {
    const std::string tag = ", d_o = " + number_text(lateral_m) + " m";
    Series angle{"theta" + tag, {}, {}, colour}, range{"R" + tag, {}, {}, colour + 1},
        offset{"d_c + d_o" + tag, {}, {}, colour + 2};
    const int steps = 1000;
    for (int i = 0; i < steps; ++i) {
      const double t_s = end_s(options) * i / steps;
      const PaperPlace place = curved_place({options.curve_radius_m, 0.0, lateral_m},
                                            Radians(radians_from_degrees(options.curve_start_deg) *
                                                    (1.0 - static_cast<double>(i) / steps)));
      for (Series* series : {&angle, &range, &offset}) series->x.push_back(t_s);
      angle.y.push_back(degrees_from_radians(place.incidence_rad));
      range.y.push_back(place.range_m);
      offset.y.push_back(place.perpendicular_m);
    }
    report.findings.push_back(
        {"least incidence angle" + tag, *std::min_element(angle.y.begin(), angle.y.end()), "deg"});
    report.findings.push_back({"incidence angle at the end" + tag, angle.y.back(), "deg"});
    for (Series* series : {&angle, &range, &offset}) {
      series->dashed = lateral_m != 0.0;
      if (series->dashed) series->colour -= 3;
      if (series->dashed && series != &angle) continue;
      figure.series.push_back(*series);
    }
    colour += 3;
  }
  report.figures.push_back(figure);
  return report;
}

}  // namespace vildar::simulate
