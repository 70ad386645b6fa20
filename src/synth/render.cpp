#include "synth/render.h"

#include "config/site_file.h"
#include "core/atomic_file.h"
#include "synth/clip_writer.h"
#include "synth/frame_times.h"
#include "synth/photodiode_trace.h"
#include "synth/renderer.h"
#include "synth/truth.h"

namespace vildar {
namespace {

/// What the site file says: the told site, and how the camera spreads light unless that is told
/// too. Demosaicing spreads it in a way that no such function describes.
Site site_as_told(const Scenario& scenario) {
  Site site = scenario.told_site.value_or(scenario.site);
  if (!scenario.told_site && site.channel) site.channel->lamp_power_told = true;  // made so
  const ImageScene& image = scenario.image;
  if (site.camera && !site.camera->psf && !image.bayer)
    site.camera->psf = PsfSite{
        {image.core_sigma_px, image.wing_share, image.wing_scale_px, image.wing_exponent}, 0.0};
  return site;
}

}  // namespace

std::vector<std::filesystem::path> render(const Scenario& scenario,
                                          const std::filesystem::path& out_dir,
                                          const RenderProgress& progress) {
  std::vector<std::filesystem::path> written;
  const auto write = [&](const char* name, const std::string& text) {
    write_file_atomically(out_dir / name, text);
    written.push_back(out_dir / name);
  };
  write("site.yaml", effective_site_yaml(site_as_told(scenario)));
  if (!scenario.site.photodiodes.empty()) {
    AtomicFile file(out_dir / "photodiode.csv");
    file.write(trace_csv_header(scenario));
    TraceRenderer trace(scenario);
    while (const TraceRenderer::Sample* sample = trace.next())
      file.write(trace_csv_line(scenario, *sample));
    file.commit();
    written.push_back(file.path());
  }
  const std::vector<TruthTrackRow> truth = truth_tracks(scenario);
  write("truth_vehicles.csv", truth_vehicles_csv(scenario, truth));
  write("truth_tracks.csv", truth_tracks_csv(scenario, truth));
  if (scenario.site.camera) {
    const std::filesystem::path clip = out_dir / clip_file_name(scenario.encoder.codec);
    Renderer renderer(scenario);
    ClipWriter writer(clip, scenario);
    const std::vector<double> times_s = frame_times_s(scenario);
    const auto frames = static_cast<std::int64_t>(times_s.size());
    std::int64_t done = 0;
    for (const double time_s : times_s) {
      writer.write(renderer.image(time_s));
      if (progress) progress(++done, frames);
    }
    writer.commit();
    written.push_back(clip);
  }
  return written;
}

}  // namespace vildar
