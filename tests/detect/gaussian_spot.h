#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "core/quantity.h"
#include "detect/linear_camera.h"

namespace vildar {

/// A gaussian spot integrated over pixels, and the bound of its flux and centre with flux, centre
/// and background free, from all pixels of the picture.
struct GaussianSpot {
  std::vector<double> light;
  double flux_variance, centre_variance;

  GaussianSpot(int size_px, double u, double v, double sigma_px, double flux) {
    const auto edge = [&](double x) { return 0.5 * std::erfc(-x / (sigma_px * std::sqrt(2.0))); };
    const auto slope = [&](double x) {
      return std::exp(-0.5 * x * x / (sigma_px * sigma_px)) / (std::sqrt(2.0 * kPi) * sigma_px);
    };
    Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
    for (int y = 0; y < size_px; ++y)
      for (int x = 0; x < size_px; ++x) {
        const double across = edge(x + 0.5 - u) - edge(x - 0.5 - u);
        const double down = edge(y + 0.5 - v) - edge(y - 0.5 - v);
        light.push_back(flux * across * down);
        const Eigen::Vector4d gradient(
            across * down, flux * down * (slope(x - 0.5 - u) - slope(x + 0.5 - u)),
            flux * across * (slope(y - 0.5 - v) - slope(y + 0.5 - v)), 1.0);
        information += gradient * gradient.transpose() / LinearCamera::variance(light.back());
      }
    const Eigen::Matrix4d covariance = information.inverse();
    flux_variance = covariance(0, 0);
    centre_variance = 0.5 * (covariance(1, 1) + covariance(2, 2));
  }
};

}  // namespace vildar
