#include "track/lamp_parts.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

namespace vildar {
namespace {

constexpr double kBeside_m = 0.25, kAbove_m = 0.16, kLargest_m = 0.42;

/// Beside one another, or above, if nothing clips: else that may hold its image on a wet road, or a
/// fog lamp, below it.
bool belong_together(const Blob& a, const Blob& b, double px_per_m) {
  const Eigen::Vector2d apart_px = (a.centre_px - b.centre_px).cwiseAbs();
  const bool beside = apart_px.x() > apart_px.y();
  // An indicator beside a lamp is no part of that.
  constexpr double kTwins = 2.0;
  if (a.kind == LampKind::headlamp && std::max(a.flux, b.flux) > kTwins * std::min(a.flux, b.flux))
    return false;
  return (beside || a.saturated_px + b.saturated_px == 0) &&
         apart_px.norm() < (beside ? kBeside_m : kAbove_m) * px_per_m;
}

PixelBox box_of_both(const PixelBox& a, const PixelBox& b) {
  return {std::min(a.u_min, b.u_min), std::min(a.v_min, b.v_min), std::max(a.u_max, b.u_max),
          std::max(a.v_max, b.v_max)};
}

/// Pixels per metre at a light, for the farthest that it may be; 0 where that is not known.
double least_px_per_m(const Blob& blob, const RoadView& view) {
  constexpr double kSigmas = 2.0;
  const auto at_px = view.spot_from_pixel(blob.centre_px);
  if (!at_px) return 0.0;
  const LampPlace place = view.place(*at_px);
  const double inverse_depth_per_m =
      place.inverse_depth_per_m - kSigmas * view.inverse_depth_sigma_per_m(place);
  return std::max(0.0, inverse_depth_per_m * place.across_px.norm());
}

Blob sum_of(const std::vector<const Blob*>& parts) {
  // Each picture shows another share of the light in each part, or may have lost one of them.
  constexpr double kUnevenShare = 0.1, kLostShare = 0.5;
  constexpr double kLeastFlux = 1e-9;
  const auto weight_of = [=](const Blob& part) { return std::max(part.flux, kLeastFlux); };
  const Blob& brightest = **std::ranges::max_element(parts, {}, &Blob::flux);
  Blob lamp = brightest;
  lamp.lamp.reset();
  lamp.flux = lamp.flux_sigma = lamp.cr = lamp.cb = lamp.row_fraction = 0.0;
  lamp.area_px = lamp.saturated_px = 0;
  lamp.centre_px.setZero();
  lamp.centre_sigma_px.setZero();
  double weights = 0.0;
  for (const Blob* part : parts) weights += weight_of(*part);
  for (const Blob* part : parts) {
    const double share = weight_of(*part) / weights;
    lamp.flux += part->flux;
    lamp.flux_sigma += part->flux_sigma;
    lamp.area_px += part->area_px;
    lamp.saturated_px += part->saturated_px;
    lamp.box = box_of_both(lamp.box, part->box);
    lamp.defects = lamp.defects | part->defects;
    lamp.centre_px += share * part->centre_px;
    lamp.centre_sigma_px += share * part->centre_sigma_px;
    lamp.row_fraction += share * part->row_fraction;
    lamp.cr += share * part->cr;
    lamp.cb += share * part->cb;
  }
  Eigen::Vector2d square = Eigen::Vector2d::Zero();
  for (const Blob* part : parts)
    square += weight_of(*part) / weights *
              ((part->centre_px - lamp.centre_px).cwiseAbs2() + part->spread_px.cwiseAbs2());
  lamp.spread_px = square.cwiseSqrt();
  lamp.centre_sigma_px += kUnevenShare * lamp.spread_px +
                          kLostShare * (brightest.centre_px - lamp.centre_px).cwiseAbs();
  return lamp;
}

/// Moves those of `others` that are parts of one lamp with the first of `parts` behind it.
void gather(std::vector<const Blob*>& parts, std::vector<const Blob*>& others, double px_per_m) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    std::erase_if(others, [&, &part = *parts[i]](const Blob* other) {
      const auto is_near = [&](const Blob* one) {
        return (other->centre_px - one->centre_px).norm() < kLargest_m * px_per_m;
      };
      const bool belongs =
          belong_together(*other, part, px_per_m) && std::ranges::all_of(parts, is_near);
      if (belongs) parts.push_back(other);
      return belongs;
    });
}

}  // namespace

void join_lamp_parts(BlobFrame& frame, const RoadView& view) {
  std::vector<Blob> joined;
  std::vector<char> is_part(frame.blobs.size(), 0);
  for (const LampKind kind : {LampKind::taillamp, LampKind::headlamp}) {
    std::vector<const Blob*> left;
    for (const Blob& blob : frame.blobs)
      if (blob.kind == kind) left.push_back(&blob);
    std::ranges::stable_sort(left, std::ranges::greater{}, &Blob::flux);
    while (!left.empty()) {
      std::vector<const Blob*> parts{left.front()};
      left.erase(left.begin());
      gather(parts, left, least_px_per_m(*parts.front(), view));
      if (parts.size() == 1) continue;
      joined.push_back(sum_of(parts));
      for (const Blob* part : parts)
        is_part[static_cast<std::size_t>(part - frame.blobs.data())] = 1;
    }
  }
  if (joined.empty()) return;
  std::vector<Blob> blobs;
  for (std::size_t i = 0; i < frame.blobs.size(); ++i)
    if (!is_part[i]) blobs.push_back(std::move(frame.blobs[i]));
  std::ranges::move(joined, std::back_inserter(blobs));
  for (std::size_t i = 0; i < blobs.size(); ++i) blobs[i].id = static_cast<int>(i);
  frame.blobs = std::move(blobs);
}

}  // namespace vildar
