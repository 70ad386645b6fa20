#include "config/site_file.h"

#include <gtest/gtest.h>

#include "config/site_text.h"
#include "core/random.h"
#include "core/text.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

std::string table_of(int count, double step) {
  std::string out = "[";
  for (int i = 0; i < count; ++i) out += (i ? ", " : "") + number_text(i * step);
  return out + "]";
}

/// The contract's example with every optional key that it leaves out.
std::string full_site() {
  std::string text = with(kContractSite, "yaw_deg: 0.0\n  pitch_deg: -4.0\n  roll_deg: 0.0",
                          "yaw_deg: {mean: 190, std: 0.5}\n  pitch_deg: -4.1\n  roll_deg: 0.7");
  text = with(text, "coefficients: [0, 0, 0, 0, 0]",
              "coefficients: [-0.31, 0.11, 1.0e-4, -2.0e-4, -0.02]");
  text = with(text, "[0.0, 0.0, 5.0] # in the road frame", "[0, 0.1, {mean: 5.2, std: 0.05}]");
  text = with(text, "rolling_shutter_s: 0.0 ", "rolling_shutter_s: 0.016 ");
  text = with(text, "{kind: srgb}",
              "{kind: table, values: " + table_of(256, 1.0 / 255.0) +
                  "}\n  psf: {core_sigma_px: 1.2, wing_share: {mean: 0.04, std: 0.003}, "
                  "wing_scale_px: 2.5, "
                  "wing_exponent: 3.1}\n  gain_db: {mean: -30, std: 2}\n  path_loss_exponent: "
                  "{mean: 1.9, std: 0.1}\n ");
  text = with(text, "  time_offset_s:", "  volts_per_count: 5.0e-5\n  time_offset_s:");
  text = with(text, "mains_hz: 50",
              "- {id: pd-1, position_m: [2, 0, 5], full_scale_v: 3.3}\nmains_hz: 60");
  text = with(text, "kind: straight ", "kind: curved ");
  text = with(text, "straight_m: 0.0 ", "straight_m: {mean: 12.5, std: 0.5} ");
  text = with(text, "radius_m: 40.0 ", "radius_m: {mean: 40.0, std: 0.4} ");
  text = with(text, "turn: left ", "turn: right ");
  text = with(text, "lateral_m: -4.0", "lateral_m: {mean: -4.0, std: 0.3}");
  text = with(text, "  lamp_power_w: 1.0 ",
              "  half_power_angle_deg: 40\n  lamp_power_w: {mean: 1.5, std: 0.2} ");
  return with(text, "speed_mps: 0.0  ", "speed_mps: {mean: 17, std: 0.1}  ");
}

