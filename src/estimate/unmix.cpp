#include "estimate/unmix.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>

#include "estimate/joint_cost.h"
#include "estimate/power_blocks.h"
#include "optics/channel.h"

namespace vildar {
namespace {

constexpr std::size_t kFewestBlocks = 20;
// ln of a gain is near enough a broken line in ln D: knots this far apart, between which it changes
// by this share, and by this much per radian squared, beside what the headlamps' shapes make of it.
constexpr double kKnots_nat = 0.15, kStep = 0.03, kWidth = 1.5;
constexpr double kEdge_rad = 0.45;    // a beam is modelled up to this azimuth
constexpr double kPast_m = 2.0;       // and dark from here on behind the photodiode
constexpr double kUnmodelled = 0.01;  // of the light
constexpr double kFarthest_m = 300.0;

// How lamps may be unlike the law throughout: a width, a tilt and another exponent.
constexpr std::size_t kShapes = 3;
using Shapes = std::array<double, kShapes>;

struct Law {
  double exponent = 2.0, exponent_std = 0.0, cosine_exponent = 0.0;

  explicit Law(const ChannelSite& channel)
      : exponent(channel.path_loss_exponent->mean), exponent_std(channel.path_loss_exponent->std) {
    if (channel.half_power_angle_rad)
      cosine_exponent = lambertian_order(Radians(*channel.half_power_angle_rad)) + 1.0;
  }
};

// One vehicle's light at gain one in every block, where between two knots that lies, and in which
// blocks it is too far to the side for a model.
struct Shine {
  std::vector<double> light, knot;
  std::vector<bool> beside;
  double nearest = INFINITY, farthest = -INFINITY;  // knots
  double across_m = 0.0, below_m = 0.0;
  Eigen::Index first = 0;  // of its unknowns, the knots' gains and then the shapes
  double gain = 0.0;
  std::vector<double> gains;  // of the knots, about which the fit is linear

  bool shines() const { return farthest >= nearest; }
  Eigen::Index knots() const {
    return static_cast<Eigen::Index>(std::floor(farthest) - std::floor(nearest)) + 2;
  }
  Eigen::Index unknowns() const { return knots() + static_cast<Eigen::Index>(kShapes); }
  // Azimuth squared, elevation and ln D at a knot.
  Shapes shapes(Eigen::Index index) const {
    const double log_distance = kKnots_nat * (std::floor(nearest) + static_cast<double>(index));
    const double distance_m = std::exp(log_distance);
    return {std::pow(std::min(kEdge_rad, across_m / distance_m), 2), below_m / distance_m,
            log_distance};
  }
};

Shine shine_of(const Trajectory& way, const Law& law, const Eigen::Vector3d& receiver_m,
               const std::vector<PowerBlock>& blocks) {
  Shine shine;
  const bool oncoming = way.at(way.to_s).range_m < way.at(way.from_s).range_m;
  for (const PowerBlock& block : blocks) {
    const MotionState state = way.at(block.time_s);
    const Eigen::Vector3d apart_m =
        Eigen::Vector3d(state.range_m, state.lateral_m, way.lamp_height_m()) - receiver_m;
    const double distance_m = apart_m.norm();
    const double on_mps = oncoming ? state.over_ground_mps : -state.over_ground_mps;
    const bool ahead = apart_m.x() > 0.0 && on_mps > 0.0;
    const bool beside =
        apart_m.x() > -kPast_m && std::abs(apart_m.y()) > std::tan(kEdge_rad) * apart_m.x();
    const bool shines = ahead && !beside && distance_m < kFarthest_m;
    shine.light.push_back(shines ? std::pow(distance_m, -law.exponent) *
                                       std::pow(apart_m.x() / distance_m, law.cosine_exponent)
                                 : 0.0);
    const double knot = std::log(distance_m) / kKnots_nat;
    shine.knot.push_back(knot);
    shine.beside.push_back(beside);
    shine.across_m = std::abs(apart_m.y());
    shine.below_m = -apart_m.z();
    if (!shines) continue;
    shine.nearest = std::min(shine.nearest, knot);
    shine.farthest = std::max(shine.farthest, knot);
  }
  return shine;
}

// The blocks and all that is fitted to them: the ambient level first, then each vehicle's knots.
struct Mixture {
  std::vector<PowerBlock> blocks;
  std::vector<Shine> shines;
  Shapes shape_std{};
  Eigen::Index unknowns = 1;
  Eigen::VectorXd sigma_w;

