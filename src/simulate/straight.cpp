#include <algorithm>
#include <cmath>
#include <set>

#include "optics/incidence.h"
#include "optics/radar_limit.h"
#include "simulate/experiments.h"
#include "simulate/series.h"

namespace vildar::simulate {
namespace {

std::string shown(double value) { return number_text(value); }

// Radar's limit along the pass: as published, and over the same window.
std::vector<Series> radar(const Options& options) {
  Series plain{"radar: cos(theta)", {}, {}, 5}, window{"radar, same window", {}, {}, 5, true};
  const double travelled_m = options.speed_mps * options.duration_s;
  for (double range_m = options.start_range_m; range_m > 1e-6;
       range_m -= options.start_range_m / 1500.0) {
    const Metres range(range_m), d(options.perpendicular_m);
    const double theta_deg = degrees_from_radians(straight_place(range, d).incidence_rad);
    plain.x.push_back(theta_deg);
    plain.y.push_back(100.0 * radar_share_straight(range, d));
    if (range_m + travelled_m > options.start_range_m) continue;
    window.x.push_back(theta_deg);
    window.y.push_back(100.0 * radar_share_straight_window(range, Metres(travelled_m), d));
  }
  return {plain, window};
}

void add_limits(const std::vector<Case>& cases, const std::vector<PassScores>& scores, bool cosine,
                Report& report) {
  for (std::size_t i = 0; i < cases.size(); ++i)
    report.findings.push_back(
        {"paper LS stays at 90 % or above up to, " + cases[i].label + ", " + cosine_tag(cosine),
         last_above(scores[i].incidence_deg, scores[i].accuracy_percent, 90.0), "deg"});
}

void add_figures(const std::string& name, const std::string& title, const std::string& caption,
                 const std::vector<Case>& cases, const std::vector<PassScores>& scores,
                 Report& report) {
  Figure accuracy = accuracy_figure(cases, scores, Against::incidence);
  accuracy.name = name;
  accuracy.title = title;
  accuracy.caption = caption;
  report.figures.push_back(accuracy);
  Figure error = error_figure(cases, scores, Against::incidence);
  error.name = name + "-error";
  error.title = title + ": error and bound";
  error.caption = "Root mean square error of the same runs beside the Cramer-Rao bound.";
  report.figures.push_back(error);
}

}  // namespace

Report straight_duration(const Options& options) {
  Report report{"straight-duration", {}, {}, {}};
  for (const bool cosine : cosine_readings(options)) {
    std::vector<Case> cases;
    for (const double duration_s : options.durations_s) {
      cases.push_back({shown(duration_s) + " s", straight_pass(options, cosine)});
      cases.back().pass.duration_s = duration_s;
    }
    const auto scores = score_cases(cases, options, cosine ? 1 : 2);
    add_figures("straight-duration-" + cosine_tag(cosine),
                "Straight road, estimation duration, and radar/lidar, " + cosine_title(cosine),
                "Speed estimation accuracy compared to radar/lidar for different estimation "
                "durations; " +
                    cosine_words(cosine) + ", SNR " + shown(options.snr_db) + " dB.",
                cases, scores, report);
    Figure& accuracy = report.figures[report.figures.size() - 2];
    accuracy.y_low = 50.0;
    accuracy.y_high = 102.0;
    for (const Series& series : radar(options)) accuracy.series.push_back(series);
    add_limits(cases, scores, cosine, report);
  }
  const auto lines = radar(options);
  std::vector<double> x = lines[0].x, y = lines[0].y;
  report.findings.push_back({"radar stays at 90 % or above up to", last_above(x, y, 90.0), "deg"});
  report.findings.push_back({"radar over the same window stays at 90 % or above up to",
                             last_above(lines[1].x, lines[1].y, 90.0), "deg"});
  report.findings.push_back({"radar over the same window, least", lines[1].y.back(), "%"});
  return report;
}

Report straight_snr(const Options& options) {
  Report report{"straight-snr", {}, {}, {}};
  for (const bool cosine : cosine_readings(options)) {
    std::vector<Case> cases;
    for (const double snr_db : options.snrs_db) {
      cases.push_back({shown(snr_db) + " dB", straight_pass(options, cosine)});
      Pass& pass = cases.back().pass;
      pass.sigma_w = sigma_of(snr_db, options.snr_kind, power_at_start_w(pass));
    }
    const auto scores = score_cases(cases, options, cosine ? 3 : 4);
    add_figures("straight-snr-" + cosine_tag(cosine),
                "Straight road, initial SNR, " + cosine_title(cosine),
                "Speed estimation accuracy for different initial SNR values; " +
                    cosine_words(cosine) + ", window " + shown(options.duration_s) + " s.",
                cases, scores, report);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const double bias = scores[i].bias_percent.front(), rmse = scores[i].rmse_percent.front();
      report.findings.push_back(
          {"first window, standard deviation, " + cases[i].label + ", " + cosine_tag(cosine),
           std::sqrt(std::max(0.0, rmse * rmse - bias * bias)), "%"});
    }
  }
  return report;
}