TEST(SiteFile, EveryKeyArrivesInItsPlaceAndUnit) {
  const TemporaryFolder folder;
  const Site site = load_site(folder.write("site.yaml", full_site()));
  EXPECT_EQ(site.file, folder.path() / "site.yaml");
  ASSERT_TRUE(site.camera);
  const CameraSite& camera = *site.camera;
  EXPECT_EQ(camera.width_px, 1920);
  EXPECT_EQ(camera.height_px, 1080);
  EXPECT_EQ(camera.focal_px, (std::array<double, 2>{1400.0, 1400.0}));
  EXPECT_EQ(camera.focal_std_px, 14.0);
  EXPECT_EQ(camera.principal_px, (std::array<double, 2>{959.5, 539.5}));
  EXPECT_EQ(camera.distortion, DistortionModel::brown);
  EXPECT_EQ(camera.distortion_coefficients,
            (std::array<double, 5>{-0.31, 0.11, 1.0e-4, -2.0e-4, -0.02}));
  EXPECT_EQ(camera.position_m,
            (std::array<Uncertain, 3>{Uncertain{0, 0}, Uncertain{0.1, 0}, Uncertain{5.2, 0.05}}));
  EXPECT_DOUBLE_EQ(camera.yaw_rad.mean, 190.0 * kDegree);
  EXPECT_DOUBLE_EQ(camera.yaw_rad.std, 0.5 * kDegree);
  EXPECT_DOUBLE_EQ(camera.pitch_rad.mean, -4.1 * kDegree);
  EXPECT_DOUBLE_EQ(camera.roll_rad.mean, 0.7 * kDegree);
  EXPECT_EQ(camera.exposure_s, 0.002);
  EXPECT_EQ(camera.rolling_shutter_s, 0.016);
  EXPECT_EQ(camera.response, ResponseKind::table);
  ASSERT_EQ(camera.response_table.size(), 256u);
  EXPECT_EQ(camera.response_table.back(), 1.0);
  EXPECT_EQ(camera.psf, (PsfSite{{1.2, 0.04, 2.5, 3.1}, 0.003}));
  EXPECT_EQ(camera.gain_db, (Uncertain{-30.0, 2.0}));
  EXPECT_EQ(camera.path_loss_exponent, (Uncertain{1.9, 0.1}));

  ASSERT_EQ(site.photodiodes.size(), 2u);
  const PhotodiodeSite& diode = site.photodiodes[0];
  EXPECT_EQ(diode.id, "pd0");
  EXPECT_EQ(diode.position_m[2], (Uncertain{5.0, 0.0}));
  EXPECT_DOUBLE_EQ(diode.half_field_of_view_rad, 70.0 * kDegree);
  EXPECT_EQ(diode.area_m2, 1.0e-4);
  EXPECT_EQ(diode.gain_ratio, (Uncertain{1.0, 0.002}));
  EXPECT_EQ(diode.responsivity_a_per_w, 0.45);
  EXPECT_EQ(diode.transimpedance_v_per_a, 1.0e6);
  EXPECT_EQ(diode.volts_per_count, 5.0e-5);
  EXPECT_EQ(diode.time_offset_s, (Uncertain{0.0, 0.02}));
  EXPECT_EQ(site.photodiodes[1].id, "pd-1");
  EXPECT_EQ(site.photodiodes[1].position_m[0], (Uncertain{2.0, 0.0}));
  EXPECT_EQ(site.photodiodes[1].full_scale_v, 3.3);
  EXPECT_FALSE(site.photodiodes[1].area_m2);

  EXPECT_EQ(site.mains_hz, 60.0);
  EXPECT_EQ(site.road.kind, RoadKind::curved);
  EXPECT_EQ(site.road.straight_m, (Uncertain{12.5, 0.5}));
  EXPECT_EQ(site.road.radius_m, (Uncertain{40.0, 0.4}));
  EXPECT_EQ(site.road.turn, Turn::right);
  ASSERT_EQ(site.road.lanes.size(), 2u);
  EXPECT_EQ(site.road.lanes[0].id, "near");
  EXPECT_EQ(site.road.lanes[0].lateral_m, (Uncertain{-4.0, 0.3}));
  EXPECT_EQ(site.road.lanes[0].direction, Direction::oncoming);
  EXPECT_EQ(site.road.lanes[1].width_m, 3.5);
  EXPECT_EQ(site.road.lanes[1].direction, Direction::receding);
  EXPECT_EQ(site.road.speed_limit_mps, 13.9);
  EXPECT_EQ(site.lamps.height_m, (Uncertain{0.68, 0.08}));
  EXPECT_EQ(site.lamps.separation_m, (Uncertain{1.25, 0.12}));
  EXPECT_EQ(site.lamps.tail_height_m, (Uncertain{0.85, 0.15}));
  EXPECT_EQ(site.lamps.tail_separation_m, (Uncertain{1.2, 0.0}));
  ASSERT_TRUE(site.channel);
  EXPECT_EQ(site.channel->gain_db, (Uncertain{-49.32, 3.0}));
  EXPECT_EQ(site.channel->path_loss_exponent, (Uncertain{1.21, 0.05}));
  ASSERT_TRUE(site.channel->half_power_angle_rad);
  EXPECT_DOUBLE_EQ(*site.channel->half_power_angle_rad, 40.0 * kDegree);
  EXPECT_EQ(site.channel->lamp_power_w, (Uncertain{1.5, 0.2}));
  ASSERT_TRUE(site.ego);
  EXPECT_EQ(site.ego->speed_mps, (Uncertain{17.0, 0.1}));
}

TEST(SiteFile, TheContractsExampleIsReadThoughItsRoadIsStraight) {
  const TemporaryFolder folder;
  const Site site = load_site(folder.write("site.yaml", kContractSite));
  EXPECT_EQ(site.road.kind, RoadKind::straight);
  EXPECT_EQ(site.photodiodes.size(), 1u);
  EXPECT_FALSE(site.camera->gain_db);
  EXPECT_FALSE(site.camera->psf);
}

