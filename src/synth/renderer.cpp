#include "synth/renderer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "optics/atmosphere.h"
#include "synth/bayer.h"
#include "synth/light.h"
#include "synth/psf.h"

namespace vildar {
namespace {

constexpr double kSmallestDisc_px = 0.01;  // a point, to any PSF that a camera has

const CameraSite& camera_of(const Scenario& scenario) {
  if (!scenario.site.camera) throw std::invalid_argument("Renderer: the site has no camera");
  if (!scenario.site.camera->exposure_s)
    throw std::invalid_argument("Renderer: camera.exposure_s is not given");
  return *scenario.site.camera;
}

PsfShape psf_of(const ImageScene& image) {
  return {image.core_sigma_px, image.wing_share, image.wing_scale_px, image.wing_exponent};
}

constexpr int kRoadLightStep_px = 16;

// A straight road looks the same all along; what turns before the camera must be drawn anew.
bool road_turns(const Site& site) {
  return site.ego && (site.road.kind == RoadKind::curved || site.ego->turns_known());
}

}  // namespace

Renderer::Renderer(const Scenario& scenario)
    : scenario_(scenario),
      site_(camera_of(scenario)),
      camera_(site_),
      shake_(scenario),
      exposure_s_(*site_.exposure_s),
      // A pixel of solid angle 1 / f^2 that shines with L lights the lens with L / f^2 lx.
      electrons_per_cd_(scenario.image.electrons_per_lux_s * exposure_s_ /
                        (site_.focal_px[0] * site_.focal_px[1])),
      psf_(psf_of(scenario.image), 2.0 * std::hypot(site_.width_px, site_.height_px) + 16.0),
      light_(site_.width_px, site_.height_px, psf_, exposure_s_,
             site_.rolling_shutter_s / site_.height_px),
      sensor_(scenario.image, site_, exposure_s_, scenario.seed),
      ground_(camera_, site_, 1),
      ground_turns_(road_turns(scenario.site)),
      background_(background_of(ground_, scenario, {})),
      road_light_(GroundMap(camera_, site_, kRoadLightStep_px), camera_.position_m()),
      road_row_(static_cast<std::size_t>(site_.width_px)) {}

template <class Position>
std::optional<RowSighting> Renderer::sighting(double time_s, const Position& position_m) const {
  return sighting_at_row_time(camera_, site_, time_s,
                              [&](double at_s) { return shake_.steady_m(position_m(at_s), at_s); });
}

std::vector<LampImage> Renderer::lamps(double time_s) const {
  std::vector<LampImage> images;
  const double reach_px = std::hypot(site_.width_px, site_.height_px);
  for (const Emitter& emitter : emitters_toward(scenario_, camera_.position_m(), time_s)) {
    const auto position_m = [&](double at_s) {
      return emitter_position_m(scenario_, emitter, at_s);
    };
    const auto seen = sighting(time_s, position_m);
    if (!seen) continue;
    LampImage image;
    image.centre_px = seen->pixel_px;
    const Eigen::Vector2d outside_px(
        std::max({0.0, -image.centre_px.x(), image.centre_px.x() - site_.width_px}),
        std::max({0.0, -image.centre_px.y(), image.centre_px.y() - site_.height_px}));
    if (outside_px.norm() > reach_px) continue;
    constexpr double kStep_s = 1e-4;
    const auto pixel_at = [&](double at_s) {
      return camera_.project(shake_.steady_m(position_m(at_s), at_s));
    };
    const auto before = pixel_at(seen->time_s - kStep_s), after = pixel_at(seen->time_s + kStep_s);
    if (!before || !after) continue;
    image.velocity_px_per_s = (*after - *before) / (2.0 * kStep_s);
    const double distance_m = (position_m(seen->time_s) - camera_.position_m()).norm();
    image.disc_radius_px = std::clamp(camera_.focal_px() * emitter.radius_m / distance_m,
                                      kSmallestDisc_px, kLargestDisc_px);
    const double illuminance_lx = emitter.intensity_cd / (distance_m * distance_m);
    const double pulse =
        emitter.waveform.mean(seen->time_s - 0.5 * exposure_s_, seen->time_s + 0.5 * exposure_s_);
    image.flux = illuminance_lx * pulse * scenario_.image.electrons_per_lux_s * exposure_s_;
    image.colour = emitter.colour;
    image.streak_px = camera_.focal_px() * emitter.streak_rad;
    images.push_back(image);
  }
  return images;
}

std::vector<QuadImage> Renderer::signs(double time_s) const {
  std::vector<QuadImage> images;
  for (const SignScene& sign : scenario_.signs) {
    const Eigen::Vector2d across(-std::sin(sign.facing_rad), std::cos(sign.facing_rad));
    const auto corner_m = [&](double side, double up, double at_s) {
      const Eigen::Vector2d still_m =
          Eigen::Vector2d(sign.position_m[0], sign.position_m[1]) + side * across;
      const Eigen::Vector2d seen_m = ego_pose(scenario_.site, at_s).seen_m(still_m);
      return Eigen::Vector3d(seen_m.x(), seen_m.y(), sign.position_m[2] + up);
    };
    const EgoPose ego = ego_pose(scenario_.site, time_s);
    const Eigen::Vector2d face = ego.turned({std::cos(sign.facing_rad), std::sin(sign.facing_rad)});
    const Eigen::Vector3d middle_m = corner_m(0.0, 0.0, time_s);
    if (!(face.dot((camera_.position_m() - middle_m).head<2>()) > 0.0)) continue;
    QuadImage image;
    static constexpr double kSides[4] = {-0.5, 0.5, 0.5, -0.5}, kUps[4] = {-0.5, -0.5, 0.5, 0.5};
    bool whole = true;
    for (std::size_t i = 0; i < 4 && whole; ++i) {
      const auto seen = sighting(time_s, [&](double at_s) {
        return corner_m(kSides[i] * sign.width_m, kUps[i] * sign.height_m, at_s);
      });
      whole = seen.has_value();
      if (seen) image.corners_px[i] = seen->pixel_px;
    }
    if (!whole) continue;
    image.light =
        sign.luminance_cd_per_m2 * electrons_per_cd_ *
        transmittance(scenario_.extinction_per_m, Metres((middle_m - camera_.position_m()).norm()));
    image.colour = {sign.red_blue[0], sign.red_blue[1]};
    images.push_back(image);
  }
  return images;
}

void Renderer::prepare_ground(double time_s) {
  if (ground_turns_)
    background_ = background_of(ground_, scenario_, ego_pose(scenario_.site, time_s));
  if (scenario_.image.road_light)
    road_light_.update(scenario_, states_at(scenario_, time_s), time_s);
}

void Renderer::gather_row(int v, const Eigen::Vector2d& shift_px, float* light_e) {
  const int width_px = site_.width_px;
  if (light_.has_far())
    light_.far_row(v, light_e);
  else
    std::fill_n(light_e, width_px, 0.0F);
  // The steady scene of a shaken camera, to the nearest pixel.
  const int steady_v =
      std::clamp(v - static_cast<int>(std::lround(shift_px.y())), 0, site_.height_px - 1);
  const int shift_u = static_cast<int>(std::lround(shift_px.x()));
  const std::size_t start = static_cast<std::size_t>(steady_v) * static_cast<std::size_t>(width_px);
  const float* scene = &background_.cd_per_m2[start];
  const float* surface = &background_.surface[start];
  const auto electrons = static_cast<float>(electrons_per_cd_);
  const auto black_e = static_cast<float>(scenario_.image.black_level_e);
  const bool lit = !road_light_.dark();
  if (lit) road_light_.row(steady_v, width_px, road_row_.data());
  if (shift_u == 0 && !lit) {
    for (int u = 0; u < width_px; ++u) light_e[u] += black_e + electrons * scene[u];
  } else if (shift_u == 0) {
    for (int u = 0; u < width_px; ++u)
      light_e[u] +=
          black_e + electrons * (scene[u] + surface[u] * road_row_[static_cast<std::size_t>(u)]);
  } else {
    for (int u = 0; u < width_px; ++u) {
      const int steady_u = std::clamp(u - shift_u, 0, width_px - 1);
      const float road = lit ? road_row_[static_cast<std::size_t>(steady_u)] : 0.0F;
      light_e[u] += black_e + electrons * (scene[steady_u] + surface[steady_u] * road);
    }
  }
  const LightPlane::Span span = light_.touched(v);
  const float* near = light_.near_row(v);
  for (int u = span.first; u < span.last; ++u) light_e[u] += near[u];
}

struct Renderer::Planes {
  std::vector<std::uint8_t> luma, cb, cr;
  int width_px, chroma_width_px;

