#pragma once

#include <vector>

#include "calib/psf/lamp_crops.h"
#include "detect/lamp_pictures.h"
#include "detect/linear_camera.h"

namespace vildar {

/// Crops of single lamps behind a known PSF, taken by LinearCamera: discs of 0.2 to 4 px, their
/// middle `least_times_white` to `most_times_white` of white, evenly in the logarithm.
inline std::vector<LampCrop> lit_crops(const PsfShape& shape, int count, double least_times_white,
                                       double most_times_white, Random& random) {
  constexpr int kSize_px = 75;
  const LampPictures pictures(shape, kSize_px);
  const LinearCamera camera;
  std::vector<LampCrop> crops;
  for (int i = 0; i < count; ++i) {
    const double disc_px = 0.2 * std::pow(20.0, random.uniform(0.0, 1.0));
    const double times_white =
        least_times_white * std::pow(most_times_white / least_times_white, (i + 0.5) / count);
    const double middle_px = (kSize_px - 1) / 2.0;
    const auto light = pictures.of({LampPictures::lamp(
        middle_px + random.uniform(-0.5, 0.5), middle_px + random.uniform(-0.5, 0.5), disc_px,
        pictures.flux(disc_px, times_white))});
    LampCrop crop;
    crop.light = camera.expose(light, kSize_px, random);
    crop.tables = std::make_shared<LampCrop::Tables>(
        LampCrop::Tables{{crop.light.linear.begin(), crop.light.linear.end()},
                         {crop.light.noise.rounding.begin(), crop.light.noise.rounding.end()}});
    crop.light.linear = crop.tables->linear;
    crop.light.noise.rounding = crop.tables->rounding;
    crop.lamps.push_back(guess_of(crop.light, std::hypot(shape.core_sigma_px, 0.5 * disc_px)));
    crop.frame = crop.lamp_id = i;
    crops.push_back(std::move(crop));
  }
  return crops;
}

}  // namespace vildar
