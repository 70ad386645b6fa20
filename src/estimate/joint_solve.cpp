#include "estimate/joint_solve.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "estimate/solve.h"

namespace vildar {
namespace {

using Eigen::Index;

constexpr double kTolerance = 0.05;  // sigmas
constexpr Index kFirstLight = kPathParameters;

// All unknowns one after the other.
Eigen::VectorXd packed(const JointUnknowns& unknowns) {
  Eigen::VectorXd all(first_own(unknowns.own.size()));
  std::copy_n(unknowns.path.data(), kPathParameters, all.data());
  std::copy_n(unknowns.light.data(), kLightParameters, all.data() + kFirstLight);
  for (std::size_t r = 0; r < unknowns.own.size(); ++r)
    std::copy_n(unknowns.own[r].data(), kReceiverParameters, all.data() + first_own(r));
  return all;
}

JointUnknowns unpacked(const Eigen::VectorXd& all, std::size_t receivers) {
  JointUnknowns unknowns;
  unknowns.path = all.head<kPathParameters>();
  std::copy_n(all.data() + kFirstLight, kLightParameters, unknowns.light.begin());
  unknowns.own.resize(receivers);
  for (std::size_t r = 0; r < receivers; ++r)
    std::copy_n(all.data() + first_own(r), kReceiverParameters, unknowns.own[r].begin());
  return unknowns;
}

std::vector<int> free_light(const LightSetting& light) {
  std::vector<int> free{kFirstLight + kLogGain};
  if (light.exponent_std > 0.0) free.push_back(kFirstLight + kExponent);
  if (light.time_shift_std_s > 0.0) free.push_back(kFirstLight + kTimeShift);
  for (int i = kBeamWidth; i < kLightParameters; ++i) free.push_back(kFirstLight + i);
  return free;
}

bool ratio_is_free(const JointProblem& joint, std::size_t receiver) {
  return receiver > 0 && joint.receivers[receiver].receiver.log_ratio_std > 0.0;
}

std::vector<int> free_unknowns(const JointProblem& joint) {
  std::vector<int> free = free_parameters(joint.geometry);
  std::ranges::copy(free_light(joint.light), std::back_inserter(free));
  for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
    const Receiver& receiver = joint.receivers[r].receiver;
    const auto first = static_cast<int>(first_own(r));
    free.insert(free.end(), {first + kBackground, first + kDrift});
    if (ratio_is_free(joint, r)) free.push_back(first + kLogRatio);
    if (r > 0 && receiver.ahead_std_m > 0.0) free.push_back(first + kAhead);
  }
  return free;
}

// Whitened residuals and, where asked for, their slopes by all unknowns.
class Rows {
 public:
  Rows(const JointProblem& joint, bool with_slopes) : with_slopes_(with_slopes) {
    Index count = kLightParameters;
    for (const Lit& lit : joint.receivers)
      count += static_cast<Index>(lit.blocks.size()) + kReceiverParameters;
    slopes_.setZero(first_own(joint.receivers.size()), with_slopes ? count : 1);
    values_.resize(count);
  }

  // Of the next residual, to be filled in before it is added.
  double* slopes() { return slopes_.col(with_slopes_ ? count_ : 0).data(); }
  void add(double residual) {
    cost_ += 0.5 * residual * residual;
    values_[count_++] = residual;
  }
  // With Huber's loss.
  void add_softly(double residual) {
    constexpr double kBound = 2.0;
    const double size = std::abs(residual);
    const double weight = size > kBound ? std::sqrt(kBound / size) : 1.0;
    if (with_slopes_) slopes_.col(count_) *= weight;
    cost_ += size > kBound ? 0.5 * kBound * (size - kBound) : 0.0;
    add(weight * residual);
  }
  void add_prior(Index unknown, double off, double std) {
    if (!(std > 0.0)) return;
    slopes()[unknown] = 1.0 / std;
    add(off / std);
  }
  /// By `free`; those of the bearings come last.
  Residuals with(const Residuals& bearings, const std::vector<int>& free) const {
    Residuals all;
    const Index own = count_, others = bearings.values.size();
    all.cost = cost_ + bearings.cost;
    all.values.resize(own + others);
    all.values << values_.head(own), bearings.values;
    if (!with_slopes_) return all;
    all.slopes.setZero(static_cast<Index>(free.size()), own + others);
    for (std::size_t k = 0; k < free.size(); ++k)
      all.slopes.row(static_cast<Index>(k)).head(own) = slopes_.row(free[k]).head(own);
    all.slopes.topRightCorner(bearings.slopes.rows(), others) = bearings.slopes;
    return all;
  }

