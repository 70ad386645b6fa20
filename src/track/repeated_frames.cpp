#include "track/repeated_frames.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vildar {
namespace {

constexpr int kFewestPixels = 12;  // noise of a lit road makes less
constexpr double kBeside_px = 5.0;
constexpr double kCoded_px = 0.1;        // by which coding anew moves a light
constexpr std::size_t kMostLights = 64;  // the brightest: each is looked for among all

// Whether one of `lights` stands where this one does.
template <class Light>
bool any_stands(const std::vector<Light>& lights, const Light& light) {
  constexpr double kMostSigmas = 5.0;
  const double within_px = kMostSigmas * light.sigma_px.maxCoeff() + kCoded_px;
  return std::ranges::any_of(lights, [&](const Light& other) {
    return (other.centre_px - light.centre_px).norm() <= within_px;
  });
}

// The only one of `lights` within reach of `at_px`, or none.
template <class Light>
const Light* only_light(const std::vector<Light>& lights, const Eigen::Vector2d& at_px,
                        double reach_px) {
  const Light* only = nullptr;
  for (const Light& light : lights) {
    if ((light.centre_px - at_px).norm() > reach_px) continue;
    if (only != nullptr) return nullptr;
    only = &light;
  }
  return only;
}

}  // namespace

std::vector<RepeatedFrames::Light> RepeatedFrames::lights_of(const BlobFrame& frame) {
  std::vector<const Blob*> plain;
  for (const Blob& blob : frame.blobs)
    if (blob.area_px >= kFewestPixels) plain.push_back(&blob);
  if (plain.size() > kMostLights) {
    const auto brightest = plain.begin() + kMostLights;
    std::ranges::nth_element(plain, brightest, std::greater<>{}, &Blob::flux);
    plain.erase(brightest, plain.end());
  }
  std::vector<Light> lights;
  lights.reserve(plain.size());
  for (const Blob* const blob : plain) {
    const PixelBox& box = blob->box;
    Light light;
    light.centre_px = blob->centre_px;
    light.sigma_px = blob->centre_sigma_px;
    light.reach_px = std::max(box.u_max - box.u_min, box.v_max - box.v_min) + kBeside_px;
    lights.push_back(light);
  }
  return lights;
}

// A light's velocity is that of its last way; one that has others near it is not followed, nor one
// where another may have come: a lamp that stands, where one passes that is not seen.
void RepeatedFrames::follow(std::vector<Light>& now, double duration_s) const {
  for (const Light& before : lights_) {
    const Light* const light =
        only_light(now, before.centre_px + duration_s * before.velocity_px_per_s, before.reach_px);
    if (light == nullptr || only_light(lights_, before.centre_px, before.reach_px) == nullptr)
      continue;
    Light& followed = now[static_cast<std::size_t>(light - now.data())];
    followed.followed = ++followed.came_from == 1;
    followed.velocity_px_per_s = (light->centre_px - before.centre_px) / duration_s;
    followed.velocity_sigma_px_per_s =
        (light->sigma_px.cwiseAbs2() + before.sigma_px.cwiseAbs2()).cwiseSqrt() / duration_s;
  }
}

bool RepeatedFrames::repeats(const BlobFrame& frame) {
  constexpr double kSharp = 0.1;      // of the way expected
  constexpr double kAsSharp = 2.0;    // one light's sigma of another's
  constexpr double kTells = 0.1;      // of the weight needed
  constexpr double kMostWay = 0.05;   // of it, beside three sigmas
  constexpr double kNearlyAll = 0.8;  // of the lights
  std::vector<Light> now = lights_of(frame);
  const double duration_s = seconds_of(frame.time) - time_s_;
  double along = 0.0, weight = 0.0, sharpest_px = INFINITY;  // of those seen to move
  std::size_t stand = 0;
  for (const Light& before : lights_) {
    stand += any_stands(now, before);
    const Light* const same = only_light(now, before.centre_px, before.reach_px);
    if (!before.followed || same == nullptr ||
        same->sigma_px.maxCoeff() > kAsSharp * before.sigma_px.maxCoeff())
      continue;
    const Eigen::Vector2d way_px = same->centre_px - before.centre_px;
    const Eigen::Vector2d variance_px2 = (before.sigma_px.cwiseAbs2() + same->sigma_px.cwiseAbs2());
    const Eigen::Vector2d expected_px = duration_s * before.velocity_px_per_s;
    const Eigen::Array2d way_variance =
        variance_px2.array() + (duration_s * before.velocity_sigma_px_per_s).array().square() +
        kCoded_px * kCoded_px;
    along += (expected_px.array() * way_px.array() / way_variance).sum();
    const double told = (expected_px.array().square() / way_variance).sum();
    weight += told;
    if (told * kSharp * kSharp > kTells)
      sharpest_px = std::min(sharpest_px, before.sigma_px.maxCoeff());
  }
  const auto nearly_all = kNearlyAll * static_cast<double>(std::max(lights_.size(), now.size()));
  // Stains of a coded road come and go, and may have seemed to move; what is seen as sharply as
  // what moved, where nothing was, has moved.
  const auto moved = [&](const Light& light) {
    return light.sigma_px.maxCoeff() <= kAsSharp * sharpest_px && !any_stands(lights_, light);
  };
  if (weight * kSharp * kSharp > 1.0 && static_cast<double>(stand) >= nearly_all &&
      std::abs(along / weight) < kMostWay + 3.0 / std::sqrt(weight) &&
      std::ranges::none_of(now, moved))
    return true;
  if (duration_s > 0.0) follow(now, duration_s);
  lights_ = std::move(now);
  time_s_ = seconds_of(frame.time);
  return false;
}

}  // namespace vildar
