#include "track/tracker.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "track/aim.h"
#include "track/association.h"
#include "track/attitude.h"
#include "track/drive_attitude.h"
#include "track/heir.h"
#include "track/held_records.h"
#include "track/lamp_parts.h"
#include "track/lone_tracks.h"
#include "track/look_alikes.h"
#include "track/own_lamp.h"
#include "track/pairing.h"
#include "track/resume.h"
#include "track/spots.h"
#include "track/standing.h"
#include "track/unmeasured_lights.h"
#include "track/vehicle.h"

namespace vildar {

class Tracker::Impl {
 public:
  Impl(const TrackOptions& options, const Site& site)
      : options_(options),
        view_(site),
        aim_(site),
        pairing_(view_),
        attitude_(view_.focal_px()),
        reach_px_(kReachShare * site.camera->width_px),
        rolling_shutter_s_(site.camera->rolling_shutter_s) {
    if (site.ego) drive_attitude_.emplace(site);
  }

  std::vector<VehicleTrack> update(BlobFrame& frame);
  std::vector<VehicleTrack> finish();
  const TrackCounts& counts() const { return counts_; }
  std::vector<std::optional<CameraTurn>> turns_in(std::span<const std::int64_t> frames) const {
    if (drive_attitude_) return drive_attitude_->turns_in(frames);
    std::vector<std::optional<CameraTurn>> turns;
    for (const std::int64_t frame : frames) turns.push_back(attitude_.at(frame));
    return turns;
  }
  std::optional<CameraTime> live_since() const;

 private:
  static constexpr double kOutside_px = 4.0;
  static constexpr double kReachShare = 0.03;  // of the image width, for the common motion

  void follow(const std::vector<Spot>& spots, const BlobFrame& frame);
  void learn_strength();
  void find_turn(const BlobFrame& now);
  void bear(const std::vector<Spot>& spots, const Association& found, const BlobFrame& frame);
  double patience(const Lamp& lamp, std::int64_t frame) const;
  void end_lost(const BlobFrame& frame, std::vector<VehicleTrack>& ended);
  Verdict end_vehicle(Vehicle& vehicle, std::vector<VehicleTrack>& ended);
  void forget_ended(CameraTime now);
  void end_single(const Lamp& whole, std::vector<VehicleTrack>& ended);
  void report(Verdict verdict, VehicleTrack&& track, std::vector<VehicleTrack>& ended);
  void count(Verdict verdict);
  void name_kinds(BlobFrame& frame, const std::vector<Spot>& spots) const;

