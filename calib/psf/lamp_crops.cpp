#include "calib/psf/lamp_crops.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "detect/lamp_meter.h"

namespace vildar {
namespace {

constexpr double kMostRim_px = 45.0;
constexpr double kLeastPeak = 0.25;     // of white: fainter lamps show no wings
constexpr double kWidestCore_px = 1.5;  // for the reach alone
constexpr double kMostMotion_px = 0.35;
constexpr double kMostMove_px = 25.0, kSameShare = 0.4;
constexpr double kMostElongation = 1.4;
constexpr int kLeastClippedForShape_px = 12;
constexpr std::size_t kMostTogether = 2;
constexpr std::size_t kMostOfLamp = 12, kMostOfSize = 48;

int size_class(double rim_px) {
  return rim_px > 0.0 ? 1 + static_cast<int>(std::log2(std::max(rim_px, 1.0))) : 0;
}

LumaView copy_of(const LumaView& luma, int u_min, int v_min, int u_max, int v_max) {
  LumaView copy = luma;
  copy.width_px = u_max - u_min + 1;
  copy.height_px = v_max - v_min + 1;
  copy.stride_bytes = copy.width_px * luma.bytes_per_sample();
  auto pixels = std::make_shared<std::vector<std::uint8_t>>(
      static_cast<std::size_t>(copy.stride_bytes) * static_cast<std::size_t>(copy.height_px));
  for (int v = 0; v < copy.height_px; ++v)
    std::memcpy(pixels->data() + static_cast<std::ptrdiff_t>(v) * copy.stride_bytes,
                luma.row(v_min + v) + u_min * luma.bytes_per_sample(),
                static_cast<std::size_t>(copy.stride_bytes));
  copy.data = pixels->data();
  copy.row_maxima = nullptr;
  copy.owner = std::move(pixels);
  return copy;
}

}  // namespace

void CropCollector::begin_clip(std::optional<double> exposure_s) {
  exposure_s_ = exposure_s;
  before_at_.reset();
  before_.clear();
  tables_.reset();
}

void CropCollector::follow(const Frame& frame, const SeenLights& seen) {
  const std::size_t n = seen.peaks.size();
  now_.assign(n, {});
  exposed_share_ = 1.0;
  if (before_at_ && exposure_s_) {
    const double since_s = std::chrono::duration<double>(frame.time - *before_at_).count();
    exposed_share_ = std::min(1.0, *exposure_s_ / since_s);
  }
  std::vector<Followed> followed;
  for (std::size_t i = 0; i < n; ++i) {
    const Measured& light = seen.lights[i];
    Candidate& now = now_[i];
    now.rim_px = rim_px(seen.peaks[i]);
    now.size_px = light.spread_px.maxCoeff();
    now.reach_px = LampFitter::reach_px(now.rim_px, now.size_px, kWidestCore_px);
    now.usable = light.lamp_like && now.rim_px < kMostRim_px;
    double nearest_px = kMostMove_px / kSameShare;
    for (std::size_t j = 0; j < n; ++j)
      if (j != i)
        nearest_px = std::min(nearest_px, (seen.lights[j].centre_px - light.centre_px).norm());
    double least_px = kSameShare * nearest_px;
    for (const Followed& one : before_) {
      const Eigen::Vector2d moved_px = light.centre_px - one.centre_px;
      if (!(moved_px.norm() < least_px)) continue;
      least_px = moved_px.norm();
      now.moved_px = moved_px;
      now.id = one.id;
    }
    if (now.id < 0) now.id = next_id_++;
    followed.push_back({light.centre_px, now.id});
  }
  before_ = std::move(followed);
  before_at_ = frame.time;
}

// Nothing where more lights overlap than can be parted, or one that is no lamp.
std::optional<std::vector<std::size_t>> CropCollector::group_of(const SeenLights& seen,
                                                                std::size_t first) const {
  std::vector<std::size_t> group{first};
  for (std::size_t k = 0; k < group.size(); ++k)
    for (std::size_t j = 0; j < now_.size(); ++j) {
      if (std::find(group.begin(), group.end(), j) != group.end()) continue;
      const double apart_px = (seen.lights[j].centre_px - seen.lights[group[k]].centre_px).norm();
      if (apart_px > now_[j].reach_px + now_[group[k]].reach_px) continue;
      if (!now_[j].usable || group.size() == kMostTogether) return std::nullopt;
      group.push_back(j);
    }
  return group;
}

const char* CropCollector::fault_of(const SeenLights& seen,
                                    const std::vector<std::size_t>& group) const {
  const LumaView& luma = seen.light.luma;
  for (const std::size_t i : group) {
    const Measured& light = seen.lights[i];
    const Candidate& now = now_[i];
    const Eigen::Vector2d low = light.centre_px.array() - now.reach_px;
    const Eigen::Vector2d high = light.centre_px.array() + now.reach_px;
    if (light.cut_by_edge || !(low.minCoeff() >= 1.0) || !(high.x() < luma.width_px - 2.0) ||
        !(high.y() < luma.height_px - 2.0))
      return "near_edge";
    const auto peak_code = static_cast<std::size_t>(seen.peaks[i].peak_code);
    if (static_cast<double>(seen.light.linear[peak_code]) < kLeastPeak) return "faint";
    if (seen.peaks[i].clipped_px >= kLeastClippedForShape_px && light.elongation > kMostElongation)
      return "not_round";
    if (!now.moved_px) return "first_seen";
    if (now.moved_px->norm() * exposed_share_ > kMostMotion_px) return "moving";
  }
  return nullptr;
}

void CropCollector::keep(const SeenLights& seen, const std::vector<std::size_t>& group) {
  double most_rim_px = 0.0;
  for (const std::size_t i : group) most_rim_px = std::max(most_rim_px, now_[i].rim_px);
  const int size = size_class(most_rim_px), id = now_[group.front()].id;
  Kept& kept = kept_[{size, id}];
  if (kept.seen++ % kept.stride != 0) return;

  Eigen::Vector2d low = seen.lights[group.front()].centre_px, high = low;
  for (const std::size_t i : group) {
    low = low.cwiseMin((seen.lights[i].centre_px.array() - now_[i].reach_px).matrix());
    high = high.cwiseMax((seen.lights[i].centre_px.array() + now_[i].reach_px).matrix());
  }
  const Eigen::Vector2i first = low.array().floor().cast<int>(),
                        last = high.array().ceil().cast<int>();
  if (!tables_)
    tables_ = std::make_shared<LampCrop::Tables>(
        LampCrop::Tables{{seen.light.linear.begin(), seen.light.linear.end()},
                         {seen.light.noise.rounding.begin(), seen.light.noise.rounding.end()}});
  LampCrop crop;
  crop.light = seen.light;
  crop.light.luma = copy_of(seen.light.luma, first.x(), first.y(), last.x(), last.y());
  crop.tables = tables_;
  crop.light.linear = tables_->linear;
  crop.light.noise.rounding = tables_->rounding;
  for (const std::size_t i : group) {
    LampGuess guess;
    guess.centre_px = seen.lights[i].centre_px - first.cast<double>();
    guess.rim_px = now_[i].rim_px;
    guess.size_px = now_[i].size_px;
    crop.lamps.push_back(guess);
  }
  crop.lamp_id = id;
  crop.frame = frames_;
  kept.crops.push_back(std::move(crop));
  if (kept.crops.size() <= kMostOfLamp) return;
  for (std::size_t i = 1; 2 * i < kept.crops.size(); ++i)
    kept.crops[i] = std::move(kept.crops[2 * i]);
  kept.crops.resize((kept.crops.size() + 1) / 2);
  kept.stride *= 2;
}

void CropCollector::add(const Frame& frame, const SeenLights& seen) {
  ++frames_;
  follow(frame, seen);
  std::vector<bool> done(now_.size(), false);
  for (std::size_t i = 0; i < now_.size(); ++i) {
    if (done[i] || !now_[i].usable) continue;
    const auto group = group_of(seen, i);
    if (!group) {
      ++left_out_["crowded"];
      continue;
    }
    for (const std::size_t member : *group) done[member] = true;
    if (const char* fault = fault_of(seen, *group))
      ++left_out_[fault];
    else
      keep(seen, *group);
  }
}

std::vector<LampCrop> CropCollector::crops() const {
  std::map<int, std::vector<const Kept*>> sizes;
  for (const auto& [key, kept] : kept_) sizes[key.first].push_back(&kept);
  std::vector<LampCrop> chosen;
  for (const auto& [size, lamps] : sizes) {
    std::size_t taken = 0;
    for (std::size_t turn = 0; turn < 2 * kMostOfLamp; ++turn)
      for (const Kept* lamp : lamps) {
        if (turn >= lamp->crops.size() || taken == kMostOfSize) continue;
        chosen.push_back(lamp->crops[turn]);
        ++taken;
      }
  }
  return chosen;
}

}  // namespace vildar
