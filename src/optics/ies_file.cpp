#include "optics/ies_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/quantity.h"
#include "core/text.h"
#include "optics/ies_numbers.h"

namespace vildar {
namespace {

constexpr double kMetresPerFoot = 0.3048;
constexpr double kMostAngles = 10'000.0;

[[noreturn]] void fail(const std::filesystem::path& file, int line, const std::string& fault,
                       const std::string& remedy) {
  throw InputError(file.string() + ":" + std::to_string(line) + ": " + fault + "; " + remedy);
}

/// First line of the file. 1986 had none of its own: whatever is no later header is its label.
std::string standard_of(const std::filesystem::path& file, std::string_view first_line) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kHeaders{{
      {"IESNA91", "LM-63-1991"},
      {"IESNA:LM-63-1995", "LM-63-1995"},
      {"IESNA:LM-63-2002", "LM-63-2002"},
      {"IES:LM-63-2019", "LM-63-2019"},
  }};
  for (const auto& [header, standard] : kHeaders)
    if (first_line == header) return std::string(standard);
  if (first_line.starts_with("IESNA") || first_line.starts_with("IES:"))
    fail(file, 1, "header \"" + std::string(first_line) + "\" is not one of LM-63",
         "expected IESNA91, IESNA:LM-63-1995, IESNA:LM-63-2002 or IES:LM-63-2019");
  return "LM-63-1986";
}

/// What follows "TILT=", and all text after that line; sets its number and the standard.
struct TiltLine {
  std::string_view tilt, data;
};
TiltLine up_to_tilt(const std::filesystem::path& file, std::string_view text, std::string& standard,
                    int& line) {
  constexpr std::string_view kTilt = "TILT=";
  for (line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view row = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line == 1) standard = standard_of(file, row);
    if (row.starts_with(kTilt)) return {row.substr(kTilt.size()), text};
  }
  fail(file, std::max(line - 1, 1), "no line begins with TILT=",
       "this is not an LM-63 file: export the lamp as IES LM-63-2002 or 2019");
}

/// Share of the lamp's light that is left at no tilt.
double tilt_factor(IesNumbers& numbers) {
  numbers.whole("the lamp-to-luminaire geometry", 1, 3);
  const std::size_t pairs = numbers.whole("the number of tilt angles", 1, kMostAngles);
  const auto angles_deg = numbers.several("tilt angle", pairs);
  const auto factors = numbers.several("tilt factor", pairs);
  const auto level = std::find(angles_deg.begin(), angles_deg.end(), 0.0);
  if (level == angles_deg.end())
    numbers.fail("the tilt angles have no 0", "add the factor of the lamp as it was measured");
  const double factor = factors[static_cast<std::size_t>(level - angles_deg.begin())];
  if (!(factor > 0.0)) numbers.fail("the tilt factor at 0 is not positive", "correct it");
  return factor;
}

std::vector<double> increasing_angles(IesNumbers& numbers, const std::string& which,
                                      std::size_t count, double least_deg, double most_deg) {
  auto angles_deg = numbers.several("the " + which + " angle", count);
  if (std::adjacent_find(angles_deg.begin(), angles_deg.end(), std::greater_equal<>()) !=
      angles_deg.end())
    numbers.fail("the " + which + " angles do not increase", "sort them, each angle once");
  if (angles_deg.front() < least_deg || angles_deg.back() > most_deg)
    numbers.fail(
        "the " + which + " angles run from " + number_text(angles_deg.front()) + " to " +
            number_text(angles_deg.back()),
        "this photometric type has " + number_text(least_deg) + " to " + number_text(most_deg));
  return angles_deg;
}

/// Which part of the circle the planes of a type C table cover. Planes that end one step before 360
/// are closed by a copy of the first; the table has to follow, so `closes` says so.
TableSymmetry plane_symmetry(const IesNumbers& numbers, std::vector<double>& planes_deg,
                             bool& closes) {
  closes = false;
  if (planes_deg.size() == 1) return TableSymmetry::rotational;
  const double first_deg = planes_deg.front(), last_deg = planes_deg.back();
  if (first_deg == 90.0 && last_deg == 270.0) return TableSymmetry::bilateral_side;
  if (first_deg == 0.0) {
    if (last_deg == 90.0) return TableSymmetry::quadrant;
    if (last_deg == 180.0) return TableSymmetry::bilateral;
    if (last_deg == 360.0) return TableSymmetry::none;
    double widest_deg = 0.0;
    for (std::size_t i = 1; i < planes_deg.size(); ++i)
      widest_deg = std::max(widest_deg, planes_deg[i] - planes_deg[i - 1]);
    if (last_deg > 180.0 && 360.0 - last_deg <= 1.001 * widest_deg) {
      planes_deg.push_back(360.0);
      closes = true;
      return TableSymmetry::none;
    }
  }
  numbers.fail(
      "the horizontal angles run from " + number_text(first_deg) + " to " + number_text(last_deg),
      "type C needs 0 alone, 0 to 90, 0 to 180, 90 to 270 or 0 to 360");
}

