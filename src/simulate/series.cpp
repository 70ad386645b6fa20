#include "simulate/series.h"

#include <algorithm>

namespace vildar::simulate {
namespace {

Figure axes(Against against) {
  Figure figure;
  if (against == Against::incidence) {
    figure.x_title = "incidence angle in degrees";
    figure.x_column = "incidence_deg";
  } else {
    figure.x_title = "time in s";
    figure.x_column = "t_s";
  }
  return figure;
}

const std::vector<double>& x_of(const PassScores& scores, Against against) {
  return against == Against::incidence ? scores.incidence_deg : scores.time_s;
}
const std::vector<double>& ml_x_of(const PassScores& scores, Against against) {
  return against == Against::incidence ? scores.ml_incidence_deg : scores.ml_time_s;
}

}  // namespace

std::vector<PassScores> score_cases(const std::vector<Case>& cases, const Options& options,
                                    std::uint64_t family) {
  std::vector<PassScores> scores;
  for (std::size_t i = 0; i < cases.size(); ++i)
    scores.push_back(score_pass(cases[i].pass, options, 1000 * family + i));
  return scores;
}

Figure accuracy_figure(const std::vector<Case>& cases, const std::vector<PassScores>& scores,
                       Against against) {
  Figure figure = axes(against);
  figure.y_title = "estimation accuracy in %";
  figure.y_column = "accuracy_percent";
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const int colour = static_cast<int>(i);
    figure.series.push_back({"paper LS, " + cases[i].label, x_of(scores[i], against),
                             scores[i].accuracy_percent, colour});
    if (!scores[i].ml_accuracy_percent.empty())
      figure.series.push_back({"ML, " + cases[i].label, ml_x_of(scores[i], against),
                               scores[i].ml_accuracy_percent, colour, true});
  }
  // The whole scale where the accuracy falls, a close look where it does not.
  double least = 100.0;
  for (const PassScores& one : scores)
    for (const double accuracy : one.accuracy_percent) least = std::min(least, accuracy);
  figure.y_low = 50.0;
  for (const double low : {80.0, 90.0, 94.0, 98.0})
    if (least > low + 0.05 * (100.0 - low)) figure.y_low = low;
  figure.y_high = 100.0 + 0.04 * (100.0 - *figure.y_low);
  return figure;
}

Figure error_figure(const std::vector<Case>& cases, const std::vector<PassScores>& scores,
                    Against against) {
  Figure figure = axes(against);
  figure.y_title = "root mean square error in % of the speed";
  figure.y_column = "rmse_percent";
  figure.log_y = true;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const int colour = static_cast<int>(i);
    figure.series.push_back(
        {"paper LS, " + cases[i].label, x_of(scores[i], against), scores[i].rmse_percent, colour});
    if (scores[i].bound_percent.empty()) continue;
    figure.series.push_back({"bound, " + cases[i].label, ml_x_of(scores[i], against),
                             scores[i].bound_percent, colour, true});
    Series ml{"ML, " + cases[i].label, ml_x_of(scores[i], against), scores[i].ml_rmse_percent,
              colour};
    ml.dots = true;
    figure.series.push_back(ml);
  }
  return figure;
}

std::vector<bool> cosine_readings(const Options& options) {
  std::vector<bool> readings;
  if (options.with_cosine) readings.push_back(true);
  if (options.without_cosine) readings.push_back(false);
  return readings;
}

std::string cosine_tag(bool cosine) { return cosine ? "with-cosine" : "no-cosine"; }

std::string cosine_title(bool cosine) { return cosine ? "with the cosine" : "without the cosine"; }

std::string cosine_words(bool cosine) {
  return cosine ? "the generator multiplies by cos^(n+1)(theta)" : "the generator has no cosine";
}

}  // namespace vildar::simulate
