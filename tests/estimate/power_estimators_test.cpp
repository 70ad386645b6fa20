#include "estimate/power_estimators.h"

#include <limits>

#include <gtest/gtest.h>

#include "estimate/power_bound.h"
#include "estimate/power_filter.h"
#include "estimate/power_pass.h"

namespace vildar {
namespace {

using namespace power_pass;

constexpr PowerMethod kMethods[] = {PowerMethod::paper_ls,       PowerMethod::weighted_ls,
                                    PowerMethod::max_likelihood, PowerMethod::huber,
                                    PowerMethod::ceres,          PowerMethod::kalman};

const PowerEstimate& value_of(const PowerOutcome& outcome) {
  if (const auto* refusal = std::get_if<PowerRefusal>(&outcome))
    throw std::runtime_error("refused: " + refusal->reason);
  return std::get<PowerEstimate>(outcome);
}

Miss miss_of(const PowerOutcome& outcome) { return std::get<PowerRefusal>(outcome).miss; }

TEST(PowerEstimators, AllAreExactWithoutNoise) {
  const double sigma = sigma_w(60.0);
  for (const Window& window : kWindows) {
    const Samples samples = straight_window(window, 0.0);
    for (const PowerMethod method : kMethods) {
      const PowerOutcome outcome = estimate_power(straight_problem(samples, 0.0, sigma), method);
      const PowerEstimate& estimate = value_of(outcome);
      // The filter starts from a prior on the speed, which pulls a little.
      const double slack = method == PowerMethod::kalman ? 0.02 * estimate.speed_sigma_mps() : 1e-6;
      EXPECT_NEAR(estimate.speed_mps(), kSpeed_mps, slack) << name_of(method) << window.name;
      EXPECT_NEAR(estimate.value[kPowerRange], window.from_m, slack) << name_of(method);
      EXPECT_EQ(estimate.samples_used, static_cast<std::int64_t>(samples.time_s.size()));
    }
  }
}

TEST(PowerEstimators, MaximumLikelihoodReachesTheBoundAndCovers) {
  constexpr int kTrials = 300;
  constexpr double kSlack = 4.0 / 24.5;    // four sigmas of an RMSE: 4 / sqrt(2 n)
  constexpr double kCoverageSlack = 0.05;  // four binomial sigmas
  Random random(11);
  for (const double cosine : {0.0, kCosine})
    for (const Window& window : {kWindows[0], kWindows[3]})
      for (const double snr_db : {10.0, 40.0}) {
        const double sigma = sigma_w(snr_db);
        const Samples clean = straight_window(window, cosine);
        PowerProblem problem = straight_problem(clean, cosine, sigma);
        const auto bound = std::get<PowerMatrix>(power_bound(
            clean.time_s, sigma, straight_truth(window.from_m), problem.known, problem.setting));
        double sum2 = 0.0;
        int covered = 0;
        for (int trial = 0; trial < kTrials; ++trial) {
          const std::vector<double> power = with_noise(clean.power_w, sigma, random);
          problem.power_w = power;
          const PowerOutcome outcome = estimate_power(problem, PowerMethod::max_likelihood);
          const PowerEstimate& estimate = value_of(outcome);
          sum2 += std::pow(estimate.speed_mps() - kSpeed_mps, 2.0);
          const auto interval = estimate.speed_95_mps();
          covered += interval[0] < kSpeed_mps && kSpeed_mps < interval[1];
          EXPECT_LE(estimate.iterations, 6);
        }
        EXPECT_NEAR(std::sqrt(sum2 / kTrials / bound(kPowerSpeed, kPowerSpeed)), 1.0, kSlack)
            << window.name << ' ' << snr_db << " dB, m " << cosine;
        EXPECT_NEAR(covered / static_cast<double>(kTrials), 0.95, kCoverageSlack);
      }
}

TEST(PowerEstimators, CeresFindsTheSameMinimumAndCovariance) {
  Random random(5);
  const double sigma = sigma_w(30.0);
  for (const Window& window : kWindows) {
    const Samples clean = straight_window(window, kCosine);
    PowerProblem problem = straight_problem(clean, kCosine, sigma);
    problem.known[kPowerAcceleration] = Uncertain{0.0, 1.5};
    problem.known[kPowerPerpendicular] = Uncertain{kPerpendicular_m, 0.05};
    problem.known[kPowerLogGain] = Uncertain{0.0, 0.05};
    const std::vector<double> power = with_noise(clean.power_w, sigma, random);
    problem.power_w = power;
    const PowerOutcome ours = estimate_power(problem, PowerMethod::max_likelihood);
    const PowerOutcome theirs = estimate_power(problem, PowerMethod::ceres);
    const PowerEstimate &a = value_of(ours), &b = value_of(theirs);
    EXPECT_NEAR(a.speed_mps(), b.speed_mps(), 0.02 * a.speed_sigma_mps()) << window.name;
    EXPECT_NEAR(a.speed_sigma_mps() / b.speed_sigma_mps(), 1.0, 0.01) << window.name;
    EXPECT_NEAR(a.chi2_per_dof, b.chi2_per_dof, 1e-3);
  }
}

TEST(PowerEstimators, NoiseIsTakenFromTheResidualsWhereNotGiven) {
  Random random(8);
  const double sigma = sigma_w(30.0);
  const Samples clean = straight_window(kWindows[0], 0.0);
  const std::vector<double> power = with_noise(clean.power_w, sigma, random);
  PowerProblem problem = straight_problem(clean, 0.0, sigma);
  problem.power_w = power;
  const PowerOutcome told = estimate_power(problem, PowerMethod::max_likelihood);
  problem.sigma_w = {};
  for (const PowerMethod method : {PowerMethod::max_likelihood, PowerMethod::huber}) {
    const PowerOutcome untold = estimate_power(problem, method);
    // One sigma of a standard deviation from 300 samples: 4 %; of the median's, half as much again.
    EXPECT_NEAR(value_of(untold).noise_sigma_w / sigma, 1.0, 0.2);
    EXPECT_NEAR(value_of(untold).speed_mps(), value_of(told).speed_mps(),
                value_of(told).speed_sigma_mps());
  }
}

TEST(PowerEstimators, HuberShrugsOffOutliers) {
  Random random(9);
  const double sigma = sigma_w(30.0);
  const Samples clean = straight_window(kWindows[0], 0.0);
  PowerProblem problem = straight_problem(clean, 0.0, sigma);
  double plain2 = 0.0, robust2 = 0.0;
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<double> power = with_noise(clean.power_w, sigma, random);
    for (double& p : power)
      if (random.uniform() < 0.02) p += 10.0 * sigma;
    problem.power_w = power;
    const auto squared = [&](PowerMethod method) {
      const PowerOutcome outcome = estimate_power(problem, method);
      return std::pow(value_of(outcome).speed_mps() - kSpeed_mps, 2.0);
    };
    plain2 += squared(PowerMethod::max_likelihood);
    robust2 += squared(PowerMethod::huber);
  }
  EXPECT_LT(std::sqrt(robust2), 0.8 * std::sqrt(plain2));
}

TEST(PowerEstimators, UnknownsAreFoundWhereTheWindowShowsThem) {
  Random random(4);
  const double sigma = sigma_w(60.0);
  for (const PowerParameter unknown :
       {kPowerLogGain, kPowerPerpendicular, kPowerExponent, kPowerAcceleration}) {
    const Samples clean = straight_window(kWindows[3], 0.0);
    PowerProblem problem = straight_problem(clean, 0.0, sigma);
    problem.known[unknown].reset();
    const auto bound = std::get<PowerMatrix>(
        power_bound(clean.time_s, sigma, straight_truth(15.0), problem.known, problem.setting));
    const std::vector<double> power = with_noise(clean.power_w, sigma, random);
    problem.power_w = power;
    const PowerOutcome outcome = estimate_power(problem, PowerMethod::max_likelihood);
    const PowerEstimate& estimate = value_of(outcome);
    const double sigma_mps = std::sqrt(bound(kPowerSpeed, kPowerSpeed));
    EXPECT_NEAR(estimate.speed_mps(), kSpeed_mps, 4.0 * sigma_mps) << symbol_of(unknown);
    EXPECT_NEAR(estimate.speed_sigma_mps() / sigma_mps, 1.0, 0.1) << symbol_of(unknown);
  }
}

// From the start of the arc, where a receding mirror image on the far side fits as well, to the
// sensor itself, where the light grows without bound within a block of samples.
TEST(PowerEstimators, CurvedRoadFromStartToEnd) {
  constexpr int kTrials = 200;
  constexpr double kSlack = 4.0 / 20.0;  // four sigmas of an RMSE
  Random random(21);
  const double at_start_w = std::pow(80.0 * std::sin(0.25 * kPi), -kExponent);
  for (const auto& [beta_rad, snr_db] :
       {std::pair{0.5 * kPi, 35.0}, {0.8, 30.0}, {0.3, 30.0}, {0.1005, 30.0}}) {
    PowerVector truth = straight_truth(40.0 * beta_rad);
    truth[kPowerSpeed] = 40.0;
    truth[kPowerPerpendicular] = 0.0;
    Samples clean;
    for (int i = 0; i < 100; ++i) {
      clean.time_s.push_back(i * 1e-3);
      clean.power_w.push_back(std::pow(80.0 * std::sin(0.5 * (beta_rad - i * 1e-3)), -kExponent));
    }
    const double sigma = at_start_w * std::pow(10.0, -snr_db / 20.0);
    PowerProblem problem = straight_problem(clean, 0.0, sigma);
    problem.setting.curved = true;
    problem.known[kPowerPerpendicular] = Uncertain{0.0, 0.0};
    problem.known[kPowerRadius] = Uncertain{40.0, 0.0};
    const auto bound = std::get<PowerMatrix>(
        power_bound(clean.time_s, sigma, truth, problem.known, problem.setting));
    double sum2 = 0.0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const std::vector<double> power = with_noise(clean.power_w, sigma, random);
      problem.power_w = power;
      const PowerOutcome outcome = estimate_power(problem, PowerMethod::max_likelihood);
      sum2 += std::pow(value_of(outcome).speed_mps() - 40.0, 2.0);
    }
    EXPECT_NEAR(std::sqrt(sum2 / kTrials / bound(kPowerSpeed, kPowerSpeed)), 1.0, kSlack)
        << "beta " << beta_rad;
  }
}

