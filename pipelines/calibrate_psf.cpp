#include <filesystem>
#include <iostream>
#include <memory>
#include <set>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "calib/psf/calibrate_psf.h"
#include "capture/clip_source.h"
#include "config/site_file.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/text.h"
#include "pipelines/commands.h"
#include "pipelines/interrupt.h"
#include "pipelines/progress.h"
#include "pipelines/safe_output.h"

namespace vildar {
namespace {

struct PsfArguments {
  std::vector<std::filesystem::path> clips;
  std::filesystem::path site, out;
  bool json = false;
};

struct Gathered {
  std::vector<LampCrop> crops;
  std::map<std::string, std::int64_t> left_out;
  std::int64_t frames = 0;
  std::vector<std::string> lossy;  // clips whose codec loses of a picture, and the codec
};

Gathered gather(const PsfArguments& arguments, const Site& site) {
  CropCollector collector;
  Gathered gathered;
  std::set<std::filesystem::path> files;
  for (const std::filesystem::path& file : arguments.clips) {
    if (!files.insert(std::filesystem::weakly_canonical(file)).second)
      throw ConfigError({{file.string(), 0, "", "the clip is given twice", "name each clip once"}});
    ClipSource clip(file);
    check_site_fits_clip(site, clip.info().width_px, clip.info().height_px);
    if (!clip.info().lossless)
      gathered.lossy.push_back(file.string() + " (" + clip.info().codec + ")");
    DetectOptions detect;
    detect.lossy = !clip.info().lossless;
    Detector detector(detect, Response(*site.camera), site.camera->exposure_s);
    collector.begin_clip(site.camera->exposure_s);
    Progress progress("looking for lamps", clip.info().frames_declared, "frames");
    while (const std::optional<Frame> frame = clip.next()) {
      throw_if_interrupted();
      if (frame->damaged) continue;
      if (const auto seen = detector.look(*frame)) collector.add(*frame, *seen);
      progress.update(frame->index + 1);
    }
  }
  gathered.crops = collector.crops();
  gathered.left_out = collector.left_out();
  gathered.frames = collector.frames();
  return gathered;
}

std::string list_of(const auto& counts) {
  std::string out;
  for (const auto& [reason, count] : counts)
    out += (out.empty() ? "" : ", ") + reason + " " + std::to_string(count);
  return out;
}

PsfCalibration calibrated(const Gathered& gathered) {
  auto outcome = calibrate_psf(gathered.crops, !gathered.lossy.empty());
  if (auto* found = std::get_if<PsfCalibration>(&outcome)) return std::move(*found);
  const Miss miss = std::get<Miss>(outcome);
  std::string fault = std::to_string(gathered.crops.size()) +
                      " pictures of isolated lamps do not give the camera's PSF (" +
                      std::string(name_of(miss)) + ")";
  const std::string left_out = list_of(gathered.left_out);
  if (!left_out.empty()) fault += "; lamps of frames not taken: " + left_out;
  switch (miss) {
    case Miss::too_few_samples:
      fault +=
          "; at least eight are needed: record lamps that stand apart from others and from lit "
          "road, such as far street lamps or motorcycles";
      break;
    case Miss::unobservable:
      fault +=
          "; the share of the wings is open: with the core clipped, share and light are one "
          "number. Add a clip of the same camera with a shorter exposure, in which lamps clip "
          "little or not at all";
      break;
    case Miss::bad_fit:
      fault +=
          "; too many leave a shape that no gaussian core with power-law wings explains: "
          "record lamps far from lit surfaces, or take a lossless clip";
      break;
    default: fault += "; give more clips, or longer ones";
  }
  for (const std::string& clip : gathered.lossy)
    fault += "; " + clip + " was coded with loss, which reshapes rims and wings: take FFV1";
  throw InputError(fault);
}

constexpr const char* kBrightness[] = {"below 1", "1 to 10", "10 to 100", "100 to 1000",
                                       "above 1000"};

std::string text_report(const PsfCalibration& found, const Gathered& gathered) {
  std::string out = std::to_string(found.crops) + " pictures of " + std::to_string(found.lamps) +
                    " lamps in " + std::to_string(found.frames) + " of " +
                    std::to_string(gathered.frames) + " frames";
  if (!found.left_out.empty()) out += "; left out: " + list_of(found.left_out);
  if (!gathered.left_out.empty())
    out += "; lamps of frames not taken: " + list_of(gathered.left_out);
  out += "\nlamps, by the light of their middle over nominal white:";
  for (std::size_t i = 0; i < found.by_brightness.size(); ++i)
    out += std::string(i > 0 ? "," : "") + " " + kBrightness[i] + ": " +
           std::to_string(found.by_brightness[i]);
  const PsfShape& shape = found.psf.shape;
  const auto line = [&](const char* key, double value, double std) {
    out += std::string("\ncamera.psf.") + key + ": " + fixed_text(value, 4) + " +- " +
           fixed_text(std, 4);
  };
  line("core_sigma_px", shape.core_sigma_px, found.core_sigma_std_px);
  line("wing_share", shape.wing_share, found.psf.wing_share_std);
  line("wing_scale_px", shape.wing_scale_px, found.wing_scale_std_px);
  line("wing_exponent", shape.wing_exponent, found.wing_exponent_std);
  out += "\nfit: chi-square per pixel " + fixed_text(found.chi2_per_dof, 2) +
         " (median over pictures); " + fixed_text(100.0 * found.shaped_share, 1) +
         " % of pictures leave a shape\n";
  for (const std::string& key : found.undetermined)
    out += "camera.psf." + key +
           " is hardly told by these lamps: what stands there is what cameras usually have\n";
  if (found.wings_from_clipped_alone)
    out +=
        "every lamp clips so much that its core is not seen: the share of the wings rests on rims "
        "alone; add a clip with a shorter exposure\n";
  for (const std::string& clip : gathered.lossy)
    out += clip +
           ": a lossy codec reshapes rims and wings, which the sigmas hold; the PSF of a lossless "
           "clip "
           "of the same camera is known many times better\n";
  return out;
}

std::string json_report(const PsfCalibration& found, const Gathered& gathered) {
  nlohmann::ordered_json report;
  report["pictures"] = found.crops;
  report["lamps"] = found.lamps;
  report["frames_used"] = found.frames;
  report["frames_read"] = gathered.frames;
  report["left_out"] = found.left_out;
  report["not_taken"] = gathered.left_out;
  for (std::size_t i = 0; i < found.by_brightness.size(); ++i)
    report["lamps_by_times_white"][kBrightness[i]] = found.by_brightness[i];
  const PsfShape& shape = found.psf.shape;
  const auto add = [&](const char* key, double value, double std) {
    report["psf"][key] = {{"mean", value}, {"std", std}};
  };
  add("core_sigma_px", shape.core_sigma_px, found.core_sigma_std_px);
  add("wing_share", shape.wing_share, found.psf.wing_share_std);
  add("wing_scale_px", shape.wing_scale_px, found.wing_scale_std_px);
  add("wing_exponent", shape.wing_exponent, found.wing_exponent_std);
  report["undetermined"] = found.undetermined;
  report["chi2_per_pixel"] = found.chi2_per_dof;
  report["shaped_share"] = found.shaped_share;
  report["every_core_clipped"] = found.wings_from_clipped_alone;
  report["lossy"] = gathered.lossy;
  return report.dump(2) + "\n";
}

void calibrate_psf_of_clips(const PsfArguments& arguments) {
  refuse_to_replace(arguments.out, ".yaml", {arguments.site});
  refuse_to_replace(arguments.out, ".yaml", arguments.clips);
  Site site = load_site(arguments.site);
  const Gathered gathered = gather(arguments, site);
  const PsfCalibration found = calibrated(gathered);
  site.camera->psf = found.psf;
  write_file_atomically(arguments.out, effective_site_yaml(site));
  std::cout << (arguments.json ? json_report(found, gathered) : text_report(found, gathered))
            << std::flush;
}

}  // namespace

void add_calibrate_psf(CLI::App& calibrate, int& exit_code) {
  auto arguments = std::make_shared<PsfArguments>();
  CLI::App* command = calibrate.add_subcommand(
      "psf", "How the camera spreads the light of lamps, from clips of isolated ones");
  command->footer(
      "Example: vildar calibrate psf short_exposure.mkv night.mkv --site site.yaml --out "
      "site_psf.yaml\n\n"
      "Lamps that stand apart are fitted in many frames together: one point-spread function for "
      "all "
      "of\n"
      "them, flux, place, radius and background for each. The new site file holds it as "
      "`camera.psf`;\n"
      "the report tells what it rests on and what the lamps do not tell. Lossless clips (FFV1) "
      "with\n"
      "lamps that clip and lamps that do not are best. See docs/photometry.md.\n"
      "Exit codes: 0 done; 2 usage or site file; 3 a clip cannot be read, or its lamps do not give "
      "the\nPSF; 5 the output cannot be written; 1 internal error.");
  command->add_option("CLIP", arguments->clips, "Clips of the camera of the site")->required();
  command->add_option("--site", arguments->site, "Site file")->required();
  command->add_option("--out", arguments->out, "Site file to write")->required();
  command->add_flag("--json", arguments->json, "Print JSON in place of the text");
  command->callback([arguments, &exit_code] {
    calibrate_psf_of_clips(*arguments);
    exit_code = 0;
  });
}

}  // namespace vildar
