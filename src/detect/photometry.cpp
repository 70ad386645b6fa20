#include "detect/photometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/quantity.h"
#include "detect/kind.h"
#include "detect/rim_fit.h"
#include "optics/picture.h"

namespace vildar {
namespace {

constexpr double kApertureSpreads = 3.5;  // 99.8 % of a gaussian's light lies within
/// Standard deviation of the share of it that a lens' wings spread further than that.
constexpr double kUntoldWings = 0.03;
constexpr double kWindowSpreads = 3.0;
constexpr double kLeastSpread_px = 0.45;
constexpr int kRingWidth_px = 3;
constexpr int kIterations = 6;
/// Error that remains however bright the light: pixel phase of a sharp one, shape of a clipped one.
constexpr double kFloorSharp_px = 0.02;
constexpr double kFloorSmooth_px = 0.003;
constexpr double kFloorClipped_px = 0.05;
constexpr double kAsymmetryShare = 0.3;
/// Of the pixels that coding makes err together; what both sides of a light share moves no centre.
constexpr double kAlikeInCentroid = 0.5;

/// What a pixel brings into the variance of a sum, linear squared.
double variance_in_sum(const LightScale& scale, int code, double alike = 1.0) {
  const double noise = scale.sigma[code], coding = scale.coding_sigma[code];
  return noise * noise + alike * scale.coding.correlated_px * coding * coding;
}

/// Error of a clipped light's centre that its outline leaves, px. Each of the 2 pi R pixels on the
/// rim of a disc is in or out by rounding, area variance 1/12 each: the centroid's variance is 1 /
/// (12 pi R). Rim pixels that are bright but not clipped tell more. Where the disc runs into
/// another, the side that cannot be seen costs a share of its radius.
double shape_sigma(const Peak& peak) {
  constexpr double kHiddenSideShare = 0.12;
  const double radius_px = std::sqrt(std::max(peak.clipped_px, 1) / kPi) + peak.eroded_px;
  const double rim_px = 2.0 * kPi * radius_px;
  const double graded = static_cast<double>(peak.count - peak.clipped_px) / rim_px;
  const double outline_px = std::sqrt(1.0 / (12.0 * kPi * radius_px)) / (1.0 + graded);
  return std::hypot(outline_px, peak.eroded_px > 0 ? kHiddenSideShare * radius_px : 0.0);
}

/// Inclusive pixel range around `centre`, inside 0..size - 1.
struct Range {
  int from, to;
  Range(double centre, double reach, int size)
      : from(std::max(0, static_cast<int>(std::ceil(centre - reach)))),
        to(std::min(size - 1, static_cast<int>(std::floor(centre + reach)))) {}
};

}  // namespace

Measured Photometer::first_guess(const LumaView& luma, std::span<const PixelAt> pixels,
                                 const Peak& peak, const LightScale& scale) const {
  Measured light;
  const double least = scale.linear[peak.level_code];
  double sum = 0.0, mean_u = 0.0, mean_v = 0.0;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero(), square = Eigen::Vector2d::Zero();
  double cross = 0.0;
  for (const PixelAt& at : pixels) {
    const double light_here =
        scale.linear[std::min(luma.code(at.u, at.v), scale.clip_code)] - least + 1e-6;
    sum += light_here;
    mean_u += light_here * at.u;
    mean_v += light_here * at.v;
    middle += Eigen::Vector2d(at.u, at.v);
  }
  light.centre_px = Eigen::Vector2d(mean_u / sum, mean_v / sum);
  const double n = static_cast<double>(pixels.size());
  middle /= n;
  for (const PixelAt& at : pixels) {
    const Eigen::Vector2d offset = Eigen::Vector2d(at.u, at.v) - middle;
    square += offset.cwiseAbs2();
    cross += offset.x() * offset.y();
  }
  square = square.array() / n + 1.0 / 12.0;  // a pixel is a square, not a point
  cross /= n;
  const double half_sum = 0.5 * square.sum();
  const double swing = std::hypot(0.5 * (square.x() - square.y()), cross);
  light.elongation = std::sqrt((half_sum + swing) / std::max(half_sum - swing, 1.0 / 12.0));
  // Pixels above half the peak of a gaussian: a disc of radius 1.18 s, of variance 0.69 s^2.
  light.spread_px = (square / 0.69).cwiseSqrt().array() + 0.6 * peak.eroded_px;
  light.spread_px = light.spread_px.cwiseMax(kLeastSpread_px);
  light.cut_by_edge = peak.box.u_min == 0 || peak.box.v_min == 0 ||
                      peak.box.u_max == luma.width_px - 1 || peak.box.v_max == luma.height_px - 1;
  return light;
}

int Photometer::median_of_ring(std::size_t codes) {
  counts_.resize(std::max(counts_.size(), codes));
  for (const int code : ring_) ++counts_[code];
  int median = *std::min_element(ring_.begin(), ring_.end());
  for (int rank = static_cast<int>(ring_.size() / 2); rank >= counts_[median]; ++median)
    rank -= counts_[median];
  for (const int code : ring_) counts_[code] = 0;
  return median;
}

void Photometer::find_background(const LumaView& luma, const LightScale& scale, Measured& light) {
  const Eigen::Vector2d reach = kApertureSpreads * light.spread_px;
  const Range inner_u(light.centre_px.x(), reach.x() + 0.5, luma.width_px);
  const Range inner_v(light.centre_px.y(), reach.y() + 0.5, luma.height_px);
  const Range outer_u(light.centre_px.x(), reach.x() + 0.5 + kRingWidth_px, luma.width_px);
  const Range outer_v(light.centre_px.y(), reach.y() + 0.5 + kRingWidth_px, luma.height_px);
  ring_.clear();
  // A wide ring has more pixels than a background needs.
  const int step = 1 + static_cast<int>(reach.sum() / 24.0);
  for (int v = outer_v.from; v <= outer_v.to; v += v < inner_v.from || v >= inner_v.to ? 1 : step) {
    const bool beside = v >= inner_v.from && v <= inner_v.to;
    for (int u = outer_u.from; u <= outer_u.to; u += beside ? 1 : step) {
      if (beside && u >= inner_u.from && u <= inner_u.to) u = inner_u.to + 1;
      if (u <= outer_u.to) ring_.push_back(luma.code(u, v));
    }
  }
  if (ring_.empty()) {
    light.background = 0.0;
    light.background_sigma = scale.sigma[0];
    return;
  }
  const int code = median_of_ring(scale.linear.size());
  // The mean of the codes near the median is finer than the median, which is a whole code.
  const double reach_linear =
      3.0 * scale.sigma[code] +
      scale.linear[std::min<std::size_t>(code + 1, scale.linear.size() - 1)] - scale.linear[code];
  double sum = 0.0;
  int n = 0;
  for (const int other : ring_) {
    if (std::abs(scale.linear[other] - scale.linear[code]) > reach_linear) continue;
    sum += scale.linear[other];
    ++n;
  }
  light.background = sum / n;
  light.background_sigma = std::sqrt(variance_in_sum(scale, code) / n);
}

void Photometer::find_neighbours(std::size_t index) {
  neighbours_.clear();
  const Measured& light = lights_[index];
  const double size = light.spread_px.maxCoeff();
  for (std::size_t j = 0; j < lights_.size(); ++j) {
    if (j == index) continue;
    const Eigen::Vector2d apart = lights_[j].centre_px - light.centre_px;
    const double reach = kApertureSpreads * (size + lights_[j].spread_px.maxCoeff());
    if (std::abs(apart.x()) > reach || std::abs(apart.y()) > reach) continue;
    const double distance = apart.norm();
    if (distance < 0.5) continue;
    neighbours_.push_back(
        {apart / distance, distance * size / (size + lights_[j].spread_px.maxCoeff())});
  }
}

bool Photometer::beyond(const Eigen::Vector2d& offset) const {
  return std::any_of(neighbours_.begin(), neighbours_.end(), [&](const Neighbour& neighbour) {
    return offset.dot(neighbour.towards) > neighbour.limit_px;
  });
}

// Columns of the row `dv_px` below the light that are no neighbour's, on both sides of the centre.
Photometer::Columns Photometer::own_columns(double dv_px, const Measured& light, int from,
                                            int to) const {
  constexpr double kAcross = 1e-9;  // of a unit vector
  for (const Neighbour& neighbour : neighbours_) {
    const double tu = neighbour.towards.x(), along = dv_px * neighbour.towards.y();
    if (std::abs(tu) < kAcross) {
      if (std::abs(along) > neighbour.limit_px) return {from, from - 1};
      continue;
    }
    const double middle = light.centre_px.x() - along / tu;
    const double half = neighbour.limit_px / std::abs(tu);
    from = std::max(from,
                    static_cast<int>(std::ceil(std::clamp(middle - half, from - 1.0, to + 1.0))));
    to =
        std::min(to, static_cast<int>(std::floor(std::clamp(middle + half, from - 1.0, to + 1.0))));
  }
  return {from, to};
}

void Photometer::set_window(const LumaView& luma, const Measured& light, int step) {
  const Eigen::Vector2d& s = light.spread_px;
  const Range range_u(light.centre_px.x(), kWindowSpreads * s.x(), luma.width_px);
  const Range range_v(light.centre_px.y(), kWindowSpreads * s.y(), luma.height_px);
  window_u_.clear();
  for (int u = range_u.from; u <= range_u.to; ++u) {
    const double offset = u - light.centre_px.x(), z = offset / s.x();
    window_u_.push_back({std::exp(-0.5 * z * z), offset});
  }
  rows_.clear();
  for (int v = range_v.from; v <= range_v.to; v += step) {
    const double offset = v - light.centre_px.y(), z = offset / s.y();
    const Columns own = own_columns(offset, light, range_u.from, range_u.to);
    const int first = own.from + (range_u.from - own.from) % step;
    rows_.push_back({v, first < own.from ? first + step : first, own.to, range_u.from, offset,
                     std::exp(-0.5 * z * z)});
  }
}

// Windowed centroid (as SExtractor's XWIN_IMAGE): weights of the light's own shape come within a
// few per cent of the Cramer-Rao bound of a gaussian. A window cut off on one side for a neighbour
// is cut off on the other as well, so that it pulls the centre nowhere.
void Photometer::refine_centre(const LumaView& luma, const LightScale& scale, const Peak& peak,
                               Measured& light) {
  const Eigen::Vector2d start_px = light.centre_px;
  const Eigen::Vector2d most_spread = 1.5 * light.spread_px;
  // What a light shares with a neighbour lies below the valley between them.
  const bool above_valley = peak.split && peak.eroded_px == 0;
  const double floor = above_valley
                           ? std::max<double>(light.background, scale.linear[peak.level_code])
                           : light.background;
  const double least = above_valley ? 0.0 : -std::numeric_limits<double>::infinity();
  double sum = 0.0;
  Eigen::Vector2d gain = Eigen::Vector2d::Zero();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::Vector2d s = light.spread_px;
    // Wide lights come near their centre on a coarser grid; the last iterations see every pixel.
    const bool coarse = iteration < kIterations - 2;
    const int step = coarse ? 1 + static_cast<int>(s.minCoeff() / 5.0) : 1;
    set_window(luma, light, step);
    double here = 0.0;
    Eigen::Vector2d first = Eigen::Vector2d::Zero(), second = Eigen::Vector2d::Zero();
    for (const WindowRow& row : rows_) {
      double in_row = 0.0, first_u = 0.0, second_u = 0.0;
      for (int u = row.from; u <= row.to; u += step) {
        const auto& [weight, offset] = window_u_[u - row.window_from];
        const int code = std::min(luma.code(u, row.v), scale.clip_code);
        const double weighted = weight * std::max(scale.linear[code] - floor, least);
        in_row += weighted;
        first_u += weighted * offset;
        second_u += weighted * offset * offset;
      }
      here += row.weight * in_row;
      first += row.weight * Eigen::Vector2d(first_u, in_row * row.offset_px);
      second += row.weight * Eigen::Vector2d(second_u, in_row * row.offset_px * row.offset_px);
    }
    if (!(here > 0.0)) break;
    sum = here;
    const Eigen::Vector2d mean = first / sum;
    const Eigen::Vector2d windowed = (second / sum - mean.cwiseAbs2())
                                         .cwiseMax(0.05 * s.cwiseAbs2())
                                         .cwiseMin(0.8 * s.cwiseAbs2());
    gain = (1.0 - windowed.array() / s.array().square()).inverse();
    const Eigen::Vector2d move = mean.cwiseProduct(gain).cwiseMax(-s).cwiseMin(s);
    light.centre_px += move;
    light.spread_px =
        windowed.cwiseProduct(gain).cwiseSqrt().cwiseMax(kLeastSpread_px).cwiseMin(most_spread);
    if (step == 1 && move.cwiseAbs().maxCoeff() < 1e-3 && iteration >= 3) break;
  }
  Eigen::Vector2d variance = Eigen::Vector2d::Zero();
  for (const WindowRow& row : rows_) {
    double in_row = 0.0, by_u = 0.0;
    for (int u = row.from; u <= row.to; ++u) {
      const auto& [weight, offset] = window_u_[u - row.window_from];
      const int code = std::min(luma.code(u, row.v), scale.clip_code);
      if (scale.linear[code] - floor <= least) continue;
      const double noise2 = weight * weight * variance_in_sum(scale, code, kAlikeInCentroid);
      in_row += noise2;
      by_u += noise2 * offset * offset;
    }
    variance +=
        row.weight * row.weight * Eigen::Vector2d(by_u, in_row * row.offset_px * row.offset_px);
  }
  if (sum > 0.0) variance = variance.cwiseProduct(gain.cwiseAbs2()) / (sum * sum);
  const double shape_sigma_px = shape_sigma(peak);
  for (int axis = 0; axis < 2; ++axis) {
    const double sharpness = std::clamp(1.2 - light.spread_px[axis], 0.0, 0.5) / 0.5;
    double floor_px = std::lerp(kFloorSmooth_px, kFloorSharp_px, sharpness);
    if (peak.clipped_px > 0)
      floor_px = std::hypot(kFloorClipped_px, shape_sigma_px,
                            kAsymmetryShare * (light.centre_px[axis] - start_px[axis]));
    floor_px = std::max(floor_px, scale.coding.centre_px);
    light.centre_sigma_px[axis] = std::hypot(std::sqrt(variance[axis]), floor_px);
  }
}

