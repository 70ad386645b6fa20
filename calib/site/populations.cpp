#include "calib/site/populations.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "estimate/lane_choice.h"
#include "optics/camera.h"

namespace vildar {
namespace {

// Of a stated variance, the share that is common to the vehicles of one site.
constexpr double kSiteShare = 0.5;
// What a stated spread is worth, in passes.
constexpr double kLengthWeight = 4.0;
// What the site file calls known is taken as good to this.
constexpr double kKnown_m = 0.001;
// Vehicles do not drive along the road to better than this; worth one pass.
constexpr double kTurnSpread_rad = 5e-5;
constexpr double kTurnWeight = 1.0;
// One lens has one focal length; seen by single passes it differs by what is left of its
// distortion.
constexpr double kFocalSpread = 1e-4;
constexpr double kFocalWeight = 1.0;

// Mean of the logarithm of a quantity that scatters by a relative spread about its own mean.
double log_mean(double mean, double relative_spread) {
  return std::log(mean) - 0.5 * relative_spread * relative_spread;
}

// A length is learned where its sign and scale are clear: this many sigmas from nought.
constexpr double kClearOfNought = 4.0;

// A length's population from what the site states of vehicles and of the camera's own place.
Population length(std::string key, Shared kind, Uncertain stated_m, double camera_std_m) {
  Population population;
  population.key = std::move(key);
  population.kind = kind;
  population.stated = stated_m;
  const double size_m = std::abs(stated_m.mean);
  population.likely_spread = std::sqrt(1.0 - kSiteShare) * stated_m.std / size_m;
  population.mean = {log_mean(size_m, population.likely_spread),
                     std::hypot(std::sqrt(kSiteShare) * stated_m.std, camera_std_m) / size_m};
  population.spread_weight = kLengthWeight;
  return population;
}

double without(double std, double part_std) {
  return std::sqrt(std::max(0.0, std * std - part_std * part_std));
}

}  // namespace

double Population::mean_value() const {
  if (!is_length(kind)) return present;
  return std::copysign(std::exp(present + 0.5 * spread * spread), stated.mean);
}

PopulationList::PopulationList(Site stated, Site present)
    : stated_(std::move(stated)), present_(std::move(present)) {}

std::size_t PopulationList::index_of(const Population& population) {
  const auto found = std::ranges::find(populations_, population.key, &Population::key);
  if (found != populations_.end()) return static_cast<std::size_t>(found - populations_.begin());
  populations_.push_back(population);
  populations_.back().spread = population.likely_spread;
  populations_.back().present = population.mean.mean;
  return populations_.size() - 1;
}

Pass PopulationList::pass_of(std::size_t track, LampKind kind, const Trajectory& trajectory) {
  Pass pass;
  pass.track = track;
  pass.problem = trajectory.problem;
  pass.path = trajectory.fit.parameters;
  pass.free = free_parameters(trajectory.problem);
  MetricPriors& priors = pass.problem.priors;
  const MetricPriors own_priors = priors;
  const CameraSite& camera = *stated_.camera;
  const auto take = [&](std::optional<Uncertain>& prior, Population population, double extra_std) {
    // A length called known stays a prior of the pass alone.
    if (!(population.stated.std > kKnown_m)) return;
    const double std_m = prior->std;
    prior.reset();
    if (!(std::abs(population.stated.mean) > kClearOfNought * std_m)) return;
    population.tail = kind == LampKind::taillamp;
    pass.members.push_back({index_of(population), extra_std});
  };
  const std::string lamps = kind == LampKind::taillamp ? "lamps.tail_" : "lamps.";
  // Classes of lamps are told, not learned.
  const bool one_population = trajectory.lamps.empty();
  if (priors.drop_m && one_population) {
    const double camera_std_m = camera.position_m[2].std;
    take(priors.drop_m,
         length(lamps + "height_m", Shared::drop,
                {priors.drop_m->mean, without(priors.drop_m->std, camera_std_m)}, camera_std_m),
         0.0);
  }
  if (pass.problem.pairs && priors.separation_m && one_population)
    take(priors.separation_m,
         length(lamps + "separation_m", Shared::separation, *priors.separation_m, 0.0), 0.0);
  const auto lane = std::ranges::find(stated_.road.lanes, trajectory.lane, &LaneSite::id);
  if (priors.lateral_m && lane != stated_.road.lanes.end()) {
    const double lane_std_m = lane_prior_m(*lane).std, camera_std_m = camera.position_m[1].std;
    Population population = length("road.lanes." + lane->id + ".lateral_m", Shared::lateral,
                                   {priors.lateral_m->mean, lane_std_m}, camera_std_m);
    population.lane = lane->id;
    // One lamp may be either of a pair, so that its prior is wider than the lane's.
    const double extra_std_m =
        pass.problem.pairs ? 0.0
                           : without(priors.lateral_m->std, std::hypot(lane_std_m, camera_std_m));
    take(priors.lateral_m, population, extra_std_m / std::abs(priors.lateral_m->mean));
  }
  // A pass that shares no length keeps what fixes its scale to itself.
  if (pass.members.empty()) priors = own_priors;
  const std::array<const char*, 3> keys{"camera.yaw_deg", "camera.pitch_deg", "camera.roll_deg"};
  const std::array<const Uncertain*, 3> stated_rad{&camera.yaw_rad, &camera.pitch_rad,
                                                   &camera.roll_rad};
  const CameraSite& now = *present_.camera;
  const std::array<const Uncertain*, 3> present_rad{&now.yaw_rad, &now.pitch_rad, &now.roll_rad};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    priors.turn_rad[axis] = {};
    if (!(stated_rad[axis]->std > 0.0)) continue;
    Population population;
    population.key = keys[axis];
    population.kind = static_cast<Shared>(static_cast<std::size_t>(Shared::yaw) + axis);
    population.stated = {stated_rad[axis]->mean - present_rad[axis]->mean, stated_rad[axis]->std};
    population.mean = population.stated;
    population.likely_spread = kTurnSpread_rad;
    population.spread_weight = kTurnWeight;
    pass.members.push_back({index_of(population), 0.0});
  }
  if (priors.log_focal.std > 0.0) {
    Population population;
    population.key = "camera.focal_px";
    population.kind = Shared::focal;
    population.stated = {std::log(camera.focal_px[0] / now.focal_px[0]),
                         camera.focal_std_px / Camera(camera).focal_px()};
    population.mean = population.stated;
    population.likely_spread = kFocalSpread;
    population.spread_weight = kFocalWeight;
    priors.log_focal = {};
    pass.members.push_back({index_of(population), 0.0});
  }
  return pass;
}

}  // namespace vildar
