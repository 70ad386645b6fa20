#include "track/association.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "core/median.h"
#include "optics/lamp_colour.h"
#include "track/assignment.h"

namespace vildar {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Minus twice the log likelihood of a missed lamp (1 in 10) and of a new light at the spot (1e-4
// per px^2 of a picture 1920 px wide), on the scale of chi2 + log_det of a match.
constexpr double kUnassigned = 19.0;

struct Link {
  int lamp, spot;
  double cost;
};

// The longer a lamp is hidden, the wider is the gate that it may come out in; a vehicle has not
// driven back meanwhile.
bool goes_back(const Lamp& lamp, const Spot& spot, const RoadView& view) {
  constexpr double kMoved_px = 4.0, kBack_px = 6.0;
  const double scale = view.picture_px_per_usual();
  if (view.moving_sensor() || lamp.records.empty()) return false;
  const Eigen::Vector2d last_px = lamp.records.back().at_px;
  const Eigen::Vector2d moved_px = lamp.at_px() - last_px;
  const double length_px = moved_px.norm();
  return length_px > kMoved_px * scale &&
         (spot.at_px - last_px).dot(moved_px) < -kBack_px * scale * length_px;
}

std::vector<Link> links_within_gate(const Lamps& lamps, const std::vector<Spot>& spots,
                                    double gate_chi2, const RoadView& view) {
  constexpr int kSettled = 3, kKnown = 5;
  // A lamp does not change this much between two looks; whatever is there now is another light.
  constexpr double kMostStepLn = 2.3, kMostStepDimLn = 1.8;
  constexpr double kFluxSigmaLn = 0.8, kMostFluxCost = 12.0, kUnknownKindCost = 2.0;
  std::vector<Link> links;
  for (int i = 0; i < static_cast<int>(lamps.size()); ++i) {
    const Lamp& lamp = *lamps[i];
    const LampKind kind = lamp.sightings() >= kSettled ? lamp.kind() : LampKind::other;
    for (int j = 0; j < static_cast<int>(spots.size()); ++j) {
      const Blob& blob = *spots[j].blob;
      if (opposed(kind, blob.kind) && colour_tells(blob.cr, blob.cb, blob.colour_chance)) continue;
      const auto distance = lamp.distance_within(spots[j], gate_chi2);
      if (!distance || goes_back(lamp, spots[j], view)) continue;
      const double flux_ln = std::log(std::max(blob.flux, 1e-9)) - lamp.log_flux();
      const double most_flux_ln = blob.kind == LampKind::other ? kMostStepDimLn : kMostStepLn;
      if (lamp.sightings() >= kKnown && std::abs(flux_ln) > most_flux_ln) continue;
      const double flux_cost = std::min(kMostFluxCost, std::pow(flux_ln / kFluxSigmaLn, 2));
      const double kind_cost = kind != blob.kind ? kUnknownKindCost : 0.0;
      links.push_back({i, j, distance->chi2 + distance->log_det + flux_cost + kind_cost});
    }
  }
  return links;
}

bool stands_alone(const Lamp& lamp) {
  constexpr int kEstablished = 5;
  if (lamp.sightings() < kEstablished) return false;
  return lamp.vehicle || (lamp.on_vehicle.share() <= 0.5 && lamp.mirrored.share() <= 0.5);
}

// Only a light of its own, followed for long, may be mistaken for another one: not the reflections
// and trim that surround a lamp.
bool rivals(const Lamp& a, const Lamp& b) {
  if (a.vehicle && a.vehicle == b.vehicle) return false;
  return stands_alone(a) && stands_alone(b);
}

void find_doubts(const Lamps& lamps, const std::vector<Link>& links, Association& found) {
  constexpr double kMargin = 3.0;
  const auto cost = [&](int lamp, int spot) {
    for (const Link& link : links)
      if (link.lamp == lamp && link.spot == spot) return link.cost;
    return kInfinity;
  };
  found.doubtful.assign(lamps.size(), 0);
  for (const Link& link : links) {
    for (int i = 0; i < static_cast<int>(lamps.size()); ++i) {
      const auto spot = found.spot_of_lamp[i];
      if (spot != link.spot || i == link.lamp || !rivals(*lamps[i], *lamps[link.lamp])) continue;
      const auto other_spot = found.spot_of_lamp[link.lamp];
      const double now = cost(i, *spot) + (other_spot ? cost(link.lamp, *other_spot) : 0.0);
      const double swapped = link.cost + (other_spot ? cost(i, *other_spot) : 0.0);
      if (swapped - now < kMargin) {
        found.doubtful[i] = 1;
        if (other_spot) found.doubtful[link.lamp] = 1;
      }
    }
  }
}

// Indices of the lamps seen `least` times or more, at most `most` of them.
std::vector<int> longest_seen(const Lamps& lamps, int least, std::ptrdiff_t most) {
  std::vector<int> chosen;
  for (int i = 0; i < static_cast<int>(lamps.size()); ++i)
    if (lamps[i]->sightings() >= least) chosen.push_back(i);
  if (std::ssize(chosen) > most) {
    std::nth_element(chosen.begin(), chosen.begin() + most, chosen.end(), [&](int one, int other) {
      return lamps[one]->sightings() > lamps[other]->sightings();
    });
    chosen.resize(static_cast<std::size_t>(most));
  }
  return chosen;
}

constexpr double kAgreement_px = 2.0;

// Where all lamps, three at least, went the same way to what is nearest to each: those that are
// followed less closely by more.
std::optional<Eigen::Vector2d> step_of_all(const std::vector<Eigen::Vector2d>& to_nearest_px) {
  constexpr std::size_t kFewest = 3;
  constexpr double kShare = 0.25;
  if (to_nearest_px.size() < kFewest) return std::nullopt;
  std::vector<double> u, v;
  for (const Eigen::Vector2d& by_px : to_nearest_px) {
    u.push_back(by_px.x());
    v.push_back(by_px.y());
  }
  const Eigen::Vector2d usual_px(median(std::move(u)), median(std::move(v)));
  const double reach_px = kAgreement_px + kShare * usual_px.norm();
  const bool all = std::ranges::all_of(to_nearest_px, [&](const Eigen::Vector2d& by_px) {
    return (by_px - usual_px).norm() < reach_px && by_px.dot(usual_px) > 0.0;
  });
  return all ? std::optional(usual_px) : std::nullopt;
}

}  // namespace

CommonShift common_shift(const Lamps& lamps, const std::vector<Spot>& spots, double reach_px) {
  constexpr int kFewest = 4, kSettled = 3;
  constexpr std::ptrdiff_t kNearest =
      24;  // spots of one lamp: the cost must not grow with a crowd's square
  constexpr std::ptrdiff_t kMostLamps = 200;
  constexpr double kPreferSmall_per_px = 0.03, kLeast_px = 1.5;
  constexpr double kLeastSigmas = 2.0, kMoreThanAtRest = 1.5;
  struct Step {
    int lamp;
    Eigen::Vector2d by_px;
  };
  const auto shorter = [](const Step& one, const Step& other) {
    return one.by_px.squaredNorm() < other.by_px.squaredNorm();
  };
  std::vector<Step> steps;
  int lamps_used = 0;
  std::vector<double> nearest_px(lamps.size(), kInfinity);
  std::vector<Eigen::Vector2d> to_nearest_px;
  for (const int i : longest_seen(lamps, kSettled, kMostLamps)) {
    const auto before = static_cast<std::ptrdiff_t>(steps.size());
    for (const Spot& spot : spots) {
      const Eigen::Vector2d by_px = spot.at_px - lamps[i]->at_px();
      if (by_px.squaredNorm() < reach_px * reach_px) steps.push_back({i, by_px});
      double& least_px = nearest_px[static_cast<std::size_t>(i)];
      least_px = std::min(least_px, by_px.norm());
    }
    if (static_cast<std::ptrdiff_t>(steps.size()) > before) {
      ++lamps_used;
      to_nearest_px.push_back(
          std::min_element(steps.begin() + before, steps.end(), shorter)->by_px);
    }
    if (static_cast<std::ptrdiff_t>(steps.size()) > before + kNearest) {
      std::nth_element(steps.begin() + before, steps.begin() + before + kNearest, steps.end(),
                       shorter);
      steps.resize(static_cast<std::size_t>(before + kNearest));
    }
  }
  // A small step that fits the lamps' own uncertainty is theirs to learn as a change of speed.
  std::vector<double> sigmas_px;
  for (const auto& lamp : lamps)
    if (lamp->sightings() >= kSettled) sigmas_px.push_back(lamp->position_sigma_px());
  const auto clear = [&](const Eigen::Vector2d& shift_px) {
    return shift_px.norm() >= std::max(kLeast_px, kLeastSigmas * median(sigmas_px));
  };
  if (const auto all_px = step_of_all(to_nearest_px); all_px && clear(*all_px))
    return {*all_px, true};
  if (lamps_used < kFewest) return {};
  std::sort(steps.begin(), steps.end(),
            [](const Step& one, const Step& other) { return one.by_px.x() < other.by_px.x(); });

  const auto near = [&](const Step& a, const Step& b) {
    return (a.by_px - b.by_px).squaredNorm() < kAgreement_px * kAgreement_px;
  };
  double best = -kInfinity;
  const Step* centre = nullptr;
  int support = 0;
  std::vector<const Step*> counted_for(lamps.size(), nullptr);
  auto window = steps.begin();
  for (const Step& step : steps) {
    while (window->by_px.x() < step.by_px.x() - kAgreement_px) ++window;
    int agree = 0;
    for (auto other = window;
         other != steps.end() && other->by_px.x() < step.by_px.x() + kAgreement_px; ++other) {
      const Step*& last = counted_for[static_cast<std::size_t>(other->lamp)];
      if (last == &step || !near(step, *other)) continue;
      last = &step;
      ++agree;
    }
    const double score = agree - kPreferSmall_per_px * step.by_px.norm();
    if (score > best) {
      best = score;
      centre = &step;
      support = agree;
    }
  }
  if (support < kFewest || 2 * support < lamps_used) return {};
  // Where most are at rest, others may seem to have moved: to their images on a wet road.
  const double at_rest_px = std::min(kAgreement_px, 0.5 * centre->by_px.norm());
  const auto at_rest =
      std::ranges::count_if(nearest_px, [&](double least_px) { return least_px < at_rest_px; });
  if (support < kMoreThanAtRest * static_cast<double>(at_rest)) return {};
  std::vector<double> u, v;
  for (const Step& step : steps)
    if (near(*centre, step)) {
      u.push_back(step.by_px.x());
      v.push_back(step.by_px.y());
    }
  const Eigen::Vector2d shift_px(median(std::move(u)), median(std::move(v)));
  return clear(shift_px) ? CommonShift{shift_px} : CommonShift{};
}

Association associate(const Lamps& lamps, const std::vector<Spot>& spots, double gate_chi2,
                      const RoadView& view) {
  const double unassigned = kUnassigned + 4.0 * std::log(view.picture_px_per_usual());
  const std::vector<Link> links = links_within_gate(lamps, spots, gate_chi2, view);
  const int lamp_count = static_cast<int>(lamps.size());
  // Lights that share no spot are assigned apart: the problems stay small.
  std::vector<int> parent(lamps.size() + spots.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  for (const Link& link : links) parent[root(link.lamp)] = root(lamp_count + link.spot);

  Association found;
  found.spot_of_lamp.resize(lamps.size());
  found.spot_taken.assign(spots.size(), 0);
  std::vector<std::vector<Link>> groups(parent.size());
  for (const Link& link : links) groups[root(link.lamp)].push_back(link);
  for (const std::vector<Link>& group : groups) {
    if (group.empty()) continue;
    std::vector<int> rows, columns;
    for (const Link& link : group) {
      rows.push_back(link.lamp);
      columns.push_back(link.spot);
    }
    for (std::vector<int>* ids : {&rows, &columns}) {
      std::sort(ids->begin(), ids->end());
      ids->erase(std::unique(ids->begin(), ids->end()), ids->end());
    }
    Eigen::MatrixXd cost =
        Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(rows.size()),
                                  static_cast<Eigen::Index>(columns.size()), kInfinity);
    const auto place_of = [](const std::vector<int>& ids, int id) {
      return std::lower_bound(ids.begin(), ids.end(), id) - ids.begin();
    };
    for (const Link& link : group)
      cost(place_of(rows, link.lamp), place_of(columns, link.spot)) = link.cost;
    const auto assigned = assign_rows(cost, unassigned);
    for (std::size_t row = 0; row < rows.size(); ++row)
      if (assigned[row]) {
        const int spot = columns[*assigned[row]];
        found.spot_of_lamp[rows[row]] = spot;
        found.spot_taken[spot] = 1;
      }
  }
  find_doubts(lamps, links, found);
  return found;
}

}  // namespace vildar
