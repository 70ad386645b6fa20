#include "optics/ies_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/quantity.h"
#include "core/random.h"
#include "optics/lamp_beam.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"
#include "toward.h"

namespace vildar {
namespace {

std::vector<double> steps(double first, double last, double step) {
  std::vector<double> values;
  for (int i = 0; first + i * step <= last + 1e-9; ++i) values.push_back(first + i * step);
  return values;
}

/// A file to be written. The defaults are a lamp of one candela, type C, metres.
struct Made {
  std::string header = "IES:LM-63-2019\n[TEST] made by hand\n[MANUFAC] none\n";
  std::string tilt = "TILT=NONE\n";
  std::string lamps = "1 -1 1";
  int type = 1, unit = 2;
  std::string opening = "0.1 0.2 0.3";
  std::string ballast = "1 1 55";
  std::vector<double> vertical_deg = {0.0, 90.0, 180.0}, horizontal_deg = {0.0};
  std::function<double(double horizontal_deg, double vertical_deg)> intensity = [](double, double) {
    return 1.0;
  };
  std::string tail = "";

  std::string text() const {
    std::ostringstream out;
    out.precision(12);
    out << header << tilt << lamps << ' ' << vertical_deg.size() << ' ' << horizontal_deg.size()
        << ' ' << type << ' ' << unit << ' ' << opening << '\n'
        << ballast << '\n';
    const auto put = [&](const std::vector<double>& values) {
      for (std::size_t i = 0; i < values.size(); ++i)
        out << values[i] << (i % 10 == 9 ? '\n' : ' ');
      out << '\n';
    };
    put(vertical_deg);
    put(horizontal_deg);
    for (const double horizontal : horizontal_deg) {
      std::vector<double> row;
      for (const double vertical : vertical_deg) row.push_back(intensity(horizontal, vertical));
      put(row);
    }
    out << tail;
    return out.str();
  }
};

class IesFileTest : public ::testing::Test {
 protected:
  IesFile read(const Made& made) { return read_ies(folder_.write("lamp.ies", made.text())); }

  LampBeam beam_of(const Made& made, TypeCAxis axis = TypeCAxis::ahead) {
    return LampBeam(TableBeam{read(made).table, axis});
  }

