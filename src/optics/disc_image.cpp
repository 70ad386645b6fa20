#include "optics/disc_image.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr double kReach = 7.0;  // sigmas; beyond lies 2e-11 of a gaussian
constexpr double kNodesPerSigma = 6.0;
constexpr double kRowsPerSigma = 4.0;
constexpr double kPixelReach_px = 1.5;  // how far a pixel's corner carries light
constexpr double kWingRowStep = 0.15;   // of asinh(disc radius / a)

/// Four-point Lagrange interpolation between the second and the third of four equal steps.
struct Cubic {
  double value[4], slope[4];
  explicit Cubic(double t)
      : value{-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
              -(t + 1.0) * t * (t - 2.0) / 2.0, (t + 1.0) * t * (t - 1.0) / 6.0},
        slope{(-3.0 * t * t + 6.0 * t - 2.0) / 6.0, (3.0 * t * t - 4.0 * t - 1.0) / 2.0,
              (-3.0 * t * t + 2.0 * t + 2.0) / 2.0, (3.0 * t * t - 1.0) / 6.0} {}
};

/// exp(-x) I0(x), Abramowitz and Stegun 9.8.1 and 9.8.2.
double scaled_bessel_i0(double x) {
  if (x < 3.75) {
    const double t = x * x / (3.75 * 3.75);
    return std::exp(-x) *
           (1.0 + t * (3.5156229 +
                       t * (3.0899424 +
                            t * (1.2067492 + t * (0.2659732 + t * (0.0360768 + t * 0.0045813))))));
  }
  const double t = 3.75 / x;
  return (0.39894228 +
          t * (0.01328592 +
               t * (0.00225319 +
                    t * (-0.00157565 +
                         t * (0.00916281 +
                              t * (-0.02057706 +
                                   t * (0.02635537 + t * (-0.01647633 + t * 0.00392377)))))))) /
         std::sqrt(x);
}

/// An angle whose functions are asked for again and again.
struct SineCosine {
  double cosine, sine, cosine_of_four;
  explicit SineCosine(double angle_rad)
      : cosine(std::cos(angle_rad)),
        sine(std::sin(angle_rad)),
        cosine_of_four(std::cos(4.0 * angle_rad)) {}
};

/// The middles of so many equal parts of an angle.
std::vector<SineCosine> turns(double angle_rad, int parts) {
  std::vector<SineCosine> all;
  for (int i = 0; i < parts; ++i) all.emplace_back(angle_rad * (i + 0.5) / parts);
  return all;
}

/// Mean of a radial function over the pixel at `radius_px`, averaged over the pixel's angle, and
/// the amplitude of its cosine of four times that angle.
struct PixelMean {
  double round = 0.0, square = 0.0;
  template <class Function>
  PixelMean(double radius_px, const Function& light) {
    constexpr double kNode = 0.3872983346207417;  // Gauss and Legendre: sqrt(3/5) / 2
    constexpr double kPlaces[3] = {-kNode, 0.0, kNode};
    constexpr double kWeights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    static const std::vector<SineCosine> angles = turns(kPi / 4.0, 3);
    for (const SineCosine& angle : angles) {
      const double u = radius_px * angle.cosine, v = radius_px * angle.sine;
      double mean = 0.0;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const double at_u = u + kPlaces[i], at_v = v + kPlaces[j];
          mean += kWeights[i] * kWeights[j] * light(std::sqrt(at_u * at_u + at_v * at_v));
        }
      round += mean / static_cast<double>(angles.size());
      square += 2.0 * mean * angle.cosine_of_four / static_cast<double>(angles.size());
    }
  }
};

}  // namespace

struct DiscImage::Tables {
  // The mean over a pixel, as the pixel goes round the disc, is to great accuracy a constant and a
  // cosine of four times the angle.
  struct CoreRow {
    // Zeros at the end make a row as long as the third after it: its disc is 3 / kRowsPerSigma
    // wider.
    static constexpr std::size_t kMore =
        static_cast<std::size_t>(3.0 * kNodesPerSigma / kRowsPerSigma) + 2;
    std::size_t nodes;
    Eigen::ArrayXf round, square;
    explicit CoreRow(std::size_t nodes_in)
        : nodes(nodes_in),
          round(Eigen::ArrayXf::Zero(static_cast<Eigen::Index>(nodes + kMore))),
          square(round) {}
    void set(std::size_t node, double round_here, double square_here) {
      const auto at = static_cast<Eigen::Index>(node);
      round[at] = static_cast<float>(round_here);
      square[at] = static_cast<float>(square_here);
    }
  };

