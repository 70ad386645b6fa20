#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "track/association.h"
#include "track/vehicle.h"

namespace vildar {

using Vehicles = std::vector<std::unique_ptr<Vehicle>>;

/// Gathers evidence, over frames, on which lamps belong together, and joins and parts them.
class Pairing {
 public:
  explicit Pairing(const RoadView& view) : view_(view) {}

  /// After all lamps have been updated with this frame.
  void update(Lamps& lamps, Vehicles& vehicles, std::int64_t frame, CameraTime time);
  void forget(const std::vector<Lamp*>& lamps);
  void forget_all();

 private:
  struct Evidence {
    Lamp* a;
    Lamp* b;
    double chi2 = 0.0, log_odds = 0.0;  ///< running means, see PairLook
    double inverse_depth_per_m = 0.0, width_per_depth = 0.0;
    int looks = 0;
    std::int64_t last_frame = 0;
  };

  void look_at_pairs(const Lamps& lamps, std::int64_t frame);
  void refresh(Vehicles& vehicles, std::int64_t frame, CameraTime time);
  void count_rows(const Lamps& lamps, const Vehicles& vehicles, std::int64_t frame) const;
  std::vector<Evidence*> best_pairs(std::int64_t frame);
  bool pass_on(Vehicle& vehicle, const Evidence& pair, std::int64_t frame);
  static void leave_two(const Evidence& pair, const Lamp& left, const Lamp& right);
  void join(Evidence& pair, Vehicles& vehicles, std::int64_t frame);
  Evidence* evidence_of(const Lamp* a, const Lamp* b);
  bool has_rival(const Lamp& a, const Lamp& b, int both_seen) const;

  using LampsOf = std::pair<const Lamp*, const Lamp*>;
  struct LampsHash {
    std::size_t operator()(const LampsOf& lamps) const;
  };

  const RoadView& view_;
  std::vector<Evidence> evidence_;
  std::unordered_map<LampsOf, std::size_t, LampsHash> index_;  ///< into evidence_
};

}  // namespace vildar
