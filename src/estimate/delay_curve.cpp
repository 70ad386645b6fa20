#include "estimate/delay_curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace vildar {
namespace {

constexpr std::array<int, 7> kPieces{9, 14, 21, 32, 48, 72, 108};
constexpr double kMostPieces = 0.25, kMostHalved = 0.4;  // of the rows

// Time and relative rise and fall of the near pulse so far: its root up to the peak, and beyond it
// what it has lost. Only ever grows, so noise adds nothing to it.
std::vector<std::pair<double, double>> rise_of(const DelayRows& rows) {
  std::vector<std::pair<double, double>> path;
  for (const DelayRows::Row& row : rows.rows)
    if (!row.far) path.emplace_back(row.tau_s, row.root);
  const auto peak = std::max_element(
      path.begin(), path.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const double top = peak->second;
  for (auto at = path.begin(); at != peak; ++at)
    if (at != path.begin()) at->second = std::max(at->second, std::prev(at)->second);
  double highest_later = 0.0;
  for (auto at = std::prev(path.end()); at > peak; --at) {
    highest_later = std::max(highest_later, at->second);
    at->second = 2.0 * top - highest_later;
  }
  return path;
}

// The best that these pieces do, with constant acceleration; from a point of other pieces, if one
// is given.
std::optional<DelayCurve> fit_pieces(const DelayProblem& problem, const DelayRows& rows,
                                     std::vector<double> breaks, double delay_s,
                                     const Eigen::VectorXd& known) {
  constexpr int kMostIterations = 60;
  const DelayModel model(problem, rows, CubicSpline(breaks));
  Eigen::VectorXd start = model.start(delay_s);
  if (known.size() > 0) start.head<kDelayParameters>() = known.head<kDelayParameters>();
  // A mismatch that is to be found and an acceleration trade: each is tried first without the
  // other.
  std::vector<std::vector<int>> holds{{}};
  if (model.finds_mismatch())
    holds = {{kMismatch, kBend, kOrder}, {kAlpha}, {kLogFarGain, kMismatch, kBend, kOrder}};
  std::vector<DelayModel::Point> optima;
  for (const std::vector<int>& held : holds) {
    Eigen::VectorXd value = start;
    value(held).setZero();
    if (std::ranges::count(held, kLogFarGain) > 0) value[kLogFarGain] = problem.log_ratio.mean;
    value = model.minimise(value, false, 1).value;
    if (!held.empty()) value = model.minimise(value, true, kMostIterations, held).value;
    DelayModel::Point there = model.minimise(value, true, kMostIterations);
    if (there.converged) optima.push_back(std::move(there));
  }
  if (optima.empty()) return std::nullopt;
  std::ranges::sort(optima, {}, &DelayModel::Point::cost);
  DelayCurve found{
      .value = std::move(optima.front().value), .breaks = std::move(breaks), .others = {}};
  for (std::size_t k = 1; k < optima.size(); ++k)
    found.others.push_back(
        {std::move(optima[k].value), 2.0 * (optima[k].cost - optima.front().cost)});
  found.criterion = model.residuals(found.value).squaredNorm() + 2.0 * found.pieces();
  return found;
}

// What the pieces leave of their rows.
struct Leftover {
  std::vector<std::size_t> piece;       // of each row
  std::vector<double> squares, counts;  // of each piece

  // Whether it is more than noise leaves.
  bool poor(std::size_t at) const {
    constexpr double kSigmas = 4.0;
    return squares[at] > counts[at] + kSigmas * std::sqrt(2.0 * std::max(counts[at], 1.0));
  }
};

Leftover leftover(const DelayProblem& problem, const DelayRows& rows, const DelayCurve& known) {
  const DelayModel model(problem, rows, CubicSpline(known.breaks));
  const Eigen::VectorXd residuals = model.residuals(known.value);
  const auto pieces = static_cast<std::size_t>(known.pieces());
  Leftover found{{}, std::vector<double>(pieces), std::vector<double>(pieces)};
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const double way_s = model.way_s(rows.rows[i], known.value);
    const auto piece = static_cast<std::size_t>(
        std::upper_bound(known.breaks.begin() + 1, known.breaks.end() - 1, way_s) -
        known.breaks.begin() - 1);
    found.piece.push_back(piece);
    found.squares[piece] += std::pow(residuals[static_cast<Eigen::Index>(i)], 2);
    found.counts[piece] += 1.0;
  }
  return found;
}

// Halves of the pieces that are `asked` for, but where those would be shorter than a block.
template <class Asked>
std::vector<double> halved(const std::vector<double>& breaks, double block_s, const Asked& asked) {
  std::vector<double> finer{breaks.front()};
  for (std::size_t piece = 0; piece + 1 < breaks.size(); ++piece) {
    if (asked(piece) && breaks[piece + 1] - breaks[piece] > 2.0 * block_s)
      finer.push_back(0.5 * (breaks[piece] + breaks[piece + 1]));
    finer.push_back(breaks[piece + 1]);
  }
  return finer;
}

// Where few pieces are too long for bends of the light, what they leave would be taken for motion:
// rows there, and in the pieces beside, are as unsure as they scatter. Light that is unlike
// throughout stays as it is.
bool doubt_bends(const DelayProblem& problem, const DelayCurve& known, DelayRows& rows) {
  constexpr double kFew = 0.2;  // of the rows
  const Leftover left = leftover(problem, rows, known);
  std::vector<double> factors(left.squares.size(), 1.0);
  for (std::size_t piece = 0; piece < factors.size(); ++piece) {
    if (!left.poor(piece)) continue;
    const double factor = std::sqrt(left.squares[piece] / std::max(1.0, 0.5 * left.counts[piece]));
    for (std::size_t near = piece > 0 ? piece - 1 : 0;
         near <= std::min(piece + 1, factors.size() - 1); ++near)
      factors[near] = std::max(factors[near], factor);
  }
  double doubted = 0.0;
  for (const std::size_t piece : left.piece) doubted += factors[piece] > 1.0;
  if (doubted == 0.0 || doubted > kFew * static_cast<double>(rows.rows.size())) return false;
  for (std::size_t i = 0; i < rows.rows.size(); ++i) rows.rows[i].sigma *= factors[left.piece[i]];
  return true;
}

// Akaike's criterion goes on falling where the light bends sharply, as where a view fades out.
DelayCurve refined(const DelayProblem& problem, const DelayRows& rows, DelayCurve best,
                   double delay_s) {
  constexpr int kRounds = 8;
  const auto n = static_cast<double>(rows.rows.size());
  for (int round = 0; round < kRounds; ++round) {
    const Leftover left = leftover(problem, rows, best);
    std::vector<double> finer =
        halved(best.breaks, rows.block_s, [&](std::size_t piece) { return left.poor(piece); });
    if (finer.size() == best.breaks.size() || static_cast<double>(finer.size()) > kMostHalved * n)
      break;
    auto found = fit_pieces(problem, rows, std::move(finer), delay_s, best.value);
    if (!found || !(found->criterion < best.criterion)) break;
    best = std::move(*found);
  }
  return best;
}

// Constant acceleration, and twice as many pieces as lower Akaike's information criterion: those
// are the best for the light, but the bends that they smooth off it under noise pass for motion.
Outcome<DelayCurve> steady_curve(const DelayProblem& problem, const DelayRows& rows,
                                 double delay_s) {
  std::optional<DelayCurve> best;
  int worse = 0;
  bool tried = false;
  const auto n = static_cast<double>(rows.rows.size());
  Eigen::VectorXd last;
  for (const int pieces : kPieces) {
    if (static_cast<double>(pieces) > kMostPieces * n) break;
    tried = true;
    auto found = fit_pieces(problem, rows, delay_breaks(rows, delay_s, pieces), delay_s, last);
    if (!found) continue;
    last = found->value;
    if (best && !(found->criterion < best->criterion)) {
      constexpr int kEnoughWorse = 2;
      if (++worse == kEnoughWorse) break;
      continue;
    }
    worse = 0;
    best = std::move(found);
  }
  if (!best) return tried ? Miss::not_converged : Miss::too_few_samples;
  DelayCurve chosen = refined(problem, rows, std::move(*best), delay_s);
  std::vector<double> finer = halved(chosen.breaks, rows.block_s, [](std::size_t) { return true; });
  if (static_cast<double>(finer.size()) > kMostHalved * n) return chosen;
  auto found = fit_pieces(problem, rows, std::move(finer), delay_s, chosen.value);
  return found ? *found : chosen;
}

}  // namespace

