#include "estimate/common_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

namespace vildar {
namespace {

// A fit near its optimum, as linear in all its unknowns and in how unlike the photodiodes are: of
// their gains and angles little is known, and what they receive unlike where they stand is the last
// unknown.
struct Tangent {
  std::vector<int> moved;
  Eigen::LDLT<Eigen::MatrixXd> information;
  Eigen::VectorXd step;  // to the optimum, of `moved`
  std::vector<DelayModel::Line> lines;
};

Tangent tangent(const DelayModel& model, const DelayRows& rows, const LightFit& fit) {
  Tangent found;
  const DelayModel::Point point = model.at(fit.value, true);
  const auto unlike = static_cast<int>(fit.value.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unlike + 1, unlike + 1);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unlike + 1);
  information.topLeftCorner(unlike, unlike) = point.information;
  gradient.head(unlike) = point.gradient;
  found.moved = model.free(fit.moves);
  for (int k = model.first_step(); k < unlike; ++k) {
    found.moved.push_back(k);
    information(k, k) += fit.step_precision;
    gradient[k] += fit.step_precision * fit.value[k];
  }
  constexpr double kGainStd = 0.3, kMostMismatch = 5.0;  // of a logarithm; of its sigma
  const auto free = [&](int parameter, const Uncertain& said, double std) {
    if (said.std > 0.0) {
      information(parameter, parameter) -= 1.0 / (said.std * said.std);
      gradient[parameter] -= (fit.value[parameter] - said.mean) / (said.std * said.std);
    }
    if (std::ranges::find(found.moved, parameter) == found.moved.end())
      found.moved.push_back(parameter);
    information(parameter, parameter) += 1.0 / (std * std);
  };
  free(kLogFarGain, fit.log_ratio, kGainStd);
  for (const int parameter : {kMismatch, kBend, kOrder}) free(parameter, {0.0, 1.0}, kMostMismatch);
  found.moved.push_back(unlike);
  information(unlike, unlike) += 1.0 / (kMostMismatch * kMostMismatch);
  information.col(unlike).head(unlike) = point.doubt;
  information.row(unlike).head(unlike) = point.doubt.transpose();
  for (const DelayRows::Row& row : rows.rows) {
    DelayModel::Line& line = found.lines.emplace_back();
    model.put_line(row, fit.value, line);
    const double slope = line.light * row.doubt, weight = 1.0 / (row.sigma * row.sigma);
    line.terms.push_back({unlike, slope});
    information(unlike, unlike) += weight * slope * slope;
    gradient[unlike] += weight * slope * line.beyond;
  }
  found.information.compute(information(found.moved, found.moved));
  found.step = -found.information.solve(gradient(found.moved));
  return found;
}

struct Explained {
  double chi2 = 0.0;
  Eigen::Vector2d power = Eigen::Vector2d::Zero();  // near, far
};

// By how much chi-square falls with such light, all else following.
Explained explained_by(const CommonLight& light, const DelayRows& rows, const Tangent& fit,
                       Eigen::Index unknowns) {
  Eigen::MatrixX2d across = Eigen::MatrixX2d::Zero(unknowns + 1, 2);
  Eigen::Vector2d own = Eigen::Vector2d::Zero(), gradient = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const DelayRows::Row& row = rows.rows[i];
    const double share = light.share(row.tau_s);
    if (share == 0.0) continue;
    const Eigen::Index side = row.far ? 1 : 0;
    const double weighed = share / (row.sigma * row.sigma);
    own[side] += weighed * share;
    gradient[side] += weighed * fit.lines[i].beyond;
    for (const DelayModel::Term& term : fit.lines[i].terms)
      across(term.parameter, side) += weighed * term.slope;
  }
  constexpr double kLeastTold = 1e-6;  // of what the light alone would tell
  const Eigen::MatrixX2d both = across(fit.moved, Eigen::all);
  Eigen::Matrix2d information = -both.transpose() * fit.information.solve(both);
  information.diagonal() += (1.0 + kLeastTold) * own;
  if (!(own.minCoeff() > 0.0)) return {};
  const Eigen::Vector2d pull = gradient + both.transpose() * fit.step;
  Explained found;
  found.power = -information.ldlt().solve(pull);
  found.chi2 = -pull.dot(found.power);
  return found;
}

bool is_alike(const Eigen::Vector2d& power) {
  constexpr double kLeast = 0.05;  // of the brighter
  return power[0] * power[1] > 0.0 &&
         power.cwiseAbs().minCoeff() > kLeast * power.cwiseAbs().maxCoeff();
}

// What noise alone exceeds for one vehicle in five hundred. An acceleration that wanders does so
// between its steps, too, and passes for light.
double clear_chi2(const LightFit& fit) {
  constexpr double kClear = 25.0, kWanders_mps2 = 0.5;
  const double wanders_mps2 = fit.step_precision > 0.0 ? 1.0 / std::sqrt(fit.step_precision) : 0.0;
  return kClear * (1.0 + wanders_mps2 / kWanders_mps2);
}

}  // namespace

std::optional<FoundLight> find_common_light(const DelayModel& model, const DelayRows& rows,
                                            const LightFit& fit) {
  constexpr std::array kWidths_s{0.005, 0.012, 0.03, 0.07};
  const double least_chi2 = clear_chi2(fit);
  const Tangent near = tangent(model, rows, fit);
  FoundLight best{{}, least_chi2};
  for (const double width_s : kWidths_s) {
    const double apart_s = std::max(0.5 * width_s, rows.block_s);
    for (double tau_s = rows.first_s; tau_s < rows.last_s; tau_s += apart_s) {
      const CommonLight light{tau_s, width_s};
      const Explained found = explained_by(light, rows, near, fit.value.size());
      const double chi2 = found.chi2 / fit.noise_factor;
      if (chi2 > best.chi2 && is_alike(found.power)) best = {light, chi2};
    }
  }
  return best.chi2 > least_chi2 ? std::optional(best) : std::nullopt;
}

}  // namespace vildar