  // Whether a vehicle other than `own` is beside the photodiode.
  bool beside(std::size_t block, std::size_t own) const {
    for (std::size_t j = 0; j < shines.size(); ++j)
      if (j != own && shines[j].beside[block]) return true;
    return false;
  }
};
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

// What one vehicle's unknowns bring to a block.
template <class Visit>
void visit(const Shine& shine, std::size_t block, Visit add) {
  if (!(shine.light[block] > 0.0)) return;
  const double place = shine.knot[block] - std::floor(shine.nearest);
  const double share = place - std::floor(place);
  const auto knot = shine.first + static_cast<Eigen::Index>(std::floor(place));
  add(knot, (1.0 - share) * shine.light[block]);
  add(knot + 1, share * shine.light[block]);
}

// First guess: constant gains, none below zero.
void guess_gains(Mixture& mix, double ambient_w) {
  const auto n = static_cast<Eigen::Index>(mix.blocks.size());
  const auto count = static_cast<Eigen::Index>(mix.shines.size());
  Eigen::MatrixXd light(n, count);
  Eigen::VectorXd power(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto block = static_cast<std::size_t>(i);
    if (mix.beside(block, kNone)) {
      light.row(i).setZero();
      power[i] = 0.0;
      continue;
    }
    power[i] = (mix.blocks[block].power_w - ambient_w) / mix.sigma_w[i];
    for (Eigen::Index j = 0; j < count; ++j)
      light(i, j) = mix.shines[static_cast<std::size_t>(j)].light[block] / mix.sigma_w[i];
  }
  // Coordinate descent keeps every gain at zero or above.
  constexpr int kRounds = 50;
  Eigen::VectorXd gains = Eigen::VectorXd::Zero(count);
  for (int round = 0; round < kRounds; ++round)
    for (Eigen::Index j = 0; j < count; ++j) {
      const double square = light.col(j).squaredNorm();
      if (!(square > 0.0)) continue;
      const double step = light.col(j).dot(power - light * gains) / square;
      gains[j] = std::max(0.0, gains[j] + step);
    }
  constexpr double kDimmest = 0.1;  // of the brightest
  for (Eigen::Index j = 0; j < count; ++j)
    mix.shines[static_cast<std::size_t>(j)].gain = std::max(gains[j], kDimmest * gains.maxCoeff());
}

struct Fitted {
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
  double misfit = 0.0;  // chi-square of blocks and steps, per block
};

// Linear about the gains of `mix`.
Fitted fit(const Mixture& mix, double ambient_w, double ambient_std_w) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(mix.unknowns, mix.unknowns);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(mix.unknowns);
  const auto add = [&](const std::vector<std::pair<Eigen::Index, double>>& row, double value) {
    for (const auto& [a, of_a] : row) {
      gradient[a] += of_a * value;
      for (const auto& [b, of_b] : row) information(a, b) += of_a * of_b;
    }
  };
  std::vector<std::vector<std::pair<Eigen::Index, double>>> rows;
  std::vector<double> values;
  rows.push_back({{0, 1.0 / ambient_std_w}});
  values.push_back(ambient_w / ambient_std_w);
  for (const Shine& shine : mix.shines) {
    constexpr double kLevel = 2.0;  // of a gain, relative to the first guess
    if (!shine.shines()) continue;
    rows.push_back({{shine.first, 1.0 / (kLevel * shine.gain)}});
    values.push_back(1.0 / kLevel);
    const Eigen::Index first_shape = shine.first + shine.knots();
    for (std::size_t k = 0; k < kShapes; ++k) {  // a shape of no std has no say below
      const double weight = mix.shape_std[k] > 0.0 ? 1.0 / mix.shape_std[k] : 1.0;
      rows.push_back({{first_shape + static_cast<Eigen::Index>(k), weight}});
      values.push_back(0.0);
    }
    for (Eigen::Index k = 1; k < shine.knots(); ++k) {
      const Shapes before = shine.shapes(k - 1), here = shine.shapes(k);
      const double step = std::hypot(kStep, kWidth * (before[0] - here[0]));
      const double gain = shine.gains[static_cast<std::size_t>(k)];
      const double gain_before = shine.gains[static_cast<std::size_t>(k - 1)];
      auto& row = rows.emplace_back();
      row.emplace_back(shine.first + k, 1.0 / (step * gain));
      row.emplace_back(shine.first + k - 1, -1.0 / (step * gain_before));
      for (std::size_t of = 0; of < kShapes; ++of)
        if (mix.shape_std[of] > 0.0)
          row.emplace_back(first_shape + static_cast<Eigen::Index>(of),
                           (here[of] - before[of]) / step);
      values.push_back(-std::log(gain / gain_before) / step);
    }
  }
  for (std::size_t i = 0; i < mix.blocks.size(); ++i) {
    if (mix.beside(i, kNone)) continue;
    const double sigma_w = mix.sigma_w[static_cast<Eigen::Index>(i)];
    auto& row = rows.emplace_back();
    row.emplace_back(0, 1.0 / sigma_w);
    for (const Shine& shine : mix.shines)
      visit(shine, i, [&](Eigen::Index k, double light) { row.emplace_back(k, light / sigma_w); });
    values.push_back(mix.blocks[i].power_w / sigma_w);
  }
  for (std::size_t i = 0; i < rows.size(); ++i) add(rows[i], values[i]);
  // Scaled to a unit diagonal: gains and the ambient level differ by many orders.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * information * scale.asDiagonal());
  Fitted fitted;
  fitted.value = scale.asDiagonal() * solver.solve(scale.cwiseProduct(gradient));
  fitted.covariance = scale.asDiagonal() *
                      solver.solve(Eigen::MatrixXd::Identity(mix.unknowns, mix.unknowns)) *
                      scale.asDiagonal();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    double error = values[i];
    for (const auto& [k, weight] : rows[i]) error -= weight * fitted.value[k];
    fitted.misfit += error * error / static_cast<double>(mix.blocks.size());
  }
  return fitted;
}

