#include "track/pairing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/by_frame.h"
#include "track/heir.h"
#include "track/held_records.h"
#include "track/pair_likelihood.h"

namespace vildar {
namespace {

constexpr int kLooksKept = 15;  // frames of the running mean
constexpr int kLooksToJoin = 4;
constexpr double kMostChi2ToJoin = 13.0;
constexpr double kMostChi2ToStay = 17.0;
constexpr double kMostChi2Counted = 50.0;
// Looks at a pair are not independent of one another: only one in so many counts as one.
constexpr double kLooksPerFact = 3.0, kMostFacts = 3.0;
// Natural log odds: that two neighbours are one vehicle's before anything is seen of them, and that
// an arrangement which has held so far goes on.
constexpr double kPriorLogOdds = -0.5;
constexpr double kStayingLogOdds = 3.0;
constexpr int kYoung = 15;  // frames seen together
constexpr int kLong = 45;   // what was seen of a pair for so long is reported
constexpr double kMostShareOfRival = 0.5;
constexpr double kLeastLogOdds = -15.0;
// The body of a vehicle hides, from low down, whatever shines on the line between its lamps.
constexpr double kBetweenChi2 = 12.0;
constexpr double kHighAbove_m = 2.0;  // over the lamps

bool fits_kind(const Lamp& a, const Lamp& b) {
  const LampKind ka = a.kind(), kb = b.kind();
  return ka == kb ? ka != LampKind::other : ka == LampKind::other || kb == LampKind::other;
}

// In the middle of tail lamps a white light shines on the number plate, or is that in the own
// headlamps.
bool lights_plate(const Lamp& third, const Lamp& a, const Lamp& b) {
  constexpr double kOffMiddle = 0.2;  // of the distance between the lamps
  const Eigen::Vector2d off_px = third.at_px() - 0.5 * (a.at_px() + b.at_px());
  return off_px.norm() < kOffMiddle * (b.at_px() - a.at_px()).norm() &&
         a.kind() == LampKind::taillamp && b.kind() == LampKind::taillamp &&
         third.kind() != LampKind::taillamp;
}

bool is_mirrored(const Lamp& lamp) {
  constexpr int kLooks = 3;
  return lamp.mirrored.looks() >= kLooks && lamp.mirrored.share() > 0.5;
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

double log_odds_of(double per_look, int looks) {
  return kPriorLogOdds + per_look * std::min(kMostFacts, looks / kLooksPerFact);
}

double staying_log_odds(const Vehicle& vehicle) {
  return kStayingLogOdds * std::min(1.0, vehicle.both_seen / static_cast<double>(kYoung));
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
// farther; but no two vehicles stand so close behind one another, and the body of one hides what is
// behind it up to its roof.
bool same_body(const Vehicle& vehicle, const Eigen::Vector2d& middle_px, double width_per_depth,
               const RoadView& view) {
  constexpr double kShortestGap_m = 6.5, kUnder_m = 1.0, kOver_m = 3.0, kOffMiddle_m = 0.4,
                   kOffMiddleHigh_m = 0.9, kHalfBody_m = 1.6, kMargin_m = 0.15,
                   kRoofOverLamps_m = 0.5;
  const Eigen::Vector2d own_px = 0.5 * (vehicle.left->at_px() + vehicle.right->at_px());
  const LampPlace at = view.place(own_px);
  Eigen::Matrix2d axes;
  axes << at.across_px, at.down_px;
  if (!(std::abs(axes.determinant()) > 1e-9)) return false;
  const double inverse_depth = vehicle.inverse_depth_per_m;
  const Eigen::Vector2d off_m = axes.inverse() * (middle_px - own_px) / inverse_depth;
  const bool high = view.height_over_lamps_m() > kHighAbove_m;
  if (off_m.y() > kUnder_m || off_m.y() < -kOver_m) return false;
  const double ratio = width_per_depth / vehicle.width_per_depth;
  // Seen from low down, what stands behind a vehicle and between its lamps is hidden.
  const double half_m = 0.5 * vehicle.width_per_depth / inverse_depth;
  if (!high && std::abs(off_m.x()) + half_m * ratio < half_m + kMargin_m) return true;
  const double off_middle_m =
      high ? std::max(kOffMiddleHigh_m, kHalfBody_m - half_m * ratio) : kOffMiddle_m;
  if (std::abs(off_m.x()) > off_middle_m) return false;
  if (ratio < (high ? 0.4 : 0.6) || ratio > 1.6) return false;
  if (high && std::abs(off_m.y()) < kRoofOverLamps_m) return true;
  const double gap_m =
      high ? 1.0 / view.place(middle_px).inverse_depth_per_m - 1.0 / at.inverse_depth_per_m
           : (1.0 / ratio - 1.0) / inverse_depth;
  const double doubt_m = high ? view.gap_sigma_m(inverse_depth) : 0.0;
  return std::abs(gap_m) < kShortestGap_m - doubt_m;
}

}  // namespace

void Pairing::look_at_pairs(const Lamps& lamps, std::int64_t frame) {
  const double widest = 2.8 * view_.focal_px();
  const bool low = view_.height_over_lamps_m() < kHighAbove_m;
  std::vector<Lamp*> seen;
  for (const auto& lamp : lamps)
    if (lamp->seen_at(frame) && lamp->sightings() >= 2 && !is_mirrored(*lamp))
      seen.push_back(lamp.get());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Lamp& a = *seen[i];
    for (std::size_t j = i + 1; j < seen.size(); ++j) {
      Lamp& b = *seen[j];
      const Eigen::Vector2d vector_px = b.at_px() - a.at_px();
      const double nearest = std::max(a.place().inverse_depth_per_m, b.place().inverse_depth_per_m);
      const double level_px = std::abs(vector_px.dot(a.place().across_px.unitOrthogonal()));
      const bool worth_a_look = vector_px.norm() < widest * std::max(nearest, 1.0 / 15.0) &&
                                level_px < 4.0 + 0.35 * vector_px.norm() && fits_kind(a, b);
      if (!worth_a_look) continue;

      PairLook look = look_at_pair(a, b, view_);
      Evidence* known = evidence_of(&a, &b);
      if (!known) {
        if (!(look.chi2 < kMostChi2Counted)) continue;
        known = &evidence_.emplace_back(Evidence{&a, &b});
        index_[{&a, &b}] = evidence_.size() - 1;
      }
      if (low && std::any_of(seen.begin(), seen.end(), [&](const Lamp* third) {
            return third != &a && third != &b && stands_between(*third, a, b) &&
                   !lights_plate(*third, a, b);
          })) {
        look.chi2 += kBetweenChi2;
        look.log_odds -= 0.5 * kBetweenChi2;
      }
      known->looks = std::min(known->looks + 1, kLooksKept);
      known->chi2 += (std::min(look.chi2, kMostChi2Counted) - known->chi2) / known->looks;
      known->log_odds += (std::max(look.log_odds, kLeastLogOdds) - known->log_odds) / known->looks;
      known->inverse_depth_per_m = look.fit.inverse_depth_per_m;
      known->width_per_depth = look.fit.width_per_depth;
      known->last_frame = frame;
    }
  }
}

std::size_t Pairing::LampsHash::operator()(const LampsOf& lamps) const {
  const std::hash<const Lamp*> hash;
  return hash(lamps.first) * 31 + hash(lamps.second);
}

Pairing::Evidence* Pairing::evidence_of(const Lamp* a, const Lamp* b) {
  for (const LampsOf& lamps : {LampsOf(a, b), LampsOf(b, a)})
    if (const auto found = index_.find(lamps); found != index_.end())
      return &evidence_[found->second];
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
    if ((pair.last_frame != frame && !together) || pair.looks < kLooksToJoin) continue;
    if (!together && (pair.chi2 > kMostChi2ToJoin || !fits_kind(*pair.a, *pair.b))) continue;
    const double worth = log_odds_of(pair.log_odds, pair.looks) +
                         (together ? staying_log_odds(*pair.a->vehicle) : 0.0);
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

// The vehicle goes on with the likelier pair where that has one of its lamps, and one that came out
// of the other.
bool Pairing::pass_on(Vehicle& vehicle, const Evidence& pair, std::int64_t frame) {
  const bool has_a = pair.a->vehicle == &vehicle, has_b = pair.b->vehicle == &vehicle;
  if (has_a == has_b) return false;
  const Lamp& kept = has_a ? *pair.a : *pair.b;
  if (!hand_over(vehicle, kept, has_a ? *pair.b : *pair.a)) return false;
  vehicle.chi2 = pair.chi2;
  vehicle.inverse_depth_per_m = pair.inverse_depth_per_m;
  vehicle.width_per_depth = pair.width_per_depth;
  vehicle.last_both = vehicle.last_good = frame;
  vehicle.last_both_time = kept.records.back().time;
  return true;
}

// Each is what is left of a vehicle whose other lamp has long been lost, and they stand as a pair
// on: in what hid them they went over to another vehicle's, or only one of them did. Both begin
// anew.
void Pairing::leave_two(const Evidence& pair, const Lamp& left, const Lamp& right) {
  Vehicle& one = *left.vehicle;
  Vehicle& other = *right.vehicle;
  if (pair.looks < kLooksKept || one.left != &left || other.right != &right || one.right ||
      other.left)
    return;
  one.cut_after = one.last_both;
  other.cut_after = other.last_both;
}

void Pairing::join(Evidence& pair, Vehicles& vehicles, std::int64_t frame) {
  Vehicle* vehicle = pair.a->vehicle ? pair.a->vehicle : pair.b->vehicle;
  const bool a_is_left = pair.a->at_px().x() < pair.b->at_px().x();
  Lamp* left = a_is_left ? pair.a : pair.b;
  Lamp* right = a_is_left ? pair.b : pair.a;
  if (pair.a->vehicle && pair.b->vehicle) {
    leave_two(pair, *left, *right);
    return;
  }
  if (vehicle) {  // the lost lamp must have stood on the side where the new one is
    const bool fits =
        vehicle->left == left ? !vehicle->right : vehicle->right == right && !vehicle->left;
    constexpr double kMostStretch = 1.4;
    const double stretch = pair.width_per_depth / pair.inverse_depth_per_m /
                           (vehicle->width_per_depth / vehicle->inverse_depth_per_m);
    if (!fits || stretch > kMostStretch || stretch < 1.0 / kMostStretch) {
      if (vehicle->both_seen >= kYoung || vehicle->cut_after) return;
      // Hardly seen as a pair, and with another partner than this likelier one.
      for (Lamp* lamp : {vehicle->left, vehicle->right})
        if (lamp) lamp->vehicle = nullptr;
      std::erase_if(vehicles, [&](const auto& one) { return one.get() == vehicle; });
      vehicle = nullptr;
    }
  }
  if (!vehicle) {
    const Eigen::Vector2d middle_px = 0.5 * (left->at_px() + right->at_px());
    for (const auto& other : vehicles)
      if (other->left && other->right &&
          same_body(*other, middle_px, pair.width_per_depth, view_) &&
          !outshines(*left, *right, *other, false)) {
        left->on_vehicle.add(true, kLooksKept);
        right->on_vehicle.add(true, kLooksKept);
        return;
      }
    vehicle = vehicles.emplace_back(std::make_unique<Vehicle>()).get();
    vehicle->kind = left->kind() != LampKind::other ? left->kind() : right->kind();
  }
  vehicle->left = left;
  vehicle->right = right;
  left->vehicle = right->vehicle = vehicle;
  left->set_aside.clear();
  right->set_aside.clear();
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
      const PairLook look = look_at_pair(*left, *right, view_);
      const PairFit& fit = look.fit;
      const double chi2 = std::min(kMostChi2Counted, look.chi2);
      vehicle->chi2 += (chi2 - vehicle->chi2) / kLooksKept;
      vehicle->inverse_depth_per_m = fit.inverse_depth_per_m;
      vehicle->width_per_depth = fit.width_per_depth;
      ++vehicle->both_seen;
      vehicle->last_both = frame;
      vehicle->last_both_time = time;
      if (vehicle->chi2 < kMostMeanChi2 && chi2 < kMostChi2ToJoin) vehicle->last_good = frame;
      const bool crossed = left->at_px().x() > right->at_px().x() + kCrossed_px;
      if (has_changed(*left, vehicle->kind) || has_changed(*right, vehicle->kind))
        vehicle->cut_after = std::min(vehicle->last_good, frame - kNoticed);
      else if (crossed || vehicle->chi2 > kMostChi2ToStay) {
        vehicle->cut_after = vehicle->last_good;
        vehicle->came_apart = true;
        vehicle->ambiguous |= has_rival(*left, *right, vehicle->both_seen);
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
    bool known_first = false;  // vehicles are in the order in which they were found
    for (const auto& other : vehicles) {
      known_first = known_first || other == vehicle;
      if (other == vehicle || other->kind != vehicle->kind || !other->left || !other->right)
        continue;
      const Eigen::Vector2d middle_px = 0.5 * (left->at_px() + right->at_px());
      if (same_body(*other, middle_px, vehicle->width_per_depth, view_) &&
          !outshines(*left, *right, *other, known_first)) {
        ++vehicle->second_on_body;
        break;
      }
    }
  }
}

// Whether one of the lamps goes as well with a third, which was there for most of the time that the
// two were seen as a pair: then nothing tells that they ever were one.
bool Pairing::has_rival(const Lamp& a, const Lamp& b, int both_seen) const {
  const auto seen_beside = [](const Lamp& one_lamp, const Lamp& other_lamp) {
    std::size_t frames = 0;
    for_each_common_frame(one_lamp.records, other_lamp.records, &LampRecord::frame,
                          [&](const LampRecord&, const LampRecord&) { ++frames; });
    return static_cast<double>(frames);
  };
  // Of pairs that stand for long only the last records are held.
  const double together = std::min<double>(both_seen, kHeldAlone);
  return std::any_of(evidence_.begin(), evidence_.end(), [&](const Evidence& other) {
    if (other.looks < kLooksToJoin || other.chi2 > kMostChi2ToJoin ||
        !(log_odds_of(other.log_odds, other.looks) > 0.0))
      return false;
    return (other.a == &a || other.a == &b) != (other.b == &a || other.b == &b) &&
           seen_beside(*other.a, *other.b) > kMostShareOfRival * together;
  });
}

void Pairing::update(Lamps& lamps, Vehicles& vehicles, std::int64_t frame, CameraTime time) {
  look_at_pairs(lamps, frame);
  const std::vector<Evidence*> chosen = best_pairs(frame);
  // A pair gives way when a likelier arrangement of all lamps leaves it out. What was seen of it
  // for long is reported; a short one never was.
  for (const Evidence& pair : evidence_) {
    Vehicle* vehicle = pair.a->vehicle;
    if (!vehicle || vehicle != pair.b->vehicle) continue;
    const auto takes_one = [&](const Evidence* other) {
      return other != &pair &&
             (other->a == pair.a || other->a == pair.b || other->b == pair.a || other->b == pair.b);
    };
    if (std::find(chosen.begin(), chosen.end(), &pair) != chosen.end()) continue;
    if (vehicle->both_seen >= kYoung && std::none_of(chosen.begin(), chosen.end(), takes_one))
      continue;
    if (vehicle->both_seen >= kYoung &&
        std::any_of(chosen.begin(), chosen.end(),
                    [&](Evidence* other) { return pass_on(*vehicle, *other, frame); }))
      continue;
    if (vehicle->both_seen >= kLong || !vehicle->past_left.empty() ||
        !vehicle->past_right.empty()) {
      vehicle->cut_after = vehicle->last_good;
      vehicle->came_apart = true;
      vehicle->ambiguous |= has_rival(*pair.a, *pair.b, vehicle->both_seen);
      continue;
    }
    pair.a->vehicle = pair.b->vehicle = nullptr;
    std::erase_if(vehicles, [&](const auto& one) { return one.get() == vehicle; });
  }
  for (Evidence* pair : chosen)
    if (!pair->a->vehicle || pair->a->vehicle != pair->b->vehicle) join(*pair, vehicles, frame);
  refresh(vehicles, frame, time);
  count_rows(lamps, vehicles, frame);
}

// Between headlamps, or tail lamps, and level with them nothing shines; between the outer ones of a
// row over a lorry's cab, or of a light bar, the others do. From low down it may be a vehicle
// behind.
void Pairing::count_rows(const Lamps& lamps, const Vehicles& vehicles, std::int64_t frame) const {
  if (view_.height_over_lamps_m() < kHighAbove_m) return;
  for (const auto& vehicle : vehicles) {
    if (vehicle->last_both != frame) continue;
    const Lamp &left = *vehicle->left, &right = *vehicle->right;
    vehicle->in_row += std::ranges::any_of(lamps, [&](const auto& third) {
      return third->seen_at(frame) && third.get() != &left && third.get() != &right &&
             stands_between(*third, left, right) && !lights_plate(*third, left, right);
    });
  }
}

void Pairing::forget(const std::vector<Lamp*>& lamps) {
  const std::unordered_set<const Lamp*> gone(lamps.begin(), lamps.end());
  const auto was_of_one = [&](const Evidence& pair) {
    return gone.contains(pair.a) || gone.contains(pair.b);
  };
  if (gone.empty() || std::erase_if(evidence_, was_of_one) == 0) return;
  index_.clear();
  for (std::size_t i = 0; i < evidence_.size(); ++i) index_[{evidence_[i].a, evidence_[i].b}] = i;
}

void Pairing::forget_all() {
  evidence_.clear();
  index_.clear();
}

}  // namespace vildar
