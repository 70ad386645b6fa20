#include "synth/renderer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "synth/background.h"
#include "synth/row_time.h"

namespace vildar {
namespace {

constexpr double kSmallestDisc_px = 0.01;  // a point, to any PSF that a camera has
constexpr double kLargestDisc_px = 1000.0;

const CameraSite& camera_of(const Scenario& scenario) {
  if (!scenario.site.camera) throw std::invalid_argument("Renderer: the site has no camera");
  if (!scenario.site.camera->exposure_s)
    throw std::invalid_argument("Renderer: camera.exposure_s is not given");
  return *scenario.site.camera;
}

PsfShape psf_of(const ImageScene& image) {
  return {image.core_sigma_px, image.wing_share, image.wing_scale_px, image.wing_exponent};
}

}  // namespace

Renderer::Renderer(const Scenario& scenario)
    : scenario_(scenario),
      site_(camera_of(scenario)),
      camera_(site_),
      exposure_s_(*site_.exposure_s),
      psf_(psf_of(scenario.image), 2.0 * std::hypot(site_.width_px, site_.height_px) + 16.0),
      light_(site_.width_px, site_.height_px, psf_, exposure_s_,
             site_.rolling_shutter_s / site_.height_px),
      sensor_(scenario.image, site_, scenario.seed),
      background_e_(background_cd_per_m2(camera_, site_, scenario.site.road, scenario.image)) {
  // A pixel of solid angle 1 / f^2 that shines with L lights the lens with L / f^2 lx.
  const double electrons =
      scenario.image.electrons_per_lux_s * exposure_s_ / (site_.focal_px[0] * site_.focal_px[1]);
  for (float& light : background_e_)
    light = static_cast<float>(light * electrons + scenario.image.black_level_e);
}

std::vector<LampImage> Renderer::lamps(double time_s) const {
  std::vector<LampImage> images;
  const double reach_px = std::hypot(site_.width_px, site_.height_px);
  for (const Emitter& emitter : emitters_toward(scenario_, camera_.position_m(), time_s)) {
    const auto position_m = [&](double at_s) -> Eigen::Vector3d {
      if (!emitter.vehicle) return emitter.position_m;
      const VehicleScene& vehicle = scenario_.vehicles[*emitter.vehicle];
      const auto lamp_m = [&](double lamp_s) {
        return lamp_positions_m(vehicle,
                                state_at(vehicle, scenario_.site.road, lamp_s))[emitter.lamp];
      };
      return emitter.position_m + lamp_m(at_s) - lamp_m(time_s);
    };
    const auto sighting = sighting_at_row_time(camera_, site_, time_s, position_m);
    if (!sighting) continue;
    constexpr double kStep_s = 1e-4;
    const auto before = camera_.project(position_m(sighting->time_s - kStep_s));
    const auto after = camera_.project(position_m(sighting->time_s + kStep_s));
    if (!before || !after) continue;
    LampImage image;
    image.centre_px = sighting->pixel_px;
    const Eigen::Vector2d outside_px(
        std::max({0.0, -image.centre_px.x(), image.centre_px.x() - site_.width_px}),
        std::max({0.0, -image.centre_px.y(), image.centre_px.y() - site_.height_px}));
    if (outside_px.norm() > reach_px) continue;
    image.velocity_px_per_s = (*after - *before) / (2.0 * kStep_s);
    const double distance_m = (position_m(sighting->time_s) - camera_.position_m()).norm();
    image.disc_radius_px = std::clamp(camera_.focal_px() * emitter.radius_m / distance_m,
                                      kSmallestDisc_px, kLargestDisc_px);
    const double illuminance_lx = emitter.intensity_cd / (distance_m * distance_m);
    image.flux = illuminance_lx * scenario_.image.electrons_per_lux_s * exposure_s_;
    image.colour = emitter.colour;
    images.push_back(image);
  }
  return images;
}

Frame Renderer::image(double time_s) {
  light_.clear();
  for (const LampImage& lamp : lamps(time_s)) light_.add(lamp);

  const int width_px = site_.width_px, height_px = site_.height_px;
  const int chroma_width_px = (width_px + 1) / 2, chroma_height_px = (height_px + 1) / 2;
  const auto count = [](int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  };
  struct Planes {
    std::vector<std::uint8_t> luma, cb, cr;
  };
  const auto planes = std::make_shared<Planes>();
  planes->luma.resize(count(width_px, height_px));
  planes->cb.assign(count(chroma_width_px, chroma_height_px), 128);
  planes->cr = planes->cb;

  Frame frame;
  frame.index = std::llround(time_s * scenario_.frame_rate_hz);
  frame.time = time_from_seconds<CameraTime>(time_s);
  std::vector<float> row(static_cast<std::size_t>(width_px));
  for (int v = 0; v < height_px; ++v) {
    if (light_.has_far())
      light_.far_row(v, row.data());
    else
      std::fill(row.begin(), row.end(), 0.0F);
    const float* background = &background_e_[count(width_px, v)];
    for (int u = 0; u < width_px; ++u) row[static_cast<std::size_t>(u)] += background[u];
    const LightPlane::Span span = light_.touched(v);
    const float* near = light_.near_row(v);
    for (int u = span.first; u < span.last; ++u) row[static_cast<std::size_t>(u)] += near[u];
    if (v % 2 == 0) {
      const float* red = light_.red_row(v);
      const float* blue = light_.blue_row(v);
      for (int u = span.first & ~1; u < span.last; u += 2) {
        const float light = row[static_cast<std::size_t>(u)];
        const Sensor::Chroma chroma = sensor_.chroma(light, red[u] - near[u], blue[u] - near[u]);
        const std::size_t place = count(chroma_width_px, v / 2) + static_cast<std::size_t>(u / 2);
        planes->cb[place] = chroma.cb;
        planes->cr[place] = chroma.cr;
      }
    }
    sensor_.expose_row(row.data(), width_px, frame.index, v, &planes->luma[count(width_px, v)]);
  }

  frame.luma.owner = planes;
  frame.luma.data = planes->luma.data();
  frame.luma.stride_bytes = width_px;
  frame.luma.width_px = width_px;
  frame.luma.height_px = height_px;
  frame.luma.black_code = Sensor::kBlackCode;
  frame.luma.white_code = Sensor::kWhiteCode;
  frame.chroma.cb = planes->cb.data();
  frame.chroma.cr = planes->cr.data();
  frame.chroma.stride_bytes = chroma_width_px;
  return frame;
}

}  // namespace vildar