TEST(PowerEstimators, TheTimeReversedPassHasTheOppositeSpeed) {
  const double sigma = sigma_w(40.0);
  Samples samples = straight_window(kWindows[0], 0.0);
  for (double& t_s : samples.time_s) t_s = -t_s;
  const PowerOutcome outcome =
      estimate_power(straight_problem(samples, 0.0, sigma), PowerMethod::max_likelihood);
  EXPECT_NEAR(value_of(outcome).speed_mps(), -kSpeed_mps, 1e-6);
}

TEST(PowerEstimators, RefusesByName) {
  const double sigma = sigma_w(40.0);
  const Samples samples = straight_window(kWindows[0], 0.0);
  PowerProblem problem = straight_problem(samples, 0.0, sigma);
  problem.known[kPowerLogGain].reset();
  problem.known[kPowerPerpendicular].reset();
  for (const PowerMethod method : kMethods) {
    const PowerOutcome outcome = estimate_power(problem, method);
    EXPECT_EQ(std::get<PowerRefusal>(outcome).reason,
              "speed is not observable: K and d both unknown");
  }
  problem = straight_problem(samples, 0.0, sigma);
  problem.known[kPowerLogGain].reset();
  EXPECT_EQ(miss_of(estimate_power(problem, PowerMethod::max_likelihood)), Miss::too_uncertain);
  EXPECT_EQ(std::get<PowerRefusal>(estimate_power(problem, PowerMethod::paper_ls)).reason,
            "a line fit gives V and R alone; K must be known exactly");
}

