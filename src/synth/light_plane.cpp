#include "synth/light_plane.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr int kFarStep_px = 4;
constexpr float kLeastFar_e = 0.0005F;  // per pixel; far below any read noise
constexpr double kLongestSmearStep_px = 0.3;
constexpr int kMostSmearSteps = 64;

// Integral of the profile over the pixel whose centre is (du, dv) from the lamp's, three Gauss
// points a side.
double pixel_mean(const LampProfile& profile, double du_px, double dv_px) {
  static constexpr double kNode = 0.3872983346207417;  // sqrt(3/5) / 2
  static constexpr double kNodes[3] = {-kNode, 0.0, kNode};
  static constexpr double kWeights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double y_px = dv_px + kNodes[i];
    for (int j = 0; j < 3; ++j) {
      const double x_px = du_px + kNodes[j];
      sum += kWeights[i] * kWeights[j] * profile.near(std::sqrt(x_px * x_px + y_px * y_px));
    }
  }
  return sum;
}

}  // namespace

LightPlane::LightPlane(int width_px, int height_px, const Psf& psf, double exposure_s, double row_s)
    : width_px_(width_px),
      height_px_(height_px),
      psf_(&psf),
      exposure_s_(exposure_s),
      row_s_(row_s),
      spans_(static_cast<std::size_t>(height_px)),
      far_columns_((width_px - 1) / kFarStep_px + 2),
      far_rows_((height_px - 1) / kFarStep_px + 2) {
  const std::size_t pixels = offset(height_px);
  luminance_.resize(pixels);
  red_.resize(pixels);
  blue_.resize(pixels);
  far_.resize(static_cast<std::size_t>(far_columns_) * static_cast<std::size_t>(far_rows_));
}

void LightPlane::clear() {
  for (int v = 0; v < height_px_; ++v) {
    Span& span = spans_[static_cast<std::size_t>(v)];
    if (span.first >= span.last) continue;
    const auto first = static_cast<std::ptrdiff_t>(offset(v)) + span.first;
    for (std::vector<float>* plane : {&luminance_, &red_, &blue_})
      std::fill_n(plane->begin() + first, span.last - span.first, 0.0F);
    span = {};
  }
  if (has_far_) std::fill(far_.begin(), far_.end(), 0.0F);
  has_far_ = false;
}

void LightPlane::touch(int v, int first, int last) {
  Span& span = spans_[static_cast<std::size_t>(v)];
  span = span.first < span.last ? Span{std::min(span.first, first), std::max(span.last, last + 1)}
                                : Span{first, last + 1};
}

void LightPlane::add_streak(const LampImage& lamp) {
  // A uniform disc has the variance radius^2 / 4 along each axis, a pixel 1 / 12.
  const double core2_px2 = psf_->shape().core_sigma_px * psf_->shape().core_sigma_px +
                           0.25 * lamp.disc_radius_px * lamp.disc_radius_px + 1.0 / 12.0;
  const double across_px = std::sqrt(core2_px2);
  const double along_px = std::sqrt(core2_px2 + lamp.streak_px * lamp.streak_px);
  constexpr double kReach = 4.0;
  const auto bounds = [](double centre_px, double sigma_px, int size) {
    return std::pair(std::max(0, static_cast<int>(std::ceil(centre_px - kReach * sigma_px))),
                     std::min(size - 1, static_cast<int>(centre_px + kReach * sigma_px)));
  };
  const auto [u_first, u_last] = bounds(lamp.centre_px.x(), across_px, width_px_);
  const auto [v_first, v_last] = bounds(lamp.centre_px.y(), along_px, height_px_);
  if (u_first > u_last || v_first > v_last) return;
  const auto weight = [](double offset_px, double sigma_px) {
    return std::exp(-0.5 * offset_px * offset_px / (sigma_px * sigma_px)) /
           (std::sqrt(2.0 * kPi) * sigma_px);
  };
  streak_weights_.clear();
  for (int u = u_first; u <= u_last; ++u)
    streak_weights_.push_back(static_cast<float>(weight(u - lamp.centre_px.x(), across_px)));
  for (int v = v_first; v <= v_last; ++v) {
    touch(v, u_first, u_last);
    const auto light = static_cast<float>(lamp.flux * weight(v - lamp.centre_px.y(), along_px));
    const auto red = static_cast<float>(lamp.colour.red),
               blue = static_cast<float>(lamp.colour.blue);
    const std::size_t start = offset(v) + static_cast<std::size_t>(u_first);
    for (std::size_t i = 0; i < streak_weights_.size(); ++i) {
      const float here = light * streak_weights_[i];
      luminance_[start + i] += here;
      red_[start + i] += red * here;
      blue_[start + i] += blue * here;
    }
  }
}