  Planes(int width, int height) : width_px(width), chroma_width_px((width + 1) / 2) {
    luma.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    cb.assign(
        static_cast<std::size_t>(chroma_width_px) * static_cast<std::size_t>((height + 1) / 2),
        128);
    cr = cb;
  }
  std::uint8_t* luma_row(int v) {
    return &luma[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px)];
  }
  void set_chroma(int u, int v, const Sensor::Chroma& chroma) {
    const std::size_t place =
        static_cast<std::size_t>(v / 2) * static_cast<std::size_t>(chroma_width_px) +
        static_cast<std::size_t>(u / 2);
    cb[place] = chroma.cb;
    cr[place] = chroma.cr;
  }
};

namespace {

// How far the shaken image lies from the steady one.
Eigen::Vector2d shift_of(const CameraShake& shake, const Camera& camera, double time_s) {
  if (shake.still()) return Eigen::Vector2d::Zero();
  return camera.focal_px() * shake.turn_rad(time_s);
}

}  // namespace

// A camera with three sensors, or one whose demosaicing is perfect: luma carries the noise.
void Renderer::expose_luminance(Planes& planes, double time_s, std::int64_t frame) {
  std::vector<float> row(static_cast<std::size_t>(site_.width_px));
  for (int v = 0; v < site_.height_px; ++v) {
    gather_row(v, shift_of(shake_, camera_, time_of_row_s(site_, time_s, v)), row.data());
    if (v % 2 == 0) {
      const LightPlane::Span span = light_.touched(v);
      const float *near = light_.near_row(v), *red = light_.red_row(v), *blue = light_.blue_row(v);
      for (int u = span.first & ~1; u < span.last; u += 2)
        planes.set_chroma(
            u, v,
            sensor_.chroma(row[static_cast<std::size_t>(u)], red[u] - near[u], blue[u] - near[u]));
    }
    sensor_.expose_row(row.data(), site_.width_px, frame, v);
    sensor_.encode_row(row.data(), site_.width_px, planes.luma_row(v));
  }
}

