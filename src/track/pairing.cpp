#include "track/pairing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace vildar {
namespace {

constexpr int kMemory = 15;  // frames of the running mean
constexpr int kLooksToJoin = 4;
constexpr int kSettledFrames = 15;  // a pair seen together that often is not rearranged
constexpr double kMostChi2ToJoin = 9.0;
constexpr double kMostChi2ToStay = 14.0;
constexpr double kMostChi2Counted = 50.0;
constexpr double kWorthOfPair = 14.0;  // against leaving two lamps alone
constexpr double kWorthOfStaying = 5.0;

bool fits_kind(const Lamp& a, const Lamp& b) {
  const LampKind ka = a.kind(), kb = b.kind();
  return ka == kb ? ka != LampKind::other : ka == LampKind::other || kb == LampKind::other;
}

bool is_free(const Lamp& lamp) {
  return !lamp.vehicle || !lamp.vehicle->left || !lamp.vehicle->right ||
         lamp.vehicle->both_seen < kSettledFrames;
}

bool is_mirrored(const Lamp& lamp) {
  constexpr int kLooks = 3;
  return lamp.mirrored.looks() >= kLooks && lamp.mirrored.share() > 0.5;
}

// Two lamps on one rigid body keep their vector but for the looming they share.
double moving_apart_chi2(const Lamp& a, const Lamp& b) {
  constexpr double kGive_per_s = 0.06, kRateGive_per_s = 0.3, kRateShare = 0.3;
  const Eigen::Vector2d apart_px = b.at_px() - a.at_px();
  const double length_px = apart_px.norm();
  if (!(length_px > 0.0)) return 0.0;
  const Eigen::Vector2d along = apart_px / length_px;
  const Eigen::Vector2d speed_pxps = b.velocity_pxps() - a.velocity_pxps();
  const double rate_per_s = 0.5 * (a.depth_rate_per_s() + b.depth_rate_per_s());
  const double sigma =
      std::hypot(a.velocity_sigma_pxps(), b.velocity_sigma_pxps(), kGive_per_s * length_px);
  const double sideways = (speed_pxps - along * along.dot(speed_pxps)).norm() / sigma;
  const double rate_sigma = kRateGive_per_s + kRateShare * std::abs(rate_per_s);
  const double stretch =
      (along.dot(speed_pxps) + rate_per_s * length_px) / std::hypot(sigma, rate_sigma * length_px);
  return sideways * sideways + stretch * stretch;
}

// The two lamps of a vehicle are alike but for beams, dirt and what clipping hides.
double unequal_chi2(const Lamp& a, const Lamp& b) {
  constexpr double kFluxSigmaLn = 0.8, kMost = 14.0;
  return std::min(kMost, std::pow((a.log_flux() - b.log_flux()) / kFluxSigmaLn, 2));
}

// A lamp of a pair that is no longer what it was when the pair was formed: it has gone over to a
// tail lamp, or to something that is lit.
bool has_changed(const Lamp& lamp, LampKind kind) {
  constexpr int kColourLooks = 4, kLampLooks = 15;
  constexpr double kRedShare = 0.6, kLampShare = 0.2;
  const bool turned_red = kind == LampKind::headlamp && lamp.red.looks() >= kColourLooks &&
                          lamp.red.share() > kRedShare;
  return turned_red ||
         (lamp.lamp_like.looks() >= kLampLooks && lamp.lamp_like.share() < kLampShare);
}

struct Choice {
  double worth = 0.0;
  std::vector<int> edges;
};

struct Edge {
  int a, b;
  double worth;
};

// Best set of edges without a shared end, by trying all; groups are small.
void best_matching(const std::vector<Edge>& edges, std::size_t next, std::vector<char>& used,
                   Choice& current, Choice& best) {
  if (current.worth > best.worth) best = current;
  double rest = 0.0;
  for (std::size_t e = next; e < edges.size(); ++e) rest += edges[e].worth;
  if (current.worth + rest <= best.worth) return;
  for (std::size_t e = next; e < edges.size(); ++e) {
    if (used[edges[e].a] || used[edges[e].b]) continue;
    used[edges[e].a] = used[edges[e].b] = 1;
    current.worth += edges[e].worth;
    current.edges.push_back(static_cast<int>(e));
    best_matching(edges, e + 1, used, current, best);
    current.edges.pop_back();
    current.worth -= edges[e].worth;
    used[edges[e].a] = used[edges[e].b] = 0;
  }
}

// Fog lamps below headlamps, and a bus's roof lights above them, look like a second pair, nearer or
// farther; but no two vehicles stand so close behind one another.
bool same_body(const Vehicle& vehicle, const Eigen::Vector2d& middle_px, double width_per_depth,
               const RoadView& view) {
  constexpr double kShortestGap_m = 6.5, kUnder_m = 1.0, kOver_m = 3.0, kOffMiddle_m = 0.4,
                   kOffMiddleHigh_m = 0.9, kHighCamera_m = 2.0, kMargin_m = 0.15;
  const Eigen::Vector2d own_px = 0.5 * (vehicle.left->at_px() + vehicle.right->at_px());
  const LampPlace at = view.place(own_px);
  Eigen::Matrix2d axes;
  axes << at.across_px, at.down_px;
  if (!(std::abs(axes.determinant()) > 1e-9)) return false;
  const double inverse_depth = vehicle.inverse_depth_per_m;
  const Eigen::Vector2d off_m = axes.inverse() * (middle_px - own_px) / inverse_depth;
  const bool high = view.height_over_lamps_m() > kHighCamera_m;
  if (off_m.y() > kUnder_m || off_m.y() < -kOver_m) return false;
  const double ratio = width_per_depth / vehicle.width_per_depth;
  // Seen from low down, what stands behind a vehicle and between its lamps is hidden.
  const double half_m = 0.5 * vehicle.width_per_depth / inverse_depth;
  if (!high && std::abs(off_m.x()) + half_m * ratio < half_m + kMargin_m) return true;
  if (std::abs(off_m.x()) > (high ? kOffMiddleHigh_m : kOffMiddle_m)) return false;
  if (ratio < (high ? 0.4 : 0.6) || ratio > 1.6) return false;
  const double gap_m =
      high ? 1.0 / view.place(middle_px).inverse_depth_per_m - 1.0 / at.inverse_depth_per_m
           : (1.0 / ratio - 1.0) / inverse_depth;
  return std::abs(gap_m) < kShortestGap_m;
}

}  // namespace

