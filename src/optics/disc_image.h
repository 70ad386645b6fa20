#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "types/psf.h"

namespace vildar {

struct DiscProfile;

/// The picture that a uniform disc of unit flux (a lamp) leaves on square pixels behind a
/// point-spread function, with its derivatives. Tabulated: rows over the distance from the centre
/// for a ladder of disc radii, made when first asked for. Within 2e-4 of its peak of the exact
/// integral for cores of 0.6 px and more. Copies share the tables. Not thread-safe.
class DiscImage {
 public:
  /// Throws std::invalid_argument outside the ranges of PsfShape.
  explicit DiscImage(const PsfShape& shape);

  static constexpr double kMostRadius_px = 60.0;
  /// The disc's radius in [0, kMostRadius_px]; throws std::domain_error outside.
  void set_radius(double radius_px);
  double radius_px() const { return radius_px_; }
  const PsfShape& shape() const { return shape_; }

  /// Share of the flux on one pixel, and how it changes.
  struct Pixel {
    double share = 0.0;
    double per_u = 0.0, per_v = 0.0;  ///< as the disc's centre moves, 1/px
    double per_radius = 0.0;          ///< as the disc grows, 1/px
    double per_wing_share = 0.0;
  };
  /// Of the pixel that lies (du, dv) px from the disc's centre.
  Pixel at(double du_px, double dv_px) const;

  /// Members of Pixel for many pixels, in single precision; per_radius as the disc grows.
  struct Pixels {
    std::vector<float> share, per_u, per_v, per_radius, per_wing_share;
  };
  /// Pixels come in multiples of so many.
  static constexpr std::size_t kBatch = 16;
  /// Adds `weight` times the pixels at (u, v) px of a disc in `centre_px` to `sum`. Throws
  /// std::invalid_argument where the sizes differ or are no multiple of kBatch.
  void add_to(Pixels& sum, std::span<const float> u_px, std::span<const float> v_px,
              const Eigen::Vector2d& centre_px, double weight) const;
  /// The same in place of what `pixels` held before, of whatever size.
  void set_to(Pixels& pixels, std::span<const float> u_px, std::span<const float> v_px,
              const Eigen::Vector2d& centre_px, double weight) const;
  /// The same for Pixel::share alone.
  void add_to(std::vector<float>& share, std::span<const float> u_px, std::span<const float> v_px,
              const Eigen::Vector2d& centre_px, double weight) const;

 private:
  // Wings are tabulated over y = x / (1 + x), x = distance / (a + disc radius), from one node below
  // y = 0 to two above y = 1, in units of 1 / (a + disc radius)^2.
  static constexpr int kWingSteps = 96;
  static constexpr int kWingNodes = kWingSteps + 4;
  struct Tables;
  DiscProfile profile(std::span<const float> u_px, std::span<const float> v_px,
                      const Eigen::Vector2d& centre_px, double weight) const;

  PsfShape shape_;
  std::shared_ptr<Tables> tables_;
  double radius_px_ = -1.0;
  double step_px_;  // of the core's nodes

  // For the radius in force.
  struct Core {
    std::vector<float> round, round_slope, square, square_slope;  // and the slopes by radius
  };
  Core core_;
  double core_reach_px_ = 0.0;
  double unit_px_ = 1.0;
  std::array<float, kWingNodes> wing_{}, wing_slope_{};
};

}  // namespace vildar