TEST(SiteFile, ATraceOfTheOwnSpeedHasASigma) {
  const TemporaryFolder folder;
  folder.write("ego.csv", "t_s,speed_mps\n0,10\n1,11\n");
  const std::string traced = with(kContractSite, "speed_mps: 0.0  ", "trace: ego.csv  ");
  const Site site = load_site(folder.write("site.yaml", traced + "  speed_std_mps: 0.3\n"));
  EXPECT_EQ(site.ego->speed_mps.std, 0.3);
  EXPECT_EQ(load_site(folder.write("again.yaml", effective_site_yaml(site))).ego, site.ego);
  EXPECT_THROW(
      load_site(folder.write("site.yaml", std::string(kContractSite) + "  speed_std_mps: 0.3\n")),
      ConfigError);
}

TEST(SiteFile, WhatIsLeftOutStaysUnknown) {
  const TemporaryFolder folder;
  const Site site =
      load_site(folder.write("site.yaml", "version: 1\nphotodiode: {position_m: [0, 0, 5]}\n"));
  EXPECT_FALSE(site.camera);
  ASSERT_EQ(site.photodiodes.size(), 1u);
  EXPECT_EQ(site.photodiodes[0].id, "pd0");
  EXPECT_FALSE(site.photodiodes[0].area_m2);
  EXPECT_FALSE(site.photodiodes[0].responsivity_a_per_w);
  EXPECT_FALSE(site.channel);
  EXPECT_FALSE(site.ego);
  EXPECT_FALSE(site.road.speed_limit_mps);
  EXPECT_FALSE(site.road.radius_m);
  EXPECT_TRUE(site.road.lanes.empty());
  EXPECT_FALSE(site.lamps.height_m);
}

TEST(SiteFile, AGainRatioLeftOutIsNotKnownToBeOne) {
  const TemporaryFolder folder;
  const auto site_with = [&](const char* ratio) {
    return load_site(folder.write("site.yaml", std::string("version: 1\nphotodiodes:\n"
                                                           "  - {id: a, position_m: [0, 0, 5]}\n"
                                                           "  - {id: b, position_m: [2, 0, 5]") +
                                                   ratio + "}\n"));
  };
  const Site left_out = site_with(""), told = site_with(", gain_ratio: 1");
  EXPECT_TRUE(left_out.photodiodes[0].gain_ratio_told);
  EXPECT_EQ(left_out.photodiodes[0].gain_ratio, (Uncertain{1.0, 0.0}));
  EXPECT_FALSE(left_out.photodiodes[1].gain_ratio_told);
  EXPECT_EQ(left_out.photodiodes[1].gain_ratio.mean, 1.0);
  EXPECT_GE(left_out.photodiodes[1].gain_ratio.std, 0.03);
  EXPECT_EQ(told.photodiodes[1].gain_ratio, (Uncertain{1.0, 0.0}));
  EXPECT_TRUE(told.photodiodes[1].gain_ratio_told);
}

// A vehicle that has its sensor with it is on the bend all along.
TEST(SiteFile, WhereABendBeginsIsAskedForWhereTheSensorStands) {
  const TemporaryFolder folder;
  const std::string site =
      "version: 1\nphotodiode: {position_m: [0, 0, 5]}\n"
      "road: {kind: curved, radius_m: 40, turn: left}\n";
  const auto problems = problems_of(folder.write("site.yaml", site));
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].key, "road.straight_m");
  EXPECT_TRUE(problems_of(folder.write("site.yaml", site + "ego: {speed_mps: 10}\n")).empty());
  EXPECT_TRUE(
      problems_of(folder.write("site.yaml", with(site, "turn: left", "turn: left, straight_m: 0")))
          .empty());
}

TEST(SiteFile, ALampPowerLeftOutIsNotKnownToBeOneWatt) {
  const TemporaryFolder folder;
  const std::string key =
      "  lamp_power_w: 1.0                      # optical, of the whole vehicle\n";
  const Site left_out = load_site(folder.write("site.yaml", with(kContractSite, key, "")));
  EXPECT_FALSE(left_out.channel->lamp_power_told);
  EXPECT_EQ(effective_site_yaml(left_out).find("lamp_power_w"), std::string::npos);
  EXPECT_TRUE(load_site(folder.write("site.yaml", kContractSite)).channel->lamp_power_told);
}