void Pairing::look_at_pairs(const Lamps& lamps, std::int64_t frame) {
  constexpr double kSigmaShare = 0.7, kUnknownKind = 2.0;
  constexpr double kLaneSigma_m = 0.9, kMostLane = 4.0;
  const double widest = 2.8 * view_.focal_px();
  for (std::size_t i = 0; i < lamps.size(); ++i) {
    Lamp& a = *lamps[i];
    if (!a.seen_at(frame) || !is_free(a) || is_mirrored(a) || a.sightings() < 2) continue;
    for (std::size_t j = i + 1; j < lamps.size(); ++j) {
      Lamp& b = *lamps[j];
      if (!b.seen_at(frame) || !is_free(b) || is_mirrored(b) || b.sightings() < 2) continue;
      const Eigen::Vector2d vector_px = b.at_px() - a.at_px();
      const double nearest = std::max(a.place().inverse_depth_per_m, b.place().inverse_depth_per_m);
      const double level_px = std::abs(vector_px.dot(a.place().across_px.unitOrthogonal()));
      const bool worth_a_look = vector_px.norm() < widest * std::max(nearest, 1.0 / 15.0) &&
                                level_px < 4.0 + 0.35 * vector_px.norm() && fits_kind(a, b);
      if (!worth_a_look) continue;

      const double sigma_px = std::hypot(0.6, a.position_sigma_px(), b.position_sigma_px());
      const PairFit fit = view_.fit_pair(a.at_px(), b.at_px(), kSigmaShare * sigma_px);
      double chi2 = fit.chi2 + moving_apart_chi2(a, b);
      chi2 += unequal_chi2(a, b);
      if (a.kind() != b.kind()) chi2 += kUnknownKind;
      const Eigen::Vector2d middle_px = 0.5 * (a.at_px() + b.at_px());
      const double lateral_m = view_.road_at(middle_px, fit.inverse_depth_per_m).lateral_m;
      if (const auto off_m = view_.off_lane_centre_m(lateral_m))
        chi2 +=
            std::min(kMostLane, std::pow(*off_m / std::hypot(kLaneSigma_m, 0.15 * lateral_m), 2));
      Evidence* known = evidence_of(&a, &b);
      if (!known) {
        if (!(chi2 < kMostChi2Counted)) continue;
        known = &evidence_.emplace_back(Evidence{&a, &b});
      }
      known->looks = std::min(known->looks + 1, kMemory);
      known->chi2 += (std::min(chi2, kMostChi2Counted) - known->chi2) / known->looks;
      known->inverse_depth_per_m = fit.inverse_depth_per_m;
      known->width_per_depth = fit.width_per_depth;
      known->last_frame = frame;
    }
  }
}