std::vector<double> delay_breaks(const DelayRows& rows, double delay_s, int pieces) {
  constexpr double kRise = 1.5;  // pieces of the rise over those of the time
  auto path = rise_of(rows);     // u, share of the way
  const double span_s = rows.last_s - rows.first_s + delay_s;
  for (auto& [tau_s, share] : path) share = (tau_s - rows.first_s) / span_s + kRise * share;
  const double first = rows.first_s, last = rows.last_far_s + delay_s > rows.last_s
                                                ? rows.last_far_s + delay_s
                                                : rows.last_s;
  if (last > path.back().first) path.emplace_back(last, path.back().second + 1.0 / pieces);
  if (first < path.front().first) path.emplace(path.begin(), first, 0.0);
  std::vector<double> breaks{first};
  std::size_t i = 0;
  for (int piece = 1; piece < pieces; ++piece) {
    const double wanted = path.front().second + (path.back().second - path.front().second) *
                                                    static_cast<double>(piece) / pieces;
    while (i + 2 < path.size() && path[i + 1].second < wanted) ++i;
    const double share =
        std::clamp((wanted - path[i].second) / (path[i + 1].second - path[i].second), 0.0, 1.0);
    const double u = path[i].first + share * (path[i + 1].first - path[i].first);
    if (u > breaks.back() + rows.block_s && u < last - rows.block_s) breaks.push_back(u);
  }
  breaks.push_back(last);
  return breaks;
}

Outcome<DelayCurve> best_delay_curve(const DelayProblem& problem, DelayRows& rows, double delay_s) {
  auto outcome = steady_curve(problem, rows, delay_s);
  auto* known = std::get_if<DelayCurve>(&outcome);
  constexpr int kDoubts = 3;
  for (int round = 0; known && round < kDoubts && doubt_bends(problem, *known, rows); ++round)
    if (auto again = fit_pieces(problem, rows, known->breaks, delay_s, known->value))
      *known = std::move(*again);
  return outcome;
}

}  // namespace vildar