TEST(PowerEstimators, EveryKindOfBadInputIsNamed) {
  const double sigma = 1e-4, nan = std::numeric_limits<double>::quiet_NaN();
  const auto miss = [&](std::vector<double> t_s, std::vector<double> p_w, PowerMethod method) {
    const PowerProblem problem = straight_problem({t_s, p_w}, 0.0, sigma);
    PowerProblem spans = problem;
    spans.time_s = t_s;
    spans.power_w = p_w;
    return miss_of(estimate_power(spans, method));
  };
  for (const PowerMethod method : kMethods) {
    EXPECT_EQ(miss({}, {}, method), Miss::too_few_samples) << name_of(method);
    EXPECT_EQ(miss({0.0}, {0.1}, method), Miss::too_few_samples) << name_of(method);
    EXPECT_EQ(miss({0.0, 0.1, 0.2}, {nan, nan, 0.1}, method), Miss::too_few_samples);
    EXPECT_EQ(miss({1.0, 1.0, 1.0, 1.0}, {0.1, 0.1, 0.1, 0.1}, method), Miss::no_time_spread);
    EXPECT_EQ(miss({0.0, 0.1, 0.2, 0.3}, {-1.0, 0.0, -2.0, 0.0}, method), Miss::below_noise);
    // K D^-gamma at D = d = 0.5 m is 2.3: brighter than any place on the line of motion.
    EXPECT_EQ(miss({0.0, 0.1, 0.2, 0.3}, {9.0, 9.1, 9.2, 9.3}, method), Miss::outside_model)
        << name_of(method);
    EXPECT_THROW(miss({0.0, 0.1}, {0.1}, method), std::invalid_argument);
  }
}