Pairing::Evidence* Pairing::evidence_of(const Lamp* a, const Lamp* b) {
  for (Evidence& pair : evidence_)
    if ((pair.a == a && pair.b == b) || (pair.a == b && pair.b == a)) return &pair;
  return nullptr;
}

std::vector<Pairing::Evidence*> Pairing::best_pairs(std::int64_t frame) {
  constexpr std::size_t kMostTried = 14;
  std::vector<Evidence*> candidates;
  std::vector<Lamp*> lamps;
  std::vector<Edge> edges;
  const auto index_of = [&](Lamp* lamp) {
    const auto found = std::find(lamps.begin(), lamps.end(), lamp);
    if (found != lamps.end()) return static_cast<int>(found - lamps.begin());
    lamps.push_back(lamp);
    return static_cast<int>(lamps.size()) - 1;
  };
  for (Evidence& pair : evidence_) {
    const bool together = pair.a->vehicle && pair.a->vehicle == pair.b->vehicle;
    const bool recent = pair.last_frame == frame || together;
    if (!recent || pair.looks < kLooksToJoin || !is_free(*pair.a) || !is_free(*pair.b)) continue;
    if (!together && (pair.chi2 > kMostChi2ToJoin || !fits_kind(*pair.a, *pair.b))) continue;
    const double worth = kWorthOfPair - pair.chi2 + (together ? kWorthOfStaying : 0.0);
    if (worth <= 0.0) continue;
    candidates.push_back(&pair);
    edges.push_back({index_of(pair.a), index_of(pair.b), worth});
  }

  // Groups of lamps linked by candidate pairs; each is solved on its own.
  std::vector<int> group(lamps.size());
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = static_cast<int>(i);
  for (bool changed = true; changed;) {
    changed = false;
    for (const Edge& edge : edges) {
      const int low = std::min(group[edge.a], group[edge.b]);
      changed |= group[edge.a] != low || group[edge.b] != low;
      group[edge.a] = group[edge.b] = low;
    }
  }
  std::vector<Evidence*> chosen;
  std::vector<char> used(lamps.size(), 0);
  for (std::size_t g = 0; g < group.size(); ++g) {
    std::vector<Edge> own;
    std::vector<Evidence*> own_pairs;
    for (std::size_t e = 0; e < edges.size(); ++e)
      if (group[edges[e].a] == static_cast<int>(g)) {
        own.push_back(edges[e]);
        own_pairs.push_back(candidates[e]);
      }
    Choice best;
    if (own.size() <= kMostTried) {
      Choice current;
      best_matching(own, 0, used, current, best);
    } else {  // too many to try all: best edge first
      std::vector<int> order(own.size());
      for (std::size_t e = 0; e < order.size(); ++e) order[e] = static_cast<int>(e);
      std::sort(order.begin(), order.end(),
                [&](int a, int b) { return own[a].worth > own[b].worth; });
      for (const int e : order)
        if (!used[own[e].a] && !used[own[e].b]) {
          used[own[e].a] = used[own[e].b] = 1;
          best.edges.push_back(e);
        }
    }
    for (const int e : best.edges) chosen.push_back(own_pairs[e]);
  }
  return chosen;
}

void Pairing::join(Evidence& pair, Vehicles& vehicles, std::int64_t frame) {
  Vehicle* vehicle = pair.a->vehicle ? pair.a->vehicle : pair.b->vehicle;
  const bool a_is_left = pair.a->at_px().x() < pair.b->at_px().x();
  Lamp* left = a_is_left ? pair.a : pair.b;
  Lamp* right = a_is_left ? pair.b : pair.a;
  if (vehicle) {  // the lost lamp must have stood on the side where the new one is
    const bool fits =
        vehicle->left == left ? !vehicle->right : vehicle->right == right && !vehicle->left;
    constexpr double kMostStretch = 1.4;
    const double stretch = pair.width_per_depth / pair.inverse_depth_per_m /
                           (vehicle->width_per_depth / vehicle->inverse_depth_per_m);
    if (!fits || (pair.a->vehicle && pair.b->vehicle) || stretch > kMostStretch ||
        stretch < 1.0 / kMostStretch)
      return;
  } else {
    const Eigen::Vector2d middle_px = 0.5 * (left->at_px() + right->at_px());
    for (const auto& other : vehicles)
      if (other->left && other->right &&
          same_body(*other, middle_px, pair.width_per_depth, view_) &&
          !outshines(*left, *right, *other)) {
        left->on_vehicle.add(true, kMemory);
        right->on_vehicle.add(true, kMemory);
        return;
      }
    vehicle = vehicles.emplace_back(std::make_unique<Vehicle>()).get();
    vehicle->kind = left->kind() != LampKind::other ? left->kind() : right->kind();
  }
  vehicle->left = left;
  vehicle->right = right;
  left->vehicle = right->vehicle = vehicle;
  vehicle->chi2 = pair.chi2;
  vehicle->inverse_depth_per_m = pair.inverse_depth_per_m;
  vehicle->width_per_depth = pair.width_per_depth;
  vehicle->last_both = vehicle->last_good = frame;
  vehicle->last_both_time = left->records.back().time;
}