Report straight_speed(const Options& options) {
  Report report{"straight-speed", {}, {}, {}};
  for (const bool cosine : cosine_readings(options)) {
    Figure figure;
    figure.name = "straight-speed-" + cosine_tag(cosine);
    figure.title = "Straight road, actual speed, " + cosine_title(cosine);
    figure.caption = "Accuracy of the first window against its length for different speeds; " +
                     cosine_words(cosine) + ", SNR " + shown(options.snr_db) + " dB.";
    figure.x_title = "estimation duration in s";
    figure.x_column = "duration_s";
    figure.y_title = "estimation accuracy in %";
    figure.y_column = "accuracy_percent";
    figure.y_low = 50.0;
    figure.y_high = 102.0;
    int colour = 0;
    for (const double speed_mps : options.speeds_mps) {
      Series paper{"paper LS, " + shown(speed_mps) + " m/s", {}, {}, colour};
      Series ml{"ML, " + shown(speed_mps) + " m/s", {}, {}, colour, true};
      for (double duration_s = 0.05; duration_s < 0.651; duration_s += 0.05) {
        Pass pass = straight_pass(options, cosine);
        pass.speed_mps = speed_mps;
        pass.duration_s = duration_s;
        if (speed_mps * duration_s > 0.9 * options.start_range_m) break;
        const PassScores scores = score_pass(pass, options,
                                             5000 + 100 * static_cast<std::uint64_t>(colour) +
                                                 static_cast<std::uint64_t>(1e3 * duration_s),
                                             true);
        paper.x.push_back(duration_s);
        paper.y.push_back(scores.accuracy_percent.front());
        if (scores.ml_accuracy_percent.empty()) continue;
        ml.x.push_back(duration_s);
        ml.y.push_back(scores.ml_accuracy_percent.front());
      }
      for (std::size_t i = 0; i < paper.x.size(); ++i)
        if (paper.y[i] >= 95.0) {
          report.findings.push_back(
              {"duration for 95 %, " + shown(speed_mps) + " m/s, " + cosine_tag(cosine), paper.x[i],
               "s"});
          break;
        }
      figure.series.push_back(paper);
      if (!ml.x.empty()) figure.series.push_back(ml);
      ++colour;
    }
    report.figures.push_back(figure);
  }
  return report;
}

Report straight_half_angle(const Options& options) {
  Report report{"straight-half-angle", {}, {}, {}};
  std::vector<Case> cases;
  for (const double angle_deg : options.half_power_angles_deg) {
    Options lamp = options;
    lamp.half_power_angle_deg = angle_deg;
    cases.push_back({shown(angle_deg) + " deg", straight_pass(lamp, true)});
  }
  const auto scores = score_cases(cases, options, 6);
  add_figures("straight-half-angle", "Straight road, half-power angle of the lamp",
              "Speed estimation accuracy for headlamps with different half-power angles; the "
              "generator multiplies by cos^(n+1)(theta), which alone knows the angle.",
              cases, scores, report);
  add_limits(cases, scores, true, report);
  return report;
}

Report straight_channel(const Options& options) {
  Report report{"straight-channel", {}, {}, {}};
  std::set<double> durations_s{options.duration_s};
  if (!options.durations_s.empty())
    durations_s.insert({options.durations_s.front(), options.durations_s.back()});
  Options lambertian = options;
  lambertian.gain_db = options.lambertian_gain_db;
  lambertian.path_loss_exponent = options.lambertian_exponent;
  for (const bool common_noise : {false, true}) {
    std::vector<Case> cases;
    for (const double duration_s : durations_s) {
      Pass simulated = straight_pass(options, false), other = straight_pass(lambertian, false);
      simulated.duration_s = other.duration_s = duration_s;
      if (common_noise) other.sigma_w = simulated.sigma_w;
      cases.push_back({"simulated, " + shown(duration_s) + " s", simulated});
      cases.push_back({"Lambertian, " + shown(duration_s) + " s", other});
    }
    const auto scores = score_cases(cases, options, common_noise ? 8 : 7);
    const std::string noise = common_noise ? "one noise in watts for both" : "the same initial SNR";
    add_figures(common_noise ? "straight-channel-same-noise" : "straight-channel-same-snr",
                "Straight road, channel model, " + noise,
                "Speed estimation accuracy of the simulated and the Lambertian channel (the pairs "
                "K, gamma of the channel table) for different estimation durations, " +
                    noise + ".",
                cases, scores, report);
    for (std::size_t i = 0; i < cases.size(); ++i)
      report.findings.push_back({"first window, error, " + cases[i].label + ", " + noise,
                                 scores[i].rmse_percent.front(), "%"});
  }
  return report;
}

}  // namespace vildar::simulate