// To YAML 1.1 a number without a point is none where it has an exponent.
TEST(SiteFile, SmallNumbersAreWrittenAsNumbersForEveryReader) {
  const TemporaryFolder folder;
  const Site site = load_site(folder.write("site.yaml", kContractSite));
  const std::string text = effective_site_yaml(site);
  EXPECT_NE(text.find("area_m2: 1.0e-04"), std::string::npos) << text;
}

struct Breach {
  std::string from, to;  // one change of the full site
  std::string key;       // where the problem must be
  std::string at;        // text of the broken file on whose line it must be
};

// Centimetres, millimetres, square millimetres, map coordinates, radians.
TEST(SiteFile, LengthsNoRoadHasNameTheUnit) {
  const TemporaryFolder folder;
  const std::string sound = full_site();
  for (const auto& [from, to, unit] : std::vector<std::array<std::string, 3>>{
           {"separation_m: {mean: 1.25, std: 0.12}", "separation_m: {mean: 125, std: 12}",
            "in metres"},
           {"height_m: {mean: 0.68,", "height_m: {mean: 68,", "in metres"},
           {"{mean: 5.2, std: 0.05}", "{mean: 520, std: 5}", "in metres"},
           {"position_m: [2, 0, 5]", "position_m: [2, 0, 500]", "in metres"},
           {"position_m: [2, 0, 5]", "position_m: [463000, 0, 5]", "in metres"},
           {"lateral_m: -7.5", "lateral_m: -750", "in metres"},
           {"-7.5, width_m: 3.5", "-7.5, width_m: 350", "in metres"},
           {"area_m2: 1.0e-4", "area_m2: 7.5", "in square metres"},
           {"half_field_of_view_deg: 70", "half_field_of_view_deg: 1.22", "in degrees"}}) {
    const std::vector<Problem> problems =
        problems_of(folder.write("site.yaml", with(sound, from, to)));
    ASSERT_EQ(problems.size(), 1u) << to;
    EXPECT_NE(problems[0].remedy.find(unit), std::string::npos) << to << problems[0].remedy;
  }
}

// A motorcycle's two headlamps, a tractor's lamps on its roof.
TEST(SiteFile, LampsOfAllThatDrivesAreTaken) {
  const TemporaryFolder folder;
  for (const auto& [height, separation] : {std::pair{"0.9", "0.15"}, {"3.2", "2.4"}}) {
    std::string text = with(full_site(), "separation_m: {mean: 1.25, std: 0.12}",
                            std::string("separation_m: ") + separation);
    text = with(text, "  height_m: {mean: 0.68, std: 0.08}", std::string("  height_m: ") + height);
    EXPECT_NO_THROW(load_site(folder.write("site.yaml", text))) << height;
  }
}

