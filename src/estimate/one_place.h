#pragma once

#include <vector>

#include "estimate/vehicle.h"

namespace vildar {

/// Whether two measured vehicles are one, seen twice: in all of the time that both are in view they
/// stand, as far as can be told, where two vehicles do not fit, and they seldom show four lamps at
/// once, or surely stand inside one another, or their lamps right below one another. Of a light
/// without a partner it is enough that it cannot be told apart from a vehicle that has two lamps.
/// So are two in view one after the other, within 3.5 s, of which the second surely goes on where
/// the first was, though it may have braked by 1 m/s² between. False where either has no speed from
/// the camera.
bool one_vehicle(const VehicleEstimate& one, const VehicleEstimate& other);

/// Whether the lamps of `upper` move as lamps higher on the body of `carrier` would: from a camera
/// high over the lamps those seem farther off, by a factor that stays, and as much faster. A
/// vehicle of its own would have to reach the camera at once with the other, always in one line
/// with it, and drive beside all lanes, right above the other, in its very lane, or far faster; of
/// one light, or of a pair that would stand closer together than a car's or shine half as bright as
/// the other, in line with a pair the first is enough.
/// `over_lamps_m` is the camera's height over headlamps.
bool rides_on(const VehicleEstimate& upper, const VehicleEstimate& carrier, double over_lamps_m);

/// Whether the lamps of `lower` are the image on a wet road of those of `source`, which are
/// brighter, or less drawn out with more light for their size, or as wide and right where a smooth
/// road has it, whatever the light: in line with them as rides_on()
/// says, by a factor that an image asks for.
bool mirrors(const VehicleEstimate& lower, const VehicleEstimate& source, double over_lamps_m,
             double lamp_height_m);

/// Whether a lone `light` stands on the body of `carrier`, which shows its pair: for a second or
/// more it keeps its place beyond the pair, no further than the next vehicle's lamps come (3.5 m
/// and a quarter of a second), and within 1.3 m beside its middle; from
/// 4.5 m on it is 0.6 m beside that, too, or fainter than the pair. A caravan's side marker, say.
/// Or a fainter pair, in line with it and up to 8 m behind, whose place changes by less than 0.5 m:
/// a caravan's front markers.
bool on_the_body(const VehicleEstimate& light, const VehicleEstimate& carrier);

/// Whether a lone `light` moves as the glint that a lamp of `source` draws along a rail or a wall
/// beside the road: farther out in the picture, fainter than the lamps (of lamps that clip, than
/// what is seen of them), at a distance that stays the same share of theirs, so that both reach the
/// camera at once. A motorcycle that is overtaken right there looks the same.
bool glints_beside(const VehicleEstimate& light, const VehicleEstimate& source);

/// Measured vehicles, held while another track may turn out to be of the same vehicle. Of two that
/// are one, or a car and its trailer, the speed of smaller relative sigma stands, or that of the
/// headlamps where the other is of the fog lamps or strips about them; the other is withheld
/// (ambiguous_identity), as are lamps that ride on another vehicle or stand on its side, images of
/// its lamps on the road and glints beside it.
class MeasuredVehicles {
 public:
  /// Height of the camera over headlamps, and theirs over the road, in metres.
  MeasuredVehicles(double over_lamps_m, double lamp_height_m)
      : over_lamps_m_(over_lamps_m), lamp_height_m_(lamp_height_m) {}

  void add(VehicleEstimate estimate);
  /// Hands over, in the order added, those that none can be the same as that is first seen at
  /// `time_s` or later; no vehicle added later may have been in view before.
  std::vector<VehicleEstimate> take_before(double time_s);

 private:
  /// Whether either is a part, an image or a glint of the other, which then has no speed.
  bool withhold_part(VehicleEstimate& upper, VehicleEstimate& carrier) const;

  double over_lamps_m_ = 0.0, lamp_height_m_ = 0.0;
  std::vector<VehicleEstimate> held_;
};

}  // namespace vildar
