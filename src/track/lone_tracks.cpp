#include "track/lone_tracks.h"

#include <algorithm>
#include <utility>

#include "track/resume.h"

namespace vildar {
std::optional<VehicleTrack> LoneTracks::add(VehicleTrack track, const Lamp& light, bool drove_out,
                                            const RoadView& view) {
  std::vector<LampRecord> records = light.records;
  const auto goes_on_here = [&](const Waiting& one) {
    if (one.track.kind != track.kind) return false;
    return one.heir ? *one.heir == light.id : goes_on(one.records, records, view);
  };
  if (std::ranges::count_if(waiting_, goes_on_here) == 1) {
    const auto before = std::ranges::find_if(waiting_, goes_on_here);
    track.ambiguous_identity |= before->track.ambiguous_identity;
    track.direction_contradicts |= before->track.direction_contradicts;
    track.sightings.insert(track.sightings.begin(), before->track.sightings.begin(),
                           before->track.sightings.end());
    records.insert(records.begin(), before->records.begin(), before->records.end());
    waiting_.erase(before);
  }
  if (drove_out) return track;
  waiting_.push_back({std::move(track), std::move(records), std::nullopt});
  return std::nullopt;
}

std::vector<VehicleTrack> LoneTracks::take_done(CameraTime now, const Lamps& lamps,
                                                const RoadView& view) {
  std::vector<VehicleTrack> done;
  std::vector<Waiting> still;
  for (Waiting& one : waiting_) {
    const double waited_s = seconds_of(now) - seconds_of(one.records.back().time);
    const auto may_be_heir = [&](const auto& lamp) {
      if (lamp->vehicle || lamp->fixed || lamp->records.empty()) return false;
      return one.heir ? *one.heir == lamp->id : goes_on(one.records, lamp->records, view);
    };
    if (waited_s >= kLongestWait_s) {
      const auto heir = std::ranges::find_if(lamps, may_be_heir);
      if (heir == lamps.end()) {
        done.push_back(std::move(one.track));
        continue;
      }
      one.heir = (*heir)->id;
    }
    still.push_back(std::move(one));
  }
  waiting_ = std::move(still);
  return done;
}

std::vector<VehicleTrack> LoneTracks::take_all() {
  std::vector<VehicleTrack> all;
  for (Waiting& one : waiting_) all.push_back(std::move(one.track));
  waiting_.clear();
  return all;
}

const LampRecord* LoneTracks::oldest() const {
  const auto first = std::ranges::min_element(
      waiting_, {}, [](const Waiting& one) { return one.records.front().frame; });
  return first == waiting_.end() ? nullptr : &first->records.front();
}

}  // namespace vildar