  explicit Tables(const PsfShape& psf)
      : shape(psf),
        step_px(psf.core_sigma_px / kNodesPerSigma),
        disc_step_px(psf.core_sigma_px / kRowsPerSigma) {}

  void add_core_row();
  void add_wing_row();
  double wing_of_disc(double radius_px, double disc_px) const;

  PsfShape shape;
  double step_px, disc_step_px;
  std::vector<double> within;  // of a gaussian at each distance, light inside the last row's disc
  std::vector<CoreRow> core_rows;
  std::vector<std::array<double, kWingNodes>> wing_rows;
};

DiscImage::DiscImage(const PsfShape& shape)
    : shape_(shape), step_px_(shape.core_sigma_px / kNodesPerSigma) {
  if (!(shape.core_sigma_px >= 0.5) || !(shape.wing_share >= 0.0 && shape.wing_share < 1.0) ||
      !(shape.wing_scale_px > 0.0) || !(shape.wing_exponent > 2.0))
    throw std::invalid_argument(
        "DiscImage: core sigma must be >= 0.5 px, wing share in [0, 1), scale > 0, exponent > 2");
  tables_ = std::make_shared<Tables>(shape);
}

// Light of a gaussian, at distance r from it, inside a disc: the rings t of the disc add
// t / s^2 exp(-(r^2 + t^2) / 2 s^2) I0(r t / s^2) (Rice 1945).
void DiscImage::Tables::add_core_row() {
  const double sigma_px = shape.core_sigma_px, s2 = sigma_px * sigma_px;
  const auto index = static_cast<double>(core_rows.size());
  const double disc_px = index * disc_step_px;
  const auto at_px = [&](std::size_t i) { return static_cast<double>(i) * step_px; };
  within.resize(static_cast<std::size_t>(
                    std::ceil((disc_px + kReach * sigma_px + 2.0 * kPixelReach_px) / step_px)) +
                4);
  if (index > 0.0) {
    constexpr double kGauss = 0.3872983346207417;
    for (std::size_t i = 0; i < within.size(); ++i) {
      if (std::abs(at_px(i) - disc_px) > (kReach + 1.0) * sigma_px) continue;
      for (const double place : {-kGauss, 0.0, kGauss}) {
        const double t_px = disc_px + (place - 0.5) * disc_step_px, apart_px = at_px(i) - t_px;
        within[i] += disc_step_px * (place == 0.0 ? 8.0 : 5.0) / 18.0 * t_px / s2 *
                     std::exp(-0.5 * apart_px * apart_px / s2) *
                     scaled_bessel_i0(at_px(i) * t_px / s2);
      }
    }
  }
  const auto density = [&](double radius_px) {
    if (index == 0.0) return std::exp(-0.5 * radius_px * radius_px / s2) / (2.0 * kPi * s2);
    const auto below = std::min(static_cast<std::size_t>(radius_px / step_px), within.size() - 3);
    const Cubic cubic(radius_px / step_px - static_cast<double>(below));
    const double before = within[below > 0 ? below - 1 : 1];
    return (cubic.value[0] * before + cubic.value[1] * within[below] +
            cubic.value[2] * within[below + 1] + cubic.value[3] * within[below + 2]) /
           (kPi * disc_px * disc_px);
  };
  CoreRow row(static_cast<std::size_t>((disc_px + kReach * sigma_px + kPixelReach_px) / step_px) +
              4);
  const double flat = index > 0.0 ? 1.0 / (kPi * disc_px * disc_px) : 0.0;
  for (std::size_t i = 1; i < row.nodes; ++i) {
    const double radius_px = at_px(i - 1);
    if (radius_px < disc_px - kReach * sigma_px - kPixelReach_px) {
      row.set(i, flat, 0.0);
      continue;
    }
    const PixelMean mean(radius_px, density);
    row.set(i, mean.round, mean.square);
  }
  row.set(0, row.round[2], row.square[2]);
  core_rows.push_back(std::move(row));
}