TEST(SiteFile, EachRuleBrokenAloneIsNamedWithKeyAndLine) {
  const TemporaryFolder folder;
  const std::string sound = full_site();
  const std::vector<Breach> breaches{
      {"version: 1\n", "version: 2\n", "version", "version: 2"},
      {"version: 1\n", "", "version", ""},
      {"image_size_px: [1920, 1080]", "image_size_px: [1920, 0]", "camera.image_size_px[1]",
       "[1920"},
      {"image_size_px: [1920, 1080]", "image_size_px: [1920.5, 1080]", "camera.image_size_px[0]",
       "[1920.5"},
      {"  image_size_px: [1920, 1080]\n", "", "camera.image_size_px", "camera:"},
      {"image_size_px: [1920, 1080]", "image_size_px: [1920]", "camera.image_size_px", "[1920]"},
      {"focal_px: [1400.0, 1400.0]", "focal_px: [1400.0, -1]", "camera.focal_px[1]", "-1]"},
      {"  focal_px: [1400.0, 1400.0]\n", "", "camera.focal_px", "camera:"},
      {"focal_std_px: 14.0", "focal_std_px: 300.0", "camera.focal_std_px", "300.0"},
      {"  principal_px: [959.5, 539.5]\n", "", "camera.principal_px", "camera:"},
      {"principal_px: [959.5", "principal_px: [.nan", "camera.principal_px[0]", ".nan"},
      {"model: brown", "model: braun", "camera.distortion.model", "braun"},
      {"model: brown", "model: fisheye", "camera.distortion.coefficients", "fisheye"},
      {"model: brown", "model: none", "camera.distortion.coefficients", "model: none"},
      {"[-0.31, 0.11, 1.0e-4, -2.0e-4, -0.02]", "[-0.31, 0.11]", "camera.distortion.coefficients",
       "model: brown"},
      {"{model: brown, coefficients: [-0.31, 0.11, 1.0e-4, -2.0e-4, -0.02]}", "brown",
       "camera.distortion", "brown"},
      {"position_m: [0, 0.1, {mean: 5.2, std: 0.05}]", "position_m: [0, 0.1]", "camera.position_m",
       "[0, 0.1]"},
      {"{mean: 5.2, std: 0.05}", "{mean: 5.2, std: -0.05}", "camera.position_m[2].std", "-0.05"},
      {"{mean: 190, std: 0.5}", "{mean: 190, std: inf}", "camera.yaw_deg.std", "std: inf"},
      {"pitch_deg: -4.1", "pitch_deg: -94.1", "camera.pitch_deg", "-94.1"},
      {"{mean: 5.2, std: 0.05}", "{mean: -5.2, std: 0.05}", "camera.position_m", "position_m"},
      {"principal_px: [", "principal_px: [-9", "camera.principal_px", "principal_px"},
      {"exposure_s: 0.002", "exposure_s: 11", "camera.exposure_s", "exposure_s: 11"},
      {"exposure_s: 0.002", "exposure_s: 0", "camera.exposure_s", "exposure_s: 0"},
      {"rolling_shutter_s: 0.016", "rolling_shutter_s: -1", "camera.rolling_shutter_s", "_s: -1"},
      {"kind: table", "kind: tabel", "camera.response.kind", "tabel"},
      {"kind: table", "kind: srgb", "camera.response.values", "kind: srgb"},
      {"kind: table", "kind: table, exponent: 2", "camera.response.exponent", "exponent: 2"},
      {"{kind: table, values: " + table_of(256, 1.0 / 255.0), "{kind: gamma",
       "camera.response.exponent", "kind: gamma"},
      {"{kind: table, values: " + table_of(256, 1.0 / 255.0), "{kind: table",
       "camera.response.values", "kind: table"},
      {table_of(256, 1.0 / 255.0), table_of(255, 1.0), "camera.response.values", "kind: table"},
      {table_of(256, 1.0 / 255.0), table_of(256, 0.0), "camera.response.values", "kind: table"},
      {"core_sigma_px: 1.2", "core_sigma_px: 0.4", "camera.psf.core_sigma_px", "psf:"},
      {"{mean: 0.04, std: 0.003}", "1", "camera.psf.wing_share", "psf:"},
      {"wing_scale_px: 2.5, ", "", "camera.psf.wing_scale_px", "psf:"},
      {"wing_scale_px: 2.5", "wing_scale_px: 0.4", "camera.psf.wing_scale_px", "psf:"},
      {"wing_exponent: 3.1", "wing_exponent: 2", "camera.psf.wing_exponent", "psf:"},
      {"  path_loss_exponent: {mean: 1.9,", "  path_loss_exponent: {mean: 0,",
       "camera.path_loss_exponent.mean", "{mean: 0,"},
      {"id: pd-1", "id: pd0", "photodiodes[1].id", "- {id: pd0"},
      {"{id: pd-1, ", "{", "photodiodes[1].id", "- {position_m"},
      {"id: pd-1", "id: \"a,b\"", "photodiodes[1].id", "a,b"},
      {"position_m: [2, 0, 5], ", "", "photodiodes[1].position_m", "- {id: pd-1"},
      {"half_field_of_view_deg: 70", "half_field_of_view_deg: 0",
       "photodiodes[0].half_field_of_view_deg", "view_deg: 0"},
      {"half_field_of_view_deg: 70", "half_field_of_view_deg: 91",
       "photodiodes[0].half_field_of_view_deg", "view_deg: 91"},
      {"area_m2: 1.0e-4", "area_m2: 0", "photodiodes[0].area_m2", "area_m2: 0"},
      {"area_m2: 1.0e-4", "aera_m2: 1.0e-4", "photodiodes[0].aera_m2", "aera_m2"},
      {"gain_ratio: {mean: 1.0, std: 0.002}", "gain_ratio: -1", "photodiodes[0].gain_ratio",
       "gain_ratio: -1"},
      {"gain_ratio: {mean: 1.0, std: 0.002}", "gain_ratio: 2", "photodiodes[0].gain_ratio",
       "gain_ratio: 2"},
      {"responsivity_a_per_w: 0.45", "responsivity_a_per_w: 0",
       "photodiodes[0].responsivity_a_per_w", "per_w: 0"},
      {"transimpedance_v_per_a: 1.0e6", "transimpedance_v_per_a: x",
       "photodiodes[0].transimpedance_v_per_a", "per_a: x"},
      {"volts_per_count: 5.0e-5", "volts_per_count: -1", "photodiodes[0].volts_per_count",
       "volts_per_count: -1"},
      {"full_scale_v: 3.3", "full_scale_v: 3.3, volts_per_count: 1.0e-3",
       "photodiodes[1].full_scale_v", "full_scale_v: 3.3"},
      {"mains_hz: 60", "photodiode: {position_m: [0, 0, 5]}\nmains_hz: 60", "photodiode",
       "photodiode: {"},
      {"mains_hz: 60", "mains_hz: 0", "mains_hz", "mains_hz: 0"},
      {"kind: curved", "kind: curvy", "road.kind", "curvy"},
      {"  kind: curved              # straight | curved\n", "", "road.kind", "road:"},
      {"straight_m: {mean: 12.5", "straight_m: {mean: -1", "road.straight_m.mean",
       "straight_m: {mean: -1"},
      {"radius_m: {mean: 40.0, std: 0.4}", "radius_m: 0", "road.radius_m", "radius_m: 0"},
      {"  radius_m: {mean: 40.0, std: 0.4}              # curved only\n", "", "road.radius_m",
       "road:"},
      {"radius_m: {mean: 40.0, std: 0.4}", "radius_m: 7.5", "road.lanes[1].lateral_m", "{id: far"},
      {"turn: right", "turn: rihgt", "road.turn", "rihgt"},
      {"  turn: right                  # curved only\n", "", "road.turn", "road:"},
      {"id: far", "id: near", "road.lanes[1].id", "lateral_m: -7.5"},
      {"{id: far,  ", "{", "road.lanes[1].id", "lateral_m: -7.5"},
      {"lateral_m: -7.5, ", "", "road.lanes[1].lateral_m", "{id: far"},
      {"-7.5, width_m: 3.5", "-7.5, width_m: 0", "road.lanes[1].width_m", "{id: far"},
      {"direction: receding", "direction: receeding", "road.lanes[1].direction", "receeding"},
      {", direction: receding", "", "road.lanes[1].direction", "{id: far"},
      {"speed_limit_mps: 13.9", "speed_limit_mps: 0", "road.speed_limit_mps", "mps: 0"},
      {"height_m: {mean: 0.68", "height_m: {mean: -0.68", "lamps.height_m.mean", "-0.68"},
      {"separation_m: {mean: 1.25, std: 0.12}", "separation_m: wide", "lamps.separation_m", "wide"},
      {"separation_m: {mean: 1.25, std: 0.12}", "separation_m:", "lamps.separation_m",
       "separation_m:"},
      {"gain_db: {mean: -49.32, std: 3.0}", "gain_db: {mean: -49.32}", "channel.gain_db.std",
       "-49.32"},
      {"path_loss_exponent: {mean: 1.21", "path_loss_exponent: {mean: -1.21",
       "channel.path_loss_exponent.mean", "-1.21"},
      {"half_power_angle_deg: 40", "half_power_angle_deg: 90", "channel.half_power_angle_deg",
       "deg: 90"},
      {"lamp_power_w: {mean: 1.5, std: 0.2}", "lamp_power_w: 0", "channel.lamp_power_w",
       "lamp_power_w: 0"},
      {"lamp_power_w: {mean", "luminous_efficacy_lm_per_w: 0\n  lamp_power_w: {mean",
       "channel.luminous_efficacy_lm_per_w", "lm_per_w: 0"},
      {"speed_mps: {mean: 17", "speed_mps: {mean: -17", "ego.speed_mps.mean", "-17"},
      {"speed_mps: {mean: 17, std: 0.1}", "{}", "ego", "ego:"},
      {"mains_hz: 60", "mains_hz: 60\nmains_hz: 60", "mains_hz", ""},
      {"mains_hz: 60", "main_hz: 60", "main_hz", "main_hz"},
      {"lamps:  ", "lamsp:  ", "lamsp", "lamsp"},
  };
  for (const Breach& breach : breaches) {
    const std::string text = with(sound, breach.from, breach.to);
    const std::filesystem::path file = folder.write("site.yaml", text);
    const std::vector<Problem> problems = problems_of(file);
    ASSERT_EQ(problems.size(), 1u) << breach.to << " for " << breach.from;
    EXPECT_EQ(problems[0].file, file.string());
    EXPECT_EQ(problems[0].key, breach.key);
    if (!breach.at.empty()) {
      EXPECT_EQ(problems[0].line, line_of(text, breach.at)) << to_string(problems[0]);
    }
    EXPECT_FALSE(problems[0].fault.empty()) << breach.key;
    EXPECT_FALSE(problems[0].remedy.empty()) << breach.key;
  }
}