 private:
  bool with_slopes_;
  Index count_ = 0;
  double cost_ = 0.0;
  Eigen::MatrixXd slopes_;
  Eigen::VectorXd values_;
};

void add_priors(const LightSetting& light, const JointUnknowns& at, Rows& rows) {
  if (light.log_gain_std > 0.0) {
    double* slopes = rows.slopes();
    slopes[kFirstLight + kLogGain] = 1.0 / light.log_gain_std;
    slopes[kFirstLight + kExponent] = at.path[kLogScale] / light.log_gain_std;
    slopes[kLogScale] = at.light[kExponent] / light.log_gain_std;
    rows.add((at.light[kLogGain] + at.light[kExponent] * at.path[kLogScale] - light.log_gain) /
             light.log_gain_std);
  }
  rows.add_prior(kFirstLight + kExponent, at.light[kExponent] - light.exponent, light.exponent_std);
  rows.add_prior(kFirstLight + kTimeShift, at.light[kTimeShift] - light.time_shift_s,
                 light.time_shift_std_s);
  for (int i = kBeamWidth; i < kLightParameters; ++i)
    rows.add_prior(kFirstLight + i, at.light[static_cast<std::size_t>(i)], beam_prior_std(i));
}

// Background and drift are loose, up to the brightest signal.
void add_priors(const Lit& lit, const ReceiverVector& own, Index first, double span_s, Rows& rows) {
  rows.add_prior(first + kBackground, own[kBackground] - lit.start[kBackground], 1.0);
  rows.add_prior(first + kDrift, own[kDrift], 1.0 / span_s);
  rows.add_prior(first + kLogRatio, own[kLogRatio] - lit.receiver.log_ratio,
                 lit.receiver.log_ratio_std);
  rows.add_prior(first + kAhead, own[kAhead], lit.receiver.ahead_std_m);
}

std::optional<Residuals> residuals(const JointProblem& joint, const JointUnknowns& at,
                                   const std::vector<int>& free, bool with_slopes) {
  const auto bearings = geometry_residuals(joint.geometry, at.path, free_parameters(joint.geometry),
                                           with_slopes ? Slopes::of_path : Slopes::none);
  if (!bearings) return std::nullopt;
  Rows rows(joint, with_slopes);
  for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
    const Lit& lit = joint.receivers[r];
    const std::array<const double*, 3> unknowns{at.path.data(), at.light.data(), at.own[r].data()};
    for (const LitBlock& block : lit.blocks) {
      std::array<double*, 3> slopes{rows.slopes(), rows.slopes() + kFirstLight,
                                    rows.slopes() + first_own(r)};
      double residual = 0.0;
      if (!BlockResidual(joint.light, lit.receiver, block)
               .Evaluate(unknowns.data(), &residual, with_slopes ? slopes.data() : nullptr))
        return std::nullopt;
      rows.add_softly(residual);
    }
    add_priors(lit, at.own[r], first_own(r), joint.span_s, rows);
  }
  add_priors(joint.light, at, rows);
  return rows.with(*bearings, free);
}

