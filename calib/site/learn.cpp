#include "calib/site/learn.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "calib/site/stated_sigmas.h"
#include "estimate/trajectory.h"
#include "optics/camera.h"

namespace vildar {
namespace {

constexpr int kMostRounds = 4;    // of fitting all passes anew with the pose learned so far
constexpr int kSpreadRounds = 3;  // of joint solution and spreads in turn

constexpr const char* kStrange = "unlike_the_others";
constexpr const char* kUnsure = "lane_or_lamps_unsure";
constexpr double kSure = 0.9;  // probability of a lane and class of lamps that a pass may teach

struct Fitted {
  std::vector<std::size_t> tracks;
  std::vector<Trajectory> trajectories;
  std::map<std::string, int> left_out;

  void leave_out(std::size_t index) {
    tracks.erase(tracks.begin() + static_cast<std::ptrdiff_t>(index));
    trajectories.erase(trajectories.begin() + static_cast<std::ptrdiff_t>(index));
    ++left_out[kStrange];
  }
};

Fitted fit_all(std::span<const VehicleTrack> tracks, const std::vector<bool>& strange,
               const Site& site) {
  const Camera camera(*site.camera);
  Fitted fitted;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (strange[i]) {
      ++fitted.left_out[kStrange];
      continue;
    }
    std::vector<std::string> warnings;
    auto outcome = fit_trajectories(tracks[i], camera, site, warnings);
    if (const Miss* miss = std::get_if<Miss>(&outcome)) {
      ++fitted.left_out[std::string(name_of(*miss))];
      continue;
    }
    Trajectory& likeliest = std::get<std::vector<Trajectory>>(outcome).front();
    if (likeliest.weight < kSure) {
      ++fitted.left_out[kUnsure];
      continue;
    }
    fitted.tracks.push_back(i);
    fitted.trajectories.push_back(std::move(likeliest));
  }
  return fitted;
}

double median_speed_std(const Fitted& fitted) {
  std::vector<double> stds;
  for (std::size_t i = 0; i < fitted.trajectories.size(); ++i) {
    const Trajectory& trajectory = fitted.trajectories[i];
    const MotionState state =
        trajectory.at(best_time_s(trajectory, trajectory.from_s, trajectory.to_s));
    stds.push_back(state.speed_std_mps / std::abs(state.over_ground_mps));
  }
  const auto middle = stds.begin() + static_cast<std::ptrdiff_t>(stds.size() / 2);
  std::nth_element(stds.begin(), middle, stds.end());
  return *middle;
}

// The populations and passes of one round, jointly solved.
struct Round {
  std::vector<Population> populations;
  std::vector<LinearPass> linear;
  Learned learned;
};

std::optional<Round> solve_round(std::span<const VehicleTrack> tracks, const Fitted& fitted,
                                 const Site& stated, const Site& present) {
  PopulationList list(stated, present);
  std::vector<Pass> passes;
  for (std::size_t i = 0; i < fitted.tracks.size(); ++i)
    passes.push_back(
        list.pass_of(fitted.tracks[i], tracks[fitted.tracks[i]].kind, fitted.trajectories[i]));
  Round round;
  round.populations = list.all();
  for (int i = 0; i < kSpreadRounds; ++i) {
    if (!solve_jointly(passes, round.populations)) return std::nullopt;
    round.linear.clear();
    for (const Pass& pass : passes) round.linear.push_back(linearise(pass, round.populations));
    round.learned = learn_spreads(round.linear, round.populations);
  }
  for (std::size_t k = 0; k < round.populations.size(); ++k)
    round.populations[k].present = round.learned.means[static_cast<Eigen::Index>(k)];
  return round;
}

int passes_of(std::size_t population, const Round& round) {
  int count = 0;
  for (const LinearPass& pass : round.linear)
    count += std::ranges::any_of(pass.members, [&](const Membership& member) {
      return member.population == population && !(member.extra_std > 0.0);
    });
  return count;
}

// Whether the site file gives the quantity itself; what it leaves out of tail lamps is taken from
// the headlamps, and stays so.
bool is_stated(const Site& site, const Population& population) {
  if (!population.tail) return true;
  if (population.kind == Shared::separation) return site.lamps.tail_separation_m.has_value();
  return population.kind != Shared::drop || site.lamps.tail_height_m.has_value();
}

// The place of a population in the site file; that of the focal length is two numbers and a sigma.
Uncertain& stated_in(Site& site, const Population& population) {
  CameraSite& camera = *site.camera;
  LampsSite& lamps = site.lamps;
  switch (population.kind) {
    case Shared::yaw: return camera.yaw_rad;
    case Shared::pitch: return camera.pitch_rad;
    case Shared::roll: return camera.roll_rad;
    case Shared::separation:
      return population.tail ? *lamps.tail_separation_m : *lamps.separation_m;
    case Shared::drop: return population.tail ? *lamps.tail_height_m : *lamps.height_m;
    case Shared::lateral:
    case Shared::focal: break;
  }
  return std::ranges::find(site.road.lanes, population.lane, &LaneSite::id)->lateral_m;
}

void state(Site& site, const Population& population, const Uncertain& learned) {
  if (population.kind != Shared::focal) {
    stated_in(site, population) = learned;
    return;
  }
  CameraSite& camera = *site.camera;
  const double factor = learned.mean / Camera(camera).focal_px();
  for (double& focal_px : camera.focal_px) focal_px *= factor;
  camera.focal_std_px = learned.std;
}

// A mean of a population as the site file states it.
double mean_for_file(const Population& population, double mean, const CameraSite& pose) {
  switch (population.kind) {
    case Shared::drop: return pose.position_m[2].mean - mean;
    case Shared::separation: return mean;
    case Shared::lateral: return pose.position_m[1].mean + mean;
    case Shared::yaw: return pose.yaw_rad.mean + mean;
    case Shared::pitch: return pose.pitch_rad.mean + mean;
    case Shared::roll: return pose.roll_rad.mean + mean;
    case Shared::focal: return Camera(pose).focal_px() * std::exp(mean);
  }
  return 0.0;
}

// A drop or lateral offset is stated of lamp or lane; the camera's own sigma comes on top of it.
double std_for_file(const Population& population, double std, const CameraSite& camera) {
  double camera_std = 0.0;
  if (population.kind == Shared::drop) camera_std = camera.position_m[2].std;
  if (population.kind == Shared::lateral) camera_std = camera.position_m[1].std;
  constexpr double kLeast_m = 0.001;
  return camera_std > 0.0
             ? std::sqrt(std::max(kLeast_m * kLeast_m, std * std - camera_std * camera_std))
             : std;
}

// How far a mean has moved from its prior, over the sigma of such ways, whose variance is what the
// data took of the prior's.
double strain_of(const Uncertain& prior, const Uncertain& learned) {
  constexpr double kLeastTold = 0.1;  // of the variance
  const double told = std::max(kLeastTold, 1.0 - std::pow(learned.std / prior.std, 2));
  return (learned.mean - prior.mean) / (prior.std * std::sqrt(told));
}

SiteLearning learning_of(const Round& round, const Site& stated, const Site& present, int fewest) {
  SiteLearning learning;
  learning.site = stated;
  const std::vector<double> stds = stated_stds(round.populations, round.learned);
  for (std::size_t k = 0; k < round.populations.size(); ++k) {
    const Population& population = round.populations[k];
    LearnedQuantity quantity;
    quantity.key = population.key;
    quantity.angle = is_turn(population.kind);
    // In units of the site file per unit of the population.
    const bool focal = population.kind == Shared::focal;
    const double unit = focal ? Camera(*present.camera).focal_px() : 1.0;
    quantity.before = {mean_for_file(population, population.stated.mean, *present.camera),
                       focal ? stated.camera->focal_std_px : population.stated.std};
    quantity.passes = passes_of(k, round);
    const auto own = static_cast<Eigen::Index>(k);
    quantity.mean_std =
        unit * population.per_step() * std::sqrt(round.learned.covariance(own, own));
    quantity.spread = unit * population.per_step() * population.spread;
    quantity.after = quantity.before;
    if (quantity.passes >= fewest && is_stated(stated, population)) {
      quantity.after = {mean_for_file(population, population.mean_value(), *present.camera),
                        unit * std_for_file(population, stds[k], *stated.camera)};
      quantity.strain = strain_of(population.mean, {round.learned.means[own],
                                                    std::sqrt(round.learned.covariance(own, own))});
      state(learning.site, population, quantity.after);
    }
    learning.quantities.push_back(quantity);
  }
  Eigen::MatrixXd before =
      Eigen::MatrixXd::Zero(round.learned.covariance.rows(), round.learned.covariance.cols());
  for (std::size_t k = 0; k < round.populations.size(); ++k)
    before(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)) =
        round.populations[k].mean.std * round.populations[k].mean.std;
  learning.common_scale_std = common_scale_std(round.populations, round.learned.covariance);
  learning.common_scale_std_before = common_scale_std(round.populations, before);
  return learning;
}