TEST(SiteFile, SeveralFaultsAreAllReportedInOrder) {
  const TemporaryFolder folder;
  std::string text = with(full_site(), "focal_px: [1400.0, 1400.0]", "focal_px: [0, 0]");
  text = with(text, "area_m2: 1.0e-4", "area_m: 1.0e-4");
  text = with(text, "turn: right", "turn: up");
  text = with(text, "gain_db: {mean: -49.32, std: 3.0}", "gain_db: {mean: -49.32, std: -3.0}");
  const std::vector<Problem> problems = problems_of(folder.write("site.yaml", text));
  std::vector<std::string> keys;
  for (const Problem& problem : problems) keys.push_back(problem.key);
  EXPECT_EQ(keys, (std::vector<std::string>{"camera.focal_px[0]", "camera.focal_px[1]",
                                            "photodiodes[0].area_m", "road.turn",
                                            "channel.gain_db.std"}));
  EXPECT_EQ(problems.at(2).remedy, "did you mean \"area_m2\"?");
}

TEST(SiteFile, AnEmptySiteNeedsASensor) {
  const TemporaryFolder folder;
  const auto problems = problems_of(folder.write("site.yaml", "version: 1\nmains_hz: 50\n"));
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].fault.find("neither a camera nor a photodiode"), std::string::npos);
}

