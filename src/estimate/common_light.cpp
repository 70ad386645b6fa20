#include "estimate/common_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

namespace vildar {
namespace {

bool earlier(const DelayRows::Row& row, double tau_s) { return row.tau_s < tau_s; }

// Of a weighted sum over the rows of one side.
struct Told {
  Eigen::VectorXd of_unknowns;  // by the root of their covariance, so that a square is information
  double pull = 0.0, weight = 0.0;

  void add(double share, const Told& row) {
    of_unknowns += share * row.of_unknowns;
    pull += share * row.pull;
    weight += share * share * row.weight;
  }
};

// A fit near its optimum, as linear in all its unknowns and in how unlike the photodiodes are: of
// their gains and angles little is known, and what they receive unlike where they stand is the last
// unknown.
struct Tangent {
  std::vector<Told> rows;   // of power in one row: pull is what it misses at the optimum
  std::vector<Told> later;  // and in all rows of its side from that one on
};

// As it is at `fit`, and where the data ask for the optimum.
struct Linear {
  std::vector<int> moved;
  std::vector<DelayModel::Line> lines;
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

Linear linear(const DelayModel& model, const DelayRows& rows, const LightFit& fit) {
  Linear found;
  const DelayModel::Point point = model.at(fit.value, true);
  const auto unlike = static_cast<int>(fit.value.size());
  Eigen::MatrixXd& information = found.information;
  Eigen::VectorXd& gradient = found.gradient;
  information = Eigen::MatrixXd::Zero(unlike + 1, unlike + 1);
  gradient = Eigen::VectorXd::Zero(unlike + 1);
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
  return found;
}

Tangent tangent(const DelayModel& model, const DelayRows& rows, const LightFit& fit) {
  const Linear near = linear(model, rows, fit);
  const Eigen::LDLT<Eigen::MatrixXd> solver(near.information(near.moved, near.moved));
  Eigen::VectorXd step = Eigen::VectorXd::Zero(near.gradient.size());
  step(near.moved) = -solver.solve(near.gradient(near.moved));
  const auto count = static_cast<Eigen::Index>(rows.rows.size());
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(near.gradient.size(), count);
  std::vector<double> missed(rows.rows.size());
  for (std::size_t i = 0; i < missed.size(); ++i) {
    missed[i] = near.lines[i].beyond;
    for (const DelayModel::Term& term : near.lines[i].terms) {
      missed[i] += term.slope * step[term.parameter];
      slopes(term.parameter, static_cast<Eigen::Index>(i)) += term.slope;
    }
  }
  Eigen::MatrixXd roots =
      solver.transpositionsP() * Eigen::MatrixXd(slopes(near.moved, Eigen::all));
  solver.matrixL().solveInPlace(roots);
  Tangent found;
  for (std::size_t i = 0; i < missed.size(); ++i) {
    const double weight = 1.0 / (rows.rows[i].sigma * rows.rows[i].sigma);
    const auto root = roots.col(static_cast<Eigen::Index>(i)).array();
    const auto known = solver.vectorD().array();
    found.rows.push_back({weight * (known > 0.0).select(root / known.max(1e-300).sqrt(), 0.0),
                          weight * missed[i], weight});
  }
  found.later = found.rows;
  for (std::size_t i = found.later.size() - 1; i-- > 0;)
    if (rows.rows[i].far == rows.rows[i + 1].far) found.later[i].add(1.0, found.later[i + 1]);
  return found;
}

struct Explained {
  double chi2 = 0.0;
  Eigen::Vector2d power = Eigen::Vector2d::Zero();  // near, far
};

// By how much chi-square falls with such light, all else following.
Explained explained_by(const CommonLight& light, const DelayRows& rows, const Tangent& fit) {
  Eigen::MatrixX2d across(fit.rows.front().of_unknowns.size(), 2);
  Eigen::Vector2d own, pull;
  const auto far = std::ranges::find(rows.rows, true, &DelayRows::Row::far);
  for (const bool of_far : {false, true}) {
    const auto end = of_far ? rows.rows.end() : far;
    const auto [before, after] = light.between_s();
    const auto first = std::lower_bound(of_far ? far : rows.rows.begin(), end, before, earlier);
    const auto whole = std::lower_bound(first, end, after, earlier);
    const auto at = [&](auto row) { return static_cast<std::size_t>(row - rows.rows.begin()); };
    Told sum{Eigen::VectorXd::Zero(across.rows())};
    if (whole != end) sum = fit.later[at(whole)];
    for (auto row = first; row != whole; ++row) sum.add(light.share(row->tau_s), fit.rows[at(row)]);
    const Eigen::Index side = of_far ? 1 : 0;
    across.col(side) = sum.of_unknowns;
    own[side] = sum.weight;
    pull[side] = sum.pull;
  }
  constexpr double kLeastTold = 1e-6;  // of what the light alone would tell
  if (!(own.minCoeff() > 0.0)) return {};
  Eigen::Matrix2d information = -across.transpose() * across;
  information.diagonal() += (1.0 + kLeastTold) * own;
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
      const Explained found = explained_by(light, rows, near);
      const double chi2 = found.chi2 / fit.noise_factor;
      if (chi2 > best.chi2 && is_alike(found.power)) best = {light, chi2};
    }
  }
  return best.chi2 > least_chi2 ? std::optional(best) : std::nullopt;
}

}  // namespace vildar