// For lit surfaces, which have no centre worth refining: the light of their own pixels, and a
// centre known to a share of their size.
void Photometer::sum_pixels(const LumaView& luma, std::span<const PixelAt> pixels,
                            const LightScale& scale, Measured& light) const {
  constexpr double kCentreShare = 0.25;
  constexpr double kBelowLevelShare = 0.5;  // light that its level leaves out
  double sum = 0.0, variance = 0.0;
  for (const PixelAt& at : pixels) {
    const int code = luma.code(at.u, at.v);
    sum += scale.linear[code] - light.background;
    variance += variance_in_sum(scale, code);
  }
  light.flux = std::max(sum, 0.0);
  light.flux_sigma =
      std::hypot(std::sqrt(variance), static_cast<double>(pixels.size()) * light.background_sigma,
                 kBelowLevelShare * light.flux);
  light.centre_sigma_px = kCentreShare * light.spread_px;
}

void Photometer::sum_flux(const LumaView& luma, const LightScale& scale, Measured& light) const {
  const Eigen::Vector2d reach = (kApertureSpreads * light.spread_px).array() + 0.5;
  const Range range_u(light.centre_px.x(), reach.x(), luma.width_px);
  const Range range_v(light.centre_px.y(), reach.y(), luma.height_px);
  double sum = 0.0, variance = 0.0, pixels = 0.0;
  for (int v = range_v.from; v <= range_v.to; ++v) {
    for (int u = range_u.from; u <= range_u.to; ++u) {
      Eigen::Vector2d offset(u - light.centre_px.x(), v - light.centre_px.y());
      if (offset.cwiseQuotient(reach).squaredNorm() > 1.0) continue;
      int from_u = u, from_v = v;
      if (!neighbours_.empty() && beyond(offset)) {
        // What the neighbour covers is taken from the opposite side of the centre.
        if (beyond(-offset)) continue;
        from_u = static_cast<int>(std::lround(light.centre_px.x() - offset.x()));
        from_v = static_cast<int>(std::lround(light.centre_px.y() - offset.y()));
        if (from_u < 0 || from_v < 0 || from_u >= luma.width_px || from_v >= luma.height_px)
          continue;
      }
      const int code = luma.code(from_u, from_v);
      sum += scale.linear[code] - light.background;
      variance += variance_in_sum(scale, code);
      pixels += 1.0;
    }
  }
  light.flux = sum;
  light.flux_sigma = std::hypot(std::sqrt(variance), pixels * light.background_sigma,
                                std::max(scale.coding.flux_share, kUntoldWings) * sum);
}