void LightPlane::add(const QuadImage& quad) {
  const double sigma_px = std::hypot(psf_->shape().core_sigma_px, std::sqrt(1.0 / 12.0));
  const double reach_px = 4.0 * sigma_px;
  Eigen::Vector2d low = quad.corners_px[0], high = low, middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : quad.corners_px) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
    middle += 0.25 * corner;
  }
  const auto clamped = [](double place_px, int size) {
    return static_cast<int>(std::clamp(place_px, 0.0, size - 1.0));
  };
  if (high.x() < 0.0 || high.y() < 0.0 || low.x() > width_px_ || low.y() > height_px_) return;
  const int u_first = clamped(low.x() - reach_px, width_px_);
  const int u_last = clamped(high.x() + reach_px, width_px_);
  for (int v = clamped(low.y() - reach_px, height_px_);
       v <= clamped(high.y() + reach_px, height_px_); ++v) {
    touch(v, u_first, u_last);
    for (int u = u_first; u <= u_last; ++u) {
      double cover = 1.0;
      for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Vector2d& from = quad.corners_px[i];
        const Eigen::Vector2d edge = (quad.corners_px[(i + 1) % 4] - from).normalized();
        const Eigen::Vector2d normal(-edge.y(), edge.x());
        const double inward = normal.dot(middle - from) < 0.0 ? -1.0 : 1.0;
        const double inside_px = inward * normal.dot(Eigen::Vector2d(u, v) - from);
        cover *= 0.5 * std::erfc(-inside_px / (sigma_px * std::sqrt(2.0)));
      }
      const std::size_t place = offset(v) + static_cast<std::size_t>(u);
      const double light = quad.light * cover;
      luminance_[place] += static_cast<float>(light);
      red_[place] += static_cast<float>(quad.colour.red * light);
      blue_[place] += static_cast<float>(quad.colour.blue * light);
    }
  }
}

void LightPlane::add(const LampImage& lamp) {
  if (lamp.streak_px > 0.0) {
    add_streak(lamp);
    return;
  }
  const LampProfile profile = psf_->profile(lamp.disc_radius_px);
  const double smear_px = lamp.velocity_px_per_s.norm() * exposure_s_;
  const int steps =
      std::clamp(static_cast<int>(std::ceil(smear_px / kLongestSmearStep_px)), 1, kMostSmearSteps);
  for (int step = 0; step < steps; ++step)
    add_near(lamp, profile, exposure_s_ * ((step + 0.5) / steps - 0.5), 1.0 / steps);
  add_far(lamp, profile);
}

void LightPlane::add_near(const LampImage& lamp, const LampProfile& profile, double time_s,
                          double share) {
  const Eigen::Vector2d middle_px = lamp.centre_px + time_s * lamp.velocity_px_per_s;
  // A row further down is exposed later by row_s.
  const Eigen::Vector2d per_row_px = row_s_ * lamp.velocity_px_per_s;
  const double reach_px = profile.near_radius_px() + 1.0 +
                          profile.near_radius_px() * per_row_px.lpNorm<Eigen::Infinity>();
  const double flux = lamp.flux * share;
  const double sharp_px = profile.sharp_radius_px() + 1.0;
  const int v_first = std::max(0, static_cast<int>(std::floor(middle_px.y() - reach_px)));
  const int v_last =
      std::min(height_px_ - 1, static_cast<int>(std::ceil(middle_px.y() + reach_px)));
  for (int v = v_first; v <= v_last; ++v) {
    const double later_rows = v - lamp.centre_px.y();
    const Eigen::Vector2d centre_px = middle_px + later_rows * per_row_px;
    const double dv_px = v - centre_px.y();
    const double wide2 =
        (profile.near_radius_px() + 1.0) * (profile.near_radius_px() + 1.0) - dv_px * dv_px;
    if (!(wide2 > 0.0)) continue;
    const double wide_px = std::sqrt(wide2);
    const int u_first = std::max(0, static_cast<int>(std::floor(centre_px.x() - wide_px)));
    const int u_last =
        std::min(width_px_ - 1, static_cast<int>(std::ceil(centre_px.x() + wide_px)));
    if (u_first > u_last) continue;
    touch(v, u_first, u_last);
    float* luminance = &luminance_[offset(v)];
    float* red = &red_[offset(v)];
    float* blue = &blue_[offset(v)];
    for (int u = u_first; u <= u_last; ++u) {
      const double du_px = u - centre_px.x();
      const double r2 = du_px * du_px + dv_px * dv_px;
      const double light = flux * (r2 < sharp_px * sharp_px ? pixel_mean(profile, du_px, dv_px)
                                                            : profile.near(std::sqrt(r2)));
      luminance[u] += static_cast<float>(light);
      red[u] += static_cast<float>(lamp.colour.red * light);
      blue[u] += static_cast<float>(lamp.colour.blue * light);
    }
  }
}