  TrackOptions options_;
  RoadView view_;
  Aim aim_;
  Pairing pairing_;
  Sway sway_;
  Attitude attitude_;
  std::optional<DriveAttitude> drive_attitude_;  ///< of a moving sensor, in the other's stead
  double reach_px_, rolling_shutter_s_;
  Lamps lamps_;
  Vehicles vehicles_;
  Vehicles waiting_;              ///< lost from view or taken apart, and may yet be found again
  std::int64_t waits_since_ = 0;  ///< frame in which the last of them began to
  Vehicles ended_;  ///< reported, while lights are followed that may have been their lamps
  std::vector<std::pair<int, Lamp*>> seen_;        // spot, lamp
  std::map<const Lamp*, std::uint64_t> standing_;  ///< lights that the attitude goes by
  std::uint64_t next_standing_ = 0, lamps_found_ = 0;
  LoneTracks lone_;
  LightScale lights_;
  TrackCounts counts_;
  int reported_ = 0;
  std::optional<CameraTime> last_time_;
};

std::vector<VehicleTrack> Tracker::Impl::update(BlobFrame& frame) {
  if (last_time_ && !(frame.time > *last_time_))
    throw std::invalid_argument("Tracker::update: frame " + std::to_string(frame.frame) +
                                " is not later than the one before; pass them in order of time");
  const double dt_s = last_time_ ? seconds_of(frame.time) - seconds_of(*last_time_) : 0.0;
  last_time_ = frame.time;
  counts_.blobs += static_cast<std::int64_t>(frame.blobs.size());
  join_lamp_parts(frame, view_);
  const std::vector<Spot> spots = spots_of(frame, view_);
  for (const Blob& blob : frame.blobs)
    if (blob.kind != LampKind::other) lights_.see_colour(blob.cr, blob.cb);
  for (const auto& one : lamps_) one->predict(dt_s, view_, sway_.told() || view_.moving_sensor());
  const CommonShift shift = common_shift(lamps_, spots, reach_px_);
  sway_.see(shift);
  if (!shift.by_px.isZero())
    for (const auto& lamp : lamps_) lamp->shift(shift.by_px, dt_s);
  follow(spots, frame);
  note_look_alikes(lamps_, spots, vehicles_, view_, frame.frame, sway_.told());
  pairing_.update(lamps_, vehicles_, frame.frame, frame.time);
  if (const auto aimed = aim_.learn(vehicles_, frame.frame)) view_ = RoadView(*aimed);
  resume_lost(vehicles_, waiting_, frame.frame, waits_since_, view_);
  for (const auto& vehicle : vehicles_) mark_split_records(*vehicle);
  learn_strength();
  find_turn(frame);
  std::vector<VehicleTrack> ended;
  end_lost(frame, ended);
  name_kinds(frame, spots);
  return ended;
}

// Lights that stand in the world, well above the road or for long enough, show how the camera
// turns. From a vehicle none stands still in the picture: those above the road count.
void Tracker::Impl::find_turn(const BlobFrame& now) {
  constexpr double kLong_s = 4.0, kAboveShare = 0.5;
  const std::int64_t frame = now.frame;
  std::int64_t oldest = frame;
  if (drive_attitude_) drive_attitude_->begin(frame, seconds_of(now.time));
  for (const auto& lamp : lamps_) {
    const bool above = lamp->above.share() > kAboveShare;
    const bool stands =
        !lamp->vehicle &&
        (drive_attitude_ ? above : lamp->fixed && (above || lamp->lived_s() > kLong_s));
    if (const LampRecord* first = lamp->oldest(); first && !stands)
      oldest = std::min(oldest, first->frame);
    if (!stands || !lamp->seen_at(frame)) continue;
    const auto [entry, is_new] = standing_.try_emplace(lamp.get(), next_standing_);
    next_standing_ += is_new;
    std::vector<StaticSighting> sightings;
    for (auto record = is_new ? lamp->records.begin() : lamp->records.end() - 1;
         record != lamp->records.end(); ++record)
      if (!has(record->sighting.defects, Defect::merged) &&
          !has(record->sighting.defects, Defect::cut_by_edge))
        sightings.push_back({record->frame, record->at_px,
                             record->sighting.centre_sigma_px.maxCoeff(),
                             seconds_of(row_time(record->time, rolling_shutter_s_,
                                                 record->sighting.row_fraction))});
    if (drive_attitude_)
      drive_attitude_->add(entry->second, sightings);
    else
      attitude_.add(entry->second, sightings);
  }
  for (const auto* vehicles : {&vehicles_, &waiting_})
    for (const auto& vehicle : *vehicles)
      for (const auto* past : {&vehicle->past_left, &vehicle->past_right})
        if (!past->empty()) oldest = std::min(oldest, past->front().frame);
  if (const LampRecord* waiting = lone_.oldest()) oldest = std::min(oldest, waiting->frame);
  if (drive_attitude_) {
    drive_attitude_->forget_before(oldest);
  } else {
    attitude_.solve(frame);
    attitude_.forget_before(oldest);
  }
}

// A vehicle whose pair has held for a second or so shows how strong lamps are here; what has not
// moved yet may be a sign, or letters in the picture.
void Tracker::Impl::learn_strength() {
  constexpr int kLongEnough = 20;
  constexpr double kGoodChi2 = 5.0;
  for (const auto& vehicle : vehicles_) {
    if (vehicle->told_strength || vehicle->both_seen < kLongEnough || vehicle->chi2 > kGoodChi2 ||
        !vehicle->left || !vehicle->right ||
        std::min(vehicle->left->wandered_px(), vehicle->right->wandered_px()) < kMoved_px)
      continue;
    vehicle->told_strength = true;
    const bool clips = vehicle->left->records.back().sighting.saturated_px > 0 &&
                       vehicle->right->records.back().sighting.saturated_px > 0;
    lights_.add(vehicle->kind, std::min(strength_of(*vehicle->left), strength_of(*vehicle->right)),
                view_.place(vehicle->left->records.back().at_px).slope_down, clips);
  }
}

void Tracker::Impl::follow(const std::vector<Spot>& spots, const BlobFrame& frame) {
  const Association found = associate(lamps_, spots, options_.gate_chi2, view_);
  seen_.clear();
  std::vector<Eigen::Vector2d> place_before(lamps_.size()), speed_before(lamps_.size());
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    Lamp& lamp = *lamps_[i];
    place_before[i] = lamp.at_px();
    speed_before[i] = lamp.velocity_pxps();
    if (found.doubtful[i]) lamp.doubtful_at = frame.time;
  }
  const auto index_of = [&](const Lamp* lamp) {
    return static_cast<std::size_t>(
        std::find_if(lamps_.begin(), lamps_.end(),
                     [&](const auto& one) { return one.get() == lamp; }) -
        lamps_.begin());
  };
  std::vector<char> merged(lamps_.size(), 0);
  for (const auto& vehicle : vehicles_) {
    if (!vehicle->left || !vehicle->right) continue;
    const std::size_t l = index_of(vehicle->left), r = index_of(vehicle->right);
    const auto spot_l = found.spot_of_lamp[l], spot_r = found.spot_of_lamp[r];
    if (spot_l.has_value() == spot_r.has_value()) continue;
    // One blob for two lamps: it holds both when it stands nearer their middle than the lamp it was
    // given to, and is too wide for the gap between them.
    const int index = spot_l ? *spot_l : *spot_r;
    const Spot& spot = spots[index];
    const Eigen::Vector2d apart_px = vehicle->right->at_px() - vehicle->left->at_px();
    const Eigen::Vector2d middle_px = 0.5 * (vehicle->right->at_px() + vehicle->left->at_px());
    const double to_lamp_px =
        (spot.at_px - (spot_l ? vehicle->left : vehicle->right)->at_px()).norm();
    const double width_px = spot.blob->box.u_max - spot.blob->box.u_min + 1.0;
    if ((spot.at_px - middle_px).norm() < to_lamp_px && width_px > 0.6 * apart_px.norm()) {
      vehicle->left->update_merged(spot, -0.5 * apart_px, frame.frame, frame.time);
      vehicle->right->update_merged(spot, 0.5 * apart_px, frame.frame, frame.time);
      merged[l] = merged[r] = 1;
      seen_.emplace_back(index, vehicle->left);
    }
  }
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    if (!found.spot_of_lamp[i] || merged[i]) continue;
    lamps_[i]->update(spots[*found.spot_of_lamp[i]], frame.frame, frame.time);
    seen_.emplace_back(*found.spot_of_lamp[i], lamps_[i].get());
  }
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    Lamp& lamp = *lamps_[i];
    if (lamp.seen_at(frame.frame) || !lamp.vehicle) continue;
    const Lamp* partner = lamp.vehicle->partner_of(&lamp);
    if (!partner || !partner->seen_at(frame.frame)) continue;
    const std::size_t p = index_of(partner);
    lamp.carry(partner->at_px() - place_before[p], partner->velocity_pxps() - speed_before[p]);
  }
  for (const auto& vehicle : vehicles_) {
    // A lamp in doubt keeps its identity by a partner that is sure of its own all the while.
    bool any_now = false, all_lately = true;
    for (const Lamp* lamp : {vehicle->left, vehicle->right}) {
      if (!lamp) continue;
      any_now |= lamp->doubtful_at == frame.time;
      const bool lately =
          lamp->doubtful_at &&
          seconds_of(frame.time) - seconds_of(*lamp->doubtful_at) < options_.longest_gap_s;
      all_lately &= lately || !lamp->seen_at(frame.frame);
    }
    vehicle->ambiguous |= any_now && all_lately;
  }
  // What a light without a partner was before a doubtful step is not held against, or for, it.
  for (std::size_t i = 0; i < lamps_.size(); ++i)
    if (found.doubtful[i] && !lamps_[i]->vehicle) lamps_[i]->set_aside_before(frame.time);
  bear(spots, found, frame);
}

