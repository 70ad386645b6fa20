#pragma once

#include <optional>
#include <vector>

#include "types/blob.h"

namespace vildar {

/// How strong the lamps of this scene are: ln(flux x depth^2), which for one exposure is the same
/// near and far. Glints on car bodies, paint and lit road are far below it.
class LightScale {
 public:
  /// `strength` of a vehicle that is beyond doubt, and whether its lamps clip.
  void add(LampKind kind, double strength, bool clips);
  /// Upper quartile of the latest ones, for headlamps at least that of tail lamps; nothing before
  /// there are enough.
  std::optional<double> typical(LampKind kind) const;
  /// Whether most lamps clip; false before there are enough.
  bool usually_clips(LampKind kind) const;

 private:
  struct Memory {
    std::vector<double> strengths;
    std::vector<char> clips;
    std::size_t next = 0;
  };
  const Memory& of(LampKind kind) const { return kind == LampKind::taillamp ? tail_ : head_; }

  Memory head_, tail_;
};

}  // namespace vildar
