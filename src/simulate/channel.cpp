#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Dense>

#include "core/random.h"
#include "optics/channel.h"
#include "optics/path_loss_fit.h"
#include "simulate/experiments.h"
#include "simulate/monte_carlo.h"
#include "simulate/pass.h"
#include "simulate/series.h"

namespace vildar::simulate {
namespace {

constexpr double kArea_m2 = 1e-4;

// One unobstructed Lambertian lamp seen from 1 to 11 m along the road, fitted by a power law.
PathLossFit line_of_sight_fit(double offset_m, double order, FitDomain domain) {
  const PowerLaw lamp{lambertian_gain(order, kArea_m2), 2.0, order + 1.0};
  std::vector<double> distance_m, power_w;
  for (int range_m = 1; range_m <= 11; ++range_m) {
    distance_m.push_back(std::hypot(range_m, offset_m));
    power_w.push_back(lamp.power_w(range_m, offset_m));
  }
  return std::get<PathLossFit>(fit_path_loss(distance_m, power_w, domain));
}

struct Lamp {
  double offset_m = 0.0, order = 0.0;
};

// The offset and order whose decibel fit gives a published pair, by Newton in two unknowns.
Lamp lamp_giving(double gain_db, double exponent) {
  Eigen::Vector2d unknown(0.8, 4.0);
  const auto miss = [&](const Eigen::Vector2d& at) -> Eigen::Vector2d {
    const PathLossFit fit = line_of_sight_fit(at[0], at[1], FitDomain::decibel);
    return {db_from_ratio(fit.gain_w) - gain_db, fit.path_loss_exponent - exponent};
  };
  constexpr double kStep = 1e-5;
  for (int step = 0; step < 50; ++step) {
    const Eigen::Vector2d at = miss(unknown);
    Eigen::Matrix2d slope;
    for (int i = 0; i < 2; ++i) {
      Eigen::Vector2d moved = unknown;
      moved[i] += kStep;
      slope.col(i) = (miss(moved) - at) / kStep;
    }
    Eigen::Vector2d change = -slope.fullPivLu().solve(at);
    const double largest = (change.array() / unknown.array()).abs().maxCoeff();
    if (largest > 0.3) change *= 0.3 / largest;
    unknown += change;
    if (largest < 1e-10) break;
  }
  return {unknown[0], unknown[1]};
}

Series path_loss_curve(const std::string& label, const PowerLaw& law, double offset_m, int colour,
                       bool dashed) {
  Series series{label, {}, {}, colour, dashed};
  for (double range_m = 1.0; range_m <= 20.01; range_m += 0.1) {
    series.x.push_back(std::hypot(range_m, offset_m));
    series.y.push_back(-db_from_ratio(law.power_w(range_m, offset_m)));
  }
  return series;
}

std::string digits(double value, int count) { return fixed_text(value, count); }

}  // namespace

Report path_loss(const Options& options) {
  Report report{"path-loss", {}, {}, {}};
  Figure figure;
  figure.name = "path-loss";
  figure.title = "Path loss of both channel models";
  figure.caption =
      "Path loss against distance for the two published pairs, and for one "
      "unobstructed Lambertian lamp at the offset and half-power angle whose "
      "decibel-domain fit over R = 1 to 11 m gives each pair.";
  figure.x_title = "distance D in m";
  figure.x_column = "distance_m";
  figure.y_title = "path loss in dB";
  figure.y_column = "path_loss_db";
  Table table{
      "channel-table",
      "What a line of sight alone gives",
      "One Lambertian lamp of unit power, 1 cm^2 photodiode, R = 1 to 11 m in steps of 1 m, "
      "no reflections. Fits of ln P (dB domain) and of P (linear domain).",
      {"lamp", "offset_m", "half_power_deg", "order_n", "fit_domain", "gain_db",
       "path_loss_exponent", "rms_db"},
      {}};
  const auto add_row = [&](const std::string& name, const Lamp& lamp) {
    const double half_deg = degrees_from_radians(std::acos(std::exp(-std::log(2.0) / lamp.order)));
    for (const FitDomain domain : {FitDomain::decibel, FitDomain::linear}) {
      const PathLossFit fit = line_of_sight_fit(lamp.offset_m, lamp.order, domain);
      table.rows.push_back({name, digits(lamp.offset_m, 3), digits(half_deg, 1),
                            digits(lamp.order, 2), domain == FitDomain::decibel ? "dB" : "linear",
                            digits(db_from_ratio(fit.gain_w), 2), digits(fit.path_loss_exponent, 3),
                            digits(fit.rms_db, 2)});
    }
  };
  const double order = options.cosine_exponent() - 1.0;
  add_row("the paper's numbers", {options.perpendicular_m, order});
  int colour = 0;
  for (const auto& [name, gain_db, exponent] :
       {std::tuple{"Lambertian", options.lambertian_gain_db, options.lambertian_exponent},
        std::tuple{"simulated", options.gain_db, options.path_loss_exponent}}) {
    const Lamp lamp = lamp_giving(gain_db, exponent);
    add_row(std::string("gives the ") + name + " pair", lamp);
    figure.series.push_back(path_loss_curve(
        std::string(name) + " pair", {ratio_from_db(gain_db), exponent, 0.0}, 0.0, colour, false));
    figure.series.push_back(
        path_loss_curve("line of sight, offset " + digits(lamp.offset_m, 2) + " m",
                        {lambertian_gain(lamp.order, kArea_m2), 2.0, lamp.order + 1.0},
                        lamp.offset_m, colour, true));
    report.findings.push_back(
        {std::string("offset that gives the ") + name + " pair", lamp.offset_m, "m"});
    report.findings.push_back(
        {std::string("order n that gives the ") + name + " pair", lamp.order, ""});
    ++colour;
  }
  report.findings.push_back({"order n of the half-power angle", order, ""});
  report.findings.push_back(
      {"gain C of the order n and 1 cm^2", db_from_ratio(lambertian_gain(order, kArea_m2)), "dB"});
  report.figures.push_back(figure);
  report.tables.push_back(table);
  return report;
}

Report received_power(const Options& options) {
  Report report{"received-power", {}, {}, {}};
  for (const double snr_db : {20.0, 30.0}) {
    Figure figure;
    figure.name = "received-power-" + number_text(snr_db) + "db";
    figure.title = "Received power, initial SNR " + number_text(snr_db) + " dB";
    figure.caption =
        "Received power with the same K and gamma in both models. The Lambertian one "
        "(with the cosine) peaks and then falls though the vehicle still approaches: "
        "beyond the peak a power no longer names one range.";
    figure.x_title = "time in s";
    figure.x_column = "t_s";
    figure.y_title = "received power in dB of the power at the start";
    figure.y_column = "power_db";
    figure.y_low = -10.0;
    figure.y_high = 22.0;
    int colour = 0;
    for (const bool cosine : {false, true}) {
      const Pass pass = straight_pass(options, cosine);
      const double start_w = power_at_start_w(pass);
      const double sigma_w = sigma_of(snr_db, options.snr_kind, start_w);
      Random random(trial_seed(options.seed, 13, colour));
      const std::string name = cosine ? "Lambertian" : "simulated";
      Series noisy{name + ", samples", {}, {}, colour, false, true}, clean{name, {}, {}, colour};
      for (double t_s = 0.0; pass.start_m - pass.speed_mps * t_s > 1e-9;
           t_s += pass.sample_period_s) {
        const double power_w =
            pass.generator.power_w(pass.start_m - pass.speed_mps * t_s, pass.perpendicular_m);
        const double sample_w = power_w + sigma_w * random.normal();
        clean.x.push_back(t_s);
        clean.y.push_back(db_from_ratio(power_w / start_w));
        noisy.x.push_back(t_s);
        noisy.y.push_back(sample_w > 0.0 ? db_from_ratio(sample_w / start_w) : -99.0);
      }
      figure.series.push_back(noisy);
      figure.series.push_back(clean);
      if (cosine && snr_db == 20.0) {
        const auto peak = std::max_element(clean.y.begin(), clean.y.end()) - clean.y.begin();
        report.findings.push_back(
            {"time of the peak with the cosine", clean.x[static_cast<std::size_t>(peak)], "s"});
      }
      ++colour;
    }
    report.figures.push_back(figure);
  }
  // tan^2(theta) = gamma / m at the peak of K D^-gamma cos^m(theta).
  const double m = options.cosine_exponent(), gamma = options.path_loss_exponent;
  report.findings.push_back({"incidence angle of the peak",
                             degrees_from_radians(std::atan(std::sqrt(gamma / m))), "deg"});
  report.findings.push_back(
      {"range of the peak", options.perpendicular_m * std::sqrt(m / gamma), "m"});
  return report;
}

}  // namespace vildar::simulate
