#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "optics/channel.h"
#include "optics/incidence.h"
#include "optics/path_loss_fit.h"
#include "optics/radar_limit.h"

namespace vildar {
namespace {

constexpr double kRelative = 1e-12;

TEST(PaperChannel, OrderAndGainOfTheDefaultLamp) {
  const double n = lambertian_order(Radians(radians_from_degrees(40.0)));
  EXPECT_NEAR(n, 2.60078, 5e-6);
  EXPECT_NEAR(db_from_ratio(lambertian_gain(n, 1e-4)), -42.42, 5e-3);
}

// Of K D^-gamma cos^m along a straight road: tan^2(theta) = gamma / m.
TEST(PaperChannel, PowerPeaksAtThirtyDegrees) {
  const PowerLaw law{1.0, 1.21, lambertian_order(Radians(radians_from_degrees(40.0))) + 1.0};
  double best_m = 0.0, most_w = 0.0;
  for (double range_m = 0.1; range_m < 15.0; range_m += 1e-4)
    if (law.power_w(range_m, 0.5) > most_w) {
      most_w = law.power_w(range_m, 0.5);
      best_m = range_m;
    }
  EXPECT_NEAR(best_m, 0.863, 1e-3);
  EXPECT_NEAR(degrees_from_radians(straight_place(Metres(best_m), Metres(0.5)).incidence_rad), 30.1,
              0.05);
}

TEST(Incidence, CurveIsThatOfACircleWrittenOutByItsChord) {
  for (double beta_rad = 0.05; beta_rad < 1.6; beta_rad += 0.1) {
    const PaperPlace place = curved_place({40.0, 0.0, 0.0}, Radians(beta_rad));
    EXPECT_NEAR(place.distance_m, 80.0 * std::sin(0.5 * beta_rad), 40.0 * kRelative);
    EXPECT_NEAR(place.incidence_rad, 0.5 * beta_rad, kRelative);  // eq. (21)
  }
  EXPECT_THROW(curved_place({40.0, 0.0, 0.0}, Radians(0.0)), std::domain_error);
  EXPECT_THROW(curved_place({0.0, 1.0, 0.0}, Radians(0.5)), std::domain_error);
}

TEST(Incidence, AnOffsetTurnsTheAngleBackNearTheEnd) {
  double least_deg = 90.0;
  for (double beta_rad = 1e-4; beta_rad < 0.5 * kPi; beta_rad += 1e-4)
    least_deg = std::min(
        least_deg,
        degrees_from_radians(curved_place({40.0, 0.0, 0.5}, Radians(beta_rad)).incidence_rad));
  EXPECT_NEAR(least_deg, 9.0, 0.05);
  EXPECT_GT(curved_place({40.0, 0.0, 0.5}, Radians(1e-3)).incidence_rad,
            radians_from_degrees(80.0));
}

TEST(RadarLimit, FollowsTheChangeOfDistance) {
  // What a radar measures is the rate of D: by central differences, independent of any cosine.
  const double step_m = 1e-4;
  for (const double range_m : {15.0, 4.0, 1.0, 0.2}) {
    const double rate =
        (std::hypot(range_m + step_m, 0.5) - std::hypot(range_m - step_m, 0.5)) / (2.0 * step_m);
    EXPECT_NEAR(radar_share_straight(Metres(range_m), Metres(0.5)), rate, 1e-7);
  }
  for (const double beta_rad : {1.5, 0.8, 0.1}) {
    const PaperCurve curve{40.0, 2.0, 0.5};
    const double step_rad = 1e-5;
    const double rate = (curved_place(curve, Radians(beta_rad + step_rad)).distance_m -
                         curved_place(curve, Radians(beta_rad - step_rad)).distance_m) /
                        (2.0 * step_rad * curve.radius_m);
    EXPECT_NEAR(radar_share_curved(curve, Radians(beta_rad)), rate, 1e-7) << beta_rad;
  }
}

TEST(RadarLimit, PublishedNumbers) {
  EXPECT_NEAR(radar_share_curved({40.0, 0.0, 0.0}, Radians(0.5 * kPi)), std::sqrt(0.5), kRelative);
  // The same 0.3 s window at 20 m/s ending at 47.4 degrees, and abeam.
  const double range_m = 0.5 / std::tan(radians_from_degrees(47.4));
  EXPECT_NEAR(radar_share_straight_window(Metres(range_m), Metres(6.0), Metres(0.5)), 0.967, 1e-3);
  EXPECT_NEAR(radar_share_straight_window(Metres(0.0), Metres(6.0), Metres(0.5)), 0.920, 1e-3);
  EXPECT_NEAR(radar_share_corrected(Metres(0.2), Metres(0.5), Metres(0.5)), 1.0, kRelative);
  EXPECT_NEAR(radar_share_corrected(Metres(0.5), Metres(0.5), Metres(0.0)), std::sqrt(0.5),
              kRelative);
  EXPECT_THROW(radar_share_corrected(Metres(0.0), Metres(0.5), Metres(0.5)), std::domain_error);
  EXPECT_THROW(radar_share_straight_window(Metres(1.0), Metres(0.0), Metres(0.5)),
               std::domain_error);
}

struct Points {
  std::vector<double> distance_m, power_w;
};

Points line_of_sight(double perpendicular_m, double order, int from_m, int to_m) {
  Points points;
  const PowerLaw law{lambertian_gain(order, 1e-4), 2.0, order + 1.0};
  for (int range_m = from_m; range_m <= to_m; ++range_m) {
    points.distance_m.push_back(std::hypot(range_m, perpendicular_m));
    points.power_w.push_back(law.power_w(range_m, perpendicular_m));
  }
  return points;
}

TEST(PathLossFit, BothDomainsAreExactOnAPowerLaw) {
  Points points;
  for (double distance_m = 1.0; distance_m < 11.5; distance_m += 1.0) {
    points.distance_m.push_back(distance_m);
    points.power_w.push_back(1.17e-5 * std::pow(distance_m, -1.21));
  }
  for (const FitDomain domain : {FitDomain::decibel, FitDomain::linear}) {
    const auto fit =
        std::get<PathLossFit>(fit_path_loss(points.distance_m, points.power_w, domain));
    EXPECT_NEAR(fit.gain_w / 1.17e-5, 1.0, 1e-9);
    EXPECT_NEAR(fit.path_loss_exponent, 1.21, 1e-9);
    EXPECT_LT(fit.rms_db, 1e-6);
  }
}

// One unobstructed Lambertian lamp gives the published pairs at two offsets and half-power angles.
TEST(PathLossFit, LineOfSightAloneGivesThePublishedPairs) {
  const Points lambertian = line_of_sight(0.490, 7.87, 1, 11);
  const auto first = std::get<PathLossFit>(
      fit_path_loss(lambertian.distance_m, lambertian.power_w, FitDomain::decibel));
  EXPECT_NEAR(db_from_ratio(first.gain_w), -41.39, 0.02);
  EXPECT_NEAR(first.path_loss_exponent, 1.673, 0.003);
  const Points simulated = line_of_sight(1.335, 2.87, 1, 11);
  const auto second = std::get<PathLossFit>(
      fit_path_loss(simulated.distance_m, simulated.power_w, FitDomain::decibel));
  EXPECT_NEAR(db_from_ratio(second.gain_w), -49.32, 0.02);
  EXPECT_NEAR(second.path_loss_exponent, 1.210, 0.003);
}

TEST(PathLossFit, LinearDomainIsTheBruteForceMinimum) {
  const Points points = line_of_sight(0.5, 2.60078, 1, 11);
  const auto fit =
      std::get<PathLossFit>(fit_path_loss(points.distance_m, points.power_w, FitDomain::linear));
  EXPECT_NEAR(db_from_ratio(fit.gain_w), -44.3, 0.1);
  EXPECT_NEAR(fit.path_loss_exponent, 1.66, 0.02);
  const auto cost = [&](double k, double gamma) {
    double sum = 0.0;
    for (std::size_t i = 0; i < points.power_w.size(); ++i)
      sum += std::pow(points.power_w[i] - k * std::pow(points.distance_m[i], -gamma), 2.0);
    return sum;
  };
  const double least = cost(fit.gain_w, fit.path_loss_exponent);
  for (const double dk : {-1e-3, 0.0, 1e-3})
    for (const double dg : {-1e-3, 0.0, 1e-3})
      EXPECT_GE(cost(fit.gain_w * (1.0 + dk), fit.path_loss_exponent + dg), least * (1.0 - 1e-9));
}

TEST(PathLossFit, NamesWhatIsMissing) {
  const std::vector<double> one{1.0}, two{1.0, 2.0}, same{2.0, 2.0};
  EXPECT_EQ(std::get<Miss>(fit_path_loss(one, one, FitDomain::decibel)), Miss::too_few_samples);
  EXPECT_EQ(std::get<Miss>(fit_path_loss(same, two, FitDomain::decibel)), Miss::no_time_spread);
  EXPECT_EQ(std::get<Miss>(fit_path_loss(two, std::vector{1.0, -1.0}, FitDomain::linear)),
            Miss::below_noise);
  EXPECT_THROW(fit_path_loss(one, two, FitDomain::decibel), std::invalid_argument);
  EXPECT_THROW(fit_path_loss(std::vector{0.0, 1.0}, two, FitDomain::decibel), std::domain_error);
}

}  // namespace
}  // namespace vildar
