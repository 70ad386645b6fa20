#include "detect/detector.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "detect/kind.h"
#include "detect/lamp_meter.h"
#include "detect/levels.h"
#include "detect/peaks.h"
#include "detect/photometry.h"
#include "detect/red_lights.h"
#include "detect/run_scan.h"
#include "optics/picture.h"

namespace vildar {
namespace {

/// A clipped light this much longer than wide is two lamps run together, not one disc.
constexpr double kTwoLampElongation = 1.6;
constexpr int kLeastClippedForShape_px = 12;
/// Depth of a valley that noise alone hardly digs, in sigmas of one pixel.
constexpr double kValleySigma = 5.0;

/// A position of the stored plane in the upright picture.
Eigen::Vector2d upright(const Eigen::Vector2d& stored, int rotation_deg, const LumaView& luma) {
  const double last_u = luma.width_px - 1, last_v = luma.height_px - 1;
  switch (rotation_deg) {
    case 90: return {last_v - stored.y(), stored.x()};
    case 180: return {last_u - stored.x(), last_v - stored.y()};
    case 270: return {stored.y(), last_u - stored.x()};
    default: return stored;
  }
}

PixelBox upright(const PixelBox& box, int rotation_deg, const LumaView& luma) {
  const Eigen::Vector2d a = upright(Eigen::Vector2d(box.u_min, box.v_min), rotation_deg, luma);
  const Eigen::Vector2d b = upright(Eigen::Vector2d(box.u_max, box.v_max), rotation_deg, luma);
  const Eigen::Vector2i low = a.cwiseMin(b).cast<int>(), high = a.cwiseMax(b).cast<int>();
  return {low.x(), low.y(), high.x(), high.y()};
}

Eigen::Vector2d upright_extent(const Eigen::Vector2d& extent, int rotation_deg) {
  return rotation_deg % 180 == 90 ? Eigen::Vector2d(extent.y(), extent.x()) : extent;
}

void check(const Frame& frame) {
  const LumaView& luma = frame.luma;
  if (luma.bit_depth < 8 || luma.bit_depth > 16)
    throw std::invalid_argument("Detector: luma of " + std::to_string(luma.bit_depth) +
                                " bits, must be 8 to 16");
  if (luma.black_code < 0 || luma.white_code <= luma.black_code ||
      luma.white_code >= 1 << luma.bit_depth)
    throw std::invalid_argument("Detector: black code " + std::to_string(luma.black_code) +
                                " and white code " + std::to_string(luma.white_code) +
                                " are not a range of the luma's codes");
  if (frame.rotation_deg % 90 != 0 || frame.rotation_deg < 0 || frame.rotation_deg >= 360)
    throw std::invalid_argument("Detector: rotation of " + std::to_string(frame.rotation_deg) +
                                " degrees, must be 0, 90, 180 or 270");
}

// What H.264 and its like do to lamps (docs/photometry.md): errors of a pixel, of black to white;
// shoulders of clipped areas, rounded off from this share of clipping on; errors of a lamp as a
// whole.
constexpr float kCodingSigma = 0.018f;
struct Coded {
  double clip_share;
  double most_lone_wing_px;
  CodingErrors errors;
};
constexpr Coded kPlaces{0.5,
                        300.0,  // wings say little of where a lamp is
                        {.correlated_px = 6.0,
                         .summed_px = 6.0,
                         .flux_share = 0.03,
                         .clipped_share = 0.05,
                         .centre_px = 0.05,
                         .softened_px2 = 0.08}};
// Rims tell a lamp's place, for what they err by all around moves none; its light is told better
// where they count little.
constexpr Coded kLights{0.7,
                        600.0,
                        {.correlated_px = 6.0,
                         .summed_px = 3.0,
                         .flux_share = 0.03,
                         .clipped_share = 0.03,
                         .centre_px = 0.05,
                         .rim_factor = 5.0,
                         .softened_px2 = 0.08}};

float coding_codes(const LumaView& luma) {
  return kCodingSigma * static_cast<float>(luma.white_code - luma.black_code);
}

}  // namespace

std::vector<std::string> DetectOptions::problems() const {
  std::vector<std::string> found;
  const auto report = [&](bool holds, const char* field, double value, const char* rule) {
    if (!holds)
      found.push_back(std::string(field) + " = " + std::to_string(value) + ", must be " + rule);
  };
  report(threshold_sigma > 0.0, "threshold_sigma", threshold_sigma, "> 0");
  report(threshold_fraction > 0.0 && threshold_fraction < 1.0, "threshold_fraction",
         threshold_fraction, "above 0 and below 1");
  report(max_bright_share > 0.0 && max_bright_share <= 1.0, "max_bright_share", max_bright_share,
         "above 0 and at most 1");
  report(min_area_px >= 1, "min_area_px", min_area_px, ">= 1");
  report(min_valley_fraction > 0.0 && min_valley_fraction < 1.0, "min_valley_fraction",
         min_valley_fraction, "above 0 and below 1");
  report(full_well_electrons > 0.0, "full_well_electrons", full_well_electrons, "> 0");
  return found;
}

struct Detector::State {
  DetectOptions options;
  Response response;
  std::optional<double> exposure_s;