void Tracker::Impl::bear(const std::vector<Spot>& spots, const Association& found,
                         const BlobFrame& frame) {
  constexpr double kFarTooFaint = 3.5;
  for (std::size_t j = 0; j < spots.size(); ++j) {
    if (found.spot_taken[j] || spots[j].blob->kind == LampKind::other) continue;
    const LampPlace place = view_.place(spots[j].at_px);
    const double strength =
        std::log(std::max(spots[j].blob->flux, 1e-9)) - 2.0 * std::log(place.inverse_depth_per_m);
    auto typical = lights_.typical(spots[j].blob->kind);
    if (typical) *typical -= lights_.dimmer_ln(place.slope_down, spots[j].blob->kind);
    if (typical && strength < *typical - kFarTooFaint) continue;
    lamps_.push_back(std::make_unique<Lamp>(spots[j], place, frame.frame, frame.time, view_));
    lamps_.back()->id = ++lamps_found_;
    seen_.emplace_back(static_cast<int>(j), lamps_.back().get());
  }
}

// How many times the longest gap a lamp is waited for. A camera that stands can tell where a
// vehicle that it knows well will come out from behind another one.
double Tracker::Impl::patience(const Lamp& lamp, std::int64_t frame) const {
  constexpr int kTentative = 3, kKnownWell = 15;  // sightings
  constexpr double kTentativeShare = 0.2, kHiddenShare = 2.4;
  if (lamp.sightings() < kTentative) return kTentativeShare;
  if (!lamp.vehicle || lamp.vehicle->both_seen < kKnownWell || view_.moving_sensor()) return 1.0;
  const Lamp* partner = lamp.vehicle->partner_of(&lamp);
  return partner && !partner->seen_at(frame) ? kHiddenShare : 1.0;
}