TEST(PowerEstimators, SamplesThatAreNotFiniteAreCountedAndTheNegativeUsed) {
  const double sigma = sigma_w(40.0), nan = std::numeric_limits<double>::quiet_NaN();
  Samples samples = straight_window(kWindows[0], 0.0);
  samples.power_w[7] = nan;
  samples.time_s[9] = std::numeric_limits<double>::infinity();
  const PowerOutcome outcome =
      estimate_power(straight_problem(samples, 0.0, sigma), PowerMethod::max_likelihood);
  EXPECT_EQ(value_of(outcome).samples_outside, 2);
  EXPECT_EQ(value_of(outcome).samples_used, 298);
  EXPECT_NEAR(value_of(outcome).speed_mps(), kSpeed_mps, 1e-6);
}

TEST(PowerEstimators, PhotodiodeFormCarriesWhatIsKnown) {
  Random random(6);
  const double sigma = sigma_w(40.0);
  const Samples clean = straight_window(kWindows[3], 0.0);
  const std::vector<double> power = with_noise(clean.power_w, sigma, random);
  PhotodiodeKnowledge knowledge;
  knowledge.perpendicular_m = Uncertain{0.5, 0.0};
  knowledge.gain_w = Uncertain{1.0, 0.05};
  knowledge.path_loss_exponent = Uncertain{kExponent, 0.0};
  knowledge.acceleration_mps2 = Uncertain{0.0, 1.5};
  const PowerOutcome outcome =
      estimate_photodiode(clean.time_s, power, std::span(&sigma, 1), 0.36, knowledge);
  const PowerEstimate& estimate = value_of(outcome);
  EXPECT_NEAR(estimate.speed_mps(), kSpeed_mps, 4.0 * estimate.speed_sigma_mps());
  EXPECT_NEAR(estimate.value[kPowerRange], 15.0 - 0.36 * kSpeed_mps, 0.1);
  EXPECT_EQ(miss_of(estimate_photodiode(clean.time_s, power, std::span(&sigma, 1), 0.0, {})),
            Miss::unobservable);
  knowledge.gain_w = Uncertain{-1.0, 0.0};
  EXPECT_THROW(estimate_photodiode(clean.time_s, power, std::span(&sigma, 1), 0.0, knowledge),
               std::domain_error);
}

}  // namespace
}  // namespace vildar