// Turns of this round from the pose that its trajectories were fitted with.
double turned_rad(const Round& round) {
  double most_rad = 0.0;
  for (const Population& population : round.populations)
    if (is_turn(population.kind)) most_rad = std::max(most_rad, std::abs(population.present));
  return most_rad;
}

// The site with the pose and the focal length learned so far; what the file states of their sigmas
// stands.
Site with_pose(Site site, const CameraSite& learned) {
  site.camera->focal_px = learned.focal_px;
  site.camera->yaw_rad.mean = learned.yaw_rad.mean;
  site.camera->pitch_rad.mean = learned.pitch_rad.mean;
  site.camera->roll_rad.mean = learned.roll_rad.mean;
  return site;
}

}  // namespace

bool SiteLearning::strains_the_file() const {
  constexpr double kFar = 3.5;           // sigmas; of ten quantities
  constexpr double kHundredth = 2.3263;  // of a normal law, one-sided
  double chi2 = 0.0, learned = 0.0;
  for (const LearnedQuantity& quantity : quantities) {
    if (std::abs(quantity.strain) > kFar) return true;
    chi2 += quantity.strain * quantity.strain;
    learned += quantity.strain != 0.0 ? 1.0 : 0.0;
  }
  // Wilson and Hilferty 1931: the cube root of chi-square over its degrees is about normal.
  const double part = 2.0 / (9.0 * std::max(1.0, learned));
  return std::cbrt(chi2 * 4.5 * part) > 1.0 - part + kHundredth * std::sqrt(part);
}

