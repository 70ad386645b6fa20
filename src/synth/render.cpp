#include "synth/render.h"

#include "config/site_file.h"
#include "core/atomic_file.h"
#include "synth/clip_writer.h"
#include "synth/photodiode_trace.h"
#include "synth/renderer.h"
#include "synth/truth.h"

namespace vildar {

std::vector<std::filesystem::path> render(const Scenario& scenario,
                                          const std::filesystem::path& out_dir,
                                          const RenderProgress& progress) {
  std::vector<std::filesystem::path> written;
  const auto write = [&](const char* name, const std::string& text) {
    write_file_atomically(out_dir / name, text);
    written.push_back(out_dir / name);
  };
  write("site.yaml", effective_site_yaml(scenario.site));
  if (!scenario.site.photodiodes.empty())
    write("photodiode.csv", trace_csv(scenario, render_trace(scenario)));
  const std::vector<TruthTrackRow> truth = truth_tracks(scenario);
  write("truth_vehicles.csv", truth_vehicles_csv(scenario, truth));
  write("truth_tracks.csv", truth_tracks_csv(scenario, truth));
  if (scenario.site.camera) {
    const std::filesystem::path clip =
        out_dir / (scenario.encoder.codec == ClipCodec::ffv1 ? "clip.mkv" : "clip.mp4");
    Renderer renderer(scenario);
    ClipWriter writer(clip, scenario.encoder, *scenario.site.camera, scenario.frame_rate_hz);
    const std::int64_t frames = frame_count(scenario);
    for (std::int64_t frame = 0; frame < frames; ++frame) {
      writer.write(renderer.image(static_cast<double>(frame) / scenario.frame_rate_hz));
      if (progress) progress(frame + 1, frames);
    }
    writer.commit();
    written.push_back(clip);
  }
  return written;
}

}  // namespace vildar