void Renderer::expose_mosaic(Planes& planes, double time_s, std::int64_t frame) {
  const int width_px = site_.width_px, height_px = site_.height_px;
  const auto width = static_cast<std::size_t>(width_px);
  std::vector<float> mosaic(width * static_cast<std::size_t>(height_px));
  for (int v = 0; v < height_px; ++v) {
    float* row = &mosaic[static_cast<std::size_t>(v) * width];
    gather_row(v, shift_of(shake_, camera_, time_of_row_s(site_, time_s, v)), row);
    const LightPlane::Span span = light_.touched(v);
    const float *near = light_.near_row(v), *red = light_.red_row(v), *blue = light_.blue_row(v);
    for (int u = span.first; u < span.last; ++u) {
      const float red_excess = red[u] - near[u], blue_excess = blue[u] - near[u];
      switch (bayer_colour(u, v)) {
        case 0: row[u] += red_excess; break;
        case 1: row[u] -= static_cast<float>(Sensor::green_deficit(red_excess, blue_excess)); break;
        default: row[u] += blue_excess;
      }
    }
    sensor_.expose_row(row, width_px, frame, v);
    for (int u = 0; u < width_px; ++u)
      row[u] = std::min(row[u], static_cast<float>(scenario_.image.full_well_e));
  }
  const auto colours = demosaic(mosaic, width_px, height_px);
  for (int v = 0; v < height_px; ++v)
    for (int u = 0; u < width_px; ++u) {
      const std::size_t place = static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
      const Sensor::Codes codes = sensor_.codes_of(static_cast<double>(colours[0][place]),
                                                   static_cast<double>(colours[1][place]),
                                                   static_cast<double>(colours[2][place]));
      planes.luma_row(v)[u] = codes.luma;
      if (v % 2 == 0 && u % 2 == 0) planes.set_chroma(u, v, codes.chroma);
    }
}

Frame Renderer::image(double time_s) {
  light_.clear();
  for (const LampImage& lamp : lamps(time_s)) light_.add(lamp);
  for (const QuadImage& sign : signs(time_s)) light_.add(sign);
  prepare_ground(time_s);

  const auto planes = std::make_shared<Planes>(site_.width_px, site_.height_px);
  Frame frame;
  frame.index = std::llround(time_s * scenario_.frame_rate_hz);
  frame.time = time_from_seconds<CameraTime>(time_s);
  if (scenario_.image.bayer)
    expose_mosaic(*planes, time_s, frame.index);
  else
    expose_luminance(*planes, time_s, frame.index);

  frame.luma.owner = planes;
  frame.luma.data = planes->luma.data();
  frame.luma.stride_bytes = site_.width_px;
  frame.luma.width_px = site_.width_px;
  frame.luma.height_px = site_.height_px;
  frame.luma.black_code = Sensor::kBlackCode;
  frame.luma.white_code = Sensor::kWhiteCode;
  frame.chroma.cb = planes->cb.data();
  frame.chroma.cr = planes->cr.data();
  frame.chroma.stride_bytes = planes->chroma_width_px;
  return frame;
}

}  // namespace vildar
