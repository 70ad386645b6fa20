#pragma once

#include "track/association.h"
#include "track/attitude.h"
#include "track/road_view.h"

namespace vildar {

/// Whether a camera on its stand sways, as one that is held by hand: all lamps went one way in
/// three of the last two hundred frames, and do so now and then from there on.
class Sway {
 public:
  void see(const CommonShift& shift);
  bool told() const { return told_; }

 private:
  double share_ = 0.0;
  bool told_ = false;
};

/// Whether a light stands in the world, though the camera may shake: in a second and more it has
/// moved by less than a metre or 5 px, or has gone to and fro and got nowhere, or, before a camera
/// that sways, has kept its angle to another light of its own beside it for 2 s while both moved by
/// less than 0.1 rad: lights of vehicles part as they come nearer. Never before a camera that
/// drives.
bool stands_in_the_world(const Lamp& lamp, const Lamps& lamps, const RoadView& view, bool sways);

/// A lamp where the camera at rest would have seen it, in the frames in which its turn is told.
Lamp steadied(const Lamp& lamp, const Attitude& attitude, const RoadView& view);

}  // namespace vildar