// Circles of radius t about the point lie whole inside the disc up to disc - r, and with part of
// their length from |disc - r| to disc + r.
double DiscImage::Tables::wing_of_disc(double radius_px, double disc_px) const {
  const double a2 = shape.wing_scale_px * shape.wing_scale_px, q = shape.wing_exponent;
  const auto wing = [&](double t_px) {
    return (0.5 * q - 1.0) / (kPi * a2) * std::pow(1.0 + t_px * t_px / a2, -0.5 * q);
  };
  if (disc_px == 0.0) return wing(radius_px);
  const double inner_px = disc_px - radius_px;
  double sum = inner_px > 0.0 ? 1.0 - std::pow(1.0 + inner_px * inner_px / a2, 1.0 - 0.5 * q) : 0.0;
  const double middle_px = std::max(disc_px, radius_px), half_px = std::min(disc_px, radius_px);
  if (!(half_px > 0.0)) return sum / (kPi * disc_px * disc_px);
  constexpr int kPlaces = 32;
  static const std::vector<SineCosine> places = turns(kPi, kPlaces);
  for (const SineCosine& place : places) {
    const double t_px = middle_px - half_px * place.cosine;
    const double cosine =
        (radius_px * radius_px + t_px * t_px - disc_px * disc_px) / (2.0 * radius_px * t_px);
    sum += kPi / kPlaces * half_px * place.sine * wing(t_px) * 2.0 * t_px *
           std::acos(std::clamp(cosine, -1.0, 1.0));
  }
  return sum / (kPi * disc_px * disc_px);
}

void DiscImage::Tables::add_wing_row() {
  const double disc_px =
      shape.wing_scale_px * std::sinh(kWingRowStep * static_cast<double>(wing_rows.size()));
  const double unit_px = shape.wing_scale_px + disc_px;
  const auto place = [](int i) {
    const double y = (i - 1.0) / kWingSteps;
    return y / (1.0 - y);
  };
  std::array<double, kWingNodes> exact{}, row{};
  for (int i = 0; i <= kWingSteps; ++i)
    exact[static_cast<std::size_t>(i)] =
        wing_of_disc(std::abs(place(i)) * unit_px, disc_px) * unit_px * unit_px;
  const auto light = [&](double radius_px) {
    const double x = radius_px / unit_px, position = x / (1.0 + x) * kWingSteps;
    const auto below = static_cast<std::size_t>(position);
    const Cubic cubic(position - static_cast<double>(below));
    double sum = 0.0;
    for (std::size_t k = 0; k < 4; ++k) sum += cubic.value[k] * exact[below + k];
    return sum;
  };
  for (int i = 0; i <= kWingSteps; ++i)
    row[static_cast<std::size_t>(i)] = PixelMean(std::abs(place(i)) * unit_px, light).round;
  wing_rows.push_back(row);
}

void DiscImage::set_radius(double radius_px) {
  if (!(radius_px >= 0.0 && radius_px <= kMostRadius_px))
    throw std::domain_error("DiscImage: disc radius must be in [0, 60] px");
  if (radius_px == radius_px_) return;
  radius_px_ = radius_px;
  // The tables go on evenly below a radius of 0.
  const auto rows_about = [](double position, std::size_t rows[4]) {
    const auto below = static_cast<std::size_t>(position);
    rows[0] = below > 0 ? below - 1 : 1;
    for (std::size_t k = 1; k < 4; ++k) rows[k] = below + k - 1;
    return Cubic(position - static_cast<double>(below));
  };
  std::size_t rows[4];
  {
    const Cubic cubic = rows_about(radius_px / tables_->disc_step_px, rows);
    while (tables_->core_rows.size() <= rows[3]) tables_->add_core_row();
    const std::vector<Tables::CoreRow>& all = tables_->core_rows;
    const std::size_t nodes = all[rows[3]].nodes;
    const auto mix = [&](const double(&weight)[4], double scale,
                         Eigen::ArrayXf Tables::CoreRow::*of, std::vector<float>& sum) {
      const auto n = static_cast<Eigen::Index>(nodes);
      const auto part = [&](std::size_t k) {
        return (all[rows[k]].*of).head(n) * static_cast<float>(scale * weight[k]);
      };
      sum.resize(nodes);
      Eigen::Map<Eigen::ArrayXf>(sum.data(), n) = part(0) + part(1) + part(2) + part(3);
    };
    const double per_step = 1.0 / tables_->disc_step_px;
    mix(cubic.value, 1.0, &Tables::CoreRow::round, core_.round);
    mix(cubic.slope, per_step, &Tables::CoreRow::round, core_.round_slope);
    mix(cubic.value, 1.0, &Tables::CoreRow::square, core_.square);
    mix(cubic.slope, per_step, &Tables::CoreRow::square, core_.square_slope);
    core_reach_px_ = static_cast<double>(nodes - 4) * step_px_;
  }
  const double a_px = shape_.wing_scale_px;
  unit_px_ = a_px + radius_px;
  const double place = std::asinh(radius_px / a_px);
  const Cubic cubic = rows_about(place / kWingRowStep, rows);
  while (tables_->wing_rows.size() <= rows[3]) tables_->add_wing_row();
  const double place_slope = 1.0 / (kWingRowStep * std::hypot(a_px, radius_px));
  const double per_px2 = 1.0 / (unit_px_ * unit_px_);
  const double* wings[4];
  for (std::size_t k = 0; k < 4; ++k) wings[k] = tables_->wing_rows[rows[k]].data();
  for (std::size_t i = 0; i < wing_.size(); ++i) {
    const auto mix = [&](const double(&weight)[4]) {
      return weight[0] * wings[0][i] + weight[1] * wings[1][i] + weight[2] * wings[2][i] +
             weight[3] * wings[3][i];
    };
    const double value = mix(cubic.value), slope = mix(cubic.slope);
    // At a fixed share of the unit; at() adds what the growth of the unit changes.
    wing_[i] = static_cast<float>(value * per_px2);
    wing_slope_[i] = static_cast<float>((slope * place_slope - 2.0 * value / unit_px_) * per_px2);
  }
}