void LightPlane::add_far(const LampImage& lamp, const LampProfile& profile) {
  if (!(lamp.flux * profile.far(0.0) > kLeastFar_e)) return;
  const double edge = lamp.flux * profile.far(profile.near_radius_px());
  double reach_px = profile.near_radius_px();
  const double exponent = psf_->shape().wing_exponent;
  if (edge > kLeastFar_e) reach_px *= std::pow(edge / kLeastFar_e, 1.0 / exponent);
  const auto first = [&](double centre_px) {
    return std::max(0, static_cast<int>(std::floor((centre_px - reach_px) / kFarStep_px)));
  };
  const auto last = [&](double centre_px, int count) {
    return static_cast<int>(std::min(count - 1.0, std::ceil((centre_px + reach_px) / kFarStep_px)));
  };
  const int i_last = last(lamp.centre_px.x(), far_columns_);
  const int j_last = last(lamp.centre_px.y(), far_rows_);
  const double reach2 = reach_px * reach_px;
  for (int j = first(lamp.centre_px.y()); j <= j_last; ++j) {
    const double dv_px = j * kFarStep_px - lamp.centre_px.y();
    float* row = &far_[static_cast<std::size_t>(j) * static_cast<std::size_t>(far_columns_)];
    for (int i = first(lamp.centre_px.x()); i <= i_last; ++i) {
      const double du_px = i * kFarStep_px - lamp.centre_px.x();
      const double r2 = du_px * du_px + dv_px * dv_px;
      if (r2 < reach2) row[i] += static_cast<float>(lamp.flux * profile.far(std::sqrt(r2)));
    }
  }
  has_far_ = true;
}

void LightPlane::far_row(int v, float* light) const {
  const auto columns = static_cast<std::size_t>(far_columns_);
  const float* above = &far_[static_cast<std::size_t>(v / kFarStep_px) * columns];
  const float* below = above + columns;
  const float share = static_cast<float>(v % kFarStep_px) / kFarStep_px;
  const auto node = [&](int i) { return above[i] + share * (below[i] - above[i]); };
  float left = node(0);
  for (int i = 0, u = 0; u < width_px_; ++i) {
    const float right = node(i + 1);
    const float step = (right - left) / kFarStep_px;
    for (int k = 0; k < kFarStep_px && u < width_px_; ++k, ++u)
      light[u] = left + static_cast<float>(k) * step;
    left = right;
  }
}

double LightPlane::at(int u, int v) const {
  const auto columns = static_cast<std::size_t>(far_columns_);
  const float* above = &far_[static_cast<std::size_t>(v / kFarStep_px) * columns +
                             static_cast<std::size_t>(u / kFarStep_px)];
  const float* below = above + columns;
  const double across = static_cast<double>(u % kFarStep_px) / kFarStep_px;
  const double down = static_cast<double>(v % kFarStep_px) / kFarStep_px;
  const double top = (1.0 - across) * above[0] + across * above[1];
  const double bottom = (1.0 - across) * below[0] + across * below[1];
  return static_cast<double>(near_row(v)[u]) + (1.0 - down) * top + down * bottom;
}

}  // namespace vildar