  std::string message_of(const std::string& text) {
    const auto file = folder_.write("bad.ies", text);
    try {
      read_ies(file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  TemporaryFolder folder_;
};

TEST_F(IesFileTest, ALampOfOneCandelaAllAroundSendsOutFourPi) {
  EXPECT_NEAR(read({}).table->flux_lm(), 4.0 * kPi, 1e-12);
  EXPECT_NEAR(read({.horizontal_deg = {0.0, 45.0, 90.0}}).table->flux_lm(), 4.0 * kPi, 1e-12);
  EXPECT_NEAR(read({.horizontal_deg = {0.0, 180.0}}).table->flux_lm(), 4.0 * kPi, 1e-12);
  EXPECT_NEAR(read({.horizontal_deg = {90.0, 180.0, 270.0}}).table->flux_lm(), 4.0 * kPi, 1e-12);
  EXPECT_NEAR(read({.horizontal_deg = steps(0.0, 360.0, 30.0)}).table->flux_lm(), 4.0 * kPi, 1e-12);
  EXPECT_NEAR(read({.horizontal_deg = steps(0.0, 330.0, 30.0)}).table->flux_lm(), 4.0 * kPi, 1e-12);
  // The half sphere ahead, and a quarter of it completed by symmetry.
  for (const int type : {2, 3}) {
    const auto whole = steps(-90.0, 90.0, 15.0), half = steps(0.0, 90.0, 15.0);
    EXPECT_NEAR(
        read({.type = type, .vertical_deg = whole, .horizontal_deg = whole}).table->flux_lm(),
        2.0 * kPi, 1e-12);
    EXPECT_NEAR(read({.type = type, .vertical_deg = half, .horizontal_deg = half}).table->flux_lm(),
                2.0 * kPi, 1e-12);
  }
}

/// A smooth lamp without any symmetry, by the direction of its light.
double lopsided_cd(double ahead, double left, double up) {
  return ahead <= 0.0 ? 0.0
                      : 1000.0 * ahead * ahead * (1.0 + 0.4 * left + 0.3 * up + 0.2 * left * up);
}

TEST_F(IesFileTest, TheThreeTypesDescribeTheSameLamp) {
  const auto degrees = [](double angle_deg) { return radians_from_degrees(angle_deg); };
  const auto whole = steps(-90.0, 90.0, 1.0);
  const LampBeam a = beam_of({.type = 3,
                              .vertical_deg = whole,
                              .horizontal_deg = whole,
                              .intensity = [&](double h, double v) {
                                return lopsided_cd(std::cos(degrees(v)) * std::cos(degrees(h)),
                                                   -std::cos(degrees(v)) * std::sin(degrees(h)),
                                                   std::sin(degrees(v)));
                              }});
  const LampBeam b = beam_of({.type = 2,
                              .vertical_deg = whole,
                              .horizontal_deg = whole,
                              .intensity = [&](double h, double v) {
                                return lopsided_cd(std::cos(degrees(h)) * std::cos(degrees(v)),
                                                   -std::sin(degrees(h)),
                                                   std::cos(degrees(h)) * std::sin(degrees(v)));
                              }});
  const LampBeam c = beam_of({.vertical_deg = steps(0.0, 90.0, 1.0),
                              .horizontal_deg = steps(0.0, 360.0, 2.0),
                              .intensity = [&](double h, double v) {
                                return lopsided_cd(std::cos(degrees(v)),
                                                   std::sin(degrees(v)) * std::sin(degrees(h)),
                                                   std::sin(degrees(v)) * std::cos(degrees(h)));
                              }});
  // Linear between nodes 1 to 2 degrees apart: half the squared step times the curvature.
  constexpr double kInterpolation_cd = 1.0;
  Random random(41);
  for (int i = 0; i < 400; ++i) {
    const double left_deg = random.uniform(-80.0, 80.0), up_deg = random.uniform(-80.0, 80.0);
    const double left_rad = degrees(left_deg), up_rad = degrees(up_deg);
    const double truth_cd = lopsided_cd(std::cos(up_rad) * std::cos(left_rad),
                                        std::cos(up_rad) * std::sin(left_rad), std::sin(up_rad));
    EXPECT_NEAR(toward(a, left_deg, up_deg), truth_cd, kInterpolation_cd);
    EXPECT_NEAR(toward(b, left_deg, up_deg), truth_cd, kInterpolation_cd);
    EXPECT_NEAR(toward(c, left_deg, up_deg), truth_cd, kInterpolation_cd);
  }
  // Only the even part has flux: 1000 times the integral of cos^2 over the half sphere.
  for (const LampBeam* beam : {&a, &b, &c})
    EXPECT_NEAR(beam->flux_lm() / (1000.0 * 2.0 * kPi / 3.0), 1.0, 3e-4);
}

TEST_F(IesFileTest, SymmetryFoldsTheAnglesThatAreLeftOut) {
  const auto plane = [](double h, double) { return 100.0 + h; };
  const LampBeam quadrant = beam_of({.horizontal_deg = {0.0, 90.0}, .intensity = plane});
  const LampBeam bilateral = beam_of({.horizontal_deg = {0.0, 90.0, 180.0}, .intensity = plane});
  const LampBeam side = beam_of({.horizontal_deg = {90.0, 180.0, 270.0}, .intensity = plane});
  const LampBeam open = beam_of({.horizontal_deg = {0.0, 90.0, 180.0, 270.0}, .intensity = plane});
  // The plane C stands upright ahead: 0 up, 90 left, 180 down, 270 right.
  const auto at_plane = [](const LampBeam& beam, double plane_deg) {
    const double plane_rad = radians_from_degrees(plane_deg);
    return beam.intensity_cd(Eigen::Vector3d(1.0, std::sin(plane_rad), std::cos(plane_rad)));
  };
  for (const double plane_deg : {10.0, 80.0}) {
    for (const double same_deg :
         {plane_deg, 180.0 - plane_deg, 180.0 + plane_deg, 360.0 - plane_deg})
      EXPECT_NEAR(at_plane(quadrant, same_deg), 100.0 + plane_deg, 1e-9);
    EXPECT_NEAR(at_plane(bilateral, 360.0 - plane_deg), 100.0 + plane_deg, 1e-9);
    EXPECT_NEAR(at_plane(bilateral, 180.0 - plane_deg), 280.0 - plane_deg, 1e-9);
    EXPECT_NEAR(at_plane(side, plane_deg), 280.0 - plane_deg, 1e-9);
    EXPECT_NEAR(at_plane(side, 360.0 - plane_deg), 280.0 + plane_deg, 1e-9);
    EXPECT_NEAR(at_plane(side, 180.0 + plane_deg), 280.0 + plane_deg, 1e-9);
    // Between the last plane and the first again.
    EXPECT_NEAR(at_plane(open, 270.0 + plane_deg), std::lerp(370.0, 100.0, plane_deg / 90.0), 1e-9);
  }
}

TEST_F(IesFileTest, ALuminaireShinesDownWithItsFirstPlaneAhead) {
  const LampBeam lamp =
      beam_of({.vertical_deg = {0.0, 90.0},
               .horizontal_deg = {0.0, 90.0, 180.0, 270.0, 360.0},
               .intensity = [](double h, double v) { return v + std::fmod(h, 360.0); }},
              TypeCAxis::down);
  EXPECT_NEAR(toward(lamp, 0.0, -90.0), 0.0, 1e-6);
  EXPECT_NEAR(toward(lamp, 0.0, -30.0), 60.0, 1e-9);
  EXPECT_NEAR(toward(lamp, 90.0, -30.0), 150.0, 1e-9);
  EXPECT_NEAR(toward(lamp, -90.0, -30.0), 330.0, 1e-9);
  EXPECT_EQ(toward(lamp, 0.0, 1.0), 0.0) << "beyond the measured angles";
}

TEST_F(IesFileTest, EveryFactorOfTheFileCounts) {
  const auto on_axis = [&](const Made& made) { return toward(beam_of(made), 0.0, 0.0); };
  EXPECT_NEAR(on_axis({.lamps = "2 700 2.5", .ballast = "0.8 1 55"}), 2.0, 1e-12);
  // After 1991 the second number is no factor any more.
  EXPECT_NEAR(on_axis({.ballast = "1 1.10000 55"}), 1.0, 1e-12);
  EXPECT_NEAR(on_axis({.header = "IESNA91\n[TEST] x\n", .ballast = "1 0.9 55"}), 0.9, 1e-12);
  EXPECT_NEAR(on_axis({.header = "a lamp of 1986\n", .ballast = "1 0.9 55"}), 0.9, 1e-12);
  EXPECT_NEAR(on_axis({.tilt = "TILT=INCLUDE\n1\n3\n0 45 90\n0.95 0.9 0.8\n"}), 0.95, 1e-12);
  const IesFile two_lamps = read({.lamps = "2 700 1", .unit = 1, .opening = "1 0 -0.5"});
  EXPECT_EQ(two_lamps.lamp_lumens.value(), 1400.0);
  EXPECT_NEAR(two_lamps.opening_m[0], 0.3048, 1e-12);
  EXPECT_NEAR(two_lamps.opening_m[2], -0.1524, 1e-12);
  EXPECT_EQ(two_lamps.input_power_w, 55.0);
  EXPECT_FALSE(read({}).lamp_lumens.has_value()) << "absolute photometry";
}

TEST_F(IesFileTest, KnowsTheStandardsByTheirFirstLine) {
  EXPECT_EQ(read({}).standard, "LM-63-2019");
  EXPECT_EQ(read({.header = "IESNA:LM-63-2002\r\n[TEST] x\r\n"}).standard, "LM-63-2002");
  EXPECT_EQ(read({.header = "IESNA:LM-63-1995\n"}).standard, "LM-63-1995");
  EXPECT_EQ(read({.header = "IESNA91\n"}).standard, "LM-63-1991");
  EXPECT_EQ(read({.header = ""}).standard, "LM-63-1986");
  EXPECT_EQ(read({.header = "", .tail = "\r\n\x1a"}).standard, "LM-63-1986");
  EXPECT_NE(message_of(Made{.header = "IES:LM-63-2042\n"}.text()).find("bad.ies:1: header"),
            std::string::npos);
}

TEST_F(IesFileTest, EveryFaultIsNamedWithItsLine) {
  const auto expect = [&](const std::string& text, const std::string& part) {
    EXPECT_NE(message_of(text).find(part), std::string::npos) << message_of(text);
  };
  // Lines of a made file: 1-3 header, 4 TILT, 5 lamps, 6 ballast, 7 vertical, 8 horizontal, 9
  // table.
  expect("nothing of the kind\n", "bad.ies:1: no line begins with TILT=");
  expect("", "bad.ies:1: no line begins with TILT=");
  expect(Made{.tilt = "TILT=lamp.tlt\n"}.text(), "bad.ies:4: TILT=lamp.tlt names another file");
  expect(Made{.tilt = "TILT=INCLUDE\n1\n2\n45 90\n1 0.9\n"}.text(),
         "bad.ies:8: the tilt angles have no 0");
  expect(Made{.lamps = "1 -1 0"}.text(),
         "bad.ies:5: the candela multiplier is 0; it must be positive");
  expect(Made{.lamps = "1 -1 x"}.text(),
         "bad.ies:5: \"x\" stands where the candela multiplier should");
  expect(Made{.lamps = "1 -1 nan"}.text(), "bad.ies:5: \"nan\"");
  expect(Made{.lamps = "1 0 1"}.text(), "bad.ies:5: the lumens of a lamp are 0");
  expect(Made{.type = 4}.text(), "bad.ies:5: the photometric type (1 C, 2 B, 3 A) is 4");
  expect(Made{.unit = 3}.text(), "bad.ies:5: the unit (1 feet, 2 metres) is 3");
  expect(Made{.vertical_deg = {0.0, 90.0, 90.0}}.text(),
         "bad.ies:7: the vertical angles do not increase");
  expect(Made{.vertical_deg = {-10.0, 90.0}}.text(),
         "bad.ies:7: the vertical angles run from -10 to 90");
  expect(Made{.horizontal_deg = {0.0, 70.0}}.text(),
         "bad.ies:8: the horizontal angles run from 0 to 70");
  expect(Made{.type = 3}.text(), "single horizontal angle");
  expect(Made{.intensity = [](double, double) { return -2.0; }}.text(),
         "bad.ies:9: an intensity is -2");
  expect(Made{.tail = "7\n"}.text(), "bad.ies:10: \"7\" stands after the last intensity");
  std::string cut = Made{}.text();
  cut.resize(cut.size() - 4);
  expect(cut, "the file ends where intensity 3 of 3 should stand");
  // Counts that no file can hold are refused before memory is asked for.
  expect("IES:LM-63-2019\nTILT=NONE\n1 -1 1 999999999 1 1 2 0 0 0\n",
         "bad.ies:3: the number of vertical angles");
  EXPECT_THROW(read_ies(folder_.path() / "absent.ies"), InputError);
  EXPECT_THROW(read_ies(folder_.path()), InputError);
}

TEST_F(IesFileTest, CutFilesNeverPass) {
  const std::string text = Made{.horizontal_deg = {0.0, 90.0, 180.0}}.text();
  // Cut before the last number begins; later cuts leave a shorter but whole number.
  for (std::size_t length = 0; length + 4 < text.size(); ++length)
    EXPECT_NE(message_of(text.substr(0, length)), "no error") << length;
}

TEST(IesReference, AMeasuredLuminaireSendsOutItsStatedLumens) {
  const auto file = shared_folder() / "data" / "ies" / "HellaEcoLight_2070lm_LDT.ies";
  if (!std::filesystem::exists(file))
    GTEST_SKIP() << "no reference data at " << file << "; set VILDAR_SHARED";
  const IesFile ies = read_ies(file);
  EXPECT_EQ(ies.standard, "LM-63-1991");
  // Its [LAMP] line states 2070 lm.
  EXPECT_NEAR(ies.table->flux_lm() / 2070.0, 1.0, 0.01);
  const LampBeam lamp(TableBeam{ies.table, TypeCAxis::down});
  EXPECT_NEAR(toward(lamp, 0.0, -90.0), 287.66, 1e-6);
  // Read by eye from the file at gamma = 60 and C = 0, 90 and 359.
  EXPECT_NEAR(toward(lamp, 0.0, -30.0), 899.24, 1e-6);
  EXPECT_NEAR(toward(lamp, 90.0, -30.0), 231.08, 1e-6);
  EXPECT_NEAR(toward(lamp, -1.0, -30.0), 864.67, 1e-6);
}

}  // namespace
}  // namespace vildar
