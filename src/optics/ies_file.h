#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "optics/candela_table.h"

namespace vildar {

/// What a photometric file tells of a lamp.
struct IesFile {
  std::string standard;  ///< "LM-63-1986" ... "LM-63-2019"
  std::shared_ptr<const CandelaTable> table;
  /// Light of the bare lamps, as the file states it; absent with absolute photometry (-1 in the
  /// file).
  std::optional<double> lamp_lumens;
  /// Luminous opening: width, length, height. Negative sizes mean round ones, as the standard says.
  std::array<double, 3> opening_m{};
  double input_power_w = 0.0;
};

/// Reads an ANSI/IES LM-63 file (1986, 1991, 1995, 2002, 2019; types A, B and C; TILT=NONE or
/// INCLUDE). Intensities are multiplied by the candela multiplier, the ballast factor, up to 1991
/// the ballast-lamp factor, and the tilt factor at 0 degrees. One horizontal angle or a range of
/// 0-90, 0-180 or 90-270 degrees (type C), or one that begins at 0 (types A and B, vertical angles
/// too), is completed by the symmetry that the standard gives it; planes that stop one step short
/// of 360 are closed. Directions beyond the measured ones are dark. Throws InputError naming file,
/// line, fault and remedy.
IesFile read_ies(const std::filesystem::path& file);

}  // namespace vildar