std::vector<Eigen::VectorXd> errors_of(const JointProblem& joint, const JointUnknowns& at) {
  std::vector<Eigen::VectorXd> errors;
  for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
    const Lit& lit = joint.receivers[r];
    Eigen::VectorXd& own = errors.emplace_back(static_cast<Index>(lit.blocks.size()));
    const std::array<const double*, 3> unknowns{at.path.data(), at.light.data(), at.own[r].data()};
    for (std::size_t i = 0; i < lit.blocks.size(); ++i) {
      double residual = INFINITY;
      BlockResidual(joint.light, lit.receiver, lit.blocks[i])
          .Evaluate(unknowns.data(), &residual, nullptr);
      own[static_cast<Index>(i)] = residual * lit.blocks[i].sigma;
    }
  }
  return errors;
}

}  // namespace

Index first_own(std::size_t receiver) {
  return kFirstLight + kLightParameters + kReceiverParameters * static_cast<Index>(receiver);
}

JointUnknowns start_of(const JointProblem& joint, const PathVector& path) {
  constexpr double kClearSigmas = 3.0;
  constexpr int kRounds = 2;  // the sum of two lamps bends a little
  JointUnknowns start;
  start.path = path;
  start.light[kExponent] = joint.light.exponent;
  for (const Lit& lit : joint.receivers) start.own.push_back(lit.start);
  std::vector<int> free = free_light(joint.light);
  for (std::size_t r = 0; r < joint.receivers.size(); ++r)
    if (ratio_is_free(joint, r)) free.push_back(static_cast<int>(first_own(r)) + kLogRatio);
  for (int round = 0; round < kRounds; ++round) {
    Rows rows(joint, true);
    for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
      const Lit& lit = joint.receivers[r];
      const double log_ratio = start.own[r][kLogRatio];
      for (const LitBlock& block : lit.blocks) {
        const double tau_s = block.time_s - joint.geometry.reference_s + start.light[kTimeShift];
        double value = 0.0;
        PowerGradient gradient;
        if (!(block.light > kClearSigmas * block.sigma) ||
            !log_power(path.data(), start.light.data(), joint.light, lit.receiver.position_m, 0.0,
                       tau_s, value, &gradient))
          continue;
        const double sigma = block.sigma / block.light;
        for (std::size_t i = 0; i < kLightParameters; ++i)
          rows.slopes()[kFirstLight + static_cast<Index>(i)] = -gradient.light[i] / sigma;
        rows.slopes()[first_own(r) + kLogRatio] = -1.0 / sigma;
        rows.add((std::log(block.light / block.bulge) - value - log_ratio) / sigma);
      }
      rows.add_prior(first_own(r) + kLogRatio, log_ratio - lit.receiver.log_ratio,
                     lit.receiver.log_ratio_std);
    }
    add_priors(joint.light, start, rows);
    const Residuals linear = rows.with({}, free);
    Eigen::VectorXd all = packed(start);
    all(free) -= linear.information().ldlt().solve(linear.gradient());
    start = unpacked(all, joint.receivers.size());
  }
  return start;
}

Outcome<JointSolution> solve_joint(const JointProblem& joint, const JointUnknowns& start) {
  const std::vector<int> free = free_unknowns(joint);
  const std::size_t receivers = joint.receivers.size();
  Eigen::VectorXd all = packed(start);
  const auto outcome = descend(
      [&](const Eigen::VectorXd& value, bool with_slopes) {
        all(free) = value;
        return residuals(joint, unpacked(all, receivers), free, with_slopes);
      },
      all(free), kTolerance);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const Minimum& minimum = std::get<Minimum>(outcome);
  const auto covariance = inverse_information(minimum.information);
  if (!covariance) return Miss::unobservable;
  all(free) = minimum.unknowns;
  JointSolution solution;
  solution.unknowns = unpacked(all, receivers);
  solution.covariance.setZero(all.size(), all.size());
  solution.covariance(free, free) = *covariance;
  solution.errors = errors_of(joint, solution.unknowns);
  return solution;
}

}  // namespace vildar