  LevelMeter level_meter;
  ClipMeter clip_meter;
  std::vector<PixelRun> runs;
  RunGroups groups;
  PeakFinder finder;
  RedLights red_lights;
  std::size_t bright = 0;  // of the peaks those found by their luma, the first ones
  Photometer photometer;
  std::vector<Measured>* lights = nullptr;  // of the last frame
  std::optional<LampMeter> lamp_meter;
  std::optional<FrameLight> coded_light;  // see LampMeter

  // Per code; rebuilt only when the plane's depth or range changes.
  LumaView tables_for;
  std::vector<float> linear, slope, sigma, coding_sigma;
  std::vector<float> signed_linear, rounding;
  std::vector<int> half_code;
  double half_code_background = -1.0, sigma_noise_codes = -1.0;

  std::optional<FrameLight> look(const Frame& frame, bool dim_red);
  void prepare_fit_tables(const LumaView& luma);
  FrameLight frame_light(const LumaView& luma, const Levels& levels, int clip_code,
                         const Coded& coded) const;
  void prepare_tables(const LumaView& luma, const Levels& levels);
  Blob blob_of(const Frame& frame, const Peak& peak, const Measured& light, int clip_code) const;
};

void Detector::State::prepare_fit_tables(const LumaView& luma) {
  // Noise goes on below black.
  signed_linear = linear;
  for (int code = 0; code < luma.black_code; ++code) {
    const int mirrored = std::min(2 * luma.black_code - code, static_cast<int>(linear.size()) - 1);
    signed_linear[static_cast<std::size_t>(code)] = -linear[static_cast<std::size_t>(mirrored)];
  }
  constexpr std::size_t kSteps = 256;
  rounding.resize(kSteps + 1);
  const float codes2 = options.lossy ? coding_codes(luma) * coding_codes(luma) : 1.0f / 12.0f;
  auto code = static_cast<std::size_t>(luma.black_code);
  for (std::size_t i = 0; i <= kSteps; ++i) {
    while (code + 2 < linear.size() && linear[code + 1] < static_cast<float>(i) / kSteps) ++code;
    const float step = linear[code + 1] - linear[code];
    rounding[i] = step * step * codes2;
  }
}

FrameLight Detector::State::frame_light(const LumaView& luma, const Levels& levels, int clip_code,
                                        const Coded& coded) const {
  FrameLight light;
  light.luma = luma;
  light.linear = signed_linear;
  light.clip_code = clip_code;
  const auto clip = static_cast<std::size_t>(clip_code);
  light.clip_light = 0.5 * static_cast<double>(linear[clip - 1] + linear[clip]);
  if (options.lossy) {
    const auto above = std::upper_bound(linear.begin(), linear.begin() + clip_code,
                                        static_cast<float>(coded.clip_share * light.clip_light));
    light.clip_code = static_cast<int>(above - linear.begin());
    light.clip_light = 0.5 * static_cast<double>(*(above - 1) + *above);
    light.coding = coded.errors;
    light.most_lone_wing_px = coded.most_lone_wing_px;
  }
  light.noise.electrons = options.full_well_electrons;
  light.noise.rounding = rounding;
  const auto dark = static_cast<std::size_t>(
      std::max(levels.background_code, static_cast<double>(luma.black_code)));
  const double noise = static_cast<double>(linear[dark + 1] - linear[dark]) * levels.noise_codes;
  light.noise.dark_variance =
      std::max(0.0, noise * noise - light.noise.variance(static_cast<double>(linear[dark])));
  return light;
}

void Detector::State::prepare_tables(const LumaView& luma, const Levels& levels) {
  if (linear.empty() || tables_for.bit_depth != luma.bit_depth ||
      tables_for.black_code != luma.black_code || tables_for.white_code != luma.white_code) {
    tables_for = luma;
    tables_for.owner.reset();
    tables_for.data = nullptr;
    linear = response.table_for(luma);
    slope.resize(linear.size());
    const std::size_t last = linear.size() - 1;
    for (std::size_t code = 0; code <= last; ++code)
      slope[code] = 0.5f * (linear[std::min(code + 1, last)] - linear[code > 0 ? code - 1 : 0]);
    coding_sigma.assign(linear.size(), 0.0f);
    for (std::size_t code = 0; code <= last && options.lossy; ++code)
      coding_sigma[code] = slope[code] * coding_codes(luma);
    half_code_background = sigma_noise_codes = -1.0;
    prepare_fit_tables(luma);
  }
  if (sigma_noise_codes != levels.noise_codes) {
    sigma_noise_codes = levels.noise_codes;
    sigma.resize(linear.size());
    for (std::size_t code = 0; code < linear.size(); ++code) {
      const double read = slope[code] * levels.noise_codes;
      sigma[code] =
          static_cast<float>(std::sqrt(read * read + linear[code] / options.full_well_electrons));
    }
  }
  if (half_code_background != levels.background_code) {
    half_code_background = levels.background_code;
    half_code.resize(linear.size());
    const float dark = linear[static_cast<std::size_t>(levels.background_code)];
    std::size_t half = 0;
    for (std::size_t code = 0; code < linear.size(); ++code) {
      while (half < code && linear[half] < 0.5f * (linear[code] + dark)) ++half;
      half_code[code] = static_cast<int>(half);
    }
  }
}

Blob Detector::State::blob_of(const Frame& frame, const Peak& peak, const Measured& light,
                              int clip_code) const {
  const LumaView& luma = frame.luma;
  Blob blob;
  blob.centre_px = upright(light.centre_px, frame.rotation_deg, luma);
  blob.centre_sigma_px = upright_extent(light.centre_sigma_px, frame.rotation_deg);
  blob.spread_px = upright_extent(light.spread_px, frame.rotation_deg);
  blob.box = upright(peak.box, frame.rotation_deg, luma);
  const double per_exposure = exposure_s ? 1.0 / *exposure_s : 1.0;
  blob.flux = light.flux * per_exposure;
  blob.flux_sigma = light.flux_sigma * per_exposure;
  blob.lamp = light.lamp;
  if (blob.lamp) {
    blob.lamp->flux *= per_exposure;
    blob.lamp->flux_sigma *= per_exposure;
  }
  blob.area_px = peak.area_px;
  blob.saturated_px = peak.clipped_px;
  blob.row_fraction = (light.centre_px.y() + 0.5) / luma.height_px - 0.5;
  if (peak.clipped_px > 0) blob.defects = blob.defects | Defect::saturated;
  if (light.bad_fit) blob.defects = blob.defects | Defect::bad_fit;
  if (light.cut_by_edge) blob.defects = blob.defects | Defect::cut_by_edge;
  if (peak.clipped_px >= kLeastClippedForShape_px && light.elongation > kTwoLampElongation)
    blob.defects = blob.defects | Defect::merged;
  // The level is half the peak; the rim goes on to an eighth. Of what hardly outshines its
  // surroundings these would be the most of that.
  const int rim_code = light.lamp_like ? half_code[half_code[peak.level_code]] : peak.level_code;
  RimColour rim = rim_colour(frame, peak.box, rim_code, clip_code);
  if (peak.clipped_px == 0) {
    const auto above_background =
        std::ranges::lower_bound(linear, static_cast<float>(std::max(light.background, 1e-6)));
    rim = own_colour(rim, static_cast<int>(above_background - linear.begin()), clip_code);
  }
  blob.cr = rim.cr;
  blob.cb = rim.cb;
  blob.colour_chance = rim.chance;
  blob.kind = kind_of(peak, light, linear[peak.peak_code], rim,
                      px_per_usual(luma.width_px, luma.height_px));
  return blob;
}

Detector::Detector(DetectOptions options, Response response, std::optional<double> exposure_s,
                   const std::optional<PsfSite>& psf)
    : state_(std::make_unique<State>()) {
  std::string faults;
  for (const std::string& problem : options.problems()) faults += "; " + problem;
  if (exposure_s && !(*exposure_s > 0.0))
    faults += "; exposure_s = " + std::to_string(*exposure_s) + ", must be > 0";
  if (!faults.empty()) throw std::invalid_argument("Detector: " + faults.substr(2));
  state_->options = options;
  state_->response = std::move(response);
  state_->exposure_s = exposure_s;
  if (psf) state_->lamp_meter.emplace(*psf, exposure_s);
}

Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::optional<FrameLight> Detector::State::look(const Frame& frame, bool dim_red) {
  const LumaView& luma = frame.luma;
  if (luma.data == nullptr || luma.width_px <= 0 || luma.height_px <= 0) return std::nullopt;
  check(frame);
  const Levels levels = level_meter.measure(luma, options);
  find_runs(luma, levels.threshold_code, runs);
  prepare_tables(luma, levels);
  group_runs(runs, groups);

  PeakRules rules;
  rules.clip_code = clip_meter.update(luma, runs);
  const double span = luma.white_code - luma.black_code;
  rules.least_valley_codes = static_cast<int>(
      std::ceil(std::max(options.min_valley_fraction * span, kValleySigma * levels.noise_codes)));
  rules.min_area_px = options.min_area_px;
  // It may be above the deepest code, where nothing is bright.
  const std::size_t threshold =
      std::min(static_cast<std::size_t>(levels.threshold_code), sigma.size() - 1);
  rules.noise_codes = sigma[threshold] / std::max(slope[threshold], 1e-9f);
  rules.upright = frame.rotation_deg == 0;
  rules.half_code = half_code;
  finder.clear();
  for (std::size_t g = 0; g < groups.count(); ++g) {
    const auto from = static_cast<std::size_t>(groups.first[g]);
    const auto to = static_cast<std::size_t>(groups.first[g + 1]);
    finder.add(luma, std::span<const int>(groups.order).subspan(from, to - from), runs,
               levels.threshold_code, rules);
  }
  bright = finder.peaks().size();
  if (dim_red) red_lights.add_to(finder, frame, levels, rules);
  if (finder.peaks().empty()) return std::nullopt;

  const LightScale scale{linear, sigma, coding_sigma, rules.clip_code,
                         options.lossy ? kPlaces.errors : CodingErrors{}};
  lights = &photometer.measure(luma, finder, scale);
  coded_light.reset();
  if (options.lossy) coded_light = frame_light(luma, levels, rules.clip_code, kLights);
  return frame_light(luma, levels, rules.clip_code, kPlaces);
}

std::optional<SeenLights> Detector::look(const Frame& frame) {
  const std::optional<FrameLight> light = state_->look(frame, false);
  if (!light) return std::nullopt;
  return SeenLights{*light, state_->finder.peaks(), *state_->lights};
}

BlobFrame Detector::detect(const Frame& frame) {
  BlobFrame result{frame.index, frame.time, {}};
  State& state = *state_;
  const std::optional<FrameLight> light = state.look(frame, true);
  if (!light) return result;
  const std::vector<Peak>& peaks = state.finder.peaks();
  std::vector<Measured>& lights = *state.lights;
  if (state.lamp_meter)
    state.lamp_meter->measure(*light, state.coded_light ? &*state.coded_light : nullptr, frame.time,
                              peaks, lights);
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    Blob blob = state.blob_of(frame, peaks[i], lights[i], light->clip_code);
    if (i >= state.bright && !is_dim_tail_lamp(blob)) continue;
    blob.id = static_cast<int>(result.blobs.size());
    result.blobs.push_back(std::move(blob));
  }
  return result;
}

}  // namespace vildar