void Tracker::Impl::end_lost(const BlobFrame& frame, std::vector<VehicleTrack>& ended) {
  for (const auto& vehicle : vehicles_)
    if (vehicle->cut_after) {
      // What was good is the vehicle's, what came apart or went over to another starts anew.
      for (Lamp* lamp : {vehicle->left, vehicle->right}) {
        if (!lamp) continue;
        auto& past = lamp == vehicle->left ? vehicle->past_left : vehicle->past_right;
        past.insert(past.end(), lamp->records.begin(), lamp->records.end());
        lamp->start_anew(frame.time, vehicle->both_seen);
        pairing_.forget({lamp});
      }
      vehicle->lamps_go_on = vehicle->left || vehicle->right;
      vehicle->left = vehicle->right = nullptr;
    }

  std::vector<Lamp*> lost;
  for (const auto& lamp : lamps_) {
    const double allowed_s = options_.longest_gap_s * patience(*lamp, frame.frame);
    const bool outside =
        !lamp->seen_at(frame.frame) && !view_.inside_image(lamp->at_px(), kOutside_px);
    if (lamp->unseen_s(frame.time) > allowed_s || outside) lost.push_back(lamp.get());
  }
  drop_old_records(lamps_, vehicles_);
  pairing_.forget(lost);
  for (Lamp* lamp : lost) {
    standing_.erase(lamp);
    Vehicle* vehicle = lamp->vehicle;
    if (!vehicle) {
      end_single(*lamp, ended);
      continue;
    }
    Lamp*& side = vehicle->left == lamp ? vehicle->left : vehicle->right;
    auto& past = vehicle->left == lamp ? vehicle->past_left : vehicle->past_right;
    past.insert(past.end(), lamp->records.begin(), lamp->records.end());
    side = nullptr;
    vehicle->drove_out = !view_.inside_image(lamp->at_px(), kOutside_px);
  }
  const auto end = [&](std::unique_ptr<Vehicle>& vehicle) {
    if (end_vehicle(*vehicle, ended) == Verdict::vehicle) ended_.push_back(std::move(vehicle));
    vehicle.reset();
  };
  for (auto& vehicle : vehicles_) {
    if (vehicle->left || vehicle->right) continue;
    cut_where_it_came_apart(*vehicle);
    if (vehicle->drove_out) {
      end(vehicle);
    } else {
      waits_since_ = frame.frame;
      waiting_.push_back(std::move(vehicle));
    }
  }
  std::erase(vehicles_, nullptr);
  for (auto& vehicle : waiting_)
    if (seconds_of(frame.time) - seconds_of(last_seen(*vehicle)) >= kLongestWait_s) end(vehicle);
  std::erase(waiting_, nullptr);
  std::erase_if(lamps_, [&](auto& lamp) { return std::ranges::count(lost, lamp.get()) > 0; });
  for (VehicleTrack& track : lone_.take_done(frame.time, lamps_, view_))
    report(Verdict::vehicle, std::move(track), ended);
  forget_ended(frame.time);
}

