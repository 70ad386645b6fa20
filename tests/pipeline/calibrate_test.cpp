#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "config/site_file.h"
#include "support/file_bytes.h"
#include "support/program.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

const std::string kCamera =
    "    image_size_px: [640, 360]\n"
    "    focal_px: [560.0, 560.0]\n"
    "    principal_px: [319.5, 179.5]\n"
    "    position_m: [0.0, 0.0, 5.0]\n"
    "    exposure_s: 0.001\n";
const std::string kRoad =
    "  road:\n"
    "    kind: straight\n"
    "    lanes:\n"
    "      - {id: near, lateral_m: -4.0, width_m: 3.5, direction: oncoming}\n"
    "  lamps:\n"
    "    height_m: {mean: 0.65, std: 0.08}\n"
    "    separation_m: {mean: 1.3, std: 0.12}\n";
const std::string kTruePose = "    yaw_deg: -7.3\n    pitch_deg: -5.6\n    roll_deg: 0.4\n";

std::string car(int number, double speed_mps, double range_at_zero_m, double lamp_height_m) {
  return "  - {id: v" + std::to_string(number) +
         ", kind: car, lane: near, speed_mps: " + std::to_string(speed_mps) +
         ", range_at_zero_m: " + std::to_string(range_at_zero_m) +
         ", lamp_height_m: " + std::to_string(lamp_height_m) + ", lamp_separation_m: 1.3";
}

// A camera whose pose the site file has wrong by up to a degree, and eight cars.
std::string scenario(const std::string& true_pose = kTruePose) {
  std::string text =
      "duration_s: 18.5\nframe_rate_hz: 20\nseed: 4\n"
      "site:\n  camera:\n" +
      kCamera + true_pose + kRoad + "told_site:\n  camera:\n" + kCamera +
      "    yaw_deg: {mean: -8.0, std: 1.0}\n    pitch_deg: {mean: -6.0, std: 1.0}\n"
      "    roll_deg: {mean: 0.0, std: 0.5}\n" +
      kRoad + "vehicles:\n";
  const double speeds_mps[] = {21.0, 18.5, 20.0, 16.0, 17.5, 19.0, 15.0, 16.5};
  const double heights_m[] = {0.62, 0.70, 0.66, 0.58, 0.64, 0.69, 0.67, 0.61};
  for (int i = 0; i < 8; ++i)
    text += car(i, speeds_mps[i], 10.0 + speeds_mps[i] * 2.2 * (i + 1), heights_m[i]) +
            ", intensity_cd: 800}\n";
  return text;
}

