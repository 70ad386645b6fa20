#pragma once

#include <optional>
#include <vector>

#include "track/association.h"
#include "track/road_view.h"

namespace vildar {

/// Lights that stayed alone, were found to be vehicles and were lost within the picture: a
/// motorcycle behind a lorry. Each waits for the light that it goes on as, if that turns out to be
/// a vehicle's as well. For a sensor that stands.
class LoneTracks {
 public:
  /// Takes `light`, which has ended, and the track of it. It becomes a part of the one waiting that
  /// went on as it, if there is one; then waits, or, where it drove out of the picture, is given
  /// back.
  std::optional<VehicleTrack> add(VehicleTrack track, const Lamp& light, bool drove_out,
                                  const RoadView& view);

  /// Those that no light still followed can go on with.
  std::vector<VehicleTrack> take_done(CameraTime now, const Lamps& lamps, const RoadView& view);
  std::vector<VehicleTrack> take_all();

  /// Of the records that are held; nothing where none waits.
  const LampRecord* oldest() const;

 private:
  struct Waiting {
    VehicleTrack track;
    std::vector<LampRecord> records;
    std::optional<std::uint64_t> heir;  ///< id of a light that seemed to go on as it
  };
  std::vector<Waiting> waiting_;
};

}  // namespace vildar