TEST(SiteFile, LanesMayLieOutsideTheBendButNotAtItsCentre) {
  const TemporaryFolder folder;
  const std::string left = with(full_site(), "turn: right", "turn: left");
  // To the right of a left bend there is room without end.
  EXPECT_TRUE(
      problems_of(folder.write("site.yaml", with(left, "lateral_m: -7.5", "lateral_m: -75")))
          .empty());
  EXPECT_EQ(
      problems_of(folder.write("site.yaml", with(left, "lateral_m: -7.5", "lateral_m: 40"))).size(),
      1u);
}

TEST(SiteFile, TheBeamStandsInPlaceOfThePowerLaw) {
  const TemporaryFolder folder;
  folder.write("lamp.IES", "IESNA:LM-63-2002\n");
  const std::string law =
      "  gain_db: {mean: -49.32, std: 3.0}      # K_dB: power at D = 1 m over the lamp's total "
      "power\n  path_loss_exponent: {mean: 1.21, std: 0.05}\n";
  const auto beam_of = [&](const std::string& beam) {
    return load_site(folder.write("site.yaml", with(kContractSite, law, "  beam: " + beam + "\n")))
        .channel->beam;
  };
  EXPECT_EQ(beam_of("low_beam"), "low_beam");
  EXPECT_EQ(beam_of("high_beam"), "high_beam");
  EXPECT_EQ(beam_of("lamp.IES"), (folder.path() / "lamp.IES").string());
  const auto problem_of = [&](const std::string& text) {
    const auto problems = problems_of(folder.write("site.yaml", text));
    EXPECT_EQ(problems.size(), 1u);
    return problems.at(0);
  };
  EXPECT_NE(problem_of(with(kContractSite, law, "  beam: low_beem\n")).remedy.find("\"low_beam\""),
            std::string::npos);
  EXPECT_NE(problem_of(with(kContractSite, law, "  beam: absent.ies\n")).fault.find("not exist"),
            std::string::npos);
  const std::string no_area = with(kContractSite, "  area_m2: 1.0e-4\n", "");
  EXPECT_NE(problem_of(with(no_area, law, "  beam: low_beam\n")).fault.find("pd0 has no area_m2"),
            std::string::npos);
  EXPECT_TRUE(problems_of(folder.write("site.yaml", no_area)).empty());
  const std::string both = with(kContractSite, law, "  beam: low_beam\n" + law);
  const auto problems = problems_of(folder.write("site.yaml", both));
  ASSERT_EQ(problems.size(), 2u);
  EXPECT_EQ(problems[0].key, "channel.gain_db");
  EXPECT_EQ(problems[1].key, "channel.path_loss_exponent");
}

