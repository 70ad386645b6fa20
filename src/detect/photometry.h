#pragma once

#include <optional>
#include <span>
#include <vector>

#include "detect/frame_light.h"
#include "detect/peaks.h"
#include "types/blob.h"
#include "types/frame.h"

namespace vildar {

/// What photometry needs to know of a frame.
struct LightScale {
  std::span<const float> linear;        ///< of each code: 0 at black, 1 at nominal white
  std::span<const float> sigma;         ///< of one pixel of each code, linear
  std::span<const float> coding_sigma;  ///< of what coding with loss adds to that; 0 without
  int clip_code = 255;
  CodingErrors coding;
};

/// A light measured in stored pixels. Flux in units of one pixel at nominal white.
struct Measured {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre_sigma_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d spread_px = Eigen::Vector2d::Ones();
  double flux = 0.0;
  double flux_sigma = 0.0;  ///< as large as the flux where pixels clip
  double background = 0.0;  ///< of the surroundings, linear
  double background_sigma = 0.0;
  double elongation = 1.0;  ///< long over short axis of its pixels
  bool cut_by_edge = false;
  bool lamp_like = false;
  bool bad_fit = false;
  std::optional<LampLight> lamp;
};

/// Centre, spread and flux of lights whose neighbours are known. Reuses its buffers.
class Photometer {
 public:
  /// One result per peak, in order.
  std::vector<Measured>& measure(const LumaView& luma, const PeakFinder& finder,
                                 const LightScale& scale);

 private:
  struct Neighbour {
    Eigen::Vector2d towards;  // unit vector
    double limit_px;          // how far along it the light's own half reaches
  };
  struct Columns {
    int from, to;
  };
  struct WindowColumn {
    double weight, offset_px;
  };
  struct WindowRow {
    int v, from, to;  // of its pixels
    int window_from;  // column of window_u_'s first
    double offset_px, weight;
  };
  Measured first_guess(const LumaView& luma, std::span<const PixelAt> pixels, const Peak& peak,
                       const LightScale& scale) const;
  int median_of_ring(std::size_t codes);
  void find_background(const LumaView& luma, const LightScale& scale, Measured& light);
  void find_neighbours(std::size_t index);
  Columns own_columns(double dv_px, const Measured& light, int from, int to) const;
  void set_window(const LumaView& luma, const Measured& light, int step);
  void refine_centre(const LumaView& luma, const LightScale& scale, const Peak& peak,
                     Measured& light);
  void sum_pixels(const LumaView& luma, std::span<const PixelAt> pixels, const LightScale& scale,
                  Measured& light) const;
  void sum_flux(const LumaView& luma, const LightScale& scale, Measured& light) const;
  bool beyond(const Eigen::Vector2d& offset) const;

  std::vector<Measured> lights_;
  std::vector<Neighbour> neighbours_;
  std::vector<Eigen::Vector2d> hidden_;
  std::vector<int> ring_;    // codes about a light
  std::vector<int> counts_;  // of the ring by code, 0 between calls
  std::vector<WindowColumn> window_u_;
  std::vector<WindowRow> rows_;
};

}  // namespace vildar