std::vector<Measured>& Photometer::measure(const LumaView& luma, const PeakFinder& finder,
                                           const LightScale& scale) {
  const std::vector<Peak>& peaks = finder.peaks();
  lights_.clear();
  for (const Peak& peak : peaks)
    lights_.push_back(first_guess(luma, finder.pixels(peak), peak, scale));
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    find_background(luma, scale, lights_[i]);
    lights_[i].lamp_like = like_a_lamp(peaks[i], lights_[i], scale.linear[peaks[i].peak_code], 0.0,
                                       px_per_usual(luma.width_px, luma.height_px));
    if (!lights_[i].lamp_like) {
      sum_pixels(luma, finder.pixels(peaks[i]), scale, lights_[i]);
      continue;
    }
    find_neighbours(i);
    Measured light = lights_[i];
    refine_centre(luma, scale, peaks[i], light);
    if (peaks[i].eroded_px > 0) {
      // The deepest part of its plateau, where the first guess lies, is inside its own disc.
      hidden_.clear();
      for (const Neighbour& neighbour : neighbours_) hidden_.push_back(neighbour.towards);
      const auto circle = fit_rim(luma, scale.clip_code, lights_[i].centre_px, hidden_);
      if (circle) {
        light.centre_px = circle->centre_px;
        light.centre_sigma_px.setConstant(std::hypot(kFloorClipped_px, circle->centre_sigma_px));
      }
    }
    find_background(luma, scale, light);
    sum_flux(luma, scale, light);
    if (peaks[i].clipped_px > 0) light.flux_sigma = std::hypot(light.flux_sigma, light.flux);
    lights_[i] = light;
  }
  return lights_;
}

}  // namespace vildar
