#pragma once

#include <filesystem>

#include "synth/clip_writer.h"
#include "synth/renderer.h"
#include "types/site.h"

namespace vildar {

/// Renders and codes the whole scenario, frame i at i / frame rate.
inline void write_clip(const std::filesystem::path& clip, const Scenario& scenario,
                       Renderer& renderer) {
  ClipWriter writer(clip, scenario);
  const int frames = static_cast<int>(scenario.duration_s * scenario.frame_rate_hz);
  for (int i = 0; i < frames; ++i) writer.write(renderer.image(i / scenario.frame_rate_hz));
  writer.commit();
}

/// What a site file that knows the renderer's camera exactly would say.
inline PsfSite psf_of(const ImageScene& image) {
  return {{image.core_sigma_px, image.wing_share, image.wing_scale_px, image.wing_exponent}, 0.0};
}

}  // namespace vildar