// What was one of a vehicle's lamps, if for its first frames only, was seen beside it.
void Tracker::Impl::forget_ended(CameraTime now) {
  constexpr double kLongest_s = 10.0;
  std::erase_if(ended_, [&](const auto& vehicle) {
    const CameraTime last = last_seen(*vehicle);
    const auto before = [&](const std::vector<LampRecord>& records) {
      return !records.empty() && records.front().time < last;
    };
    const auto before_it = [&](const auto& other) {
      return before(other->past_left) || before(other->past_right);
    };
    const auto seen_before = [&](const auto& lamp) {
      return lamp->oldest() && lamp->oldest()->time < last;
    };
    return seconds_of(now) - seconds_of(last) > kLongest_s ||
           (std::ranges::none_of(lamps_, seen_before) &&
            std::ranges::none_of(vehicles_, before_it) &&
            std::ranges::none_of(waiting_, before_it));
  });
}

void Tracker::Impl::report(Verdict verdict, VehicleTrack&& track,
                           std::vector<VehicleTrack>& ended) {
  count(verdict);
  if (verdict != Verdict::vehicle) return;
  track.id = ++reported_;
  ended.push_back(std::move(track));
}

Verdict Tracker::Impl::end_vehicle(Vehicle& vehicle, std::vector<VehicleTrack>& ended) {
  VehicleTrack track;
  Verdict verdict = judge_vehicle(vehicle, view_, options_, lights_, track);
  // A dashcam's own turning takes lights over one another.
  if (verdict != Verdict::short_track && !view_.moving_sensor()) {
    std::vector<const Vehicle*> others;
    for (const auto* vehicles : {&vehicles_, &waiting_, &ended_})
      for (const auto& other : *vehicles)
        if (other && other.get() != &vehicle) others.push_back(other.get());
    vehicle.last_as_another = last_frame_as_another(vehicle, others, view_);
    if (vehicle.last_as_another) verdict = judge_vehicle(vehicle, view_, options_, lights_, track);
  }
  report(verdict, std::move(track), ended);
  return verdict;
}

void Tracker::Impl::end_single(const Lamp& whole, std::vector<VehicleTrack>& ended) {
  VehicleTrack track;
  const auto judge = [&](const Lamp& lamp) {
    return judge_single(steadied(lamp, attitude_, view_), view_, options_, lights_, track);
  };
  Verdict verdict = judge(whole);
  // What it was before a doubtful step it may have been longer than since.
  std::optional<Lamp> earlier;
  if (verdict != Verdict::vehicle && whole.set_aside.size() > whole.records.size()) {
    earlier = whole.before_doubt();
    verdict = judge(*earlier);
  }
  const Lamp& lamp = earlier ? *earlier : whole;
  const auto owns = [&](const auto& vehicle) { return was_lamp_of(lamp, *vehicle, view_); };
  if (verdict == Verdict::vehicle &&
      (std::ranges::any_of(vehicles_, owns) || std::ranges::any_of(waiting_, owns) ||
       std::ranges::any_of(ended_, owns)))
    verdict = Verdict::reflection;
  if (verdict == Verdict::vehicle && !view_.moving_sensor()) {
    const bool drove_out = !view_.inside_image(lamp.at_px(), kOutside_px);
    auto done = lone_.add(std::move(track), lamp, drove_out, view_);
    if (!done) return;
    track = std::move(*done);
  }
  count_unmeasured(whole, verdict, view_, counts_);
  report(verdict, std::move(track), ended);
}

