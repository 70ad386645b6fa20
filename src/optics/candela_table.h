#pragma once

#include <memory>
#include <vector>

namespace vildar {

/// Goniometer geometries of LM-63.
enum class PhotometricType {
  c = 1,  ///< polar axis along the photometric axis: gamma from it, C around it
  b = 2,  ///< polar axis across: vertical turns the plane, horizontal within it
  a = 3,  ///< polar axis upright: horizontal turns the plane, vertical within it (headlamps)
};

/// What the horizontal angles of a table leave out.
enum class TableSymmetry {
  none,
  rotational,      ///< type C, one plane
  quadrant,        ///< type C, 0 to 90
  bilateral,       ///< type C, 0 to 180; types A and B, 0 to 90: mirrored about 0
  bilateral_side,  ///< type C, 90 to 270: mirrored about the plane through 90 and 270
};

/// Measured intensities on a grid of photometric angles.
struct CandelaGrid {
  PhotometricType type = PhotometricType::c;
  TableSymmetry symmetry = TableSymmetry::none;
  bool mirrored_vertically = false;    ///< types A and B measured from 0 up only
  std::vector<double> vertical_rad;    ///< increasing
  std::vector<double> horizontal_rad;  ///< increasing; type C without symmetry: 0 and 2 pi both
  std::vector<double> intensity_cd;    ///< all vertical angles of the first horizontal one, then on
};

/// Bilinear interpolation in a grid, and its light. Directions outside the grid are dark.
class CandelaTable {
 public:
  /// Throws std::invalid_argument where the sizes do not fit or angles do not increase.
  explicit CandelaTable(CandelaGrid grid);

  PhotometricType type() const { return grid_.type; }
  double intensity_cd(double horizontal_rad, double vertical_rad) const;
  /// Integral of the interpolated table over all directions, in closed form cell by cell.
  double flux_lm() const;

 private:
  double at(std::size_t horizontal, std::size_t vertical) const {
    return grid_.intensity_cd[horizontal * grid_.vertical_rad.size() + vertical];
  }
  CandelaGrid grid_;
};

/// Where gamma = 0 of a type C table points.
enum class TypeCAxis {
  ahead,  ///< headlamp: C 0 up, C 90 left
  down,   ///< luminaire over a road: C 0 ahead, C 90 left
};

/// A table in the lamp's axes. Types A and B: vertical positive up, horizontal positive to the
/// RIGHT as seen from behind the lamp, as vehicle lighting counts it.
struct TableBeam {
  std::shared_ptr<const CandelaTable> table;
  TypeCAxis type_c_axis = TypeCAxis::ahead;

  double intensity_cd(double azimuth_rad, double elevation_rad) const;
};

}  // namespace vildar
