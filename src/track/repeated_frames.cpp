#include "track/repeated_frames.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vildar {
namespace {

constexpr int kFewestPixels = 12;  // noise of a lit road makes less
constexpr double kBeside_px = 5.0;
constexpr std::size_t kMostLights = 64;  // the brightest: each is looked for among all

template <class Light>
bool any_light(const std::vector<Light>& lights, const Eigen::Vector2d& at_px, double within_px) {
  return std::ranges::any_of(
      lights, [&](const Light& light) { return (light.centre_px - at_px).norm() <= within_px; });
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

// A light's velocity is that of its last way; one that has others near it is not followed.
void RepeatedFrames::follow(std::vector<Light>& now, double duration_s) const {
  for (const Light& before : lights_) {
    const Light* const light =
        only_light(now, before.centre_px + duration_s * before.velocity_px_per_s, before.reach_px);
    if (light == nullptr || only_light(lights_, before.centre_px, before.reach_px) == nullptr)
      continue;
    Light& followed = now[static_cast<std::size_t>(light - now.data())];
    followed.followed = true;
    followed.velocity_px_per_s = (light->centre_px - before.centre_px) / duration_s;
    followed.velocity_sigma_px_per_s =
        (light->sigma_px.cwiseAbs2() + before.sigma_px.cwiseAbs2()).cwiseSqrt() / duration_s;
  }
}

bool RepeatedFrames::repeats(const BlobFrame& frame) {
  constexpr double kSharp = 0.1;       // of the way expected
  constexpr double kMostWay = 0.05;    // of it, beside three sigmas
  constexpr double kMostSigmas = 5.0;  // by which a light that stands may seem to move
  constexpr double kCoded_px = 0.1;    // by which coding anew moves a light
  constexpr double kNearlyAll = 0.8;   // of the lights
  std::vector<Light> now = lights_of(frame);
  const double duration_s = seconds_of(frame.time) - time_s_;
  double along = 0.0, weight = 0.0;
  std::size_t stand = 0;
  for (const Light& before : lights_) {
    stand += any_light(now, before.centre_px, kMostSigmas * before.sigma_px.maxCoeff() + kCoded_px);
    const Light* const same = only_light(now, before.centre_px, before.reach_px);
    if (!before.followed || same == nullptr) continue;
    const Eigen::Vector2d way_px = same->centre_px - before.centre_px;
    const Eigen::Vector2d variance_px2 = (before.sigma_px.cwiseAbs2() + same->sigma_px.cwiseAbs2());
    const Eigen::Vector2d expected_px = duration_s * before.velocity_px_per_s;
    const Eigen::Array2d way_variance =
        variance_px2.array() + (duration_s * before.velocity_sigma_px_per_s).array().square() +
        kCoded_px * kCoded_px;
    along += (expected_px.array() * way_px.array() / way_variance).sum();
    weight += (expected_px.array().square() / way_variance).sum();
  }
  const auto nearly_all = kNearlyAll * static_cast<double>(std::max(lights_.size(), now.size()));
  if (weight * kSharp * kSharp > 1.0 && static_cast<double>(stand) >= nearly_all &&
      std::abs(along / weight) < kMostWay + 3.0 / std::sqrt(weight))
    return true;
  if (duration_s > 0.0) follow(now, duration_s);
  lights_ = std::move(now);
  time_s_ = seconds_of(frame.time);
  return false;
}

}  // namespace vildar