// Again about the gains found, which change by a factor of e in a step at most.
Fitted fit_to_rest(Mixture& mix, double ambient_w, double ambient_std_w) {
  constexpr int kRounds = 6;
  for (Shine& shine : mix.shines)
    if (shine.shines()) shine.gains.assign(static_cast<std::size_t>(shine.knots()), shine.gain);
  Fitted fitted = fit(mix, ambient_w, ambient_std_w);
  for (int round = 1; round < kRounds; ++round) {
    for (Shine& shine : mix.shines)
      for (std::size_t k = 0; k < shine.gains.size(); ++k)
        shine.gains[k] =
            std::clamp(fitted.value[shine.first + static_cast<Eigen::Index>(k)],
                       shine.gains[k] / std::numbers::e, shine.gains[k] * std::numbers::e);
    fitted = fit(mix, ambient_w, ambient_std_w);
  }
  return fitted;
}

// Light of the others in a block, and its sigma.
struct Others {
  double light_w = 0.0, sigma_w = 0.0;
};

std::vector<Others> others_in(const Mixture& mix, std::size_t own, const Fitted& fitted) {
  std::vector<Others> found(mix.blocks.size());
  for (std::size_t i = 0; i < mix.blocks.size(); ++i) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(mix.unknowns);
    for (std::size_t j = 0; j < mix.shines.size(); ++j)
      if (j != own) visit(mix.shines[j], i, [&](Eigen::Index k, double light) { row[k] += light; });
    found[i] = {row.dot(fitted.value), std::sqrt(std::max(0.0, row.dot(fitted.covariance * row)))};
  }
  return found;
}

}  // namespace