TEST(SiteFile, WritingTheSettingsInForceAndReadingThemGivesTheSameSite) {
  const TemporaryFolder folder, elsewhere;
  folder.write("ego.csv", "t_s,speed_mps\n0,10\n1,11\n");
  folder.write("lamp.ies", "IESNA:LM-63-2002\n");
  const std::string law =
      "  gain_db: {mean: -49.32, std: 3.0}      # K_dB: power at D = 1 m over the lamp's total "
      "power\n  path_loss_exponent: {mean: 1.21, std: 0.05}\n";
  const std::vector<std::string> texts{
      std::string(kContractSite),
      full_site(),
      with(kContractSite, law, "  beam: lamp.ies\n  luminous_efficacy_lm_per_w: 250\n"),
      with(kContractSite, "{kind: srgb}", "{kind: gamma, exponent: 2.35}"),
      with(kContractSite, "model: brown, coefficients: [0, 0, 0, 0, 0]",
           "model: fisheye, coefficients: [0.1, -0.2, 0.3, 1.0e-17]"),
      with(kContractSite, "speed_mps: 0.0  ", "trace: ego.csv  "),
      "version: 1\nphotodiode: {id: 2.5, position_m: [0, 0, 5]}\n",
  };
  for (const std::string& text : texts) {
    const Site site = load_site(folder.write("site.yaml", text));
    const std::string written = effective_site_yaml(site);
    Site again = load_site(elsewhere.write("other.yaml", written));
    EXPECT_NE(again.file, site.file);
    again.file = site.file;
    EXPECT_EQ(again, site) << written;
  }
}

TEST(SiteFile, AnglesWrittenFromDegreesComeBackToTheLastBit) {
  const TemporaryFolder folder;
  Random random(7);
  for (int trial = 0; trial < 200; ++trial) {
    const std::string angle = number_text(random.uniform(-180.0, 180.0));
    const Site site = load_site(
        folder.write("site.yaml", with(kContractSite, "roll_deg: 0.0", "roll_deg: " + angle)));
    const Site again = load_site(folder.write("again.yaml", effective_site_yaml(site)));
    EXPECT_EQ(again.camera->roll_rad, site.camera->roll_rad) << angle;
  }
}

TEST(SiteFile, AClipOfAnotherSizeIsRefusedWithBothSizes) {
  const TemporaryFolder folder;
  Site site = load_site(folder.write("site.yaml", kContractSite));
  EXPECT_NO_THROW(check_site_fits_clip(site, 1920, 1080));
  for (const auto& [width, height] : {std::pair{1280, 720}, {1080, 1920}, {1920, 1088}}) {
    try {
      check_site_fits_clip(site, width, height);
      ADD_FAILURE() << width << " x " << height;
    } catch (const ConfigError& error) {
      const std::string message = error.what();
      for (const std::string& part :
           {site.file.string(), std::string("camera.image_size_px"), std::string("1920 x 1080"),
            std::to_string(width) + " x " + std::to_string(height)})
        EXPECT_NE(message.find(part), std::string::npos) << message;
      EXPECT_FALSE(error.problems().at(0).remedy.empty());
    }
  }
  site.camera.reset();
  EXPECT_THROW(check_site_fits_clip(site, 1920, 1080), ConfigError);
}

}  // namespace
}  // namespace vildar
