#include <gtest/gtest.h>

#include "estimate/power_bound.h"
#include "estimate/power_estimators.h"
#include "estimate/power_pass.h"

namespace vildar {
namespace {

using namespace power_pass;

constexpr int kTrials = 4000;
constexpr double kRatioError = 0.0112;  // one sigma of an RMSE from 4000 trials: 1 / sqrt(2 n)

struct Score {
  double ratio = 0.0, coverage = 0.0, iterations = 0.0;
  int refused = 0;
};

Score score(const Window& window, double cosine, double snr_db, PowerMethod method,
            double outlier_share = 0.0) {
  const double sigma = sigma_w(snr_db);
  const Samples clean = straight_window(window, cosine);
  PowerProblem problem = straight_problem(clean, cosine, sigma);
  const auto bound = std::get<PowerMatrix>(power_bound(
      clean.time_s, sigma, straight_truth(window.from_m), problem.known, problem.setting));
  // A seed of its own for each row, so that their errors are independent.
  Random random(
      static_cast<std::uint64_t>(1e4 * window.from_m + 1e3 * window.to_m + snr_db + 7.0 * cosine));
  Score result;
  double sum2 = 0.0;
  int covered = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> power = with_noise(clean.power_w, sigma, random);
    for (double& p : power)
      if (outlier_share > 0.0 && random.uniform() < outlier_share)
        p += 10.0 * sigma * (random.uniform() < 0.5 ? -1.0 : 1.0);
    problem.power_w = power;
    const PowerOutcome outcome = estimate_power(problem, method);
    if (const auto* refusal = std::get_if<PowerRefusal>(&outcome)) {
      if (result.refused++ == 0) ADD_FAILURE() << refusal->reason;
      continue;
    }
    const auto& estimate = std::get<PowerEstimate>(outcome);
    const double error = estimate.speed_mps() - kSpeed_mps;
    sum2 += error * error;
    const auto interval = estimate.speed_95_mps();
    covered += interval[0] < kSpeed_mps && kSpeed_mps < interval[1];
    result.iterations += estimate.iterations;
  }
  result.ratio = std::sqrt(sum2 / kTrials / bound(kPowerSpeed, kPowerSpeed));
  result.coverage = covered / static_cast<double>(kTrials);
  result.iterations /= kTrials;
  return result;
}

TEST(PowerStudy, MaximumLikelihoodReachesTheBound) {
  for (const double cosine : {0.0, kCosine})
    for (const Window& window : kWindows)
      for (const double snr_db : {10.0, 20.0, 30.0, 40.0, 50.0, 60.0}) {
        const Score s = score(window, cosine, snr_db, PowerMethod::max_likelihood);
        std::printf("ML m=%.1f %-13s %2.0f dB: ratio %.3f coverage %.3f iterations %.1f\n", cosine,
                    window.name, snr_db, s.ratio, s.coverage, s.iterations);
        EXPECT_LT(s.ratio, 1.05 + 2.0 * kRatioError) << window.name << ' ' << snr_db << " dB";
        EXPECT_GT(s.coverage, 0.93);
        EXPECT_LT(s.coverage, 0.97);
      }
}

TEST(PowerStudy, HuberCostsFivePercentAndResistsOutliers) {
  for (const double cosine : {0.0, kCosine})
    for (const Window& window : kWindows)
      for (const double snr_db : {10.0, 30.0, 60.0}) {
        const Score clean = score(window, cosine, snr_db, PowerMethod::huber);
        const Score dirty = score(window, cosine, snr_db, PowerMethod::huber, 0.02);
        std::printf("Huber m=%.1f %-13s %2.0f dB: ratio %.3f coverage %.3f, outliers %.3f %.3f\n",
                    cosine, window.name, snr_db, clean.ratio, clean.coverage, dirty.ratio,
                    dirty.coverage);
        EXPECT_LT(clean.ratio, 1.07 + 2.0 * kRatioError) << window.name;
        EXPECT_LT(dirty.ratio, 1.10 + 2.0 * kRatioError) << window.name;
        EXPECT_GT(clean.coverage, 0.93);
        EXPECT_LT(clean.coverage, 0.97);
      }
}

// Error of the paper's line over the bound, to first order in the noise: each sample's range is off
// by dR/dP, and a line weighs them all alike.
double first_order_paper_ratio(const Window& window) {
  const Samples samples = straight_window(window, 0.0);
  const auto count = static_cast<double>(samples.time_s.size());
  double mean_s = 0.0;
  for (const double t_s : samples.time_s) mean_s += t_s / count;
  double spread = 0.0, line = 0.0, a = 0.0, b = 0.0, c = 0.0;
  for (std::size_t i = 0; i < samples.time_s.size(); ++i) {
    const double t_s = samples.time_s[i], range_m = window.from_m - kSpeed_mps * t_s;
    const double slope = kExponent * range_m * samples.power_w[i] /
                         (range_m * range_m + kPerpendicular_m * kPerpendicular_m);
    spread += (t_s - mean_s) * (t_s - mean_s);
    line += (t_s - mean_s) * (t_s - mean_s) / (slope * slope);
    a += slope * slope;
    b += t_s * slope * slope;
    c += t_s * t_s * slope * slope;
  }
  return std::sqrt(line / (spread * spread) * (a * c - b * b) / a);
}

TEST(PowerStudy, PaperLeastSquaresFallsShortAsKnown) {
  for (const Window& window : kWindows)
    for (const double snr_db : {40.0, 50.0, 60.0}) {
      const Score s = score(window, 0.0, snr_db, PowerMethod::paper_ls);
      const double expected = first_order_paper_ratio(window);
      std::printf("paper %-13s %2.0f dB: ratio %.3f, to first order %.3f\n", window.name, snr_db,
                  s.ratio, expected);
      if (snr_db > 45.0) {
        EXPECT_NEAR(s.ratio / expected, 1.0, 4.0 * kRatioError) << window.name << ' ' << snr_db;
      }
      EXPECT_NEAR(s.ratio / window.paper_ratio, 1.0, 0.05) << window.name << ' ' << snr_db;
    }
}

TEST(PowerStudy, OtherMethods) {
  for (const PowerMethod method : {PowerMethod::weighted_ls, PowerMethod::kalman})
    for (const Window& window : kWindows)
      for (const double snr_db : {10.0, 20.0, 30.0, 40.0, 60.0}) {
        const Score s = score(window, 0.0, snr_db, method);
        std::printf("%s %-13s %2.0f dB: ratio %.3f coverage %.3f\n", name_of(method).data(),
                    window.name, snr_db, s.ratio, s.coverage);
        if (method == PowerMethod::kalman || snr_db >= 30.0) {
          EXPECT_LT(s.ratio, 1.05 + 2.0 * kRatioError) << window.name;
        }
      }
}

// A radian per second on 40 m, windows of 0.3 s from beta = pi/2 down to 0.35.
TEST(PowerStudy, CurvedRoadReachesTheBoundWhereThePaperDoesNot) {
  for (const double cosine : {0.0, kCosine})
    for (const double beta_rad : {0.5 * kPi, 0.8, 0.5, 0.35}) {
      PowerVector truth = straight_truth(40.0 * beta_rad);
      truth[kPowerSpeed] = 40.0;
      truth[kPowerPerpendicular] = 0.0;
      std::vector<double> time_s, clean_w;
      for (int i = 0; i < 300; ++i) {
        time_s.push_back(i * 1e-3);
        const double half_rad = 0.5 * (beta_rad - i * 1e-3);
        clean_w.push_back(std::pow(80.0 * std::sin(half_rad), -kExponent) *
                          std::pow(std::cos(half_rad), cosine));
      }
      const double sigma = std::pow(80.0 * std::sin(0.25 * kPi), -kExponent) * 1e-2;  // 40 dB
      PowerProblem problem = straight_problem({time_s, clean_w}, cosine, sigma);
      problem.time_s = time_s;
      problem.setting.curved = true;
      problem.known[kPowerPerpendicular] = Uncertain{0.0, 0.0};
      problem.known[kPowerRadius] = Uncertain{40.0, 0.0};
      const auto bound =
          std::get<PowerMatrix>(power_bound(time_s, sigma, truth, problem.known, problem.setting));
      double ratio[3] = {};
      constexpr PowerMethod kMethods[] = {PowerMethod::paper_ls, PowerMethod::weighted_ls,
                                          PowerMethod::max_likelihood};
      Random random(static_cast<std::uint64_t>(1e3 * beta_rad + cosine));
      for (int trial = 0; trial < kTrials; ++trial) {
        const std::vector<double> power = with_noise(clean_w, sigma, random);
        problem.power_w = power;
        for (int k = 0; k < 3; ++k) {
          const double error =
              std::get<PowerEstimate>(estimate_power(problem, kMethods[k])).speed_mps() - 40.0;
          ratio[k] += error * error;
        }
      }
      for (double& r : ratio) r = std::sqrt(r / kTrials / bound(kPowerSpeed, kPowerSpeed));
      std::printf("curved m=%.1f beta %.2f: paper %.3f weighted %.3f ML %.3f\n", cosine, beta_rad,
                  ratio[0], ratio[1], ratio[2]);
      EXPECT_LT(ratio[1], 1.05 + 2.0 * kRatioError);
      EXPECT_LT(ratio[2], 1.05 + 2.0 * kRatioError);
      // Very sensitive to where the window ends: a sample more or less is several percent.
      if (beta_rad < 0.4 && cosine == 0.0) {
        EXPECT_NEAR(ratio[0] / 2.7, 1.0, 0.1);
      }
    }
}

}  // namespace
}  // namespace vildar