std::optional<LearnedQuantity> SiteLearning::denied() const {
  constexpr double kDenied = 4.5;
  const auto most = std::ranges::max_element(
      quantities, {}, [](const LearnedQuantity& one) { return std::abs(one.strain); });
  if (most == quantities.end() || std::abs(most->strain) < kDenied) return std::nullopt;
  return *most;
}

Outcome<SiteLearning> learn_site(std::span<const VehicleTrack> passes, const Site& site,
                                 int fewest) {
  if (!site.camera || site.ego) throw std::invalid_argument("learn_site: needs a fixed camera");
  std::vector<bool> strange(passes.size(), false);
  Site present = site;
  SiteLearning learning;
  double speed_std_before = 0.0;
  for (int rounds = 0; rounds < kMostRounds; ++rounds) {
    Fitted fitted = fit_all(passes, strange, present);
    if (rounds == 0 && !fitted.trajectories.empty()) speed_std_before = median_speed_std(fitted);
    std::optional<Round> round;
    while (true) {
      if (std::ssize(fitted.trajectories) < fewest) return Miss::too_few_samples;
      round = solve_round(passes, fitted, site, present);
      if (!round) return Miss::not_converged;
      const auto odd = stranger(round->linear, round->learned, round->populations);
      if (!odd) break;
      strange[fitted.tracks[*odd]] = true;
      fitted.leave_out(*odd);
    }
    learning = learning_of(*round, site, present, fewest);
    learning.took_part = fitted.tracks;
    learning.left_out = fitted.left_out;
    learning.last_turn_rad = turned_rad(*round);
    if (learning.settled()) break;
    present = with_pose(site, *learning.site.camera);
  }
  const Fitted fitted = fit_all(passes, strange, learning.site);
  if (fitted.trajectories.empty()) return Miss::too_few_samples;
  learning.speed_std_before = speed_std_before;
  learning.speed_std_after = median_speed_std(fitted);
  return learning;
}

}  // namespace vildar