DiscImage::Pixel DiscImage::at(double du_px, double dv_px) const {
  const double r2 = du_px * du_px + dv_px * dv_px, r_px = std::sqrt(r2);
  const double w = shape_.wing_share;

  const double reach_px = unit_px_ + r_px, y = r_px / reach_px * kWingSteps;
  const auto wing_at = std::min(static_cast<std::size_t>(y), std::size_t{kWingSteps});
  const Cubic far(y - static_cast<double>(wing_at));
  double wing = 0.0, wing_r = 0.0, wing_radius = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto here = static_cast<double>(wing_[wing_at + k]);
    wing += far.value[k] * here;
    wing_r += far.slope[k] * here;
    wing_radius += far.value[k] * static_cast<double>(wing_slope_[wing_at + k]);
  }
  wing_r *= kWingSteps * unit_px_ / (reach_px * reach_px);
  wing_radius -= wing_r * r_px / unit_px_;

  Pixel pixel;
  pixel.share = w * wing;
  pixel.per_radius = w * wing_radius;
  pixel.per_wing_share = wing;
  double per_r = w * wing_r;
  const double inverse_r = r_px > 1e-9 ? 1.0 / r_px : 0.0;
  if (r_px < core_reach_px_) {
    const double place = r_px / step_px_;
    const auto below = static_cast<std::size_t>(place);
    const Cubic near(place - static_cast<double>(below));
    double round = 0.0, round_r = 0.0, round_radius = 0.0;
    double square = 0.0, square_r = 0.0, square_radius = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t node = below + k;
      const auto round_here = static_cast<double>(core_.round[node]);
      const auto square_here = static_cast<double>(core_.square[node]);
      round += near.value[k] * round_here;
      round_r += near.slope[k] * round_here;
      round_radius += near.value[k] * static_cast<double>(core_.round_slope[node]);
      square += near.value[k] * square_here;
      square_r += near.slope[k] * square_here;
      square_radius += near.value[k] * static_cast<double>(core_.square_slope[node]);
    }
    // cos(4 angle) = 1 - 8 cos^2 sin^2.
    const double cosine = du_px * inverse_r, sine = dv_px * inverse_r;
    const double c2 = cosine * cosine, s2 = sine * sine;
    const double four = r_px > 1e-9 ? 1.0 - 8.0 * c2 * s2 : 0.0;
    const double core = round + square * four;
    pixel.share += (1.0 - w) * core;
    pixel.per_radius += (1.0 - w) * (round_radius + square_radius * four);
    pixel.per_wing_share -= core;
    per_r += (1.0 - w) * (round_r + square_r * four) / step_px_;
    const double turn = 16.0 * (1.0 - w) * square * inverse_r * cosine * sine;
    pixel.per_u = turn * sine * (s2 - c2);
    pixel.per_v = turn * cosine * (c2 - s2);
  }
  // The pixel stays, the disc moves.
  pixel.per_u -= per_r * du_px * inverse_r;
  pixel.per_v -= per_r * dv_px * inverse_r;
  return pixel;
}

}  // namespace vildar