void Tracker::Impl::count(Verdict verdict) {
  switch (verdict) {
    case Verdict::vehicle: return;
    case Verdict::short_track: ++counts_.short_tracks; return;
    case Verdict::static_light: ++counts_.static_lights; return;
    case Verdict::reflection: ++counts_.reflections; return;
    case Verdict::off_road: ++counts_.off_road; return;
    case Verdict::undecided: ++counts_.undecided; return;
  }
}

void Tracker::Impl::name_kinds(BlobFrame& frame, const std::vector<Spot>& spots) const {
  constexpr double kShare = 0.5;
  constexpr int kLooks = 3;
  for (const auto& [index, lamp] : seen_) {
    const auto is_it = [lamp = lamp](const auto& one) { return one.get() == lamp; };
    if (std::ranges::none_of(lamps_, is_it)) continue;
    Blob& blob = frame.blobs[static_cast<std::size_t>(spots[index].blob - frame.blobs.data())];
    if (lamp->vehicle)
      blob.kind = lamp->vehicle->kind;
    else if (lamp->mirrored.looks() >= kLooks && lamp->mirrored.share() > kShare)
      blob.kind = LampKind::reflection;
    else if (lamp->fixed || (lamp->above.looks() >= kLooks && lamp->above.share() > kShare))
      blob.kind = LampKind::street;
  }
}

std::vector<VehicleTrack> Tracker::Impl::finish() {
  std::vector<VehicleTrack> ended;
  for (const auto& vehicle : vehicles_) cut_where_it_came_apart(*vehicle);
  for (const auto* vehicles : {&waiting_, &vehicles_})
    for (const auto& vehicle : *vehicles) end_vehicle(*vehicle, ended);
  for (const auto& lamp : lamps_)
    if (!lamp->vehicle) end_single(*lamp, ended);
  for (VehicleTrack& track : lone_.take_all()) report(Verdict::vehicle, std::move(track), ended);
  pairing_.forget_all();
  vehicles_.clear();
  waiting_.clear();
  ended_.clear();
  lamps_.clear();
  standing_.clear();
  last_time_.reset();
  return ended;
}

std::optional<CameraTime> Tracker::Impl::live_since() const {
  std::optional<CameraTime> oldest;
  const auto consider = [&](const LampRecord* first) {
    if (first && (!oldest || first->time < *oldest)) oldest = first->time;
  };
  for (const auto& lamp : lamps_)
    if (lamp->vehicle || !lamp->fixed) consider(lamp->oldest());
  for (const auto* vehicles : {&vehicles_, &waiting_})
    for (const auto& vehicle : *vehicles)
      for (const auto* past : {&vehicle->past_left, &vehicle->past_right})
        if (!past->empty()) consider(&past->front());
  consider(lone_.oldest());
  return oldest;
}

Tracker::Tracker(TrackOptions options, const Site& site) {
  const std::vector<std::string> problems = options.problems();
  if (!problems.empty()) {
    std::string text = "TrackOptions:";
    for (const std::string& problem : problems) text += " " + problem + ";";
    throw std::invalid_argument(text);
  }
  if (!site.camera) throw std::invalid_argument("Tracker: the site has no camera; give it one");
  impl_ = std::make_unique<Impl>(options, site);
}

Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;
std::vector<VehicleTrack> Tracker::update(BlobFrame& blobs) { return impl_->update(blobs); }
std::vector<VehicleTrack> Tracker::finish() { return impl_->finish(); }
std::optional<CameraTime> Tracker::live_since() const { return impl_->live_since(); }
std::vector<std::optional<CameraTurn>> Tracker::turns_in(
    std::span<const std::int64_t> frames) const {
  return impl_->turns_in(frames);
}
const TrackCounts& Tracker::counts() const { return impl_->counts(); }

}  // namespace vildar