class Calibrate : public testing::Test {
 protected:
  test::Ran run(const std::vector<std::string>& arguments) {
    return test::Program(VILDAR_PROGRAM, arguments, folder_.path()).wait();
  }
  std::string path(const char* name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
};

TEST_F(Calibrate, MountIsLearnedFromARunAndUsedByTheNext) {
  folder_.write("scenario.yaml", scenario());
  ASSERT_EQ(run({"render", path("scenario.yaml"), "--out", path("scene")}).code, 0);
  const std::string clip = path("scene/clip.mp4"), site = path("scene/site.yaml");
  ASSERT_EQ(run({"run", clip, "--site", site, "--out", path("first")}).code, 0);
  const std::string learned_file = path("learned.yaml");
  const test::Ran ran =
      run({"calibrate", "mount", path("first"), "--site", site, "--out", learned_file});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_NE(ran.out.find("camera.yaw_deg: -8.0000 +- 1.0000 -> "), std::string::npos) << ran.out;

  const CameraSite camera = *load_site(learned_file).camera;
  // Truth: -7.3, -5.6 and 0.4 degrees; a degree or half of one before.
  constexpr double kFar = 5.0, kClose_deg = 0.05;
  for (const auto& [turn_rad, truth_deg] :
       {std::pair{camera.yaw_rad, -7.3}, {camera.pitch_rad, -5.6}, {camera.roll_rad, 0.4}}) {
    const double error_rad = std::abs(turn_rad.mean - radians_from_degrees(truth_deg));
    EXPECT_LT(error_rad, kFar * turn_rad.std) << truth_deg << ran.out;
    EXPECT_LT(degrees_from_radians(turn_rad.std), 5.0 * kClose_deg) << truth_deg << ran.out;
  }
  EXPECT_EQ(ran.err.find("warning"), std::string::npos) << ran.err;
  const test::Ran json = run(
      {"calibrate", "mount", path("first"), "--site", site, "--out", path("again.yaml"), "--json"});
  EXPECT_NE(json.out.find("\"strain\""), std::string::npos) << json.out;
  EXPECT_NE(json.out.find("\"warnings\": []"), std::string::npos) << json.out;
  EXPECT_EQ(run({"run", clip, "--site", learned_file, "--out", path("second")}).code, 0);

  // Learned on from what was learned, a run tells no more than before; as a second run in another
  // container it would.
  ASSERT_EQ(run({"calibrate", "mount", path("first"), "--site", learned_file, "--out",
                 path("relearned.yaml")})
                .code,
            0);
  const Site learned = load_site(learned_file), relearned = load_site(path("relearned.yaml"));
  constexpr double kRounding = 1e-9;
  EXPECT_NEAR(relearned.camera->pitch_rad.mean, learned.camera->pitch_rad.mean, kRounding);
  EXPECT_NEAR(relearned.camera->pitch_rad.std, learned.camera->pitch_rad.std, kRounding);
  EXPECT_NEAR(relearned.lamps.separation_m->std, learned.lamps.separation_m->std, kRounding);
  EXPECT_EQ(relearned.learned.mount->clips, learned.learned.mount->clips);

  // What was written in its place since stays.
  std::string edited = test::bytes_of(learned_file);
  const auto yaw = edited.find("yaw_deg:");
  edited.replace(yaw, edited.find('\n', yaw) - yaw, "yaw_deg: {mean: -7.2, std: 0.5}");
  folder_.write("edited.yaml", edited);
  const test::Ran from_edited = run({"calibrate", "mount", path("first"), "--site",
                                     path("edited.yaml"), "--out", path("from_edited.yaml")});
  EXPECT_NE(from_edited.out.find("camera.yaw_deg: -7.2000 +- 0.5000 -> "), std::string::npos)
      << from_edited.out << from_edited.err;
  EXPECT_NE(from_edited.out.find("camera.pitch_deg: -6.0000 +- 1.0000 -> "), std::string::npos);
  ASSERT_EQ(learned.learned.mount->clips.size(), 1U);
  const std::string digest = learned.learned.mount->clips.front();
  fs::copy(path("first"), path("remuxed"));
  std::string told = test::bytes_of(path("remuxed/run.json"));
  for (auto at = told.find(digest); at != std::string::npos; at = told.find(digest))
    told[at] = told[at] == '0' ? '1' : '0';
  folder_.write("remuxed/run.json", told);
  test::expect_told(run({"calibrate", "mount", path("first"), path("remuxed"), "--site", site,
                         "--out", path("none.yaml")}),
                    2, {"remuxed", "to the last digit", "name one run of each clip"});
  const test::Ran other = run({"calibrate", "mount", path("remuxed"), "--site", learned_file,
                               "--out", path("others.yaml")});
  EXPECT_EQ(other.code, 0);
  EXPECT_NE(other.err.find("1 of the 1 clips that the site file was learned from"),
            std::string::npos)
      << other.err;
  const test::Ran score =
      run({"evaluate", path("second"), path("scene"), "--require", "recall>=0.85", "--require",
           "share_within_limits>=0.7", "--require", "false==0"});
  EXPECT_EQ(score.code, 0) << score.err << score.out;

  // Plenty of passes, of which none fits a camera that looks the other way.
  std::string mirrored = test::bytes_of(site);
  mirrored.erase(mirrored.find('-', mirrored.find("yaw_deg:")), 1);
  folder_.write("mirrored.yaml", mirrored);
  test::expect_told(run({"calibrate", "mount", path("first"), "--site", path("mirrored.yaml"),
                         "--out", path("none.yaml")}),
                    3, {"do not determine the site", "check the camera's position_m, yaw_deg"});
}

TEST_F(Calibrate, RunsOfACameraThatWasMovedBetweenThemAreNotAveraged) {
  const std::string learned_file = path("learned.yaml");
  for (const auto& [scene, pose] :
       {std::pair{"before", kTruePose},
        {"after", std::string("    yaw_deg: -6.6\n    pitch_deg: -5.6\n    roll_deg: 0.4\n")}}) {
    folder_.write("scenario.yaml", scenario(pose));
    ASSERT_EQ(run({"render", path("scenario.yaml"), "--out", path(scene)}).code, 0);
    const std::string clip = path(scene) + "/clip.mp4", out = path(scene) + "/run";
    ASSERT_EQ(run({"run", clip, "--site", path("before/site.yaml"), "--out", out}).code, 0);
  }
  const std::string site = path("before/site.yaml");
  test::expect_told(run({"calibrate", "mount", path("before/run"), path("after/run"), "--site",
                         site, "--out", learned_file}),
                    3, {"camera.yaw_deg is", "before/run", "after/run", "one mounting"});
  test::expect_told(run({"calibrate", "mount", path("before/run"), "--site", site, "--out", site}),
                    2, {"site.yaml", "another --out"});
  EXPECT_FALSE(fs::exists(learned_file));
}

// Ten lamps in the dark above a road, from a third of white to some thousand times white.
std::string lamps_apart(double least_times_white, double most_times_white, const char* codec) {
  std::string text =
      "duration_s: 2\nframe_rate_hz: 20\nseed: 7\n"
      "site:\n  camera:\n    image_size_px: [640, 360]\n    focal_px: [600.0, 600.0]\n"
      "    principal_px: [319.5, 179.5]\n    position_m: [0.0, 0.0, 5.0]\n    exposure_s: 0.001\n"
      "    yaw_deg: 0.0\n    pitch_deg: 10.0\n    roll_deg: 0.0\n    response: {kind: srgb}\n"
      "image: {core_sigma_px: 1.1, wing_share: 0.05, wing_scale_px: 1.7, wing_exponent: 2.8}\n"
      "encoder: {codec: " +
      std::string(codec) + "}\nstreet_lamps:\n";
  constexpr int kLamps = 10;
  constexpr double kRange_m = 80.0, kLuxOfWhite = 1.3e-3;
  for (int i = 0; i < kLamps; ++i) {
    const double times_white =
        least_times_white * std::pow(most_times_white / least_times_white, i / (kLamps - 1.0));
    // On a grid in the picture, each at its own place within a pixel.
    const double across = (i % 5 - 2) * 118.3 / 600.0, up = (40.0 - 110.7 * (i / 5 - 1)) / 600.0;
    const double tilt = std::tan(std::atan(up) + radians_from_degrees(10.0));
    text += "  - {position_m: [80.0, " + std::to_string(-kRange_m * across) + ", " +
            std::to_string(5.0 + kRange_m * tilt) +
            "], intensity_cd: " + std::to_string(times_white * kLuxOfWhite * kRange_m * kRange_m) +
            ", radius_m: " + std::to_string(0.05 + 0.03 * (i % 4)) + "}\n";
  }
  return text;
}

TEST_F(Calibrate, PsfIsFoundInAClipAndWrittenToTheSiteFile) {
  folder_.write("scenario.yaml", lamps_apart(0.35, 1000.0, "ffv1"));
  ASSERT_EQ(run({"render", path("scenario.yaml"), "--out", path("scene")}).code, 0);
  const std::string clip = path("scene/clip.mkv"), site = path("scene/site.yaml");
  const test::Ran ran =
      run({"calibrate", "psf", clip, "--site", site, "--out", path("with_psf.yaml")});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_NE(ran.out.find("camera.psf.wing_share: "), std::string::npos) << ran.out;
  const auto psf = load_site(path("with_psf.yaml")).camera->psf;
  ASSERT_TRUE(psf);
  EXPECT_LT(std::abs(psf->shape.wing_share - 0.05), 3.5 * psf->wing_share_std) << ran.out;
  EXPECT_LT(psf->wing_share_std, 0.01) << ran.out;
  EXPECT_NEAR(psf->shape.core_sigma_px, 1.1, 0.03) << ran.out;
  EXPECT_EQ(run({"run", clip, "--site", path("with_psf.yaml"), "--out", path("out")}).code, 0);
}

TEST_F(Calibrate, PsfIsRefusedByNameWhereNoLampTellsIt) {
  folder_.write("dark.yaml", lamps_apart(0.001, 0.002, "ffv1"));
  ASSERT_EQ(run({"render", path("dark.yaml"), "--out", path("dark")}).code, 0);
  const std::string clip = path("dark/clip.mkv"), site = path("dark/site.yaml");
  test::expect_told(run({"calibrate", "psf", clip, "--site", site, "--out", path("out.yaml")}), 3,
                    {"0 pictures of isolated lamps", "too_few_samples"});
  test::expect_told(
      run({"calibrate", "psf", clip, clip, "--site", site, "--out", path("out.yaml")}), 2,
      {"given twice"});
  EXPECT_FALSE(fs::exists(path("out.yaml")));
}

// One car before a camera and two photodiodes, 2 m apart along the road.
std::string lone_car(int number, double speed_mps, double lamp_height_m) {
  const auto photodiodes = [](const std::string& offset_s, const std::string& gain_ratio) {
    const std::string rest =
        "      yaw_deg: -7.3\n      pitch_deg: -5.6\n      half_field_of_view_deg: 30\n"
        "      area_m2: 1.0e-4\n      time_offset_s: " +
        offset_s + "\n";
    return "  channel: {beam: low_beam}\n"
           "  photodiodes:\n    - id: pd0\n      position_m: [0.0, 0.0, 5.0]\n" +
           rest + "    - id: pd1\n      position_m: [2.0, 0.0, 5.0]\n" + rest +
           "      gain_ratio: " + gain_ratio + "\n";
  };
  return "duration_s: " + std::to_string(64.0 / speed_mps) + "\nframe_rate_hz: 20\nseed: 5\n" +
         "site:\n  camera:\n" + kCamera + kTruePose + photodiodes("0.035", "1.08") + kRoad +
         "told_site:\n  camera:\n" + kCamera + kTruePose +
         photodiodes("{mean: 0.03, std: 0.01}", "{mean: 1.0, std: 0.1}") + kRoad + "vehicles:\n" +
         car(number, speed_mps, 60.0, lamp_height_m) +
         "}\nphotodiode: {rate_hz: 1000, noise_w: 5.0e-10, ambient_w: 2.0e-8}\n";
}

TEST_F(Calibrate, PhotodiodeGainAndClockAreLearnedFromRuns) {
  const double speeds_mps[] = {21.0, 18.5, 20.0, 16.0, 17.5, 19.0};
  const double heights_m[] = {0.62, 0.70, 0.66, 0.58, 0.64, 0.69};
  const std::string site = path("scene_0/site.yaml"), out = path("learned.yaml");
  std::vector<std::string> arguments{"calibrate", "photodiode"};
  for (int i = 0; i < 6; ++i) {
    const std::string scene = path("scene_") + std::to_string(i), run_folder = scene + "_run";
    folder_.write("scenario.yaml", lone_car(i, speeds_mps[i], heights_m[i]));
    const test::Ran rendered = run({"render", path("scenario.yaml"), "--out", scene});
    ASSERT_EQ(rendered.code, 0) << rendered.err;
    const test::Ran ran = run({"run", scene + "/clip.mp4", "--photodiode",
                               scene + "/photodiode.csv", "--site", site, "--out", run_folder});
    ASSERT_EQ(ran.code, 0) << ran.err;
    arguments.push_back(run_folder);
  }
  arguments.insert(arguments.end(), {"--site", site, "--out", out});
  const test::Ran ran = run(arguments);
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_NE(ran.out.find("photodiodes[1].gain_ratio: 1.0000 +- 0.1000 -> "), std::string::npos)
      << ran.out;
  const Site learned = load_site(out);
  constexpr double kFar = 5.0;
  const Uncertain& ratio = learned.photodiodes[1].gain_ratio;
  EXPECT_LT(std::abs(ratio.mean - 1.08), kFar * ratio.std) << ran.out;
  EXPECT_LT(ratio.std, 0.03) << ran.out;
  for (const PhotodiodeSite& photodiode : learned.photodiodes) {
    EXPECT_LT(std::abs(photodiode.time_offset_s.mean - 0.035), kFar * photodiode.time_offset_s.std)
        << ran.out;
    // Of 0.01 before; vehicles of like speeds hardly tell time from the place of the rim.
    EXPECT_LT(photodiode.time_offset_s.std, 0.007) << ran.out;
  }

  // Learned on, the same runs tell no more.
  std::vector<std::string> again = arguments;
  std::ranges::replace(again, site, out);
  *std::next(std::ranges::find(again, "--out")) = path("again.yaml");
  ASSERT_EQ(run(again).code, 0);
  const Site relearned = load_site(path("again.yaml"));
  constexpr double kRounding = 1e-9;
  EXPECT_NEAR(relearned.photodiodes[1].gain_ratio.mean, ratio.mean, kRounding);
  EXPECT_NEAR(relearned.photodiodes[1].gain_ratio.std, ratio.std, kRounding);
  EXPECT_NEAR(relearned.photodiodes[0].time_offset_s.std, learned.photodiodes[0].time_offset_s.std,
              kRounding);

  folder_.write("scene_0/photodiode.csv", "t_s,power_w\n0,0\n");
  test::expect_told(run(arguments), 3, {"run.json", "another one"});
}

TEST_F(Calibrate, PhotodiodeSaysWhatIsMissing) {
  const std::string camera =
      "version: 1\ncamera:\n  image_size_px: [640, 360]\n  focal_px: [560, 560]\n"
      "  principal_px: [320, 180]\n  position_m: [0, 0, 5]\n";
  folder_.write("camera.yaml", camera);
  folder_.write("site.yaml", camera +
                                 "photodiodes:\n  - {id: pd0, position_m: [0, 0, 5], area_m2: "
                                 "1.0e-4}\n");
  const std::string out = path("out.yaml"), folder = folder_.path().string();
  test::expect_told(
      run({"calibrate", "photodiode", folder, "--site", path("camera.yaml"), "--out", out}), 2,
      {"no photodiode"});
  const std::vector<std::string> arguments{"calibrate",       "photodiode", folder, "--site",
                                           path("site.yaml"), "--out",      out};
  test::expect_told(run(arguments), 3, {"run.json", "cannot be opened"});
  folder_.write("run.json", "{\"inputs\": [{\"role\": 3}]}");
  test::expect_told(run(arguments), 3, {"run.json", "no photodiode trace", "--photodiode"});
  folder_.write("run.json", "{\"inputs\": [{\"role\": \"photodiode\", \"path\": \"gone.csv\"}]}");
  test::expect_told(run(arguments), 3, {"run.json", "gone.csv", "is not there"});
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(Calibrate, SaysWhatIsMissing) {
  folder_.write("site.yaml",
                "version: 1\ncamera:\n  image_size_px: [640, 360]\n  focal_px: [560, 560]\n"
                "  principal_px: [320, 180]\n  position_m: [0, 0, 5]\n");
  const std::string site = path("site.yaml"), out = path("out.yaml");
  test::expect_told(run({"calibrate"}), 2, {"subcommand"});
  test::expect_told(run({"calibrate", "camera", "--help"}), 2, {"\"camera\"", "mount"});
  test::expect_told(run({"calibrate", "mount", path("none"), "--site", site, "--out", out}), 3,
                    {"speeds.csv"});
  folder_.write("speeds.csv", "track_id,direction,status\n1,oncoming,measured\n");
  folder_.write("tracks.csv",
                "frame,t_s,track_id,u_left_px,v_left_px,u_right_px,v_right_px\n0,0,1,5,5,9,5\n");
  const std::string run_folder = folder_.path().string();
  test::expect_told(run({"calibrate", "mount", run_folder, "--site", site, "--out", out}), 3,
                    {"tracks.csv", "u_left_std_px"});
  folder_.write("tracks.csv",
                "frame,t_s,track_id,u_left_px,v_left_px,u_right_px,v_right_px,u_left_std_px,"
                "v_left_std_px,u_right_std_px,v_right_std_px\n0,0,1,5,5,9,5,0.1,0.1,0.1,0.1\n");
  test::expect_told(run({"calibrate", "mount", run_folder, "--site", site, "--out", out}), 3,
                    {"1 passes", "at least five"});
  test::expect_told(
      run({"calibrate", "mount", run_folder, "--site", site, "--out", path("speeds.csv")}), 2,
      {"speeds.csv", "in a folder that is read"});
  const std::string again = run_folder + "/../" + folder_.path().filename().string() + "/";
  test::expect_told(run({"calibrate", "mount", run_folder, again, "--site", site, "--out", out}), 2,
                    {"given twice"});
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace vildar