std::vector<double> in_radians(std::vector<double> angles_deg) {
  for (double& angle : angles_deg) angle = radians_from_degrees(angle);
  return angles_deg;
}

/// Angles and intensities, the last part of a file.
CandelaGrid read_grid(IesNumbers& numbers, PhotometricType type, std::size_t vertical_count,
                      std::size_t horizontal_count, double factor) {
  const bool around = type == PhotometricType::c;
  if (!around && horizontal_count < 2)
    numbers.fail("types A and B with a single horizontal angle leave out the rest",
                 "give two or more");
  CandelaGrid grid;
  grid.type = type;
  const auto vertical_deg = increasing_angles(numbers, "vertical", vertical_count,
                                              around ? 0.0 : -90.0, around ? 180.0 : 90.0);
  const double most_aside_deg = type == PhotometricType::a ? 180.0 : 90.0;
  auto horizontal_deg =
      increasing_angles(numbers, "horizontal", horizontal_count, around ? 0.0 : -most_aside_deg,
                        around ? 360.0 : most_aside_deg);
  bool closes = false;
  if (around) {
    grid.symmetry = plane_symmetry(numbers, horizontal_deg, closes);
  } else {
    grid.mirrored_vertically = vertical_deg.front() == 0.0;
    if (horizontal_deg.front() == 0.0) grid.symmetry = TableSymmetry::bilateral;
  }
  grid.vertical_rad = in_radians(vertical_deg);
  grid.horizontal_rad = in_radians(std::move(horizontal_deg));
  grid.intensity_cd.reserve(vertical_count * (horizontal_count + 1));
  for (std::size_t i = 0; i < vertical_count * horizontal_count; ++i) {
    const double intensity = numbers.next("intensity " + std::to_string(i + 1) + " of " +
                                          std::to_string(vertical_count * horizontal_count));
    if (intensity < 0.0)
      numbers.fail("an intensity is " + number_text(intensity), "light is never negative");
    grid.intensity_cd.push_back(factor * intensity);
  }
  numbers.expect_end();
  for (std::size_t i = 0; closes && i < vertical_count; ++i)
    grid.intensity_cd.push_back(grid.intensity_cd[i]);
  return grid;
}

double positive(IesNumbers& numbers, const std::string& what) {
  const double value = numbers.next(what);
  if (!(value > 0.0)) numbers.fail(what + " is " + number_text(value), "it must be positive");
  return value;
}

}  // namespace

IesFile read_ies(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file))
    throw InputError(file.string() + ": cannot be read; give an LM-63 file");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};

  IesFile ies;
  int line = 0;
  const auto [tilt, data] = up_to_tilt(file, text, ies.standard, line);
  IesNumbers numbers(file, data, line + 1);
  double factor = 1.0;
  if (tilt == "INCLUDE") {
    factor = tilt_factor(numbers);
  } else if (tilt != "NONE") {
    fail(file, line, "TILT=" + std::string(tilt) + " names another file",
         "put the tilt data into this one (TILT=INCLUDE), or write TILT=NONE");
  }

  const double lamps = static_cast<double>(numbers.whole("the number of lamps", 1, 1e6));
  const double lumens_each = numbers.next("the lumens of a lamp");
  if (lumens_each > 0.0)
    ies.lamp_lumens = lamps * lumens_each;
  else if (lumens_each != -1.0)
    numbers.fail("the lumens of a lamp are " + number_text(lumens_each),
                 "write a positive number, or -1 for absolute photometry");
  factor *= positive(numbers, "the candela multiplier");
  const std::size_t vertical_count = numbers.whole("the number of vertical angles", 2, kMostAngles);
  const std::size_t horizontal_count =
      numbers.whole("the number of horizontal angles", 1, kMostAngles);
  const auto type =
      static_cast<PhotometricType>(numbers.whole("the photometric type (1 C, 2 B, 3 A)", 1, 3));
  const double unit_m =
      numbers.whole("the unit (1 feet, 2 metres)", 1, 2) == 1 ? kMetresPerFoot : 1.0;
  const auto opening = numbers.several("luminous opening, size", 3);
  for (std::size_t i = 0; i < 3; ++i) ies.opening_m[i] = unit_m * opening[i];
  factor *= positive(numbers, "the ballast factor");
  if (ies.standard == "LM-63-1986" || ies.standard == "LM-63-1991")
    factor *= positive(numbers, "the ballast-lamp photometric factor");
  else
    numbers.next("the number after the ballast factor");
  ies.input_power_w = numbers.next("the input power");
  ies.table = std::make_shared<const CandelaTable>(
      read_grid(numbers, type, vertical_count, horizontal_count, factor));
  return ies;
}

}  // namespace vildar
