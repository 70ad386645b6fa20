#include "detect/red_lights.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace vildar {
namespace {

constexpr double kLeastRed = 0.055, kRedSigmas = 4.0;     // of the range of Cr, of luma's noise
constexpr double kLeastLight = 0.03, kLightSigmas = 5.0;  // of black to white
constexpr double kLevel = 0.4, kLevelSigmas = 2.5;        // of the peak over its surroundings
constexpr std::size_t kMostLights = 200;
constexpr int kFewest_samples = 2, kWidest_samples = 40;  // of Cr
constexpr int kMargin_px = 2, kRing_px = 3;

PixelBox box_of(const std::vector<PixelRun>& runs, std::span<const int> indices) {
  const PixelRun& first = runs[static_cast<std::size_t>(indices.front())];
  PixelBox box{first.u_begin, first.v, first.u_end - 1, first.v};
  for (const int index : indices) {
    const PixelRun& run = runs[static_cast<std::size_t>(index)];
    box.u_min = std::min(box.u_min, run.u_begin);
    box.u_max = std::max(box.u_max, run.u_end - 1);
    box.v_max = std::max(box.v_max, run.v);
  }
  return box;
}

std::span<const int> group_of(const RunGroups& groups, std::size_t g) {
  const auto from = static_cast<std::size_t>(groups.first[g]);
  return std::span<const int>(groups.order)
      .subspan(from, static_cast<std::size_t>(groups.first[g + 1]) - from);
}

PixelBox grown(const PixelBox& box, int by_px, const LumaView& luma) {
  return {std::max(box.u_min - by_px, 0), std::max(box.v_min - by_px, 0),
          std::min(box.u_max + by_px, luma.width_px - 1),
          std::min(box.v_max + by_px, luma.height_px - 1)};
}

bool meet(const PixelBox& a, const PixelBox& b) {
  return a.u_min <= b.u_max && b.u_min <= a.u_max && a.v_min <= b.v_max && b.v_min <= a.v_max;
}

/// Mean along the border of a box.
double code_about(const LumaView& luma, const PixelBox& box) {
  double sum = 0.0;
  int count = 0;
  for (int v = box.v_min; v <= box.v_max; ++v) {
    const bool whole = v == box.v_min || v == box.v_max;
    for (int u = box.u_min; u <= box.u_max; u += whole ? 1 : std::max(1, box.u_max - box.u_min)) {
      sum += luma.code(u, v);
      ++count;
    }
  }
  return sum / count;
}

}  // namespace

bool RedLights::look_at(const ChromaView& chroma, int width, int height) {
  if (!chroma.present()) return false;
  red_ = {};
  red_.width_px = (width + (1 << chroma.shift_u) - 1) >> chroma.shift_u;
  red_.height_px = (height + (1 << chroma.shift_v) - 1) >> chroma.shift_v;
  red_.bit_depth = chroma.bit_depth;
  red_.data = chroma.cr;
  red_.stride_bytes = chroma.stride_bytes;
  if (chroma.step_bytes == 1) return true;
  const auto bytes = static_cast<std::size_t>(red_.bytes_per_sample());
  const auto columns = static_cast<std::size_t>(red_.width_px);
  const auto step = static_cast<std::size_t>(chroma.step_bytes) * bytes;
  apart_.resize(columns * bytes * static_cast<std::size_t>(red_.height_px));
  std::uint8_t* to = apart_.data();
  for (int v = 0; v < red_.height_px; ++v) {
    const std::uint8_t* from = chroma.cr + v * chroma.stride_bytes;
    for (std::size_t u = 0; u < columns; ++u, from += step) to = std::copy_n(from, bytes, to);
  }
  red_.data = apart_.data();
  red_.stride_bytes = static_cast<std::ptrdiff_t>(columns * bytes);
  return true;
}

void RedLights::find_pixels(const LumaView& luma, const PixelBox& box, const Levels& levels) {
  runs_.clear();
  const double about = code_about(luma, grown(box, kRing_px, luma));
  int most = 0;
  for (int v = box.v_min; v <= box.v_max; ++v)
    most = std::max(most, brightest_of(luma, {v, box.u_min, box.u_max + 1}));
  const double light = most - about, span = luma.white_code - luma.black_code;
  if (light < std::max(kLeastLight * span, kLightSigmas * levels.noise_codes)) return;
  level_code_ = static_cast<int>(
      std::ceil(about + std::max(kLevel * light, kLevelSigmas * levels.noise_codes)));
  for (int v = box.v_min; v <= box.v_max; ++v) {
    int begin = -1;
    for_each_code(luma, {v, box.u_min, box.u_max + 1}, [&](int u, int code) {
      if (code >= level_code_ && begin < 0) begin = u;
      if (begin >= 0 && (code < level_code_ || u == box.u_max)) {
        runs_.push_back({v, begin, code < level_code_ ? u : u + 1});
        begin = -1;
      }
    });
  }
  for (PixelRun& run : runs_) run.most_code = brightest_of(luma, run);
}

void RedLights::add_to(PeakFinder& finder, const Frame& frame, const Levels& levels,
                       PeakRules rules) {
  const LumaView& luma = frame.luma;
  const ChromaView& chroma = frame.chroma;
  if (!look_at(chroma, luma.width_px, luma.height_px)) return;
  const double range = 1 << chroma.bit_depth;
  const double noise = levels.noise_codes * range / (1 << luma.bit_depth);
  const double least_red = 0.5 * range + std::max(kLeastRed * range, kRedSigmas * noise);
  find_runs(red_, static_cast<int>(std::ceil(least_red)), red_runs_);
  if (red_runs_.empty()) return;
  group_runs(red_runs_, red_groups_);
  rules.noise_codes = levels.noise_codes;
  places_.clear();
  for (std::size_t g = 0; g < red_groups_.count(); ++g) {
    const auto red = group_of(red_groups_, g);
    const PixelBox at = box_of(red_runs_, red);
    int samples = 0;
    for (const int index : red) {
      const PixelRun& run = red_runs_[static_cast<std::size_t>(index)];
      samples += run.u_end - run.u_begin;
    }
    if (samples < kFewest_samples ||
        std::max(at.u_max - at.u_min, at.v_max - at.v_min) >= kWidest_samples)
      continue;
    const PixelBox box =
        grown({at.u_min << chroma.shift_u, at.v_min << chroma.shift_v,
               ((at.u_max + 1) << chroma.shift_u) - 1, ((at.v_max + 1) << chroma.shift_v) - 1},
              kMargin_px, luma);
    places_.push_back(box);
  }
  if (places_.size() > kMostLights) return;
  for (const PixelBox& box : places_) {
    if (std::ranges::any_of(finder.peaks(), [&](const Peak& peak) { return meet(peak.box, box); }))
      continue;
    find_pixels(luma, box, levels);
    if (runs_.empty()) continue;
    group_runs(runs_, groups_);
    for (std::size_t i = 0; i < groups_.count(); ++i)
      finder.add(luma, group_of(groups_, i), runs_, level_code_, rules);
  }
}

bool is_dim_tail_lamp(const Blob& blob) {
  constexpr double kTall = 1.6, kGive_px = 1.0;
  const double width_px = blob.box.u_max - blob.box.u_min + 1.0;
  const double height_px = blob.box.v_max - blob.box.v_min + 1.0;
  return blob.kind == LampKind::taillamp && height_px < kTall * width_px + kGive_px;
}

}  // namespace vildar