void Pairing::refresh(Vehicles& vehicles, std::int64_t frame, CameraTime time) {
  constexpr double kShortlyAlone_s = 1.0, kLongestAlone_s = 4.0, kCrossed_px = 2.0;
  constexpr std::int64_t kNoticed = 6;  // frames it takes to see that a lamp has changed
  for (const auto& vehicle : vehicles) {
    Lamp* left = vehicle->left;
    Lamp* right = vehicle->right;
    const bool both = left && right && left->seen_at(frame) && right->seen_at(frame);
    if (both) {
      const PairFit fit = view_.fit_pair(left->at_px(), right->at_px(), 1.0);
      const double chi2 = std::min(kMostChi2Counted, fit.chi2 + moving_apart_chi2(*left, *right) +
                                                         unequal_chi2(*left, *right));
      vehicle->chi2 += (chi2 - vehicle->chi2) / kMemory;
      vehicle->inverse_depth_per_m = fit.inverse_depth_per_m;
      vehicle->width_per_depth = fit.width_per_depth;
      ++vehicle->both_seen;
      vehicle->last_both = frame;
      vehicle->last_both_time = time;
      if (std::max(vehicle->chi2, chi2) < kMostChi2ToJoin) vehicle->last_good = frame;
      const bool crossed = left->at_px().x() > right->at_px().x() + kCrossed_px;
      if (has_changed(*left, vehicle->kind) || has_changed(*right, vehicle->kind))
        vehicle->cut_after = std::min(vehicle->last_good, frame - kNoticed);
      else if (crossed || vehicle->chi2 > kMostChi2ToStay) {
        vehicle->cut_after = vehicle->last_good;
        vehicle->came_apart = true;
      }
    } else {
      const double alone_s = seconds_of(time) - seconds_of(vehicle->last_both_time);
      const Lamp* lone = left ? left : right;
      if (alone_s > kLongestAlone_s ||
          (alone_s > kShortlyAlone_s && lone && has_changed(*lone, vehicle->kind)))
        vehicle->cut_after = vehicle->last_both;
    }
    if (left && right) vehicle->from_left_px = right->at_px() - left->at_px();
    if (!both) continue;
    for (const auto& other : vehicles) {
      if (other == vehicle || other->kind != vehicle->kind || !other->left || !other->right)
        continue;
      const Eigen::Vector2d middle_px = 0.5 * (left->at_px() + right->at_px());
      if (same_body(*other, middle_px, vehicle->width_per_depth, view_) &&
          !outshines(*left, *right, *other)) {
        ++vehicle->second_on_body;
        break;
      }
    }
  }
}

void Pairing::update(Lamps& lamps, Vehicles& vehicles, std::int64_t frame, CameraTime time) {
  look_at_pairs(lamps, frame);
  const std::vector<Evidence*> chosen = best_pairs(frame);
  // A young pair gives way when a better arrangement of all lamps leaves it out.
  for (const Evidence& pair : evidence_) {
    Vehicle* vehicle = pair.a->vehicle;
    if (!vehicle || vehicle != pair.b->vehicle || vehicle->both_seen >= kSettledFrames) continue;
    if (std::find(chosen.begin(), chosen.end(), &pair) != chosen.end()) continue;
    if (!vehicle->past_left.empty() || !vehicle->past_right.empty()) continue;
    pair.a->vehicle = pair.b->vehicle = nullptr;
    std::erase_if(vehicles, [&](const auto& one) { return one.get() == vehicle; });
  }
  for (Evidence* pair : chosen)
    if (!pair->a->vehicle || pair->a->vehicle != pair->b->vehicle) join(*pair, vehicles, frame);
  refresh(vehicles, frame, time);
}

void Pairing::forget(const Lamp* lamp) {
  std::erase_if(evidence_, [&](const Evidence& pair) { return pair.a == lamp || pair.b == lamp; });
}

}  // namespace vildar