Outcome<PowerTrace> own_light(const PowerTrace& trace, const Site& site,
                              std::span<const Trajectory* const> vehicles, std::size_t own,
                              double from_s, double to_s) {
  constexpr double kWorstMisfit = 2.0, kKnownTo = 0.03;
  if (!site.channel || !site.channel->beam.empty() || !site.channel->path_loss_exponent)
    return Miss::no_scale;
  const PhotodiodeSite& diode = site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  const double offset_s = diode.time_offset_s.mean, block_s = 1.0 / site.mains_hz;
  Mixture mix;
  mix.blocks = block_means(trace, from_s - offset_s, to_s - offset_s, block_s, offset_s);
  if (mix.blocks.size() < kFewestBlocks) return Miss::too_few_samples;
  mix.sigma_w.resize(static_cast<Eigen::Index>(mix.blocks.size()));
  for (std::size_t i = 0; i < mix.blocks.size(); ++i)
    mix.sigma_w[static_cast<Eigen::Index>(i)] =
        std::hypot(mix.blocks[i].sigma_w,
                   kUnmodelled * std::max(0.0, mix.blocks[i].power_w - trace.ambient_w));
  const Eigen::Vector3d receiver_m(diode.position_m[0].mean, diode.position_m[1].mean,
                                   diode.position_m[2].mean);
  const Law law(*site.channel);
  mix.shape_std = {beam_prior_std(kBeamWidth), beam_prior_std(kBeamTilt), law.exponent_std};
  for (const Trajectory* way : vehicles) {
    mix.shines.push_back(shine_of(*way, law, receiver_m, mix.blocks));
    Shine& shine = mix.shines.back();
    shine.first = mix.unknowns;
    if (shine.shines()) mix.unknowns += shine.unknowns();
  }
  guess_gains(mix, trace.ambient_w);
  if (!(mix.shines[own].gain > 0.0)) return Miss::below_noise;
  const Fitted fitted = fit_to_rest(mix, trace.ambient_w,
                                    std::max(trace.ambient_sigma_w, 0.05 * trace.noise_sigma_w));
  if (!(fitted.misfit < kWorstMisfit)) return Miss::bad_fit;

  const std::vector<Others> others = others_in(mix, own, fitted);
  PowerTrace alone{trace, {}, {}};
  double most_sigma_w = 0.0;
  std::size_t sample = 0;
  for (std::size_t i = 0; i < mix.blocks.size(); ++i) {
    const PowerBlock& block = mix.blocks[i];
    const double own_w = std::max(0.0, block.power_w - fitted.value[0] - others[i].light_w);
    if (mix.beside(i, own) || others[i].sigma_w > kKnownTo * own_w + block.sigma_w) continue;
    most_sigma_w = std::max(most_sigma_w, others[i].sigma_w);
    const double begin_s = block.time_s - offset_s - 0.5 * block_s;
    while (sample < trace.time_s.size() && trace.time_s[sample] < begin_s) ++sample;
    for (; sample < trace.time_s.size() && trace.time_s[sample] < begin_s + block_s; ++sample) {
      // Between the middles of blocks, so that no step is left.
      const double away = (trace.time_s[sample] + offset_s - block.time_s) / block_s;
      const std::size_t next =
          away > 0.0 ? std::min(i + 1, others.size() - 1) : i - std::min<std::size_t>(i, 1);
      const double others_w =
          others[i].light_w + std::abs(away) * (others[next].light_w - others[i].light_w);
      alone.time_s.push_back(trace.time_s[sample]);
      alone.power_w.push_back(trace.power_w[sample] - static_cast<float>(others_w));
    }
  }
  alone.ambient_sigma_w = std::hypot(trace.ambient_sigma_w, most_sigma_w);
  return alone;
}

}  // namespace vildar
